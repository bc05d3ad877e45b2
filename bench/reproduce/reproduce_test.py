#!/usr/bin/env python3
"""Tests the tables and the arithmetic; with a program as argument also the strategies.

    bench/reproduce/reproduce_test.py [build/release/skywave]
"""

import io
import json
import math
import subprocess
import sys
import tempfile
import unittest
from array import array
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import figures
import measure
import moving_map
import page
import report
import reproduce
from reproduce import TABLES
from tables import PLAIN, angle_for_area

PROGRAM = None


class Page(unittest.TestCase):
    def test_a_fit_finds_the_power(self):
        points = [(t, 3 * t ** -1.5) for t in (1, 2, 5, 9)]
        c, k = page.power_fit(points)
        self.assertAlmostEqual(c, 3)
        self.assertAlmostEqual(k, -1.5)
        self.assertIsNone(page.power_fit([(2, 1), (2, 3)]))

    def test_a_chart_has_a_dot_for_each_row(self):
        summary = figures.summarize(TABLES["8.2"], {})
        svg = page.chart(summary, "thesis", "a < b")
        with_errors = [row for row in summary["rows"]
                       if row["thesis"] and "squared_distance" in row["thesis"]]
        self.assertEqual(svg.count('r="3.5"'), len(with_errors))
        self.assertIn("a &lt; b", svg)
        self.assertRegex(svg, r"I\.S\.: [0-9.e+]+ t\^-[0-9.]+")
        self.assertEqual(page.chart(summary, "ours", ""), "")

    def test_a_page_needs_no_network(self):
        with tempfile.TemporaryDirectory() as folder:
            pictures = Path(folder)
            (pictures / "1.png").write_bytes(b"picture")
            summary = figures.summarize(TABLES["8.2"], {})
            text = page.page([page.section(summary, "| a |", pictures)])
        self.assertIn("data:image/png;base64,cGljdHVyZQ==", text)
        self.assertIn("error of row 1: not rendered", text)
        self.assertEqual(text.count("<figure>"), 1)
        self.assertNotRegex(text.replace("http://www.w3.org/2000/svg", ""), "https?://")


class MovingMap(unittest.TestCase):
    def test_columns_move_to_the_left_around_the_sphere(self):
        row = array("f", [x for column in range(4) for x in (column, 0, 0)])
        width, height, rows = moving_map.turn((4, 1, [row]), 5)
        self.assertEqual((width, height), (4, 1))
        self.assertEqual(list(rows[0])[::3], [1, 2, 3, 0])

    def test_a_method_is_measured_over_frames(self):
        if not PROGRAM:
            self.skipTest("no program")
        with tempfile.TemporaryDirectory() as folder:
            map_file = Path(folder) / "map.exr"
            subprocess.run([PROGRAM, "probe", "calibrate", "-o", map_file, "--height", "32"],
                           check=True, stdout=subprocess.DEVNULL)
            output = io.StringIO()
            with redirect_stdout(output):
                moving_map.main(["--data", folder, "-o", folder, "--program", PROGRAM, "--scene",
                                 "spheres", "--up", "y", "--map", "map.exr", "--frames", "3",
                                 "--lights", "6", "--size", "32x24", "--samples", "1",
                                 "--reference", "16", "--methods", "k-means", "follow", "turned"])
        rows = [line.split("|") for line in output.getvalue().splitlines() if line[:3] == "| `"]
        self.assertEqual([row[1].strip() for row in rows], ["`k-means`", "`follow`", "`turned`"])
        for row in rows:
            self.assertEqual(row[2].strip(), "6")
            for value in row[4:7]:
                self.assertGreater(float(value), 0)


