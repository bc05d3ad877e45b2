#!/usr/bin/env python3
"""Tests the comparison with other renderers; with a program as argument also a whole run.

    bench/peers/peers_test.py [build/release/skywave]
"""

import io
import json
import math
import os
import struct
import subprocess
import sys
import tempfile
import unittest
from array import array
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import peers
import pictures
import programs
import scene

PROGRAM = None

TETRAHEDRON = [(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)]


def write_ply(path):
    header = ("ply\nformat binary_little_endian 1.0\nelement vertex 4\n"
              + "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
              + "element face 4\nproperty list uchar int vertex_indices\nend_header\n")
    vertices = b"".join(struct.pack("<6f", *p, 0, 1, 0) for p in TETRAHEDRON)
    faces = b"".join(struct.pack("<B3i", 3, *f) for f in
                     ((0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)))
    path.write_bytes(header.encode() + vertices + faces)


class Outputs(unittest.TestCase):
    def test_cycles(self):
        text = "Fra:1 Mem:50M\npeers: one sample 0.500000\npeers: all samples 3.650000\nquit"
        self.assertAlmostEqual(programs.cycles_seconds(text, 64), 3.2)
        with self.assertRaises(programs.Failed):
            programs.cycles_seconds("peers: one sample 0.5", 64)
        with self.assertRaises(programs.Failed):
            programs.cycles_seconds("peers: one sample 0.5\npeers: all samples 0.4", 64)

    def test_embree(self):
        text = "BENCHMARK_RENDER_MIN 0.2\nBENCHMARK_RENDER_AVG 0.25\nBENCHMARK_RENDER_MAX 0.3\n"
        self.assertEqual(programs.embree_seconds(text), 4)
        with self.assertRaises(programs.Failed):
            programs.embree_seconds("")

    def test_povray(self):
        text = ("Pixels:            19200   Samples:               0   Smpls/Pxl: 0.00\n"
                "  Parse Time:       0 hours  0 minutes  0 seconds (0.840 seconds)\n"
                "  Trace Time:       0 hours  1 minutes  2 seconds (62.074 seconds)\n")
        self.assertEqual(programs.povray_figures(text), (62.074, 19200))
        with self.assertRaises(programs.Failed):
            programs.povray_figures("Parse Time: (1.0 seconds)\nPixels: 1")

    def test_lights_fit_into_eight_bits(self):
        lights = [{"irradiance": [3, 1, 1]}, {"irradiance": [2, 9, 1]}]
        brightest = programs.embree_factor(lights) * 10 * scene.ALBEDO / math.pi
        self.assertLess(brightest, 0.9)  # the rest is for interreflection
        self.assertGreater(brightest, 0.8)


class Figures(unittest.TestCase):
    def test_ratios(self):
        rows = peers.summarize([{"program": "Skywave", "runs": [3, 1, 2], "mse": 0.1},
                                {"program": "Cycles", "runs": [30, 6, 10], "mse": 0.2},
                                {"program": "POV-Ray", "runs": [], "skipped": "not installed"}],
                               1000, 4)
        self.assertEqual(rows[0]["seconds"], 2)
        self.assertAlmostEqual(rows[0]["msamples_per_s"], 0.002)
        self.assertAlmostEqual(rows[1]["skywave_faster"], 6)
        self.assertEqual(rows[1]["skywave_faster_range"], [5, 10])
        self.assertAlmostEqual(rows[1]["skywave_efficiency"], 12)
        self.assertNotIn("seconds", rows[2])

    def test_agreement(self):
        def picture(level):
            return 16, 12, [array("f", [level(x, y) for x in range(16) for _ in range(3)])
                            for y in range(12)]

        even, uneven = picture(lambda x, y: 1), picture(lambda x, y: 2 if x < 2 and y < 2 else 1)
        found = peers.agreement(uneven, even)
        self.assertAlmostEqual(found["worst_block"], 1)
        self.assertAlmostEqual(found["mean_ratio"], 1 + 4 / (16 * 12))
        self.assertEqual(peers.agreement(even, even), {"mean_ratio": 1, "worst_block": 0})


