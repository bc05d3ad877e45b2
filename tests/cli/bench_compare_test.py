"""Tests scripts/bench_compare.py with programs that only pretend to render, so that no time is
measured."""

import importlib.util
import os
import pathlib
import stat
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parent.parent.parent / "scripts" / "bench_compare.py"
SPEC = importlib.util.spec_from_file_location("bench_compare", SCRIPT)
bench_compare = importlib.util.module_from_spec(SPEC)
sys.dont_write_bytecode = True
SPEC.loader.exec_module(bench_compare)

# This stub writes the times of two scenes, `factor` times those of the base, with some noise by run
# number, and logs its name. `stage` scales the time of "light sample" relative to the base.
STUB = """#!{python}
import json, os, sys
folder = os.path.dirname(os.path.abspath(__file__))
log = os.path.join(folder, "log")
count = len(open(log).read().split()) if os.path.exists(log) else 0
open(log, "a").write("{name} ")
noise = 1 + {noise} * ((count * 7) % 5 - 2) / 2
if {fails}:
    sys.exit(1)
seconds = [{factor} * noise * x for x in (1.0, 1.0, 50.0)]
stages = {{name: [0.1 * s for s in seconds] for name in ("generate", "shadow", "scatter", "film")}}
stages["light sample"] = [0.01 * {stage} * s for s in seconds]
stages["idle"] = [0, 0, 0]
scenes = [{{"name": name, "repetitions": {{"render": seconds, "stages": stages}}}}
          for name in ("one", "two")]
json.dump({{"scenes": scenes}}, open(sys.argv[sys.argv.index("--json") + 1], "w"))
"""


class BenchCompare(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def stub(self, name, factor, noise=0.0, stage=1.0, fails=False):
        path = os.path.join(self.folder.name, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(STUB.format(python=sys.executable, name=name, factor=factor, noise=noise,
                                   stage=stage, fails=fails))
        os.chmod(path, os.stat(path).st_mode | stat.S_IXUSR)
        return path

    def compare(self, *arguments):
        return subprocess.run([sys.executable, str(SCRIPT), "--programs", *arguments],
                              capture_output=True, text=True, check=False)

    def test_runs_alternate(self):
        self.compare(self.stub("a", 1), self.stub("b", 1), "--pairs", "4")
        with open(os.path.join(self.folder.name, "log"), encoding="utf-8") as log:
            self.assertEqual(log.read().split(), list("abbaabba"))

    def test_slower_fails(self):
        result = self.compare(self.stub("a", 1), self.stub("b", 1.2, 0.02), "--pairs", "6")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("result=slower: render\n", result.stdout)

    def test_a_slower_stage_fails_though_noise_hides_it_in_the_whole(self):
        result = self.compare(self.stub("a", 1, 0.2), self.stub("b", 1, 0.2, stage=1.1),
                              "--pairs", "5")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("result=slower: light sample\n", result.stdout)

    def test_a_stage_that_stays_while_all_others_gain_is_not_slower(self):
        result = self.compare(self.stub("a", 1), self.stub("b", 0.8, stage=1.25), "--pairs", "4")
        self.assertEqual(result.returncode, 0, result.stdout)
        self.assertIn("light sample   1.2500  [1.2500, 1.2500]   1.0000", result.stdout)

    def test_faster_same_and_a_little_slower_pass(self):
        for factor in (0.5, 1, 1.04):
            result = self.compare(self.stub("a", 1), self.stub("b", factor), "--pairs", "4")
            self.assertEqual(result.returncode, 0, result.stdout)
            self.assertIn(f"ratio={factor:.4f} low={factor:.4f}", result.stdout)

    def test_noise_that_reaches_below_the_threshold_passes(self):
        result = self.compare(self.stub("a", 1), self.stub("b", 1.08, 0.2), "--pairs", "5")
        self.assertEqual(result.returncode, 0, result.stdout)

    def test_no_score_is_an_error_and_not_a_result(self):
        result = self.compare(self.stub("a", 1), self.stub("b", 1, fails=True), "--pairs", "3")
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("no score", result.stderr)
        self.assertNotIn("COMPARE", result.stdout)

    def test_interval_is_that_of_the_median(self):
        low, high = bench_compare.bootstrap_interval([1.0, 1.1, 1.2, 1.3, 9.0])
        self.assertEqual(low, 1.0)
        self.assertGreaterEqual(high, 1.3)
        self.assertEqual(bench_compare.bootstrap_interval([2.0] * 5), (2.0, 2.0))
        self.assertTrue(bench_compare.is_slower((1.06, 1.2), 5))
        self.assertFalse(bench_compare.is_slower((1.04, 1.2), 5))


if __name__ == "__main__":
    unittest.main()