class Tables(unittest.TestCase):
    def test_rows_are_those_of_the_thesis(self):
        counts = {name: sum(row.seconds is not None for row in table.rows)
                  for name, table in TABLES.items()}
        self.assertEqual(counts, {"8.2": 48, "8.3": 17, "8.4": 13, "8.5": 7, "8.6": 5,
                                  "8.7": 10, "8.8": 12, "8.9": 10})
        for table in TABLES.values():
            names = [row.name for row in table.rows]
            self.assertEqual(len(names), len(set(names)))
            self.assertTrue(table.row(table.base).plain)
            for row in table.rows:
                self.assertTrue(row.recipe or row.note, row.name)

    def test_area_gives_the_angle(self):
        for area, lights in ((0.331, 72), (0.864, 96), (3.71, 138)):
            angle = math.radians(angle_for_area(area, lights))
            self.assertAlmostEqual(lights * (1 - math.cos(angle / 2)) / 2, area / 100, places=12)

    def test_hybrid_row(self):
        recipe = TABLES["8.2"].row("46").recipe
        self.assertEqual(recipe.strategy,
                         "hybrid:strata=lights,angle=2.17425,from=penrose,lights=96,cluster=F2,"
                         "clusters=64,position=sample,rest=presampled,rest-samples=360")
        self.assertEqual((recipe.samples, recipe.light_samples, recipe.mis), (4, 32, False))

    def test_photon_row(self):
        table = TABLES["8.8"]
        recipe = table.row("11").recipe
        self.assertTrue(recipe.strategy.endswith("rest=presampled,rest-samples=360"))
        self.assertEqual((recipe.samples, recipe.light_samples), (4, 64))
        self.assertEqual(recipe.flags, ["--photons", "100000", "--caustic-photons", "0",
                                        "--gather", 0, "--photon-distance", "1.5"])
        summary = figures.summarize(table, {})
        self.assertNotIn("error", summary["pairs"][0]["thesis"])
        report.markdown(summary)

    def test_lines_are_of_100_columns(self):
        text = "- Row 7: " + "of the thesis " * 20
        lines = report.wrapped(text).split("\n")
        self.assertLessEqual(max(map(len, lines)), 100)
        self.assertTrue(all(line.startswith("  ") for line in lines[1:]))
        self.assertEqual(" ".join(" ".join(lines).split()), text.strip())
        row = "| " + "x" * 200 + " |"
        self.assertEqual(report.wrapped(row), row)

    def test_splitting_row(self):
        recipe = TABLES["8.6"].row("5").recipe
        self.assertEqual((recipe.samples, recipe.split, recipe.light_samples), (8, 63, 8))
        self.assertEqual(recipe.behind, recipe.strategy + ",pick=power")

    def test_compensation_is_one_over_the_light_samples(self):
        for table in TABLES.values():
            for row in table.rows:
                plain = row.recipe and row.recipe.strategy == PLAIN
                if row.recipe and "compensate" in row.recipe.strategy and not plain:
                    share = float(row.recipe.strategy.split("=")[1])
                    recipe = row.recipe
                    self.assertAlmostEqual(
                        share, max(recipe.split, 1) / recipe.light_samples, places=5)


class Figures(unittest.TestCase):
    def test_claim_of_the_thesis(self):
        summary = figures.summarize(TABLES["8.2"], {})
        pair = summary["pairs"][0]
        self.assertAlmostEqual(pair["thesis"]["faster"], 5.72, places=2)
        self.assertNotIn("ours", pair)
        row = next(row for row in summary["rows"] if row["row"] == "46")
        sign, faster = row["thesis_ratios"]["at_equal_error"]
        self.assertEqual(sign, "=")
        self.assertAlmostEqual(faster, 5.09, places=2)

    def test_time_at_an_error(self):
        plain = [{"seconds": s, "e": e} for s, e in ((1, 0.4), (4, 0.1))]
        sign, seconds = figures.seconds_at(0.2, plain, "e")
        self.assertEqual(sign, "=")
        self.assertAlmostEqual(seconds, 2)
        self.assertEqual(figures.seconds_at(0.5, plain, "e"), ("<", 1))
        self.assertEqual(figures.seconds_at(0.05, plain, "e"), (">", 4))
        uneven = [{"seconds": s, "e": e} for s, e in ((1, 4), (2, 2), (4, 8), (8, 1))]
        self.assertGreater(figures.seconds_at(4, uneven, "e")[1], 4)
        self.assertEqual(figures.seconds_at(0.5, uneven, "e"), (">", 8))

    def test_least_squares(self):
        rows = [[1, a, b] for a, b in ((0, 1), (2, 3), (5, 1), (1, 7))]
        found = figures.least_squares(rows, [2 + 3 * a - b for _, a, b in rows])
        for value, expected in zip(found, (2, 3, -1)):
            self.assertAlmostEqual(value, expected)
        self.assertIsNone(figures.least_squares([[1, 2], [1, 2]], [3, 3]))


    def test_noise_of_the_reference_is_taken_off(self):
        run = {"seconds": 1, "table_seconds": 0, "mse": 5, "relative_mse": 1,
               "squared_channel_sum": 1, "thesis_luminance": 1}
        self.assertEqual(figures.ours([run, run], 2)["squared_distance"], 9)