class Pictures(unittest.TestCase):
    def test_levels_are_middles_of_steps(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "a.ppm"
            file.write_bytes(b"P6\n2 1\n255\n" + bytes([0, 10, 32, 255, 128, 1]))
            width, height, rows = pictures.read_ppm(file)
        self.assertEqual((width, height), (2, 1))
        for value, level in zip(rows[0], (0, 10, 32, 255, 128, 1)):
            self.assertAlmostEqual(value, (level + 0.5) / 255, places=6)

    def test_exr_is_read_as_the_program_does(self):
        if PROGRAM is None:
            self.skipTest("no program")
        with tempfile.TemporaryDirectory() as folder:
            exr, pfm, errors = (Path(folder) / name for name in ("a.exr", "a.pfm", "e.json"))
            # Noise is stored uncompressed; the furnace compresses well.
            for name in ("gallery", "furnace"):
                subprocess.run([PROGRAM, "render", name, "--size", "37x21", "--spp", "4", "-q",
                                "-o", exr], check=True)
                picture = pictures.read_exr(exr)
                pictures.write_pfm(pfm, picture)
                subprocess.run([PROGRAM, "compare", pfm, exr, "--json", errors], check=True,
                               stdout=subprocess.DEVNULL)
                self.assertEqual(picture[:2], (37, 21))
                self.assertEqual(json.loads(errors.read_text())["different_pixels"], 0, name)


class Run(unittest.TestCase):
    def test_mirrored_triangles_turn_round(self):
        mesh = scene.blender_mesh([0, 0, 0, 1, 0, 0, 0, 1, 0], [0, 1, 2])
        self.assertEqual(mesh["positions"], [0, 0, 0, 1, 0, 0, 0, 0, 1])
        self.assertEqual(mesh["triangles"], [0, 2, 1])

    def test_absent_programs_are_skipped(self):
        if PROGRAM is None:
            self.skipTest("no program")
        path = os.environ["PATH"]
        with tempfile.TemporaryDirectory() as folder:
            data, out = Path(folder) / "data", Path(folder) / "out"
            (data / "models").mkdir(parents=True)
            (data / "probes" / "latlong").mkdir(parents=True)
            write_ply(data / "models" / "bunny.ply")
            subprocess.run([PROGRAM, "render", "gallery", "--camera", "latlong", "--size", "32x16",
                            "--spp", "1", "-q", "-o",
                            data / "probes" / "latlong" / "grace_latlong.exr"], check=True)
            said = io.StringIO()
            os.environ["PATH"] = folder
            try:
                with redirect_stderr(io.StringIO()), redirect_stdout(said):
                    code = peers.main(["--data", str(data), "--program", PROGRAM, "-o", str(out),
                                       "--size", "24x18", "--samples", "8", "--repeats", "2"])
            finally:
                os.environ["PATH"] = path
            summary = json.loads((out / "peers.json").read_text())
            for job, absent in (("map", "blender"), ("lights", "pathtracer"),
                                ("direct", "povray")):
                rows = next(j for j in summary["jobs"] if j["job"] == job)["rows"]
                self.assertEqual(rows[0]["program"], "Skywave")
                self.assertEqual(len(rows[0]["runs"]), 2)
                self.assertEqual(rows[-1]["skipped"], f"{absent} is not installed")
                self.assertIn(f"skipped: {absent} is not installed", said.getvalue())
                self.assertTrue((out / f"strip_{job}.png").is_file())
        self.assertEqual(code, 0)

    def test_absent_data_are_named(self):
        with tempfile.TemporaryDirectory() as folder:
            said = io.StringIO()
            with redirect_stderr(said), self.assertRaises(SystemExit):
                peers.main(["--data", folder, "--program", sys.executable, "-o", folder])
        self.assertIn("bunny.ply does not exist", said.getvalue())


if __name__ == "__main__":
    if len(sys.argv) > 1 and not sys.argv[1].startswith("-"):
        PROGRAM = sys.argv.pop(1)
    unittest.main()
