#!/usr/bin/env python3
"""Renders batches on a real Slurm cluster of one node, whose daemons are this test's own processes.

    tests/cluster/slurm_test.py PROGRAM

Pictures and parts of pictures are array jobs; one task is stopped in the middle, as before a
preemption, and has to go on from its checkpoint. The files have the bytes of a local render."""

import glob
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import slurm_cluster

PROGRAM = os.path.abspath(sys.argv.pop(1)) if len(sys.argv) > 1 else None

JOB = """[base]
scene = "spheres"
size = "{size}"
spp = {spp}
threads = 1
[axes]
seed = [1, 2]
[output]
path = "{folder}/{{seed}}.exr"
"""


def read(path):
    with open(path, "rb") as file:
        return file.read()


def processes(word):
    """Returns the ids of the processes of the program that have this word."""
    found = []
    for path in glob.glob("/proc/[0-9]*/cmdline"):
        try:
            words = read(path).decode(errors="replace").split("\0")
        except OSError:
            continue
        if words[0] == PROGRAM and word in words:
            found.append(int(path.split("/")[2]))
    return found


def catches_stop(process):
    """Returns whether a process has come so far that SIGTERM makes it save a checkpoint."""
    try:
        status = read(f"/proc/{process}/status").decode()
    except OSError:
        return False
    caught = int(status.split("SigCgt:")[1].split()[0], 16)
    return bool(caught >> (signal.SIGTERM - 1) & 1)


class Slurm(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory(prefix="sw")
        cls.cluster = slurm_cluster.Cluster(cls.scratch.name + "/cluster")
        cls.cluster.__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.cluster.__exit__()
        cls.scratch.cleanup()

    def setUp(self):
        self.folder = os.path.join(self.scratch.name, self._testMethodName)
        os.makedirs(self.folder)

    def path(self, name):
        return os.path.join(self.folder, name)

    def skywave(self, *arguments):
        subprocess.run([PROGRAM, *arguments], cwd=self.folder, check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)

    def write_job(self, name, folder, size, spp):
        with open(self.path(name), "w", encoding="ascii") as file:
            file.write(JOB.format(size=size, spp=spp, folder=folder))

    def submit(self):
        """Submits the batch as a user does. Returns what submit.sh prints."""
        done = subprocess.run([self.path("farm/submit.sh"), "--cpus-per-task=1"], check=True,
                              env=self.cluster.environment, capture_output=True, text=True)
        return done.stdout

    def logs(self):
        return "".join(f"--- {path}\n{read(path).decode()}\n"
                       for path in sorted(glob.glob(self.path("farm/logs/*"))))

    def finish(self):
        """Waits for the end of all jobs, and expects them to have succeeded."""
        states = self.cluster.wait_for_end()
        mine = {i: s for i, s in states.items() if self.is_mine(i)}
        self.assertEqual(set(mine.values()), {"COMPLETED"}, f"{mine}\n{self.logs()}")
        return mine

    def is_mine(self, task):
        return task.split("_")[0] in self.jobs

    def remember(self, line):
        self.assertRegex(line, r"^submitted \d+, then \d+\n$")
        words = line.replace(",", "").split()
        self.jobs = {words[1], words[3]}
        return words[1]

    def wait_until(self, ready):
        end = time.monotonic() + 60
        while not ready():
            self.assertLess(time.monotonic(), end, self.cluster.logs())
            time.sleep(0.05)
        time.sleep(0.3)

    def stop(self, task):
        """Does what Slurm does before a preemption or the end of the time."""
# It may fail although the signal has arrived, because it asks again while the task ends, or
        # reach the task twice.
        self.cluster.run("scancel", "--batch", "--signal=TERM", task, check=False)

    def restarts(self, task):
        text = self.cluster.run("scontrol", "show", "job", task)[1]
        return int(text.split("Restarts=")[1].split()[0])

    def expect_local_bytes(self, size, spp):
        self.write_job("local.toml", "local", size, spp)
        self.skywave("batch", "local.toml", "-q")
        for seed in (1, 2):
            self.assertEqual(read(self.path(f"out/{seed}.exr")),
                             read(self.path(f"local/{seed}.exr")))

    def merged_pairs(self):
        return read(self.path("farm/logs/finish.txt")).decode().count("merged 2 films")

    def test_parts_of_pictures_are_stopped_go_on_and_are_merged(self):
        # A part takes longer than Slurm needs to stop it, also beside other tests.
        size, spp = "160x120", 2000
        self.write_job("job.toml", "out", size, spp)
        self.skywave("batch", "job.toml", "--slurm", "farm", "--shards", "2")
        array = self.remember(self.submit())
        self.assertRegex(self.submit(), "^is queued already: ")
        stopped = array + "_2"
        self.wait_until(lambda: any(catches_stop(p) for p in processes("1000:2000")))
        self.stop(stopped)
        self.finish()
        self.assertGreaterEqual(self.restarts(stopped), 1)
        log = read(self.path("farm/logs/render_2.txt")).decode()
        self.assertIn("keeps what is rendered", log)
        self.assertEqual(glob.glob(self.path("farm/parts/*.checkpoint")), [])
        parts = sorted(glob.glob(self.path("farm/parts/*.film")))
        self.assertEqual(len(parts), 4)
        self.assertEqual(self.merged_pairs(), 2)
        self.expect_local_bytes(size, spp)
        # What is there is neither rendered nor merged again; the batch knows the merged pictures.
        files = parts + glob.glob(self.path("out/*.exr"))
        times = [os.stat(path).st_mtime_ns for path in files]
        self.remember(self.submit())
        self.finish()
        self.assertEqual([os.stat(path).st_mtime_ns for path in files], times)
        self.assertEqual(self.merged_pairs(), 2)

    def test_pictures_are_stopped_and_go_on(self):
        size, spp = "160x120", 400
        self.write_job("job.toml", "out", size, spp)
        self.skywave("batch", "job.toml", "--slurm", "farm")
        array = self.remember(self.submit())
        stopped = array + "_1"
        self.wait_until(lambda: any(catches_stop(p) for p in processes("1/2")))
        self.stop(stopped)
        self.finish()
        self.assertGreaterEqual(self.restarts(stopped), 1)
        self.assertIn("goes on from here", read(self.path("farm/logs/render_1.txt")).decode())
        self.expect_local_bytes(size, spp)


if __name__ == "__main__":
    if PROGRAM is None:
        sys.exit(__doc__)
    reason = slurm_cluster.why_not()
    if reason is not None:
        print(f"skipped: {reason}")
        sys.exit(77)
    unittest.main()
