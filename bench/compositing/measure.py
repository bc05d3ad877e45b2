#!/usr/bin/env python3
"""Measures composites against the truth: objects that are put into a photograph of a place, beside
the render of place and objects together.

    bench/compositing/measure.py -o OUT
    bench/compositing/measure.py -o OUT --size 96x72 --samples 16 --truth 64   # does it work?
    bench/compositing/measure.py -o OUT --blender PYTHON   # Cycles as well; its Python has bpy

The place is a hall with a table (hall.py). It is rendered from a camera, as the photograph, and
from the middle of the table without the camera, as the light probe. The objects are then put on the
table by the probe and the photograph alone, and compared with the truth in blocks of 8 x 8 pixels:
the table has the median, the 95th percentile and the largest of the relative errors of those blocks
that objects change by 1 % or more. The first row of each table is the render of everything with
other random numbers: the noise. OUT/compositing.png (and .jpg, if cjpeg is installed) shows the
photograph, the composites and the truth of each table from left to right.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path
from statistics import fmean, median

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "peers"))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
sys.path.insert(0, str(Path(__file__).resolve().parent))
import hall  # noqa: E402
from pictures import read_exr, write_png_strip  # noqa: E402
from reporting import lines_of_table, processor  # noqa: E402
from sheet import read_png, write_sheet  # noqa: E402

BLOCK = 8
EXPOSURE = 0.9  # of the strips


def run(*command):
    subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL)


def render(args, scene, output, samples, *flags):
    if not output.exists():
        run(args.program, "render", scene, "--size", args.size, "--spp", samples, "--max-depth", 8,
            "--quiet", "-o", output, *flags)
    return output


def blocks(picture):
    """Returns the mean colour of each block."""
    width, height, rows = picture
    means = []
    for y in range(0, height - BLOCK + 1, BLOCK):
        for x in range(0, width - BLOCK + 1, BLOCK):
            means.append([fmean(value for row in rows[y:y + BLOCK]
                                for value in row[3 * x + c:3 * (x + BLOCK):3]) for c in range(3)])
    return means


def errors(picture, truth, photograph):
    """Returns the relative errors of the blocks that differ from the photograph, ascending."""
    found = []
    for here, right, before in zip(blocks(picture), blocks(truth), blocks(photograph)):
        if max(abs(a / b - 1) for a, b in zip(right, before)) < 0.01:
            continue
        found.append(fmean(abs(a / b - 1) for a, b in zip(here, right)))
    return sorted(found)


def over(picture, alpha, photograph):
    """Returns a picture with alpha, by which its colours are multiplied, over a photograph."""
    width, height, rows = picture
    return width, height, [
        [value + (1 - cover[i // 3]) * behind[i] for i, value in enumerate(row)]
        for row, cover, behind in zip(rows, alpha, photograph[2])]


def composite_of_cycles(args, table, probe, photograph):
    output = args.output / f"{table}_cycles.exr"
    if not output.exists():
        job = args.output / f"{table}_cycles.json"
        width, height = map(int, args.size.split("x"))
        job.write_text(json.dumps(hall.for_blender(table) | {
            "map": str(probe), "picture": str(output), "samples": args.samples,
            "size": [width, height]}))
        run(args.blender, "-B", Path(__file__).resolve().parent / "blender_catcher.py", "--", job)
    alpha = [row[::3] for row in read_exr(output, ("A", "A", "A"))[2]]
    return over(read_exr(output), alpha, photograph)


def measure(args, table):
    out = args.output
    for name in ("place", "all", "objects"):
        (out / f"{table}_{name}.pbrt").write_text(hall.scene(name, table))
    place, everything = out / f"{table}_place.pbrt", out / f"{table}_all.pbrt"
    photograph = render(args, place, out / f"{table}_photograph.exr", args.truth)
    truth = read_exr(render(args, everything, out / f"{table}_truth.exr", args.truth))
    # The last --size counts. The probe is where the middle of the objects will be.
    probe = render(args, place, out / f"{table}_probe.exr", args.probe, "--size",
                   f"{args.probe_width}x{args.probe_width // 2}", "--camera", "latlong", "--eye",
                   "0,0.3,0", "--target", "0,0.3,1")
    flags = ["--env", probe, "--catcher", "table", "--backplate", photograph, "--aovs", "shadow"]
    if table == "matt":
        flags += ["--project", "camera"]
    noise = render(args, everything, out / f"{table}_again.exr", args.samples, "--seed", 7)
    ours = render(args, out / f"{table}_objects.pbrt", out / f"{table}_composite.exr",
                  args.samples, *flags)
    behind = read_exr(photograph)
    names = tuple(f"composite.{c}" for c in "RGB")
    pictures = {"everything rendered again": read_exr(noise), "Skywave": read_exr(ours, names)}
    if args.blender:
        pictures["Cycles"] = composite_of_cycles(args, table, probe, behind)
    rows = []
    for name, picture in pictures.items():
        found = errors(picture, truth, behind)
        rows.append([table, name, str(len(found)), *(f"{100 * error:.2f} %" for error in (
            median(found), found[int(0.95 * len(found))], found[-1]))])
    shown = [picture for name, picture in pictures.items() if name != "everything rendered again"]
    write_png_strip(out / f"{table}.png", [behind, *shown, truth], exposure=EXPOSURE)
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, default=Path("compositing"), metavar="OUT")
    parser.add_argument("--program", type=Path, default=Path("build/release/skywave"))
    parser.add_argument("--size", default="320x240", metavar="WxH")
    parser.add_argument("--samples", type=int, default=512, help="of composites")
    parser.add_argument("--truth", type=int, default=2048, help="samples of truth and photograph")
    parser.add_argument("--probe", type=int, default=128, help="samples of the probe")
    parser.add_argument("--probe-width", type=int, default=2048)
    parser.add_argument("--blender", metavar="PYTHON", help="a Python with the package bpy")
    parser.add_argument("--tables", nargs="+", choices=list(hall.TABLES),
                        default=list(hall.TABLES))
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    print(processor())
    rows = [row for table in args.tables for row in measure(args, table)]
    strips = [read_png(args.output / f"{table}.png") for table in args.tables]
    write_sheet(args.output / "compositing.png", strips, columns=1)
    print("\n".join(lines_of_table(
        ["table", "picture", "blocks", "median error", "95th percentile", "largest"], rows, 2)))


if __name__ == "__main__":
    main()
