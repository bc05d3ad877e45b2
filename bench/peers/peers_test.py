#!/usr/bin/env python3
"""Tests the comparison with other renderers; with a program as argument also whole runs.

    bench/peers/peers_test.py [build/release/skywave]

Every program of the comparison that is installed renders a small scene, whose mean has to be that
of Skywave within the noise.
"""

import io
import json
import math
import os
import random
import shutil
import subprocess
import sys
import tempfile
import unittest
from array import array
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from xml.etree import ElementTree

import calling
import command_calls
import estimates
import formats
import peers
import pictures
import programs
import python_calls
import report
import scene
import time_to_error

PROGRAM = None

COURT = """mtllib court.mtl
v -20 0 -4
v 20 0 -4
v 20 0 4
v -20 0 4
v 20 6 -4
v 20 6 4
v -20 6 -4
v -20 6 4
usemtl floor
f 1 2 3 4
usemtl wall
f -7 -6 -3 -4
f 1 2 5 7
f 4 3 6 8
f 3 3 4
"""
COLORS = "newmtl floor\nKd 0.5 0.25 0.125\nmap_Kd missing.jpg\nnewmtl wall\nKd 0.8 0.8 0.8\n"


def ball(columns=48, lines=24):
    """Returns a ball on the plane, before the camera of the bunny.

    It is finely divided, because programs differ in what they do where the interpolated normal and
    the triangle see different sides.
    """
    normals = [(math.sin(theta) * math.cos(phi), math.cos(theta), math.sin(theta) * math.sin(phi))
               for theta in (math.pi * (i + 0.5) / (lines + 1) for i in range(lines + 1))
               for phi in (2 * math.pi * j / columns for j in range(columns))]
    corners = [(line * columns + i, line * columns + (i + 1) % columns,
                (line + 1) * columns + i, (line + 1) * columns + (i + 1) % columns)
               for line in range(lines) for i in range(columns)]
    faces = scene.flat(((a, b, c), (c, b, d)) for a, b, c, d in corners)
    return scene.Mesh(array("f", (0.07 * x + middle for normal in normals
                                  for x, middle in zip(normal, (-0.016, 0.071, 0)))),
                      array("f", scene.flat(normals)), array("i", scene.flat(faces)))


