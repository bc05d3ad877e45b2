#!/usr/bin/env python3
"""Renders small scenes of which pbrt-v4's pictures are known, and compares means of blocks.

    tests/truth/truth_test.py PROGRAM [SCENE...] [--spp N] [--keep FOLDER] [--markdown]

A picture agrees if its total is within 1 % and every one of 8 x 10 blocks within 3 % of pbrt's, in
every channel, plus what the noise of both explains: 4 standard errors, ours from the layer
`variance`, pbrt's from the same variance and its own number of samples. A picture whose total has
noise above 0.5 % would show nothing, and is refused. scenes.py has the scenes and the differences
by design, with reasons.

--keep leaves scenes and pictures in a folder. --markdown prints the table of docs/truth.md.
"""
import argparse
import concurrent.futures
import json
import math
import os
import pathlib
import struct
import subprocess
import sys
import tempfile

from pictures import read_exr
from scenes import SCENES
from textures import write_textures

HERE = pathlib.Path(__file__).resolve().parent
ROWS, COLUMNS = 8, 10
TOTAL, BLOCK = 1.0, 3.0  # [percent]
EXACT = 0.1  # where the mean of a picture is known by a formula [percent]
SIGMAS = 4
MOST_NOISE = 0.5  # of the total [percent]


class Blocks:
    """Means of blocks, their squared standard errors, and the sum of their weights."""

    def __init__(self, size, means, variances):
        self.size, self.means, self.variances = size, means, variances
        width, height = size
        self.pixels = [((y + 1) * height // ROWS - y * height // ROWS) *
                       ((x + 1) * width // COLUMNS - x * width // COLUMNS)
                       for y in range(ROWS) for x in range(COLUMNS)]

    def total(self, channel):
        return sum(n * b[channel] for n, b in zip(self.pixels, self.means)) / sum(self.pixels)

    def total_error(self, channel):
        squares = sum(n * n * v[channel] for n, v in zip(self.pixels, self.variances))
        return math.sqrt(squares) / sum(self.pixels)


def blocks_of(width, height, channels):
    """Returns Blocks of a picture; their variances are those of one sample of each pixel."""
    means, variances = [], []
    for row in range(ROWS):
        ys = range(row * height // ROWS, (row + 1) * height // ROWS)
        for column in range(COLUMNS):
            x0, x1 = column * width // COLUMNS, (column + 1) * width // COLUMNS
            n = len(ys) * (x1 - x0)

            def mean(name):
                return sum(sum(channels[name][y][x0:x1]) for y in ys) / n
            means.append([mean(letter) for letter in "RGB"])
            variances.append([mean("variance." + letter) / n for letter in "RGB"])
    return Blocks((width, height), means, variances)


class Comparison:
    """Our blocks against others: the difference of totals and of the worst block, in percent."""

    def __init__(self, ours, theirs, spp, their_spp, block_bound):
        self.faults, self.ours = [], ours
        share = 1 / spp + 1 / their_spp  # of the variance of one sample
        self.totals, self.noise = [], 0.0
        self.worst = 0.0
        if ours.size != theirs.size:
            self.faults.append(f"its size is {ours.size}, not {theirs.size}")
            return
        for c in range(3):
            expected = theirs.total(c)
            noise = 100 * ours.total_error(c) * math.sqrt(share) / expected
            difference = 100 * (ours.total(c) / expected - 1)
            self.totals.append(difference)
            self.noise = max(self.noise, noise)
            if not abs(difference) <= TOTAL + SIGMAS * noise:
                self.faults.append(f"the total of {'RGB'[c]} differs by {difference:.2f} %")
        if self.noise > MOST_NOISE:
            self.faults.append(f"the total has noise of {self.noise:.2f} %")
        worst_excess = 0
        for i, (mean, expected) in enumerate(zip(ours.means, theirs.means)):
            for c in range(3):
                error = math.sqrt(ours.variances[i][c] * share)
                difference = mean[c] - expected[c]
                bound = block_bound / 100 * expected[c] + SIGMAS * error + 1e-6
                percent = 100 * difference / max(expected[c], 1e-6)
                # The worst block is that with the largest difference beyond its noise.
                beyond = max(abs(difference) - SIGMAS * error, 0) / max(expected[c], 1e-6)
                if beyond > worst_excess:
                    worst_excess, self.worst = beyond, percent
                if not abs(difference) <= bound:
                    self.faults.append(f"block {divmod(i, COLUMNS)} of {'RGB'[c]}: {mean[c]:.4g} "
                                       f"instead of {expected[c]:.4g}, {percent:.1f} %")

    def total(self):
        return max(self.totals, key=abs) if self.totals else math.nan


def render(program, folder, name, text, options, spp):
    """Returns the blocks of our picture."""
    scene, picture = folder / f"{name}.pbrt", folder / f"{name}.exr"
    scene.write_text(text, encoding="utf-8")
    run = subprocess.run([program, "render", str(scene), "--spp", str(spp), "--threads", "1",
                          "--compression", "none", "--aovs", "variance", "-o", str(picture),
                          *options], capture_output=True, text=True, check=False)
    if run.returncode != 0:
        raise RuntimeError(run.stderr.strip())
    return blocks_of(*read_exr(picture))


def examine(program, folder, scene, figures, spp):
    """Returns the comparison with pbrt, and the faults that count."""
    try:
        ours = render(program, folder, scene.name, scene.text, scene.options, spp)
        figure = figures[scene.name]
        pbrt = Blocks(tuple(figure["size"]), [b for row in figure["blocks"] for b in row], [])
        with_pbrt = Comparison(ours, pbrt, spp, figure["spp"], scene.block)
        faults = with_pbrt.faults
        if scene.instead:
            other = render(program, folder, scene.name + "_instead", scene.instead, (), spp)
            faults = Comparison(ours, other, spp, spp, BLOCK).faults
        elif scene.total:
            low, high = scene.total
            faults = [f"a total differs by {total:.2f} %, not by {low} to {high}"
                      for total in with_pbrt.totals if not low <= total <= high]
        if scene.exact:
            noise = SIGMAS * ours.total_error(0) / math.sqrt(spp)
            if not abs(ours.total(0) - scene.exact) <= EXACT / 100 * scene.exact + noise:
                faults = faults + [f"the mean is {ours.total(0):.5g} instead of {scene.exact:.5g}"]
        return with_pbrt, faults
    except (RuntimeError, ValueError, KeyError, IndexError, OSError, ZeroDivisionError,
            struct.error) as error:
        return None, [f"{type(error).__name__}: {error}"]


def markdown(results):
    lines = ["| scene | feature | total [%] | worst block [%] | difference by design |",
             "| --- | --- | --- | --- | --- |"]
    for scene, (with_pbrt, faults) in results:
        if not with_pbrt:
            lines.append(f"| `{scene.name}` | {scene.feature} | | | {faults[0]} |")
            continue
        exact = (f"; exactly {scene.exact:.5g}, ours {with_pbrt.ours.total(0):.5g}" if scene.exact
                 else "")
        lines.append(f"| `{scene.name}` | {scene.feature}{exact} | {with_pbrt.total():+.2f} | "
                     f"{with_pbrt.worst:+.1f} | {scene.reason} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--keep", type=pathlib.Path)
    parser.add_argument("--markdown", action="store_true")
    arguments = parser.parse_args()
    unknown = set(arguments.scenes) - {scene.name for scene in SCENES}
    if unknown:
        parser.error(f"there is no scene {', '.join(sorted(unknown))}")
    if not os.access(arguments.program, os.X_OK):
        parser.error(f"{arguments.program} is no program")
    chosen = [scene for scene in SCENES if not arguments.scenes or scene.name in arguments.scenes]
    with open(HERE / "pbrt_blocks.json", encoding="utf-8") as file:
        figures = json.load(file)
    with tempfile.TemporaryDirectory() as scratch:
        folder = arguments.keep or pathlib.Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        write_textures(folder)
        program = str(arguments.program.resolve())
        with concurrent.futures.ThreadPoolExecutor(2) as workers:
            results = list(zip(chosen, workers.map(
                lambda scene: examine(program, folder, scene, figures, arguments.spp), chosen)))
    if arguments.markdown:
        print(markdown(results), end="")
        return 1 if any(faults for _, (_, faults) in results) else 0
    failed = 0
    for scene, (with_pbrt, faults) in results:
        failed += bool(faults)
        if with_pbrt:
            print(f"{scene.name:16} total {with_pbrt.total():+7.2f} %, worst block "
                  f"{with_pbrt.worst:+8.2f} %" + (f"  ({scene.reason})" if scene.reason else ""))
        for fault in faults[:5]:
            print(f"    {scene.name}: {fault}")
    print(f"{len(results) - failed} of {len(results)} scenes agree")
    return 1 if failed or not results else 0


if __name__ == "__main__":
    sys.exit(main())
