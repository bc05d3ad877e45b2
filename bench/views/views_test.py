#!/usr/bin/env python3
"""Tests what views.py measures with and how it compares rows.

    bench/views/views_test.py build/release/skywave
"""
import math
import struct
import sys
import tempfile
import types
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import views  # noqa: E402

PROGRAM = None


class ViewsTest(unittest.TestCase):
    def test_errors_are_relative(self):
        self.assertEqual(views.relative_error([2.0] * 9, [2.0] * 9), 0)
        self.assertAlmostEqual(views.relative_error([2.2, 2.0], [2.0, 2.0]),
                               0.2**2 / (4 + 0.01) / 2)

    def test_eyes_are_around_the_origin_and_above(self):
        eyes = views.eyes_around(20, 4)
        for eye in eyes:
            self.assertAlmostEqual(math.hypot(*eye), 4, delta=1e-3)
            self.assertGreater(eye[1], 0)
        self.assertEqual(len({tuple(eye) for eye in eyes}), 20)

    def test_rows_are_compared_at_no_greater_error(self):
        ours = [("few", 1.0, 2.0, 0.1), ("many", 4.0, 8.0, 0.01)]
        text = views.table(ours, [("slow", 40.0, 80.0, 0.05), ("coarse", 5.0, 9.0, 0.2),
                                  ("clean", 900.0, 1800.0, 0.001)])
        rows = {line.split(" | ")[0][2:]: line.split(" | ") for line in text.splitlines()[2:]}
        self.assertEqual(rows["few"][1], "3600")
        self.assertEqual(rows["slow"][4], "10 times as fast |")
        self.assertEqual(rows["coarse"][4], "5 times as fast |")
        self.assertEqual(rows["clean"][4], "none has it |")

    def test_batches_render_each_eye(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            corners = "v -1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
            (folder / "a.obj").write_text(corners)
            (folder / "white.pfm").write_bytes(
                b"PF\n4 2\n-1\n" + struct.pack("<24f", *[1] * 24))
            given = types.SimpleNamespace(scene=folder / "a.obj", env=folder / "white.pfm", size=8,
                                          field_of_view=30, program=PROGRAM)
            seconds, processor, first = views.Skywave(given, folder).batch(
                "three", views.eyes_around(3, 4), spp=1)
            self.assertEqual(len(list(first.parent.glob("*.exr"))), 3)
            self.assertGreater(seconds, 0)
            self.assertGreater(processor, 0)


if __name__ == "__main__":
    PROGRAM = Path(sys.argv.pop(1)).resolve()
    unittest.main()
