#!/usr/bin/env python3
"""Tests scripts/load_bench.py: its mesh, and a run on a small one.

    tests/cli/load_bench_test.py PROGRAM
"""
import array
import importlib.util
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

PROGRAM = None
SCRIPT = pathlib.Path(__file__).resolve().parent.parent.parent / "scripts" / "load_bench.py"
SPEC = importlib.util.spec_from_file_location("load_bench", SCRIPT)
load_bench = importlib.util.module_from_spec(SPEC)
sys.dont_write_bytecode = True
SPEC.loader.exec_module(load_bench)


class LoadBench(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_script(self, *arguments):
        return subprocess.run([sys.executable, "-B", SCRIPT, *arguments], capture_output=True,
                              text=True, timeout=120, check=False)

    def test_the_mesh_is_a_hilly_square(self):
        side = 5
        load_bench.write_ply(str(self.folder / "a.ply"), side)
        self.assertEqual(os.listdir(self.folder), ["a.ply"])
        header, _, data = (self.folder / "a.ply").read_bytes().partition(b"end_header\n")
        self.assertIn(b"element vertex 25\n", header)
        self.assertIn(b"element face 32\n", header)
        vertices = array.array("f", data[:25 * 12])
        self.assertEqual(len(data), 25 * 12 + 32 * 13)
        self.assertEqual(set(vertices[0::3]), {0, 0.25, 0.5, 0.75, 1})
        self.assertLessEqual(max(map(abs, vertices[1::3])), 0.0501)
        self.assertGreater(max(vertices[1::3]) - min(vertices[1::3]), 0.02)
        # All triangles turn the same way and cover the unit square once.
        areas = []
        for face in range(32):
            record = data[25 * 12 + 13 * face:25 * 12 + 13 * (face + 1)]
            self.assertEqual(record[0], 3)
            (ax, _, az), (bx, _, bz), (cx, _, cz) = (
                vertices[3 * corner:3 * corner + 3] for corner in array.array("i", record[1:]))
            areas.append(((bx - ax) * (cz - az) - (bz - az) * (cx - ax)) / 2)
        self.assertEqual({abs(area) for area in areas}, {1 / 32})
        self.assertEqual(abs(sum(areas)), 1)

    def test_a_run_tells_triangles_and_memory(self):
        done = self.run_script(str(self.folder), "0.002", PROGRAM)
        self.assertEqual(done.returncode, 0, done.stderr)
        # The greatest square with no more than 2000 triangles has 31 squares a side.
        self.assertIn("triangles 1922, ", done.stdout)
        bytes_of = json.loads((self.folder / "hills_32.json").read_text())["bytes"]
        peak, times = map(float, re.search(r"peak (\d+) MiB: ([\d.]+) times both", done.stdout)
                          .groups())
        both = (bytes_of["bvh"] + bytes_of["meshes"]) / 2**20
        # Both numbers are rounded.
        self.assertLessEqual(abs(times * both - peak), 0.5 + 0.005 * both)
        mesh = self.folder / "hills_32.ply"
        os.utime(mesh, (1, 1))
        self.assertEqual(self.run_script(str(self.folder), "0.002", PROGRAM).returncode, 0)
        self.assertEqual(mesh.stat().st_mtime, 1)  # it is kept

    def test_without_a_folder_it_tells_how_it_is_called(self):
        done = self.run_script()
        self.assertEqual(done.returncode, 64)
        self.assertIn("usage: scripts/load_bench.py FOLDER", done.stdout)


if __name__ == "__main__":
    PROGRAM = str(pathlib.Path(sys.argv.pop(1)).resolve())
    unittest.main()
