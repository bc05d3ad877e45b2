"""The Python of README.md, docs/python.md and docs/datasets.md runs as it stands there: blocks that
need a package, where that is installed."""
import importlib.util
import pathlib
import re
import sys
import unittest

from support import Case, PROGRAM

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.dont_write_bytecode = True


class DocsTest(Case):
    def test_blocks(self):
        path = ROOT / "scripts/check_docs.py"
        specification = importlib.util.spec_from_file_location("check_docs", path)
        check_docs = importlib.util.module_from_spec(specification)
        specification.loader.exec_module(check_docs)
        pathlib.Path("model.glb").write_bytes(check_docs.cube_glb())
        pathlib.Path("map.pfm").write_bytes(check_docs.sky_pfm())
        self.command("probe", "convert", "map.pfm", "sky.hdr", "--to", "latlong")
        for name in ("README.md", "docs/python.md", "docs/datasets.md"):
            text = (ROOT / name).read_text()
            blocks = re.findall(r"^(?:<!-- not run: needs (\w+) -->\n)?```python\n(.*?)^```", text,
                                re.M | re.S)
            self.assertTrue(blocks, name)
            for needed, block in blocks:
                if needed and importlib.util.find_spec(needed) is None:
                    continue
                line = text[:text.index(block)].count("\n")
                code = "\n" * line + block
                with self.subTest(f"{name}:{line + 1}"):
                    exec(compile(code, name, "exec"), {})


if __name__ == "__main__":
    unittest.main()
