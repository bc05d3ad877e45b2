#!/usr/bin/env python3
"""Compares the speed of two git revisions, or of two programs, by alternating runs.

    scripts/bench_compare.py BASE [NEW]              revisions; NEW: HEAD
    scripts/bench_compare.py --programs A B          programs that are built already

Builds each revision in a separate worktree, runs `skywave bench --renders-only` in the order
A B B A A B B A ..., so that a drift of the machine affects both equally, and prints the median over
pairs of time(NEW) / time(BASE), for the render and for every stage, with bootstrap confidence
intervals of 95 %. Fails (exit code 1) only if a whole interval lies beyond the threshold: noise may
hide a slow-down, but it never invents one.

A stage is judged against the others: a slow-down of all stages in one run is due to the machine, so
the ratio of a stage is divided by the median ratio of all stages in the same pair. That removes
most of the noise and detects 10 % of a small stage, which the total time would never show. If most
stages have become faster, the others look slower by this measure; so the plain median of a stage
has to exceed the threshold as well.
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

BOOTSTRAPS = 2000
WHOLE = "render"  # its wall clock; every other part is a stage, summed over threads


def build(revision, folder, jobs):
    subprocess.run(["git", "worktree", "add", "--detach", "--quiet", folder, revision], check=True)
    subprocess.run(["cmake", "--preset", "release"], cwd=folder, check=True,
                   stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", "build/release", f"-j{jobs}", "--target", "skywave", "--",
                    "--quiet"], cwd=folder, check=True, stdout=sys.stderr)
    return os.path.join(folder, "build/release/skywave")


def run(program, arguments):
    """Returns the least seconds of every scene, by name: of the render (WHOLE) and of every stage.
    Other load on a machine only ever adds to a time, so the minimum repeats best."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "bench.json")
        result = subprocess.run([program, "bench", "--renders-only", *arguments, "--json", path],
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if result.returncode != 0:
            sys.exit(f"{program}: no score (exit code {result.returncode})\n{result.stderr}")
        with open(path, encoding="utf-8") as file:
            scenes = json.load(file)["scenes"]
    return {scene["name"]: {part: min(seconds) for part, seconds in
                            [(WHOLE, scene["repetitions"]["render"]),
                             *scene["repetitions"]["stages"].items()]}
            for scene in scenes}


def pair_ratios(a, b):
    """Returns geometric means over scenes of b / a, by part, without parts that take no time."""
    return {part: math.exp(statistics.fmean(math.log(b[name][part] / a[name][part]) for name in a))
            for part in next(iter(a.values()))
            if all(times[name][part] > 0 for times in (a, b) for name in a)}


def against_the_others(ratios):
    """Returns ratios of stages over the median stage, which leaves each stage's own change."""
    stages = {part: ratio for part, ratio in ratios.items() if part != WHOLE}
    middle = statistics.median(stages.values())
    return {part: ratio / middle for part, ratio in stages.items()}


def bootstrap_interval(ratios, seed=1):
    """Returns the 95 % interval of the median: percentiles of the medians of resampled pairs."""
    generator = random.Random(seed)
    medians = sorted(statistics.median(generator.choices(ratios, k=len(ratios)))
                     for _ in range(BOOTSTRAPS))
    return medians[int(0.025 * BOOTSTRAPS)], medians[int(0.975 * BOOTSTRAPS) - 1]


def is_slower(interval, threshold_percent):
    return interval[0] > 1 + threshold_percent / 100


def measure(programs, pairs, arguments):
    """Returns times of each pair: [(times of A, times of B), ...] in the order A B B A."""
    results = []
    for index in range(pairs):
        order = (0, 1) if index % 2 == 0 else (1, 0)
        times = [None, None]
        for which in order:
            times[which] = run(programs[which], arguments)
        results.append(tuple(times))
        print(f"pair {index + 1}: {pair_ratios(*times)[WHOLE]:.4f}", file=sys.stderr)
    return results


def print_ratios(name, ratios, *more):
    """Prints the median of ratios, its interval and the ratios in `more`; returns the interval."""
    low, high = bootstrap_interval(ratios)
    print(f"{name:<14} {statistics.median(ratios):.4f}  [{low:.4f}, {high:.4f}]",
          *(f"  {ratio:.4f}" for ratio in more))
    return low, high


def report(results, threshold_percent):
    for name in results[0][0]:
        print_ratios(name, [b[name][WHOLE] / a[name][WHOLE] for a, b in results])
    pairs = [pair_ratios(a, b) for a, b in results]
    relative = [against_the_others(ratios) for ratios in pairs]
    slower = []
    print(f"{'stage':<14} against the others        plain")
    for stage in relative[0]:
        interval = print_ratios(stage, [ratios[stage] for ratios in relative],
                                plain := statistics.median(ratios[stage] for ratios in pairs))
        if is_slower(interval, threshold_percent) and is_slower((plain, plain), threshold_percent):
            slower.append(stage)
    whole = [ratios[WHOLE] for ratios in pairs]
    interval = bootstrap_interval(whole)
    if is_slower(interval, threshold_percent):
        slower.insert(0, WHOLE)
    print(f"COMPARE ratio={statistics.median(whole):.4f} low={interval[0]:.4f} "
          f"high={interval[1]:.4f} pairs={len(whole)} threshold={threshold_percent:g}% "
          f"result={'slower: ' + ', '.join(slower) if slower else 'passed'}")
    return 1 if slower else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("base", help="revision, or program with --programs")
    parser.add_argument("new", nargs="?", default="HEAD")
    parser.add_argument("--programs", action="store_true", help="base and new are programs")
    parser.add_argument("--pairs", type=int, default=10, help="runs of each (default: 10)")
    parser.add_argument("--repetitions", type=int, default=9,
                        help="renders of a scene in a run, of which the least counts (default: 9)")
    parser.add_argument("--threshold", type=float, default=5,
                        help="percent that new may be slower (default: 5)")
    parser.add_argument("--jobs", type=int, default=2, help="of the builds (default: 2)")
    parser.add_argument("bench", nargs="*", metavar="-- BENCH_FLAG", help="for skywave bench")
    arguments = parser.parse_args()
    if arguments.pairs < 3:
        parser.error("an interval wants at least 3 pairs")
    flags = ["--repetitions", str(arguments.repetitions), *arguments.bench]
    if arguments.programs:
        programs = [os.path.abspath(arguments.base), os.path.abspath(arguments.new)]
        return report(measure(programs, arguments.pairs, flags), arguments.threshold)
    with tempfile.TemporaryDirectory() as folder:
        trees = [os.path.join(folder, name) for name in ("base", "new")]
        try:
            programs = [build(revision, tree, arguments.jobs)
                        for revision, tree in zip((arguments.base, arguments.new), trees)]
            return report(measure(programs, arguments.pairs, flags), arguments.threshold)
        finally:
            for tree in trees:
                subprocess.run(["git", "worktree", "remove", "--force", tree],
                               stderr=subprocess.DEVNULL, check=False)


if __name__ == "__main__":
    sys.exit(main())
