#!/usr/bin/env python3
"""Compares the speed of two git revisions, or of two programs, by alternating runs.

    scripts/bench_compare.py BASE [NEW]              revisions; NEW: HEAD
    scripts/bench_compare.py --programs A B          programs that are built already

Builds each revision in a worktree of its own, runs `skywave bench --renders-only` in the order
A B B A A B B A ..., so that a drift of the machine meets both alike, and prints the median over
pairs of time(NEW) / time(BASE) with a bootstrap confidence interval of 95 %. Fails (exit code 1) only
when the whole interval lies beyond the threshold: noise may hide a slow-down, it never invents one.
"""

import argparse
import json
import math
import os
import random
import statistics
import subprocess
import sys
import tempfile

BOOTSTRAPS = 10000


def build(revision, folder, jobs):
    subprocess.run(["git", "worktree", "add", "--detach", "--quiet", folder, revision], check=True)
    subprocess.run(["cmake", "--preset", "release"], cwd=folder, check=True,
                   stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", "build/release", f"-j{jobs}", "--target", "skywave", "--",
                    "--quiet"], cwd=folder, check=True, stdout=sys.stderr)
    return os.path.join(folder, "build/release/skywave")


def run(program, arguments):
    """Median render seconds of every scene, by name."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "bench.json")
        result = subprocess.run([program, "bench", "--renders-only", *arguments, "--json", path],
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if result.returncode != 0:
            sys.exit(f"{program}: no score (exit code {result.returncode})\n{result.stderr}")
        with open(path, encoding="utf-8") as file:
            scenes = json.load(file)["scenes"]
    return {scene["name"]: statistics.median(scene["repetitions"]["render"]) for scene in scenes}


def pair_ratio(a, b):
    """Geometric mean over scenes of b / a."""
    return math.exp(statistics.fmean(math.log(b[name] / a[name]) for name in a))


def bootstrap_interval(ratios, seed=1):
    """95 % interval of the median: percentiles of the medians of resampled pairs."""
    generator = random.Random(seed)
    medians = sorted(statistics.median(generator.choices(ratios, k=len(ratios)))
                     for _ in range(BOOTSTRAPS))
    return medians[int(0.025 * BOOTSTRAPS)], medians[int(0.975 * BOOTSTRAPS) - 1]


def is_slower(interval, threshold_percent):
    return interval[0] > 1 + threshold_percent / 100


def measure(programs, pairs, arguments):
    """Times of each pair: [(times of A, times of B), ...] in the order A B B A."""
    results = []
    for index in range(pairs):
        order = (0, 1) if index % 2 == 0 else (1, 0)
        times = [None, None]
        for which in order:
            times[which] = run(programs[which], arguments)
        results.append(tuple(times))
        print(f"pair {index + 1}: {pair_ratio(*times):.4f}", file=sys.stderr)
    return results


def report(results, threshold_percent):
    ratios = [pair_ratio(a, b) for a, b in results]
    interval = bootstrap_interval(ratios)
    for name in results[0][0]:
        scene = [b[name] / a[name] for a, b in results]
        low, high = bootstrap_interval(scene)
        print(f"{name:<14} {statistics.median(scene):.4f}  [{low:.4f}, {high:.4f}]")
    slower = is_slower(interval, threshold_percent)
    print(f"COMPARE ratio={statistics.median(ratios):.4f} low={interval[0]:.4f} "
          f"high={interval[1]:.4f} pairs={len(ratios)} threshold={threshold_percent:g}% "
          f"result={'slower' if slower else 'passed'}")
    return 1 if slower else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("base", help="revision, or program with --programs")
    parser.add_argument("new", nargs="?", default="HEAD")
    parser.add_argument("--programs", action="store_true", help="base and new are programs")
    parser.add_argument("--pairs", type=int, default=10, help="runs of each (default: 10)")
    parser.add_argument("--threshold", type=float, default=5,
                        help="percent that new may be slower (default: 5)")
    parser.add_argument("--jobs", type=int, default=2, help="of the builds (default: 2)")
    parser.add_argument("bench", nargs="*", metavar="-- BENCH_FLAG", help="for skywave bench")
    arguments = parser.parse_args()
    if arguments.pairs < 3:
        parser.error("an interval wants at least 3 pairs")
    if arguments.programs:
        programs = [os.path.abspath(arguments.base), os.path.abspath(arguments.new)]
        return report(measure(programs, arguments.pairs, arguments.bench), arguments.threshold)
    with tempfile.TemporaryDirectory() as folder:
        trees = [os.path.join(folder, name) for name in ("base", "new")]
        try:
            programs = [build(revision, tree, arguments.jobs)
                        for revision, tree in zip((arguments.base, arguments.new), trees)]
            return report(measure(programs, arguments.pairs, arguments.bench),
                          arguments.threshold)
        finally:
            for tree in trees:
                subprocess.run(["git", "worktree", "remove", "--force", tree],
                               stderr=subprocess.DEVNULL, check=False)


if __name__ == "__main__":
    sys.exit(main())
