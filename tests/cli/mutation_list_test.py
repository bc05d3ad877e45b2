#!/usr/bin/env python3
"""Tests how scripts/mutation_test.py finds the place of a fault: a text within a function."""
import importlib.util
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SPEC = importlib.util.spec_from_file_location("mutation_test", ROOT / "scripts/mutation_test.py")
LIST = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(LIST)

SOURCE = """
float Twice(float x);  // a declaration
struct Film {
  Film(int n) : size(Half(n)) {}
  float Half(float x) const { return x / 2; }
  const char* name = "}";  // a brace in a string } and in a comment
};
float Film::Twice(float x) const {
  if (Half(x) > 0) { return 2 *
      x; }
  return 'x' == '}' ? x : Half(x) / 2;
}
float Other(float x) { return 2 * x + 1'000 / 2; }
"""


def count(within, find, text=SOURCE, suffix=".cc"):
    return len(LIST.places({"within": within, "find": find}, text, suffix))


class Places(unittest.TestCase):
    def test_a_text_is_found_within_its_function_alone(self):
        self.assertEqual(count("Film::Twice", "2 * x"), 1)
        self.assertEqual(count("Twice", "2 * x"), 1)
        self.assertEqual(count("Half", "x / 2"), 1)
        self.assertEqual(count("Other", "Half"), 0)
        self.assertEqual(count("struct Film", "x / 2"), 1)
        self.assertEqual(count("Nobody", "x"), 0)

    def test_the_format_of_cpp_does_not_matter(self):
        self.assertEqual(count("Film::Twice", "return 2*x;"), 1)
        self.assertEqual(count("Other", "return2 * x"), 0)

    def test_only_the_place_within_the_function_is_replaced(self):
        fault = {"within": "Other", "find": "2 * x", "put": "3 * x"}
        changed = LIST.with_fault(fault, SOURCE, ".cc")
        self.assertEqual(changed, SOURCE.replace("2 * x", "3 * x"))

    def test_functions_of_python_end_with_their_indentation(self):
        text = "def a():\n    x = 1\n\n    y = 2\ndef b():\n    x = 1\n"
        self.assertEqual(count("a", "x = 1", text, ".py"), 1)
        self.assertEqual(count("a", "y = 2", text, ".py"), 1)
        self.assertEqual(count("b", "y = 2", text, ".py"), 0)

    def test_a_file_that_has_moved_is_found_by_its_name(self):
        with tempfile.TemporaryDirectory() as folder:
            tree = pathlib.Path(folder)
            for name in ("new/room/a.cc", "new/b.cc", "old/b.cc"):
                (tree / name).parent.mkdir(parents=True, exist_ok=True)
                (tree / name).write_text("")
            self.assertEqual(LIST.file_of({"file": "old/a.cc"}, tree), tree / "new/room/a.cc")
            self.assertEqual(LIST.file_of({"file": "old/b.cc"}, tree), tree / "old/b.cc")
            self.assertIsNone(LIST.file_of({"file": "gone/b.cc"}, tree))


if __name__ == "__main__":
    unittest.main()
