#!/usr/bin/env python3
"""Measures Skywave and other renderers on the same work.

    bench/peers/peers.py --data DATA -o OUT
    bench/peers/peers.py --data DATA -o OUT --size 80x60 --samples 8 --repeats 1   # does it work?

The scene is the grey bunny on a grey plane (scene.py), DATA/models/bunny.ply under
DATA/probes/latlong/grace_latlong.exr, in three jobs, not all of which every program supports:

    map     path tracing under the map                       Cycles
    lights  path tracing under directional lights of the map Embree's tutorial `pathtracer`
    direct  camera and shadow rays to these lights           POV-Ray

OUT receives peers.md, peers.json, a strip of pictures of every job (the reference first) and all
files that the programs were given. Programs that are not installed are reported as skipped. Exit
code 1: a program failed.
"""

import argparse
import json
import os
import sys
from datetime import date
from pathlib import Path
from statistics import median

import pictures
import programs
import report  # finds bench/reporting.py
import scene
from programs import PROGRAMS, Failed, Job, Session
from reporting import processor

REPOSITORY = Path(__file__).resolve().parents[2]
LIGHTS = 4
BLOCKS = (8, 6)
# The rows above show the environment, which programs leave black in jobs with lights.
HORIZON = 0.3


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, metavar="DATA",
                        help="folder of models and probes")
    parser.add_argument("-o", "--output", type=Path, default=Path("peers"), metavar="OUT")
    parser.add_argument("--program", type=Path, metavar="FILE",
                        default=REPOSITORY / "build" / "release" / "skywave")
    parser.add_argument("--size", default="640x480", metavar="WxH")
    parser.add_argument("--samples", type=int, default=64, metavar="N",
                        help="a pixel (map; a quarter of it with lights)")
    parser.add_argument("--depth", type=int, default=5, metavar="N", help="surfaces of a path")
    parser.add_argument("--repeats", type=int, default=3, metavar="N")
    parser.add_argument("--reference", type=int, metavar="N",
                        help="samples a pixel of the references (default: 32 times --samples)")
    parser.add_argument("--references", action="store_true",
                        help="make the references only, whose time does not matter")
    parser.add_argument("--threads", type=int, default=0, help="0: as many as there are")
    parser.add_argument("--jobs", default="map,lights,direct", metavar="NAME,...")
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
    for file in (options.program, options.data / "models" / "bunny.ply",
                 options.data / "probes" / "latlong" / "grace_latlong.exr"):
        if not file.is_file():
            parser.error(f"{file} does not exist")
    return options


def say(text):
    print(text, file=sys.stderr, flush=True)