class Report(unittest.TestCase):
    def test_block_is_replaced(self):
        document = "a\n<!-- begin table 8.2 -->\nold\n<!-- end table 8.2 -->\nb\n"
        replaced = report.insert(document, "8.2", r"new \1")
        self.assertNotIn("old", replaced)
        self.assertIn(r"new \1", replaced)
        self.assertEqual(report.insert(replaced, "8.2", r"new \1"), replaced)
        with self.assertRaises(ValueError):
            report.insert(document, "8.3", "new")

    def test_absent_data_are_named(self):
        with tempfile.TemporaryDirectory() as folder:
            said = io.StringIO()
            with redirect_stderr(said), redirect_stdout(io.StringIO()):
                code = reproduce.main(["8.2", "8.5", "--data", folder, "--program", sys.executable,
                                       "-o", folder])
        self.assertEqual(code, 1)
        self.assertIn("table 8.2 is left out", said.getvalue())
        self.assertIn("galileo_latlong.exr does not exist", said.getvalue())
        self.assertIn("nothing was measured", said.getvalue())


class Resume(unittest.TestCase):
    def test_runs_measured_alike_are_kept(self):
        facts = {"version": "1", "mse": 0.5}
        with tempfile.TemporaryDirectory() as folder:
            options = reproduce.parse(["8.2", "--data", folder, "--program", sys.executable, "-o",
                                       folder, "--size", "80x60", "--resume"])
            run = {"seconds": 1, "table_seconds": 0, "mse": 1, "relative_mse": 1,
                   "squared_channel_sum": 1, "thesis_luminance": 1}
            summary = figures.summarize(TABLES["8.2"], {"5": [run, run]})
            summary.update(reference=facts, settings={
                "size": "80x60", "threads": "all", "version": "1",
                "processor": reproduce.processor()})
            file = Path(folder) / "table_8.2.json"
            file.write_text(json.dumps(summary))
            self.assertEqual(reproduce.earlier_runs(TABLES["8.2"], facts, options),
                             {"5": [run, run]})
            with self.assertRaises(measure.Failed):
                reproduce.earlier_runs(TABLES["8.2"], {**facts, "mse": 0.4}, options)
            options.size = "40x30"
            with self.assertRaises(measure.Failed):
                reproduce.earlier_runs(TABLES["8.2"], facts, options)
            options.resume = False
            self.assertEqual(reproduce.earlier_runs(TABLES["8.2"], facts, options), {})


class Program(unittest.TestCase):
    def test_strategies_are_accepted(self):
        if PROGRAM is None:
            self.skipTest("no program")
        recipes = {(strategy, row.recipe.mis, table.integrator)
                   for table in TABLES.values() for row in table.rows if row.recipe
                   for strategy in (row.recipe.strategy, row.recipe.behind) if strategy}
        with tempfile.TemporaryDirectory() as folder:
            for strategy, mis, integrator in sorted(recipes):
                command = [PROGRAM, "render", "furnace", "--size", "2x2", "--spp", "1",
                           "--integrator", integrator, "--strategy", strategy, "-q",
                           "-o", str(Path(folder) / "a.exr")] + ([] if mis else ["--no-mis"])
                result = subprocess.run(command, capture_output=True, text=True)
                self.assertEqual(result.returncode, 0, f"{strategy}: {result.stderr}")


if __name__ == "__main__":
    if len(sys.argv) > 1 and not sys.argv[1].startswith("-"):
        PROGRAM = sys.argv.pop(1)
    unittest.main()
