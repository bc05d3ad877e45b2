#!/usr/bin/env python3
"""Measures the processor time that Skywave and Cycles take to a picture of a given error.

    bench/peers/time_to_error.py --data DATA -o OUT
    bench/peers/time_to_error.py --data DATA -o OUT --error 0.1 --scenes bunny   # does it work?

Samples are doubled until the relative mean squared error is at most --error: the mean over the
values of all pixels that see surfaces alone of d^2 / (r^2 + 0.01), r the reference. That is the
mean of two renders by Skywave of --reference samples each; what they differ by tells its noise,
which is subtracted. Time is processor time of all threads: of whole commands for Skywave, with
reading files, building tables and writing; for Cycles, in Blender's module bpy, of the render and
its denoiser, without what reads the scene. `skywave` denoises by statistics and by their mean with
Open Image Denoise (best), Cycles by Open Image Denoise. setup.sh installs bpy.

OUT receives time_to_error.md, time_to_error.json and a strip of pictures of each scene: the
reference and what each way had in the end.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import peers
import pictures
import report  # noqa: F401  finds bench/reporting.py
import scene
import skywave_calls
from calling import Failed, Job, in_environment, package_version, run
from estimates import visible
from peers import REFERENCE_SEED, REPOSITORY, say
from python_calls import HERE, write_job
from reporting import lines_of_table, number, processor

FLOOR = 0.01  # of the squared reference, as `skywave compare` has it
COUNTS = [4 << i for i in range(11)]
WAYS = {"Skywave": [], "Skywave, denoised": ["--denoise"],
        "Skywave, best": ["--denoise", "best"], "Cycles": False, "Cycles, OIDN": True}


def relative_mse(values, reference):
    return sum((x - r)**2 / (r * r + FLOOR) for x, r in zip(values, reference)) / len(reference)


class Reference:
    """The mean of two renders, and the error that it still has."""

    def __init__(self, session, job, samples):
        halves = []
        for seed in (REFERENCE_SEED, REFERENCE_SEED + 1):
            kept = session.file(f"{job.name}_{samples}_{seed}.exr")
            if not kept.is_file():
                say(f"reference of {job.name}: {samples} samples a pixel")
                made = skywave_calls.skywave(session, job, seed, samples, layers="coverage")
                os.replace(made["picture"], kept)
            halves.append(pictures.read_exr(kept))
        coverage = pictures.read_exr(kept, ("coverage.V",))[2]
        self.mask = [[value == 1 for value in row] for row in coverage]
        one, two = (visible(half, self.mask) for half in halves)
        self.values = [(a + b) / 2 for a, b in zip(one, two)]
        self.error = relative_mse([a + (a - b) / 2 for a, b in zip(self.values, one)], self.values)
        self.picture = halves[0]

    def error_of(self, file):
        return relative_mse(visible(pictures.read_exr(file), self.mask), self.values) - self.error


def processor_seconds():
    """Returns the processor time of all commands that have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def skywave_series(session, job, flags, patience):
    """Yields samples, processor seconds and the picture."""
    for samples in COUNTS:
        picture = session.file("skywave.exr")
        before = processor_seconds()
        run([session.program, "render", session.file(f"{job.scene}.pbrt"), "--env",
             session.scenes[job.scene].map, "--max-depth", job.depth, "--spp", samples, "--filter",
             "box", "--size", "{}x{}".format(*session.size), "--threads", session.threads, "--seed",
             1, "--no-energy-compensation", "-o", picture, "-q", *flags])
        seconds = processor_seconds() - before
        yield samples, seconds, picture
        if seconds > patience:
            return


def cycles_series(session, job, denoise, patience):
    picture = session.file("cycles.exr")
    file = write_job(session, job, 1, picture, denoise=denoise)
    command = [in_environment("blender")(session.environment), HERE / "blender_series.py", file]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL, text=True, bufsize=1) as process:
        try:
            for samples in COUNTS:
                print(samples, file=process.stdin)
                line = next((one for one in process.stdout if one.startswith("series: ")), None)
                if line is None:
                    raise Failed("bpy has ended")
                seconds = float(line.split()[1])
                yield samples, seconds, picture
                if seconds > patience:
                    return
        finally:
            process.stdin.close()