def make_jobs(options):
    few = max(options.samples // 4, 1)
    jobs = [Job("map", "Path tracing under the map", "path", options.samples, options.depth, 0),
            Job("lights", f"Path tracing under {LIGHTS} directional lights, all at every surface",
                "path", few, options.depth, LIGHTS),
            Job("direct", f"Camera rays and shadow rays to {LIGHTS} directional lights", "direct",
                1, options.depth, LIGHTS)]
    return [job for job in jobs if job.name in options.jobs.split(",")]


def make_session(options):
    data, folder = options.data.resolve(), options.output.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    probe = data / "probes" / "latlong" / "grace_latlong.exr"
    bunny = data / "models" / "bunny.ply"
    scene.write_pbrt(folder / "bunny.pbrt", bunny)
    programs.run([options.program, "probe", "lights", probe, "--method", "median-cut", "-n", LIGHTS,
                  "--position", "centroid", "--format", "json", "-o", folder / "lights.json"])
    lights = json.loads((folder / "lights.json").read_text())["lights"]
    return Session(options.program, folder, probe, pictures.exr_width(probe),
                   scene.read_ply(bunny), options.size, options.threads, lights)


def read_picture(result, job):
    path = result["picture"]
    picture = pictures.read_ppm(path) if path.suffix == ".ppm" else pictures.read_exr(path)
    if "exposure" in result:
        picture = pictures.scaled(picture, result["exposure"])
    return pictures.lower_part(picture, HORIZON) if job.lights else picture


def reference(session, job, options):
    """Renders the reference with Skywave and a seed that no repeat uses."""
    kept = session.file("{}_reference_{}x{}_{}x{}.exr".format(
        job.name, *session.size, options.reference, job.depth))
    if not kept.is_file():
        say(f"reference of {job.name}: {options.reference} samples a pixel")
        os.replace(programs.skywave(session, job, 1000003, options.reference)["picture"], kept)
    return read_picture({"picture": kept}, job)


def block_means(picture):
    """Returns means over r, g and b of BLOCKS parts of the picture."""
    width, height, rows = picture
    columns, lines = BLOCKS
    sums, counts = [0.0] * (columns * lines), [0] * (columns * lines)
    for y, row in enumerate(rows):
        for column in range(columns):
            part = row[3 * (column * width // columns):3 * ((column + 1) * width // columns)]
            block = y * lines // height * columns + column
            sums[block] += sum(part)
            counts[block] += len(part)
    return [total / count for total, count in zip(sums, counts) if count], sum(sums) / sum(counts)


def agreement(picture, truth):
    """Returns the mean over the reference's, and the largest relative difference of a block."""
    (blocks, whole), (true_blocks, true_whole) = block_means(picture), block_means(truth)
    return {"mean_ratio": whole / true_whole,
            "worst_block": max(abs(a / b - 1) for a, b in zip(blocks, true_blocks))}


def errors(session, picture, truth):
    files = [session.file("picture.pfm"), session.file("reference.pfm")]
    for file, pixels in zip(files, (picture, truth)):
        pictures.write_pfm(file, pixels)
    programs.run([session.program, "compare", *files, "--json", session.file("errors.json")])
    read = json.loads(session.file("errors.json").read_text())
    return {key: read[key] for key in ("mse", "relative_mse")}


def summarize(rows, pixels, samples):
    """Adds rates and ratios to rows with `runs` and errors, relative to the row of Skywave.

    Ratios of times are taken within the pairs of one repeat, so that a slow minute affects both.
    """
    for row in rows:
        if not row.get("skipped"):
            row["seconds"] = median(row["runs"])
            row["msamples_per_s"] = pixels * samples / row["seconds"] / 1e6
    ours = next((row for row in rows if row["program"] == "Skywave" and not row.get("skipped")),
                None)
    for row in rows:
        if ours and not row.get("skipped"):
            pairs = sorted(theirs / mine for theirs, mine in zip(row["runs"], ours["runs"]))
            row["skywave_faster"] = median(pairs)
            row["skywave_faster_range"] = [pairs[0], pairs[-1]]
            row["skywave_efficiency"] = row["skywave_faster"] * row["mse"] / ours["mse"]
    return rows


def measure_job(session, job, options):
    """Returns the rows of a job; the programs take turns in every repeat."""
    truth = reference(session, job, options)
    rows, last = [], {}
    able = [program for program in PROGRAMS if job.name in program.jobs]
    for program in able:
        row = {"program": program.name, "runs": []}
        if not program.is_installed():
            row["skipped"] = f"{program.executable} is not installed"
        rows.append(row)
    for repeat in range(options.repeats):
        for program, row in zip(able, rows):
            if row.get("skipped"):
                continue
            try:
                result = program.measure(session, job, repeat + 1)
                row["runs"].append(result["seconds"])
                last[program.name] = result
                say(f"{job.name}: {program.name} {result['seconds']:.2f} s")
            except Failed as reason:
                row["skipped"] = row["failed"] = str(reason)
                say(f"{job.name}: {program.name} failed: {reason}")
    shown = [truth]
    for row in rows:
        if not row.get("skipped"):
            result = last[row["program"]]
            picture = read_picture(result, job)
            shown.append(picture)
            row.update(errors(session, picture, truth), **agreement(picture, truth))
            if "rays_per_sample" in result:
                row["rays_per_sample"] = result["rays_per_sample"]
    pictures.write_png_strip(session.file(f"strip_{job.name}.png"), shown)
    return summarize(rows, session.size[0] * session.size[1], job.samples)


def command_of(options):
    """Returns the command that repeats the measurement, without the folders of this machine."""
    return ("bench/peers/peers.py --data DATA -o OUT --size {}x{} --samples {} --depth {} "
            "--repeats {} --reference {}").format(*options.size, options.samples, options.depth,
                                                  options.repeats, options.reference)


def main(arguments):
    options = parse(arguments)
    session = make_session(options)
    jobs = make_jobs(options)
    if options.references:
        for job in jobs:
            reference(session, job, options)
        return 0
    summary = {
        "schema": "skywave-peers-1",
        "settings": {"command": command_of(options), "date": date.today().isoformat(),
                     "processor": processor(), "threads": options.threads or os.cpu_count(),
                     "size": "{}x{}".format(*options.size), "repeats": options.repeats,
                     "blocks": "{} x {}".format(*BLOCKS),
                     "reference": f"Reference: Skywave, {options.reference} samples a pixel. Box "
                     "filter of one pixel everywhere. With lights the rows below the horizon are "
                     "compared."},
        "programs": [{"name": p.name, "version": p.version(), "settings": p.settings,
                      "timing": p.timing} for p in PROGRAMS], "jobs": []}
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
