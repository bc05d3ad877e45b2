#!/usr/bin/env python3
"""Measures Skywave and other renderers on the same work.

    bench/peers/peers.py --data DATA -o OUT
    bench/peers/peers.py --data DATA -o OUT --size 80x60 --samples 8 --repeats 2   # does it work?

Scenes are described once, in scene.py: the grey bunny on a grey plane, the same bunny of rough
copper, and the court of Sponza, lit by maps of DATA. Jobs, not all of which every program supports:

    bunny   path tracing of the grey bunny                  Cycles, Mitsuba, LuxCore, pbrt, Radiance
    metal   path tracing of the copper bunny                Cycles, Mitsuba, LuxCore, pbrt
    sponza  path tracing inside Sponza, light from above    as bunny
    lights  the bunny under directional lights of the map   Embree's tutorial `pathtracer`
    direct  camera and shadow rays to these lights          POV-Ray

OUT receives peers.md, peers.json, a strip of pictures of every job (the reference first) and all
files that the programs were given. Programs that are not there are reported as skipped; setup.sh
installs those that come as Python packages. Exit code 1: a program failed.
"""

import argparse
import hashlib
import json
import os
import sys
from dataclasses import asdict, replace
from datetime import date
from pathlib import Path
from statistics import median

import estimates
import formats
import pictures
import report  # finds bench/reporting.py
import scene
import skywave_calls
from calling import Failed, Job, Session, run
from programs import PROGRAMS
from reporting import processor

REPOSITORY = Path(__file__).resolve().parents[2]
LIGHTS = 4
REFERENCE_SEED = 1000003  # no repeat uses it
DEFAULTS = {"jobs": "bunny,metal,sponza,lights,direct", "programs": None}


def default_environment():
    """Returns the folder that setup.sh uses."""
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return Path(os.environ.get("SKYWAVE_PEERS") or cache / "skywave-peers")


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, metavar="DATA",
                        help="folder of models and probes")
    parser.add_argument("-o", "--output", type=Path, default=Path("peers"), metavar="OUT")
    parser.add_argument("--program", type=Path, metavar="FILE",
                        default=REPOSITORY / "build" / "release" / "skywave")
    parser.add_argument("--environment", type=Path, metavar="FOLDER",
                        default=default_environment(),
                        help="what setup.sh has made (default: %(default)s)")
    parser.add_argument("--size", default="640x480", metavar="WxH")
    parser.add_argument("--samples", type=int, default=64, metavar="N",
                        help="a pixel (a quarter of it with lights)")
    parser.add_argument("--depth", type=int, default=5, metavar="N", help="surfaces of a path")
    parser.add_argument("--repeats", type=int, default=3, metavar="N")
    parser.add_argument("--reference", type=int, metavar="N",
                        help="samples a pixel of the references (default: 32 times --samples)")
    parser.add_argument("--references", action="store_true",
                        help="make the references only, whose time does not matter")
    parser.add_argument("--threads", type=int, default=0, help="0: as many as there are")
    parser.add_argument("--jobs", default=DEFAULTS["jobs"], metavar="NAME,...")
    parser.add_argument("--programs", metavar="NAME,...",
                        help="beginnings of the names of programs to measure besides Skywave")
    options = parser.parse_args(arguments)
    try:
        options.size = tuple(map(int, options.size.split("x")))
        width, height = options.size
    except ValueError:
        parser.error("--size is two numbers, such as 640x480")
    if min(width, height, options.depth, options.repeats) < 1 or options.samples < 8:
        parser.error("--size, --depth and --repeats are at least 1, --samples at least 8")
    if width < height:
        parser.error("--size is at least as wide as it is high: some programs count the field of "
                     "view on the upright side, others on the shorter one")
    options.reference = options.reference or 32 * options.samples
    jobs = make_jobs(options)
    if len(jobs) != len(options.jobs.split(",")):
        parser.error("--jobs are bunny, metal, sponza, lights and direct")
    for file in (options.program,
                 *(options.data / file for job in jobs for file in scene.FILES[job.scene])):
        if not file.is_file():
            parser.error(f"{file} does not exist")
    return options