def measure(session, job, reference, options):
    """Returns {way: samples, seconds and error of the first picture that is good enough, or of the
    last one}, and the pictures."""
    found, shown = {}, [reference.picture]
    for way, how in WAYS.items():
        series = cycles_series if way.startswith("Cycles") else skywave_series
        with closing(series(session, job, how, options.patience)) as pictures_of_way:
            for samples, seconds, picture in pictures_of_way:
                error = reference.error_of(picture)
                say(f"{job.name}: {way}, {samples} samples: {seconds:.2f} s, {error:.5f}")
                found[way] = {"samples": samples, "seconds": seconds, "error": error,
                              "reached": error <= options.error}
                if found[way]["reached"]:
                    break
        shown.append(pictures.read_exr(picture))
    return found, shown


def lines(results):
    """Returns Markdown: seconds and samples of each way, and how far the best of Skywave's is ahead
    of the better one of Cycles."""
    rows = []
    for name, found in results.items():
        cells = []
        for one in found.values():
            cell = f"{number(one['seconds'])} ({one['samples']})"
            cells.append(cell if one["reached"] else f"> {cell}")
        ours, theirs = ([one for way, one in found.items() if way.startswith(program)]
                        for program in ("Skywave", "Cycles"))
        reached = [one["seconds"] for one in ours if one["reached"]]
        known = [one["seconds"] for one in theirs if one["reached"]]
        ahead = "" if not reached else number(
            min(known or [one["seconds"] for one in theirs]) / min(reached))
        rows.append([name, *cells, ahead if known or not ahead else f"> {ahead}"])
    return lines_of_table(["scene", *WAYS, "times ahead"], rows, 1)


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, metavar="DATA")
    parser.add_argument("-o", "--output", type=Path, default=Path("time_to_error"), metavar="OUT")
    parser.add_argument("--program", type=Path, metavar="FILE",
                        default=REPOSITORY / "build" / "release" / "skywave")
    parser.add_argument("--environment", type=Path, default=peers.default_environment(),
                        metavar="FOLDER", help="what setup.sh has made (default: %(default)s)")
    parser.add_argument("--scenes", nargs="+", choices=list(scene.FILES),
                        default=list(scene.FILES))
    parser.add_argument("--error", type=float, default=0.001)
    parser.add_argument("--size", type=int, nargs=2, default=(320, 240), metavar=("W", "H"))
    parser.add_argument("--depth", type=int, default=5, metavar="N", help="surfaces of a path")
    parser.add_argument("--reference", type=int, default=2048, metavar="N",
                        help="samples of each half")
    parser.add_argument("--patience", type=float, default=60, metavar="SECONDS",
                        help="no longer render follows one that took so long (processor time)")
    options = parser.parse_args(arguments)
    options.threads = os.cpu_count()
    return options


def main(arguments):
    options = parse(arguments)
    if in_environment("blender")(options.environment) is None:
        raise Failed("bpy is not there: bench/peers/setup.sh blender")
    jobs = [Job(name, name, name, "path", 0, options.depth, 0) for name in options.scenes]
    session = peers.make_session(options, jobs)
    results = {}
    for job in jobs:
        reference = Reference(session, job, options.reference)
        results[job.name], shown = measure(session, job, reference, options)
        pictures.write_png_strip(session.file(f"strip_{job.name}.png"), shown)
        session.file("time_to_error.json").write_text(json.dumps(
            {"error": options.error, "processor": processor(),
             "bpy": package_version("blender", "bpy")(options.environment),
             "scenes": results}, indent=1) + "\n")
        session.file("time_to_error.md").write_text("\n".join(lines(results)) + "\n")
    print("\n".join(lines(results)))


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except (Failed, ValueError, OSError) as reason:
        say(f"time_to_error.py: {reason}")
        sys.exit(1)
