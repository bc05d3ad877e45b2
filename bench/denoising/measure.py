#!/usr/bin/env python3
"""Measures the denoiser, as Markdown tables and strips of pictures.

    bench/denoising/measure.py --data DATA -o OUT
    bench/denoising/measure.py --data DATA -o OUT --size 80x60 --reference 64   # does it work?
    bench/denoising/measure.py --data DATA -o OUT --cost                        # its time
    bench/denoising/measure.py --data DATA -o OUT --until 0.001                 # time to an error
    bench/denoising/measure.py --data DATA -o OUT --by statistics oidn best     # side by side
    bench/denoising/measure.py --data DATA -o OUT --flicker                     # of frames

Six scenes are rendered with --samples and once with --reference samples. The first table has the
relative mean squared error of the noisy and of the clean picture, how many times smaller it is, and
the share of values that lie outside of their 95 % intervals; OUT/SCENE_SAMPLES.png shows the noisy
picture, the clean one and the reference. --cost renders the bunny with and without --denoise, by
turns, and reports the medians. --until doubles the samples, or lowers the error of --adaptive,
until a picture has this relative mean squared error, plain and denoised, and reports the processor
time of the whole command, which other work on the machine changes little. --by puts denoisers side
by side: relative mean squared errors, and the values outside of their intervals. --flicker renders
eight frames of scenes that stand still and cleans them, each by itself and steadied by two frames
on each side: the variance of a pixel over the frames, relative to its squared mean, and the errors.
Pictures that are in OUT are not rendered again.
"""

import argparse
import json
import resource
import subprocess
import sys
import time
from pathlib import Path
from statistics import median

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "peers"))
from pictures import read_exr, write_png_strip  # noqa: E402
from reporting import lines_of_table, number, processor  # noqa: E402

# Scene, flags, and the exposure of the strip.
SCENES = {
    "killeroos": ("models/killeroo.pbrt --env probes/latlong/galileo_latlong.exr --env-up z", 1),
    "metal bunny": ("models/bunny.ply --env probes/latlong/rnl_latlong.exr --ground "
                    "--material default=conductor:alpha=0.15", 0.5),
    "Sponza": ("models/sponza.obj --env probes/latlong/galileo_latlong.exr --eye=-12,2,0 "
               "--target 10,4,0 --fov 60", 2),
    "gallery": ("gallery", 1),
    "helmet": ("glb/DamagedHelmet.glb --env probes/latlong/grace_latlong.exr", 2),
    "lamps": ("lamps", 1),
}
FRAMES = 8  # of --flicker
COST_SIZES = ["640x480", "1920x1080", "3840x2160"]


def words(text, data):
    """Returns the flags of a scene, with the files that are in `data`."""
    return [str(data / word) if (data / word).is_file() else word for word in text.split()]


def run(*command):
    subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL)


def render(args, scene, samples, output, *flags):
    if not output.exists():
        run(args.program, "render", *words(SCENES[scene][0], args.data), "--size", args.size,
            *(["--crop", args.crop] if args.crop else []), "--spp", samples, "--quiet", "-o",
            output, *flags)


def compare(args, picture, reference):
    file = args.output / "compare.json"
    run(args.program, "compare", picture, reference, "--json", file)
    return json.loads(file.read_text())


def noisy_pictures(args):
    """Renders each scene; yields its name, samples, noisy picture and reference."""
    for scene in args.scenes:
        stem = args.output / scene.replace(" ", "_")
        reference = Path(f"{stem}_reference.exr")
        render(args, scene, args.reference, reference, "--seed", "99", "--aovs", "variance,samples")
        for samples in args.samples:
            noisy = Path(f"{stem}_{samples}.exr")
            render(args, scene, samples, noisy, "--aovs", "denoiser")
            yield scene, samples, noisy, reference


def outside(comparison):
    return f"{100 * comparison['noise']['exceeding']:.1f} %"


def quality(args):
    rows = []
    for scene, samples, noisy, reference in noisy_pictures(args):
        clean = noisy.with_name(f"{noisy.stem}_clean.exr")
        run(args.program, "denoise", noisy, "-o", clean, "--quiet")
        before, after = compare(args, noisy, reference), compare(args, clean, reference)
        rows.append([scene, str(samples), number(before["relative_mse"]),
                     number(after["relative_mse"]),
                     number(before["relative_mse"] / after["relative_mse"]),
                     number(before["flip"] / after["flip"]), outside(after)])
        strip = [read_exr(picture) for picture in (noisy, clean, reference)]
        write_png_strip(noisy.with_suffix(".png"), strip, exposure=SCENES[scene][1])
        print(*rows[-1], flush=True)
    return lines_of_table(["scene", "samples", "noisy", "clean", "times less", "FLIP, times less",
                           "outside of 95 %"], rows, 1)


def side_by_side(args):
    rows = []
    for scene, samples, noisy, reference in noisy_pictures(args):
        row = [scene, str(samples), number(compare(args, noisy, reference)["relative_mse"])]
        for by in args.by:
            clean = noisy.with_name(f"{noisy.stem}_{by}.exr")
            run(args.program, "denoise", noisy, "--by", by, "-o", clean, "--quiet")
            after = compare(args, clean, reference)
            row += [number(after["relative_mse"]), outside(after)]
        rows.append(row)
        print(*row, flush=True)
    columns = [column for by in args.by for column in (by, "outside of 95 %")]
    return lines_of_table(["scene", "samples", "noisy", *columns], rows, 1)


