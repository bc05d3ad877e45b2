#!/usr/bin/env python3
"""Tests bench/leaks.py: a closed room is dark, and one without a triangle is not.

    bench/leaks_test.py build/release/skywave
"""

import argparse
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import leaks  # noqa: E402

PROGRAM = None
SIDE = 200  # of the picture [pixels]


class Leaks(unittest.TestCase):
    def lit(self, suffix, missing):
        args = argparse.Namespace(program=PROGRAM, rays=1e6, integrator="path")
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            leaks.write_room(folder / "room.ply", missing)
            leaks.write_instances(folder / "room.pbrt", "room.ply")
            rays, lit, _ = leaks.count(args, "avx2", folder / f"room.{suffix}", SIDE)
            self.assertGreater(rays, 5e5)
            return lit

    def test_a_closed_room_is_dark(self):
        self.assertEqual(self.lit("ply", 0), 0)
        self.assertEqual(self.lit("pbrt", 0), 0)

    def test_a_room_with_a_hole_is_not(self):
        self.assertGreater(self.lit("ply", 1), 0)
        self.assertGreater(self.lit("pbrt", 1), 0)


if __name__ == "__main__":
    PROGRAM = sys.argv.pop(1)
    unittest.main()
