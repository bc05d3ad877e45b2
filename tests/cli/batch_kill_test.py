#!/usr/bin/env python3
"""Kills skywave batch at random moments, also while it writes, and runs it again each time.

    tests/cli/batch_kill_test.py PROGRAM [--kills N] [--seed S]

In the end every picture has the bytes of a run that nobody killed, and no other file is there.
Prints how far the killed runs had come. Exit code 1: something is missing, torn or left over.
"""
import argparse
import hashlib
import json
import pathlib
import random
import subprocess
import sys
import tempfile
import time

JOB = """
[base]
scene = "spheres"
size = "64x48"
spp = 4
aovs = "all"
[axes]
look = [{ label = "a" }, { label = "b", exposure = 1 }]
seed = "1-10"
[output]
path = "out/{look}/{seed:02}.exr"
"""


def start(program, folder, *flags):
    return subprocess.Popen([program, "batch", "job.toml", "-q", *flags], cwd=folder,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def hashes(folder):
    """The hash of every picture, and the names of all other files."""
    pictures, others = {}, []
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        if path.suffix in (".exr", ".png"):
            pictures[name] = hashlib.sha256(path.read_bytes()).hexdigest()
        elif path.is_file():
            others.append(name)
    return pictures, others


def finish(program, folder):
    """Runs the batch to its end and returns its seconds."""
    begin = time.monotonic()
    process = start(program, folder)
    _, errors = process.communicate(timeout=300)
    if process.returncode != 0:
        sys.exit(f"exit code {process.returncode}: {errors}")
    return time.monotonic() - begin


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    program = options.program.resolve()
    random.seed(options.seed)
    with tempfile.TemporaryDirectory() as scratch:
        whole, killed = pathlib.Path(scratch, "whole"), pathlib.Path(scratch, "killed")
        for folder in (whole, killed):
            folder.mkdir()
            (folder / "job.toml").write_text(JOB)
        seconds = finish(program, whole)
        expected, others = hashes(whole)
        if len(expected) != 40:
            sys.exit(f"there are {len(expected)} pictures, not 40")

        kills = left = torn = 0
        while kills < options.kills:
            # Once all pictures are there, the others are rendered anew.
            flags = ["--force"] if len(hashes(killed)[0]) == len(expected) else []
            process = start(program, killed, *flags)
            time.sleep(random.uniform(0, 1.1 * seconds))
            if process.poll() is not None:
                if process.returncode != 0:
                    sys.exit(f"exit code {process.returncode}: {process.stderr.read()}")
                continue
            process.kill()
            process.communicate()
            kills += 1
            pictures, rest = hashes(killed)
            left += any(name.endswith(".part") for name in rest)
            # What has the name of a picture is the picture, at every moment.
            torn += any(expected[name] != value for name, value in pictures.items())
        finish(program, killed)
        pictures, rest = hashes(killed)
        summary = json.loads((killed / "out/job.batch.json").read_text())
    print(f"{kills} kills, {left} of them while a file was written; a whole run takes "
          f"{seconds:.2f} s")
    problems = []
    if torn:
        problems.append(f"{torn} times a picture was torn")
    if pictures != expected:
        problems.append("other pictures than those of a run that was not killed: " + ", ".join(
            sorted(name for name in expected.keys() | pictures.keys()
                   if expected.get(name) != pictures.get(name))))
    if rest != others:
        problems.append(f"left over: {sorted(set(rest) - set(others))}")
    if summary["rendered"] + summary["skipped"] != 20:
        problems.append("the summary does not tell of all pictures")
    for problem in problems:
        print(problem, file=sys.stderr)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
