"""The stubs name what the package has, with the same parameters."""
import ast
import inspect
import pathlib
import unittest

import skywave

STUB = ast.parse((pathlib.Path(skywave.__file__).parent / "__init__.pyi").read_text())


def parameters_of_stub(function):
    arguments = function.args
    positional = arguments.posonlyargs + arguments.args
    names = [argument.arg for argument in positional + arguments.kwonlyargs]
    names += ["**" + arguments.kwarg.arg] if arguments.kwarg else []
    required = len(positional) - len(arguments.defaults)
    required += sum(default is None for default in arguments.kw_defaults)
    return names, required


def parameters_of(function):
    prefix = {inspect.Parameter.VAR_KEYWORD: "**"}
    parameters = inspect.signature(function).parameters.values()
    names = [prefix.get(p.kind, "") + p.name for p in parameters]
    return names, sum(p.default is p.empty and p.kind not in prefix for p in parameters)


class StubsTest(unittest.TestCase):
    def compare(self, body, holder):
        functions = [node for node in body if isinstance(node, ast.FunctionDef)]
        for node in functions:
            with self.subTest(node.name):
                attribute = inspect.getattr_static(holder, node.name)
                if isinstance(attribute, property):
                    self.assertEqual(ast.unparse(node.decorator_list[0]), "property")
                else:
                    attribute = getattr(attribute, "__func__", attribute)  # of a classmethod
                    self.assertEqual(parameters_of(attribute), parameters_of_stub(node))
        return {node.name for node in functions}

    def test_functions_and_classes(self):
        classes = [node for node in STUB.body if isinstance(node, ast.ClassDef)
                   and not node.name.startswith("_")]
        names = self.compare(STUB.body, skywave) | {node.name for node in classes}
        self.assertEqual(names, set(skywave.__all__))

    def test_methods(self):
        for node in STUB.body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                cls = getattr(skywave, node.name)
                named = self.compare(node.body, cls)
                public = {name for name, value in vars(cls).items() if not name.startswith("_")
                          and (callable(value) or isinstance(value, (property, classmethod)))}
                self.assertEqual({name for name in named if not name.startswith("_")}, public)


if __name__ == "__main__":
    unittest.main()