def relative_variance(frames):
    """Returns the mean over pixels of their variance over frames, by their squared brightness. The
    darkest count as a tenth as bright as the mean of the pictures."""
    values = [[value for row in rows for value in row] for _, _, rows in frames]
    count = len(frames)
    means = [sum(column) / count for column in zip(*values)]
    variances = [sum((value - mean)**2 for value in column) / (count - 1)
                 for column, mean in zip(zip(*values), means)]
    floor = 0.01 * (sum(means) / len(means))**2
    pixels = range(0, len(means), 3)
    return sum(sum(variances[i:i + 3]) / 3 / ((sum(means[i:i + 3]) / 3)**2 + floor)
               for i in pixels) / len(pixels)


def flicker(args):
    rows = []
    for scene in args.scenes:
        stem = args.output / scene.replace(" ", "_")
        reference = Path(f"{stem}_reference.exr")
        render(args, scene, args.reference, reference, "--seed", "99", "--aovs", "variance,samples")
        for samples in args.samples:
            noisy = [Path(f"{stem}_{samples}_frame{i}.exr") for i in range(1, FRAMES + 1)]
            for i, frame in enumerate(noisy, 1):
                render(args, scene, samples, frame, "--aovs", "denoiser", "--frame", i)
            row = [scene, str(samples)]
            errors = []
            for folder, flags in (("alone", ()), ("steady", ("--steady", 2))):
                run(args.program, "denoise", *noisy, "-o", args.output / folder, "--quiet", *flags)
                clean = [args.output / folder / frame.name for frame in noisy]
                row.append(relative_variance([read_exr(frame) for frame in clean]))
                errors.append(sum(compare(args, frame, reference)["relative_mse"]
                                  for frame in clean) / FRAMES)
            alone, steady = row[2:]
            rows.append([*row[:2], number(alone), number(steady), number(alone / steady),
                         *map(number, errors)])
            print(*rows[-1], flush=True)
    return lines_of_table(["scene", "samples", "alone", "steadied", "times less", "error alone",
                           "error steadied"], rows, 1)


def cost(args):
    scene = words(SCENES["metal bunny"][0], args.data)
    rows = []
    for size in COST_SIZES:
        seconds = {"": [], "--denoise": []}
        memory = {}
        for _ in range(args.repeats):
            for flag in seconds:
                stats = args.output / "cost.json"
                flags = [flag] if flag else []
                start = time.monotonic()
                run(args.program, "render", *scene, "--size", size, "--spp", 16, "--quiet",
                    "--stats", stats, "-o", args.output / "cost.exr", *flags)
                seconds[flag].append(time.monotonic() - start)
                memory[flag] = json.loads(stats.read_text())["peak_memory_mib"]
        plain, denoised = (median(seconds[flag]) for flag in seconds)
        rows.append([size, number(plain), number(denoised), f"{100 * (denoised / plain - 1):.1f} %",
                     *(number(memory[flag]) for flag in seconds)])
    return lines_of_table(["size", "plain [s]", "denoised [s]", "more", "plain [MiB]",
                           "denoised [MiB]"], rows, 1)


# Flags of a render, and their values from the cheapest picture on.
WAYS = {
    "plain": ("--spp {}", [8 << i for i in range(10)]),
    "denoised": ("--spp {} --denoise", [8 << i for i in range(10)]),
    "adaptive": ("--spp 4096 --adaptive {}", [0.8 / 2**(i / 2) for i in range(12)]),
    "adaptive, denoised": ("--spp 4096 --denoise --adaptive {}",
                           [0.8 / 2**(i / 2) for i in range(12)]),
}


def processor_seconds():
    """Returns the processor time of all commands that have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def until(args):
    rows = []
    for scene in args.scenes:
        reference = Path(f"{args.output / scene.replace(' ', '_')}_reference.exr")
        render(args, scene, args.reference, reference, "--seed", "99", "--aovs", "variance,samples")
        row = [scene]
        for flags, values in WAYS.values():
            found = "more"
            for value in values:
                picture = args.output / "until.exr"
                picture.unlink(missing_ok=True)
                before = processor_seconds()
                run(args.program, "render", *words(SCENES[scene][0], args.data), "--size",
                    args.size, *(["--crop", args.crop] if args.crop else []), "--quiet", "-o",
                    picture, *flags.format(value).split())
                seconds = processor_seconds() - before
                if compare(args, picture, reference)["relative_mse"] <= args.until:
                    found = f"{number(seconds)} ({number(value)})"
                    break
                if seconds > args.patience:
                    break
            row.append(found)
        rows.append(row)
        print(*row, flush=True)
    return lines_of_table(["scene", *(f"{way} [processor s]" for way in WAYS)], rows, 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, metavar="DATA")
    parser.add_argument("-o", "--output", type=Path, default=Path("denoising"), metavar="OUT")
    parser.add_argument("--program", type=Path, default=Path("build/release/skywave"))
    parser.add_argument("--size", default="640x480", metavar="WxH")
    parser.add_argument("--crop", metavar="WxH+X+Y", help="of the pictures, not of the cost")
    parser.add_argument("--samples", type=int, nargs="+", default=[16, 64, 1024])
    parser.add_argument("--reference", type=int, default=16384)
    parser.add_argument("--scenes", nargs="+", choices=list(SCENES), default=list(SCENES))
    parser.add_argument("--by", nargs="+", metavar="DENOISER", help="of `skywave denoise --by`")
    parser.add_argument("--flicker", action="store_true")
    parser.add_argument("--cost", action="store_true")
    parser.add_argument("--repeats", type=int, default=5, help="of --cost")
    parser.add_argument("--until", type=float, metavar="ERROR")
    parser.add_argument("--patience", type=float, default=30,
                        help="longest render of --until [processor s]")
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    print(processor())
    table = (flicker if args.flicker else cost if args.cost else until if args.until
             else side_by_side if args.by else quality)
    print("\n".join(table(args)))


if __name__ == "__main__":
    main()
