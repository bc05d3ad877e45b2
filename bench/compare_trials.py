#!/usr/bin/env python3
"""Tries `skywave bench --compare` on a machine: how often does it cry wolf, and how often does it
see a program that is slower?

    bench/compare_trials.py SKYWAVE --pairs 400 --load 1    # another program runs now and then
    bench/compare_trials.py SKYWAVE --pairs 100             # the machine does nothing else

Each pair is two runs of the same program. It is compared as it is, where `slower` is a false alarm,
and with the times of the second run multiplied by 1.1, where it is right.
"""

import argparse
import collections
import json
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SLOWER = 1.1
VERDICTS = {0: "passed", 1: "slower", 2: "cannot tell"}


def load(seed):
    """Uses a processor now and then, for a tenth of a second to two, until it is ended."""
    draw = random.Random(seed)
    while True:
        until = time.monotonic() + draw.uniform(0.1, 2)
        if draw.random() < 0.5:
            while time.monotonic() < until:
                pass
        else:
            time.sleep(max(0, until - time.monotonic()))


def slowed(result, factor):
    """Returns a result whose renders took `factor` times as long."""
    return {**result, "render_seconds": [factor * t for t in result["render_seconds"]]}


def verdict(program, a, b, folder):
    files = folder / "a.json", folder / "b.json"
    for file, result in zip(files, (a, b)):
        file.write_text(json.dumps(result))
    code = subprocess.run([program, "bench", "--compare", *files], stdout=subprocess.DEVNULL,
                          check=False).returncode
    return VERDICTS[code]


def measure(program, folder, scene):
    file = folder / "run.json"
    subprocess.run([program, "bench", *scene.split(), "--renders-only", "--json", file], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return json.loads(file.read_text())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--pairs", type=int, default=100)
    parser.add_argument("--load", type=int, default=0, metavar="N", help="other programs at once")
    parser.add_argument("--scene", default="spheres --size 160x120 --spp 16")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--be-load", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.be_load:
        load(options.seed)
    others = [subprocess.Popen([sys.executable, __file__, options.program, "--be-load",
                                "--seed", str(options.seed + i)]) for i in range(options.load)]
    equal, slower = collections.Counter(), collections.Counter()
    try:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            for _ in range(options.pairs):
                a, b = (measure(options.program, folder, options.scene) for _ in "ab")
                equal[verdict(options.program, a, b, folder)] += 1
                slower[verdict(options.program, a, slowed(b, SLOWER), folder)] += 1
    finally:
        for other in others:
            other.kill()
    for title, counts in (("equal", equal), (f"{SLOWER} times as long", slower)):
        print(f"{title}: " + ", ".join(f"{counts[v]} {v}" for v in VERDICTS.values()))


if __name__ == "__main__":
    main()
