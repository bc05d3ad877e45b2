#!/usr/bin/env python3
"""Measures lights of a map that turns, frame by frame: time and flicker, as a Markdown table.

    bench/reproduce/moving_map.py --data DATA -o OUT
    bench/reproduce/moving_map.py --data DATA -o OUT --frames 3 --size 40x30   # does it work?

Killeroos stand still under a map whose texels are turned by --columns from frame to frame. Each
method places its lights in every frame anew by `skywave probe presample`, but for two: the lights
of `follow` begin where those of the frame before ended (--follow), after Ghosh et al. 2006, and
`turned` has the lights of the first frame, turned with the map, which nobody can know of a map
that changes otherwise.

What a picture differs by from its reference, by importance with --reference light samples, is its
error. Its mean square, its variance over the frames (flicker) and half of the mean square of what
two successive frames differ by (jumps; for errors that know nothing of each other that is the
variance) are relative to the squared brightness of the surfaces. Files that are in OUT are not
made again.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import time

BENCH = pathlib.Path(__file__).resolve().parents[1]
sys.path += [str(BENCH), str(BENCH / "peers")]  # the modules of this folder come first
from pictures import read_exr, read_pfm, write_pfm  # noqa: E402
from reporting import lines_of_table, number, processor  # noqa: E402

METHODS = ["median-cut", "variance-cut", "penrose", "polyomino", "structured", "kollig-keller",
           "k-means", "follow", "turned"]


def in_data(args, name):
    """Returns a file of the test data, or the name of a scene of the program."""
    return args.data / name if (args.data / name).is_file() else name


def run(*command):
    """Returns the seconds that a command takes."""
    start = time.monotonic()
    subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL)
    return time.monotonic() - start


def turn(picture, columns):
    """Returns a picture whose columns are moved to the left, around the sphere."""
    width, height, rows = picture
    cut = 3 * (columns % width)
    return width, height, [row[cut:] + row[:cut] for row in rows]


def write_maps(args):
    """Returns the maps of the frames, and the width of the first."""
    first = args.output / "map.pfm"
    if not first.exists():
        run(args.program, "probe", "convert", in_data(args, args.map), first, "--to", "latlong")
    picture = read_pfm(first)
    maps = [args.output / f"map_{frame:04}.pfm" for frame in range(args.frames)]
    for frame, path in enumerate(maps):
        if not path.exists():
            write_pfm(path, turn(picture, frame * args.columns))
    return maps, picture[0]


def place_lights(args, method, maps):
    """Writes the lights of each frame; returns their files and the median of the seconds."""
    if method == "turned":
        return [args.output / "k-means_0000.json"] * len(maps), None
    sets = [args.output / f"{method}_{frame:04}.json" for frame in range(len(maps))]
    seconds = []
    for frame, (path, lights) in enumerate(zip(maps, sets)):
        begin = ["--method", "k-means" if method == "follow" else method, "-n", args.lights]
        if method == "follow" and frame > 0:
            begin = ["--follow", sets[frame - 1]]
        taken = run(args.program, "probe", "presample", path, *begin, "-o", lights)
        if frame > 0:  # the first has nothing to follow
            seconds.append(taken)
    return sets, statistics.median(seconds)


def render(args, environment, output, *flags):
    if not output.exists():
        run(args.program, "render", in_data(args, args.scene), "--env", *environment, "--env-up",
            args.up, "--integrator", "direct", "--no-mis", "--size", args.size, "--spp",
            args.samples, "--aovs", "coverage", "--quiet", "-o", output, *flags)


def errors_of(picture, reference):
    """Returns the error of each value of the pixels that see surfaces, and their brightness."""
    (_, _, rows), (_, _, right) = read_exr(picture), read_exr(reference)
    _, _, coverage = read_exr(picture, ("coverage.V",) * 3)
    values = [(a - b, b) for row, other, seen in zip(rows, right, coverage)
              for a, b, share in zip(row, other, seen) if share == 1]
    return [value[0] for value in values], statistics.fmean(value[1] for value in values)


def mean_square(values):
    return sum(value * value for value in values) / len(values)


def measure(args):
    maps, width = write_maps(args)
    references = [args.output / f"reference_{frame:04}.exr" for frame in range(args.frames)]
    for path, reference in zip(maps, references):
        render(args, [path], reference, "--strategy", "importance", "--light-samples",
               args.reference)
    rows = []
    for method in args.methods:
        sets, seconds = place_lights(args, method, maps)
        errors, brightness = [], []
        for frame, (path, lights) in enumerate(zip(maps, sets)):
            picture = args.output / f"{method}_{frame:04}.exr"
            rotated = [maps[0], "--env-rotate", 360 * frame * args.columns / width]
            render(args, rotated if method == "turned" else [path], picture, "--strategy",
                   f"hybrid:file={lights}")
            error, mean = errors_of(picture, references[frame])
            errors.append(error), brightness.append(mean)
        square = statistics.fmean(brightness) ** 2
        flicker = statistics.fmean(statistics.variance(pixel) for pixel in zip(*errors))
        jumps = statistics.fmean(mean_square([b - a for a, b in zip(before, after)]) / 2
                                 for before, after in zip(errors, errors[1:]))
        count = len(json.loads(sets[-1].read_text())["samples"])
        rows.append([f"`{method}`", str(count), "" if seconds is None else number(1000 * seconds),
                     number(statistics.fmean(map(mean_square, errors)) / square),
                     number(flicker / square), number(jumps / square)])
        print(*rows[-1], flush=True)
    return lines_of_table(["lights", "number", "ms a frame", "mean square", "flicker", "jumps"],
                          rows, 1)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=pathlib.Path, required=True, help="folder of test data")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True, help="folder")
    parser.add_argument("--program", type=pathlib.Path,
                        default=pathlib.Path("build/release/skywave"))
    parser.add_argument("--scene", default="models/killeroo.pbrt")
    parser.add_argument("--up", default="z", help="axis of the scene that is the map's up")
    parser.add_argument("--map", default="probes/latlong/galileo_latlong.exr")
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=METHODS)
    parser.add_argument("--frames", type=int, default=24)
    parser.add_argument("--columns", type=int, default=4, help="of a turn, each frame")
    parser.add_argument("--lights", type=int, default=64)
    parser.add_argument("--size", default="160x120")
    parser.add_argument("--samples", type=int, default=4)
    parser.add_argument("--reference", type=int, default=1024, help="light samples")
    args = parser.parse_args(arguments)
    args.output.mkdir(parents=True, exist_ok=True)
    table = measure(args)
    print("\n" + "\n".join([f"{processor()}, {args.frames} frames", "", *table]))


if __name__ == "__main__":
    main()