def say(text):
    print(text, file=sys.stderr, flush=True)


def make_jobs(options):
    few = max(options.samples // 4, 1)
    jobs = [Job("bunny", "Path tracing of a grey bunny under Grace", "bunny", "path",
                options.samples, options.depth, 0),
            Job("metal", "Path tracing of a bunny of copper, GGX of width 0.2, under Grace",
                "metal", "path", options.samples, options.depth, 0),
            Job("sponza", "Path tracing inside Sponza, which Galileo lights through its openings",
                "sponza", "path", options.samples, options.depth, 0),
            Job("lights", f"The grey bunny under {LIGHTS} directional lights, all at every surface",
                "bunny", "path", few, options.depth, LIGHTS),
            Job("direct", f"Its camera rays and shadow rays to {LIGHTS} directional lights",
                "bunny", "direct", 1, options.depth, LIGHTS)]
    return [job for job in jobs if job.name in options.jobs.split(",")]


def hash_of(text, files):
    """Returns a hash of `text` and of the contents of `files`."""
    parts = [text.encode(), *(file.read_bytes() for file in files)]
    return hashlib.sha256(b"".join(hashlib.sha256(part).digest() for part in parts)).hexdigest()


def make_session(options, jobs):
    data, folder = options.data.resolve(), options.output.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    described = {name: scene.make(name, data) for name in {job.scene for job in jobs}}
    session = Session(options.program.resolve(), folder, options.environment.resolve(),
                      options.size, options.threads or os.cpu_count(), described,
                      {name: pictures.exr_width(one.map) for name, one in described.items()})
    version = run([session.program, "--version"])
    for name, one in described.items():
        files = formats.write_pbrt(folder, name, one)
        session.hashes[name] = hash_of(version, [*files, one.map])
    if any(job.lights for job in jobs):
        run([session.program, "probe", "lights", described["bunny"].map, "--method", "median-cut",
             "-n", LIGHTS, "--position", "centroid", "--format", "json", "-o",
             session.file("lights.json")])
        session.lights = json.loads(session.file("lights.json").read_text())["lights"]
    return session


def read_picture(result):
    picture = pictures.read(result["picture"])
    return pictures.scaled(picture, result["exposure"]) if "exposure" in result else picture


def reference(session, job, samples):
    """Returns the picture of Skywave with many samples, and which pixels see surfaces alone.

    It is kept under a name that says what it depends on.
    """
    kept = session.file("{}_reference_{}x{}_{}x{}_{}.exr".format(
        job.name, *session.size, samples, job.depth, session.hashes[job.scene][:16]))
    if not kept.is_file():
        say(f"reference of {job.name}: {samples} samples a pixel")
        made = skywave_calls.skywave(session, job, REFERENCE_SEED, samples, layers="coverage")
        os.replace(made["picture"], kept)
    coverage = pictures.read_exr(kept, ("coverage.V",))[2]
    return pictures.read_exr(kept), [[value == 1 for value in row] for row in coverage]


def summarize(rows, pixels):
    """Adds rates and ratios to rows with `runs` and `estimate`, relative to the row of Skywave.

    Ratios of times are taken within the pairs of one repeat, so that a slow minute affects both.
    """
    for row in rows:
        if not row.get("skipped"):
            row["seconds"] = median(row["runs"])
            row["msamples_per_s"] = pixels * row["samples"] / row["seconds"] / 1e6
    ours = next((row for row in rows if row["program"] == "Skywave" and not row.get("skipped")),
                None)
    for row in rows:
        if ours and not row.get("skipped"):
            pairs = sorted(theirs / mine for theirs, mine in zip(row["runs"], ours["runs"]))
            rates = [pair * ours["samples"] / row["samples"] for pair in pairs]
            row["skywave_faster"] = median(rates)
            row["skywave_faster_range"] = [rates[0], rates[-1]]
            mine, theirs, time = ours["estimate"], row["estimate"], median(pairs)
            row["time_mse"] = time * theirs["mse"] / mine["mse"]
            if theirs["variance"] is not None and mine["variance"]:
                row["time_variance"] = time * theirs["variance"] / mine["variance"]
                row["sample_variance"] = (theirs["variance"] * row["samples"]
                                          / (mine["variance"] * ours["samples"]))
    return rows


def chosen(program, job, options):
    names = (options.programs or "").split(",")
    return job.name in program.jobs and (program.name.startswith("Skywave")
                                         or any(program.name.startswith(name) for name in names))


def measure_job(session, job, options):
    """Returns the rows of a job; the programs take turns in every repeat."""
    truth, mask = reference(session, job, options.reference)
    true_values = estimates.visible(truth, mask)
    able = [program for program in PROGRAMS if chosen(program, job, options)]
    rows = [{"program": program.name, "runs": [],
             "samples": max(round(program.share * job.samples), 2 if job.samples > 1 else 1),
             "version": program.version(session.environment)} for program in able]
    values, last = [[] for _ in able], {}
    for program, row in zip(able, rows):
        if program.find(session.environment) is None:
            row["skipped"] = program.absent
    for repeat in range(options.repeats):
        for program, row, kept in zip(able, rows, values):
            if row.get("skipped"):
                continue
            try:
                result = program.measure(session, replace(job, samples=row["samples"]),
                                         repeat + 1)
                row["runs"].append(result["seconds"])
                last[program.name] = read_picture(result)
                if repeat == 0 or program.has_seeds:
                    kept.append(estimates.visible(last[program.name], mask))
                if "rays_per_sample" in result:
                    row["rays_per_sample"] = result["rays_per_sample"]
                say(f"{job.name}: {program.name} {result['seconds']:.2f} s")
            except Failed as reason:
                row["skipped"] = row["failed"] = str(reason)
                say(f"{job.name}: {program.name} failed: {reason}")
    if rows[0].get("failed"):
        raise Failed(rows[0]["failed"])
    # The reference is Skywave's own, so its variance is that of the first row with more samples.
    own = estimates.estimate(values[0], true_values)
    variance = (own.variance or 0) * job.samples / options.reference
    for row, kept in zip(rows, values):
        if not row.get("skipped"):
            row["estimate"] = asdict(estimates.estimate(kept, true_values, variance))
    pictures.write_png_strip(session.file(f"strip_{job.name}.png"),
                             [truth] + [last[row["program"]] for row in rows
                                        if not row.get("skipped")])
    return summarize(rows, session.size[0] * session.size[1])


def command_of(options):
    """Returns the command that repeats the measurement, without the folders of this machine."""
    more = "".join(f" --{name} {value}" for name, value in (
        ("jobs", options.jobs), ("programs", options.programs)) if value != DEFAULTS[name])
    return ("bench/peers/peers.py --data DATA -o OUT --size {}x{} --samples {} --depth {} "
            "--repeats {} --reference {}{}").format(*options.size, options.samples, options.depth,
                                                    options.repeats, options.reference, more)


def main(arguments):
    options = parse(arguments)
    jobs = make_jobs(options)
    session = make_session(options, jobs)
    if options.references:
        for job in jobs:
            reference(session, job, options.reference)
        return 0
    summary = {
        "schema": "skywave-peers-2",
        "settings": {"command": command_of(options), "date": date.today().isoformat(),
                     "processor": processor(), "threads": session.threads,
                     "size": "{}x{}".format(*options.size), "repeats": options.repeats,
                     "reference": f"Reference: Skywave, {options.reference} samples a pixel, "
                     "without control. Box filter of one pixel everywhere."},
        "programs": [{"name": p.name, "version": p.version(session.environment),
                      "settings": p.settings, "timing": p.timing} for p in PROGRAMS
                     if any(chosen(p, job, options) for job in jobs)], "jobs": []}
    for job in jobs:
        summary["jobs"].append({"job": job.name, "title": job.title, "samples": job.samples,
                                "rows": measure_job(session, job, options)})
        session.file("peers.json").write_text(json.dumps(summary, indent=1) + "\n")
        session.file("peers.md").write_text(report.markdown(summary))
    print(report.markdown(summary), end="")
    return any("failed" in row for job in summary["jobs"] for row in job["rows"])


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except (Failed, ValueError, OSError) as reason:
        say(f"peers.py: {reason}")
        sys.exit(1)
