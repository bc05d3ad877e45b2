"""Tests bench/compare_trials.py with a program that only pretends to render, so that no time is
measured."""

import os
import pathlib
import stat
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parent.parent.parent / "bench" / "compare_trials.py"

# Its renders take a second, and three in every fifth run, which it then says it cannot compare.
STUB = """#!{python}
import json, os, sys
log = os.path.join(os.path.dirname(os.path.abspath(__file__)), "log")
if "--compare" in sys.argv:
    a, b = (json.load(open(file))["render_seconds"] for file in sys.argv[3:5])
    sys.exit(2 if max(a + b) > 2 else 1 if sum(b) > 1.05 * sum(a) else 0)
with open(log, "a") as file:
    file.write(" ".join(sys.argv[1:]) + chr(10))
count = len(open(log).readlines())
json.dump({{"render_seconds": [3 if count % 5 == 0 else 1] * 4}},
          open(sys.argv[sys.argv.index("--json") + 1], "w"))
"""


def command_of(process):
    try:
        return (process / "cmdline").read_bytes()
    except OSError:  # it has ended
        return b""


class CompareTrials(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.program = pathlib.Path(self.folder.name) / "program"
        self.program.write_text(STUB.format(python=sys.executable))
        os.chmod(self.program, self.program.stat().st_mode | stat.S_IXUSR)

    def run_trials(self, *arguments):
        return subprocess.run([sys.executable, "-B", SCRIPT, self.program, *arguments],
                              capture_output=True, text=True, check=True, timeout=60).stdout

    def test_each_pair_is_compared_as_it_is_and_slowed_down(self):
        # Of runs 1 to 10 the fifth and the tenth are doubtful: they are in pairs 3 and 5.
        self.assertEqual(self.run_trials("--pairs", "5", "--scene", "some scene --spp 2"),
                         "equal: 3 passed, 0 slower, 2 cannot tell\n"
                         "1.1 times as long: 0 passed, 3 slower, 2 cannot tell\n")
        runs = (pathlib.Path(self.folder.name) / "log").read_text().splitlines()
        self.assertEqual(len(runs), 10)
        for run in runs:
            self.assertRegex(run, r"^bench some scene --spp 2 --renders-only --json \S+$")

    def test_the_load_ends_with_the_trials(self):
        self.assertIn("1 passed", self.run_trials("--pairs", "1", "--load", "2"))
        arguments = os.fsencode(self.program) + b"\0--be-load"
        self.assertEqual([folder for folder in pathlib.Path("/proc").glob("[0-9]*")
                          if arguments in command_of(folder)], [])


if __name__ == "__main__":
    unittest.main()
