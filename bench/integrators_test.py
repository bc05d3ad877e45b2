#!/usr/bin/env python3
"""Tests bench/integrators.py: the figures of its table, and a run on a small picture.

    bench/integrators_test.py PROGRAM
"""
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
FOLDER = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER))
import integrators  # noqa: E402

PROGRAM = None


def contestant(error, seconds, biased=False, squared_bias=0.0):
    """A contestant whose first budget must not count."""
    return {"budgets": [{"error": 77, "seconds": 77, "biased": True, "squared_bias": 77},
                        {"error": error, "seconds": seconds, "biased": biased,
                         "squared_bias": squared_bias}]}


class Integrators(unittest.TestCase):
    def test_a_cell_is_the_factor_of_work_at_the_same_error(self):
        # Half the error in a quarter of the time of path: an eighth of its work.
        path = contestant(0.04, 2.0)
        self.assertEqual(integrators.cell(path, contestant(0.02, 0.5)), "8")
        self.assertEqual(integrators.cell(path, contestant(0.4, 2.0)), "0.1")
        self.assertEqual(integrators.cell(path, contestant(0.02, 2.0, True, 0.005)),
                         "2 (25 % bias)")
        # An estimate of no bias may be negative.
        self.assertEqual(integrators.cell(path, contestant(0.02, 2.0, True, -0.001)),
                         "2 (0 % bias)")

    def test_the_table_compares_all_with_the_first(self):
        others = [contestant(0.04 / factor, 2.0) for factor in range(2, 8)]
        text = integrators.table({"room": {"strategies": [contestant(0.04, 2.0), *others]}})
        head, line, row = text.splitlines()
        self.assertEqual(row, "| room | an interior, one window | 0.04 | 2 |"
                              " 2 | 3 | 4 | 5 | 6 | 7 |")
        self.assertEqual({head.count("|"), line.count("|"), row.count("|")}, {row.count("|")})
        names = [cell.strip() for cell in head.strip("|").split("|")][4:]
        self.assertEqual(names, [f"`{name}`" for name in integrators.INTEGRATORS[1:]])

    def test_a_run_measures_every_integrator(self):
        with tempfile.TemporaryDirectory() as scratch:
            folder = pathlib.Path(scratch) / "out"
            done = subprocess.run(
                [sys.executable, "-B", FOLDER / "integrators.py", "--program", PROGRAM,
                 "-o", folder, "--scenes", "three-spheres", "--size", "16x12", "--depth", "2",
                 "--time", "0.001", "--repeats", "2", "--reference-spp", "2", "--sheet"],
                capture_output=True, text=True, timeout=200, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            row = done.stdout.splitlines()[-1]
            self.assertTrue(row.startswith("| three-spheres | caustics of the sun | "), done.stdout)
            self.assertEqual(row.count("|"), 5 + len(integrators.INTEGRATORS) - 1)
            width, height, _ = integrators.read_png(folder / "sheet.png")
            self.assertEqual((width, height), (16 * len(integrators.INTEGRATORS), 12))


if __name__ == "__main__":
    PROGRAM = str(pathlib.Path(sys.argv.pop(1)).resolve())
    unittest.main()
