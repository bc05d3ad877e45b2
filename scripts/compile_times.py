#!/usr/bin/env python3
"""Builds the program from nothing, without a compiler cache, and prints what compiles how long.

    scripts/compile_times.py [--preset PRESET] [--target TARGET]... [--jobs N] [--units N]

The build is made in build/compile_times and removed. Times are processor seconds (user and system)
of the compiler and the linker, so that other work on the machine changes them little. They are
printed by folder, and with --units for the N units that take longest. Needs CMake and Ninja.
"""
import argparse
import collections
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = ROOT / "build" / "compile_times"


def launch(log, command):
    """Runs a compiler, and adds its processor seconds and its output file to the log."""
    status = subprocess.call(command)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    output = command[command.index("-o") + 1] if "-o" in command else "?"
    with open(log, "a", encoding="utf-8") as lines:
        lines.write(f"{used.ru_utime + used.ru_stime:.3f} {output}\n")
    return status


def folder(output):
    """Returns what a file of the build belongs to, as "scene" or "tests/scene"."""
    if output.endswith((".gch", ".pch")):
        return "precompiled headers"
    parts = re.split(r"CMakeFiles/[^/]+\.dir/", output)
    if len(parts) == 1:
        return "linking"
    if "/Unity/unity_" in output:  # a folder that is compiled as one, such as scene_pbrt
        return parts[1].removeprefix("Unity/unity_").split("_")[0]
    inside = [part for part in pathlib.PurePath(parts[0] + parts[1]).parts[:-1] if part != "/"]
    if "__" in inside or not inside:
        return "other"
    return "/".join(inside[:2] if inside[0] == "tests" else inside[:1])


def main():
    if len(sys.argv) > 3 and sys.argv[1] == "--launch":
        return launch(sys.argv[2], sys.argv[3:])
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--preset", default="program")
    parser.add_argument("--target", action="append", help="default: skywave, the program")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--units", type=int, default=0)
    options = parser.parse_args()

    shutil.rmtree(BUILD, ignore_errors=True)
    BUILD.mkdir(parents=True)
    log = BUILD / "times"
    launcher = f"{sys.executable};-S;{pathlib.Path(__file__).resolve()};--launch;{log}"
    subprocess.run(["cmake", "--preset", options.preset, "-B", BUILD,
                    f"-DCMAKE_CXX_COMPILER_LAUNCHER={launcher}",
                    f"-DCMAKE_CXX_LINKER_LAUNCHER={launcher}"],
                   cwd=ROOT, stdout=subprocess.DEVNULL, check=True)
    began = time.monotonic()
    subprocess.run(["cmake", "--build", BUILD, f"-j{options.jobs}", "--target",
                    *(options.target or ["skywave"]), "--", "--quiet"],
                   env={**os.environ, "CCACHE_DISABLE": "1"}, check=True)
    wall = time.monotonic() - began
    used = resource.getrusage(resource.RUSAGE_CHILDREN)

    units = [(float(line.split(" ", 1)[0]), line.split(" ", 1)[1])
             for line in log.read_text(encoding="utf-8").splitlines()]
    sums, counts = collections.Counter(), collections.Counter()
    for seconds, output in units:
        sums[folder(output)] += seconds
        counts[folder(output)] += 1
    print("| folder | units | processor s |\n| --- | --- | --- |")
    for name, seconds in sums.most_common():
        print(f"| {name} | {counts[name]} | {seconds:.0f} |")
    print(f"| all, with CMake and Ninja | {len(units)} | {used.ru_utime + used.ru_stime:.0f} |")
    print(f"\n{wall:.0f} s of wall time with {options.jobs} jobs")
    for seconds, output in sorted(units, reverse=True)[:options.units]:
        print(f"{seconds:7.2f} {re.sub('CMakeFiles/[^/]+[.]dir/', '', output)}")
    shutil.rmtree(BUILD)
    return 0


if __name__ == "__main__":
    sys.exit(main())
