#!/usr/bin/env python3
"""Renders a picture in parts by the Makefile of the examples: the bytes of one render.

    tests/cluster/make_test.py PROGRAM"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.path.abspath(sys.argv.pop(1)) if len(sys.argv) > 1 else None


class Make(unittest.TestCase):
    def make(self, folder):
        done = subprocess.run(
            ["make", "-f", ROOT / "examples/farm.mk", "-j2", f"SKYWAVE={PROGRAM}", "SPP=10",
             "PARTS=3", "SCENE=spheres", "OPTIONS=--size 40x30 --seed 3", "OUTPUT=a.exr"],
            cwd=folder, check=True, capture_output=True, text=True)
        return done.stdout

    def test_parts_make_the_picture(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(self.make(folder).count("--sample-range"), 3)
            subprocess.run([PROGRAM, "render", "spheres", "--size", "40x30", "--seed", "3", "--spp",
                            "10", "-q", "-o", "b.exr"], cwd=folder, check=True)
            path = pathlib.Path(folder)
            self.assertEqual((path / "a.exr").read_bytes(), (path / "b.exr").read_bytes())
            self.assertIn("up to date", self.make(folder))
            (path / "a_parts/2.film").unlink()
            self.assertEqual(self.make(folder).count("--sample-range"), 1)
            self.assertEqual((path / "a.exr").read_bytes(), (path / "b.exr").read_bytes())


if __name__ == "__main__":
    if PROGRAM is None:
        sys.exit(__doc__)
    if shutil.which("make") is None:
        print("skipped: make is not installed")
        sys.exit(77)
    unittest.main()