def smooth_map(width):
    """Returns a lat-long map on which interpolation makes no difference, with no symmetry."""
    lamp = (0.6, 0.7, -0.39)
    rows = []
    for y in range(width // 2):
        theta = math.pi * (y + 0.5) / (width // 2)
        row = array("f")
        for x in range(width):
            phi = 2 * math.pi * ((x + 0.5) / width - 0.5)
            d = (math.sin(theta) * math.sin(phi), math.cos(theta), math.sin(theta) * math.cos(phi))
            glow = 4 * math.exp(6 * (sum(a * b for a, b in zip(d, lamp)) - 1))
            row.extend((0.3 + glow, 0.3 + glow + 0.2 * d[0], 0.5 + 0.4 * d[1]))
        rows.append(row)
    return width, width // 2, rows


def write_data(folder):
    """Writes files that stand for the bunny, Sponza and their maps."""
    (folder / "models").mkdir(parents=True)
    (folder / "probes" / "latlong").mkdir(parents=True)
    (folder / "models" / "bunny.ply").write_bytes(formats.ply_bytes(ball()))
    (folder / "models" / "sponza.obj").write_text(COURT)
    (folder / "models" / "court.mtl").write_text(COLORS)
    pictures.write_pfm(folder / "map.pfm", smooth_map(64))
    for name in ("grace", "galileo"):
        subprocess.run([PROGRAM, "probe", "convert", folder / "map.pfm", "--to", "latlong",
                        folder / "probes" / "latlong" / f"{name}_latlong.exr"], check=True,
                       stdout=subprocess.DEVNULL)


class Outputs(unittest.TestCase):
    def test_cycles(self):
        text = "Fra:1 Mem:50M\npeers: one sample 0.500000\npeers: all samples 3.650000\nquit"
        self.assertAlmostEqual(python_calls.cycles_seconds(text, 64), 3.2)
        with self.assertRaises(calling.Failed):
            python_calls.cycles_seconds("peers: one sample 0.5", 64)
        with self.assertRaises(calling.Failed):
            python_calls.cycles_seconds("peers: one sample 0.5\npeers: all samples 0.4", 64)

    def test_embree(self):
        text = "BENCHMARK_RENDER_MIN 0.2\nBENCHMARK_RENDER_AVG 0.25\nBENCHMARK_RENDER_MAX 0.3\n"
        self.assertEqual(command_calls.embree_seconds(text), 4)
        with self.assertRaises(calling.Failed):
            command_calls.embree_seconds("")

    def test_povray(self):
        text = ("Pixels:            19200   Samples:               0   Smpls/Pxl: 0.00\n"
                "  Parse Time:       0 hours  0 minutes  0 seconds (0.840 seconds)\n"
                "  Trace Time:       0 hours  1 minutes  2 seconds (62.074 seconds)\n")
        self.assertEqual(command_calls.povray_figures(text), (62.074, 19200))
        with self.assertRaises(calling.Failed):
            command_calls.povray_figures("Parse Time: (1.0 seconds)\nPixels: 1")

    def test_luxcore(self):
        text = "peers: seconds 2.5\npeers: samples 125000\n"
        self.assertAlmostEqual(python_calls.luxcore_seconds(text, 100000), 2)
        with self.assertRaises(calling.Failed):
            python_calls.luxcore_seconds("peers: seconds 2.5", 100000)

    def test_lights_fit_into_eight_bits(self):
        lights = [{"irradiance": [3, 1, 1]}, {"irradiance": [2, 9, 1]}]
        brightest = command_calls.embree_factor(lights) * 10 * scene.ALBEDO / math.pi
        self.assertLess(brightest, 0.9)  # the rest is for interreflection
        self.assertGreater(brightest, 0.8)


def small_session(folder, program):
    one = scene.Scene([scene.plane()], (0, 1, 2), (0, 0, 0), scene.UP, 40, Path("map.exr"))
    job = calling.Job("bunny", "", "bunny", "path", 8, 5, 0)
    return calling.Session(program, Path(folder), Path(folder), (8, 6), 1, {"bunny": one},
                           {"bunny": 64}), job


class Inputs(unittest.TestCase):
    def test_files_of_an_earlier_session_are_made_anew(self):
        with tempfile.TemporaryDirectory() as folder:
            for eye in ((0, 1, 2), (3, 4, 5)):
                session, job = small_session(folder, shutil.which("true"))
                session.scenes["bunny"].eye = eye
                for _ in range(2):
                    file = python_calls.write_job(session, job, 1, session.file("a.exr"))
                    self.assertEqual(json.loads(file.read_text())["eye"], [eye[0], eye[2], eye[1]])

    def test_a_file_is_made_once_unless_that_failed(self):
        with tempfile.TemporaryDirectory() as folder:
            session, _ = small_session(folder, shutil.which("true"))
            session.file("a").write_text("old")
            calls = []

            def write(file):
                calls.append(file)
                if len(calls) == 1:
                    raise calling.Failed("once")
                file.write_text("new")

            with self.assertRaises(calling.Failed):
                session.make("a", write)
            for _ in range(2):
                self.assertEqual(session.make("a", write).read_text(), "new")
            self.assertEqual(len(calls), 2)

    def test_programs_that_fail_are_told_with_their_errors(self):
        with tempfile.TemporaryDirectory() as folder:
            session, job = small_session(folder, shutil.which("true"))
            broken = Path(folder) / "obj2mesh"
            broken.write_text("#!/bin/sh\necho half a mesh\necho 'no normals' >&2\nexit 3\n")
            broken.chmod(0o700)
            with self.assertRaisesRegex(calling.Failed, "^obj2mesh: no normals$"):
                command_calls.prepare_radiance(session, job, folder, {})


def outcome(variance, mse):
    return {"mean": 0, "mean_error": None, "mse": mse, "variance": variance, "bias2": None,
            "bias2_error": None}


class Figures(unittest.TestCase):
    def test_ratios(self):
        rows = peers.summarize(
            [{"program": "Skywave", "runs": [3, 1, 2], "samples": 4, "estimate": outcome(.1, .1)},
             {"program": "Cycles", "runs": [30, 6, 10], "samples": 4,
              "estimate": outcome(.2, .3)},
             {"program": "POV-Ray", "runs": [], "samples": 4, "skipped": "not installed"},
             {"program": "Mitsuba", "runs": [2, 0.5, 1], "samples": 2,
              "estimate": outcome(.15, .3)}], 1000)
        self.assertEqual(rows[0]["seconds"], 2)
        self.assertAlmostEqual(rows[0]["msamples_per_s"], 0.002)
        self.assertAlmostEqual(rows[1]["skywave_faster"], 6)
        self.assertEqual(rows[1]["skywave_faster_range"], [5, 10])
        self.assertAlmostEqual(rows[1]["time_variance"], 12)
        self.assertAlmostEqual(rows[1]["time_mse"], 18)
        self.assertNotIn("seconds", rows[2])
        self.assertEqual(report.ahead({"jobs": [{"job": "bunny", "rows": rows}]}),
                         ["- Mitsuba is ahead of Skywave in bunny: noise of equal samples, time x "
                          "variance."])
        self.assertAlmostEqual(rows[3]["skywave_faster"], 1)

    def test_noise_and_bias_are_told_apart(self):
        """Three repeats with noise 0.2 and an offset of 0.1 up here, down there."""
        source = random.Random(7)
        truth = [1 + 0.5 * (i % 3) for i in range(30000)]
        offset = [0.1 if i % 2 else -0.1 for i in range(30000)]
        repeats = [[t + o + source.gauss(0, 0.2) for t, o in zip(truth, offset)]
                   for _ in range(3)]
        found = estimates.estimate(repeats, truth)
        level = 1.5
        self.assertAlmostEqual(found.mean, 0, delta=4 * found.mean_error)
        self.assertAlmostEqual(found.variance, (0.2 / level) ** 2, delta=0.02 * 0.2 ** 2)
        self.assertAlmostEqual(found.mse, (0.1 ** 2 + 0.2 ** 2) / level ** 2, delta=5e-4)
        self.assertAlmostEqual(found.bias2, (0.1 / level) ** 2, delta=4 * found.bias2_error)
        self.assertLess(found.bias2_error, 2e-4)
        self.assertFalse(estimates.bias(found)[1])

    def test_no_bias_is_a_limit(self):
        """Independent of the number of repeats; the reference has noise of its own."""
        source = random.Random(8)
        truth = [1 + source.gauss(0, 0.05) for _ in range(30000)]
        for k in (2, 4):
            repeats = [[1 + source.gauss(0, 0.2) for _ in truth] for _ in range(k)]
            found = estimates.estimate(repeats, truth, 0.05 ** 2)
            self.assertAlmostEqual(found.bias2, 0, delta=3 * found.bias2_error)
            value, is_limit = estimates.bias(found)
            self.assertTrue(is_limit)
            self.assertLess(value, 0.05)

    def test_means_may_vary_more_than_pixels(self):
        repeats = [[1 + 0.1 * offset] * 3000 for offset in (-1, 0, 1)]
        found = estimates.estimate(repeats, [1.0] * 3000)
        self.assertAlmostEqual(found.mean_error, 0.1 / math.sqrt(3))

    def test_one_repeat_has_an_error_only(self):
        found = estimates.estimate([[2.0, 4.0]], [1.0, 3.0])
        self.assertEqual((found.mse, found.mean, found.variance, found.bias2), (0.25, 0.5, None,
                                                                                None))

    def test_visible_pixels(self):
        picture = 2, 2, [array("f", [1, 2, 3, 4, 5, 6]), array("f", [7, 8, 9, 10, 11, 12])]
        values = estimates.visible(picture, [[False, True], [True, False]])
        self.assertEqual(values.tolist(), [4, 5, 6, 7, 8, 9])


class TimeToError(unittest.TestCase):
    def test_errors_are_relative_to_the_place(self):
        # 0.1^2 / (1 + 0.01) and 0.1^2 / 0.01
        error = time_to_error.relative_mse([1.1, 0.1], [1, 0])
        self.assertAlmostEqual(error, (0.01 / 1.01 + 1) / 2)

    def test_the_best_of_both_programs_is_compared(self):
        def way(seconds, samples, reached=True):
            return {"samples": samples, "seconds": seconds, "error": 0, "reached": reached}

        both = {"Skywave": way(8, 64), "Skywave, denoised": way(2, 8),
                "Skywave, best": way(4, 4, False), "Cycles": way(90, 512, False),
                "Cycles, OIDN": way(30, 128)}
        neither = {**both, "Cycles, OIDN": way(80, 512, False)}
        none_of_ours = {name: {**one, "reached": False} for name, one in both.items()}
        row, lower, empty = time_to_error.lines(
            {"a": both, "b": neither, "c": none_of_ours})[-3:]
        self.assertEqual(row, "| a | 8 (64) | 2 (8) | > 4 (4) | > 90 (512) | 30 (128) | 15 |")
        self.assertTrue(lower.endswith("| > 80 (512) | > 40 |"), lower)
        self.assertTrue(empty.endswith("|  |"), empty)


class Scenes(unittest.TestCase):
    def test_placed_meshes_are_scaled_and_then_moved_up(self):
        mesh = scene.placed(scene.Mesh(array("f", [1, 2, 3]), array("f"), array("i")), 2, 0.5)
        self.assertEqual(list(mesh.positions), [2, 4.5, 6])

    def test_ply_goes_round(self):
        mesh = ball()
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "a.ply"
            for normals in (mesh.normals, array("f")):
                mesh.normals = normals
                file.write_bytes(formats.ply_bytes(mesh))
                self.assertEqual(scene.read_ply(file), mesh)

    def test_polygons_become_triangles_of_their_material(self):
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "court.obj").write_text(COURT)
            (Path(folder) / "court.mtl").write_text(COLORS)
            floor, wall = scene.read_obj(Path(folder) / "court.obj")
        self.assertEqual(floor.material.color, (0.5, 0.25, 0.125))
        self.assertEqual(len(floor.triangles), 6)
        self.assertEqual(len(wall.triangles), 18)  # the one without area is dropped
        self.assertEqual(sorted(set(floor.positions[2::3])), [-4, 4])
        a, b, c = (floor.positions[3 * i:3 * i + 3] for i in floor.triangles[:3])
        # Counter-clockwise of the file would look down; the mirror leaves the side as it was.
        self.assertEqual([a[0], b[0], c[0]], [-20, 20, 20])
        self.assertEqual([a[2], b[2], c[2]], [4, -4, 4])

    def test_mirrored_triangles_turn_round(self):
        mesh = scene.Mesh(array("f", [0, 0, 0, 1, 0, 0, 0, 1, 0]), array("f"),
                          array("i", [0, 1, 2]))
        one = scene.Scene([mesh], (1, 2, 3), (0, 0, 0), scene.UP, 40, Path("a.exr"))
        turned = scene.for_right_handed(one)
        self.assertEqual(turned.meshes[0].positions.tolist(), [0, 0, 0, 1, 0, 0, 0, 0, 1])
        self.assertEqual(turned.meshes[0].triangles.tolist(), [0, 2, 1])
        self.assertEqual((turned.eye, turned.up), ((1, 3, 2), (0, 0, 1)))

    def test_files_are_well_formed(self):
        metal = ball()
        metal.material = scene.COPPER
        one = scene.Scene([scene.plane(), metal], (0, 1, 2), (0, 0, 0), scene.UP, 40,
                          Path("map.exr"))
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            read = json.loads(formats.write_json(folder, "a", one).read_text())
            self.assertEqual([mesh["smooth"] for mesh in read["meshes"]], [False, True])
            self.assertEqual([mesh["material"]["alpha"] for mesh in read["meshes"]], [None, 0.2])
            for mesh, expected in zip(read["meshes"], scene.for_right_handed(one).meshes):
                self.assertEqual(scene.read_ply(Path(mesh["file"])).positions, expected.positions)
            formats.write_embree(folder / "a.xml", one)
            meshes = ElementTree.parse(folder / "a.xml").getroot().findall("TriangleMesh")
            self.assertEqual([len(mesh.find("triangles").text.split()) for mesh in meshes],
                             [6, 3 * 48 * 24 * 2])
            for stem in formats.write_radiance(folder, "a", one, "map.hdr"):
                lines = (folder / f"{stem}.obj").read_text().split("\n")
                corners = [line for line in lines if line.startswith("f ")]
                self.assertEqual(len(corners), 2 if stem == "a_0" else 48 * 24 * 2)


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


@unittest.skipIf(len(sys.argv) < 2 or sys.argv[1].startswith("-"), "no program")
class Run(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.kept = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.kept.name)
        write_data(cls.folder / "data")

    @classmethod
    def tearDownClass(cls):
        cls.kept.cleanup()

    def options(self, *more):
        return ["--data", str(self.folder / "data"), "--program", PROGRAM, "-o",
                str(self.folder / "out"), "--size", "24x18", "--samples", "8", "--repeats", "2",
                *more]

    def test_absent_programs_are_skipped(self):
        path, said = os.environ["PATH"], io.StringIO()
        os.environ["PATH"] = self.kept.name
        try:
            with redirect_stderr(io.StringIO()), redirect_stdout(said):
                code = peers.main(self.options("--environment", self.kept.name))
        finally:
            os.environ["PATH"] = path
        summary = json.loads((self.folder / "out" / "peers.json").read_text())
        for job in summary["jobs"]:
            rows = {row["program"]: row for row in job["rows"]}
            self.assertEqual(len(rows["Skywave"]["runs"]), 2)
            self.assertGreater(rows["Skywave"]["estimate"]["variance"], 0)
            absent = [p for p in programs.PROGRAMS if job["job"] in p.jobs and p.absent]
            self.assertTrue(absent)
            for program in absent:
                self.assertEqual(rows[program.name]["skipped"], program.absent)
                self.assertIn(f"| {program.name} | skipped: {program.absent} |", said.getvalue())
            self.assertTrue((self.folder / "out" / f"strip_{job['job']}.png").is_file())
        self.assertEqual(code, 0)

    def test_references_belong_to_their_scene_and_map(self):
        data = self.folder / "changing"
        write_data(data)
        options = peers.parse(self.options("--data", str(data), "--jobs", "bunny,sponza", "-o",
                                           str(self.folder / "kept")))
        jobs = peers.make_jobs(options)
        session = peers.make_session(options, jobs)
        self.assertEqual(peers.make_session(options, jobs).hashes, session.hashes)
        probe, model = (data / file for file in (scene.FILES["bunny"][1], scene.FILES["sponza"][0]))
        probe.write_bytes(probe.read_bytes() + b"\0")
        other_map = peers.make_session(options, jobs)
        self.assertNotEqual(other_map.hashes["bunny"], session.hashes["bunny"])
        self.assertEqual(other_map.hashes["sponza"], session.hashes["sponza"])
        model.write_text(COURT.replace("v 20 6 4\n", "v 20 7 4\n"))
        other_model = peers.make_session(options, jobs)
        self.assertEqual(other_model.hashes["bunny"], other_map.hashes["bunny"])
        self.assertNotEqual(other_model.hashes["sponza"], session.hashes["sponza"])
        with redirect_stderr(io.StringIO()):
            for one in (session, session, other_map):
                peers.reference(one, jobs[0], 4)
        self.assertEqual(len(list((self.folder / "kept").glob("bunny_reference_*"))), 2)

    def test_file_of_pbrt_is_the_same_scene(self):
        """Skywave reads pbrt-v4's files, so map, camera and materials can be compared."""
        options = peers.parse(self.options("--size", "48x36"))
        jobs = peers.make_jobs(options)[:3]
        session = peers.make_session(options, jobs)
        for job in jobs:
            truth, mask = peers.reference(session, job, 256)
            picture = session.file("v4.exr")
            calling.run([PROGRAM, "render", command_calls.write_pbrt_job(session, job), "--strict",
                         "--no-energy-compensation", "--spp", 256, "--seed", 5, "-q", "-o",
                         picture])
            found = estimates.estimate([estimates.visible(pictures.read(picture), mask)],
                                       estimates.visible(truth, mask))
            self.assertLess(abs(found.mean), 0.01, job.name)
            self.assertLess(found.mse, 0.003, job.name)

    def test_programs_agree(self):
        """Means within the noise, which two repeats give, and 1 % for metals that differ."""
        # At depth 2 a surface more or less would show.
        options = peers.parse(self.options("--size", "48x36", "--samples", "64", "--depth", "2"))
        jobs = peers.make_jobs(options)
        session = peers.make_session(options, jobs)
        for program in programs.PROGRAMS[1:]:
            if program.find(session.environment) is None:
                print(f"skipped: {program.absent}", file=sys.stderr)
                continue
            # The grey bunny shows nothing that the copper one and its grey plane do not.
            for job in [job for job in jobs if job.name in program.jobs][-2:]:
                with self.subTest(program=program.name, job=job.name):
                    truth, mask = peers.reference(session, job, 1024)
                    values = [estimates.visible(peers.read_picture(
                        program.measure(session, job, seed)), mask)
                        for seed in range(1, 3 if program.has_seeds else 2)]
                    found = estimates.estimate(values, estimates.visible(truth, mask))
                    self.assertLess(abs(found.mean), 0.01 + 4 * (found.mean_error or 0))

    def test_absent_data_are_named(self):
        with tempfile.TemporaryDirectory() as folder:
            said = io.StringIO()
            with redirect_stderr(said), self.assertRaises(SystemExit):
                peers.main(["--data", self.kept.name + "/none", "--program", sys.executable, "-o",
                            folder])
        self.assertIn("bunny.ply does not exist", said.getvalue())


if __name__ == "__main__":
    if len(sys.argv) > 1 and not sys.argv[1].startswith("-"):
        PROGRAM = sys.argv.pop(1)
    unittest.main()
