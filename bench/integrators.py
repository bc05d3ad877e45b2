#!/usr/bin/env python3
"""Shows which integrator is best where: `skywave converge` on built-in scenes, as a Markdown table.

    bench/integrators.py [--program build/release/skywave] [-o FOLDER] [--time SECONDS] ...

Every scene represents a kind of light transport. All integrators get the same time. The table gives
error and time of `path` and, for the others, error times time of `path` over their own: the factor
by which less work gives the same error, provided that all of the error is noise. If a bias is
found, its share of the squared error, which more samples do not remove, is given. References come
from the unbiased integrator with less noise in that scene. --sheet also renders the final picture
of each as sheet.png, with one row per scene and one column per integrator. Needs the standard
library only.
"""

import argparse
import json
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "scripts"))
from sheet import read_png, write_sheet  # noqa: E402

SCENES = {
    "many-shapes": "open, matt",
    "room": "an interior, one window",
    "three-spheres": "caustics of the sun",
    "materials": "glossy and rough, open",
    "lamps": "small lamps in a room",
    "many-materials": "every BSDF, open",
}
# These integrators compute the references.
REFERENCE = {"room": "bdpt", "three-spheres": "bdpt", "lamps": "bdpt"}
INTEGRATORS = ["path", "light", "bdpt", "photon", "vcm", "vpl", "irradiance-cache"]


def call(arguments, command, scene, *flags):
    """Calls the program for one of the scenes."""
    common = ["-q", "--size", arguments.size, "--max-depth", str(arguments.depth)]
    if arguments.guide:
        common.append("--guide")
    subprocess.run([arguments.program, command, scene, *common, *flags], check=True,
                   stdout=subprocess.DEVNULL)


def converge(arguments, scene, file):
    call(arguments, "converge", scene, "--measure", "relative_mse",
         "--time", str(arguments.time), "--repeats", str(arguments.repeats),
         "--reference-integrator", REFERENCE.get(scene, "path"),
         "--reference-spp", str(arguments.reference_spp), "--json", str(file),
         "--integrators", *INTEGRATORS)


def picture(arguments, scene, contestant):
    """Renders the final picture of a contestant."""
    name = contestant["integrator"]
    file = arguments.output / f"{scene}-{name}.exr"
    call(arguments, "render", scene, "--integrator", name,
         "--spp", str(contestant["budgets"][-1]["samples_per_pixel"]), "-o", str(file))
    return read_png(file.with_suffix(".png"))


def cell(first, other):
    """Returns a cell from two lists of budgets, using their last ones."""
    path, last = first["budgets"][-1], other["budgets"][-1]
    text = f"{path['error'] * path['seconds'] / (last['error'] * last['seconds']):.2g}"
    if last["biased"]:
        text += f" ({max(0, 100 * last['squared_bias'] / last['error']):.0f} % bias)"
    return text


def table(results):
    lines = ["| scene | | error of `path` | its time [s] | " +
             " | ".join(f"`{name}`" for name in INTEGRATORS[1:]) + " |",
             "| --- | --- | --- | --- |" + " --- |" * (len(INTEGRATORS) - 1)]
    for scene, result in results.items():
        first, *others = result["strategies"]
        last = first["budgets"][-1]
        cells = [scene, SCENES[scene], f"{last['error']:.2g}", f"{last['seconds']:.2g}"]
        cells += [cell(first, other) for other in others]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="build/release/skywave")
    parser.add_argument("-o", "--output", type=pathlib.Path, default=pathlib.Path("integrators"))
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=list(SCENES))
    parser.add_argument("--size", default="160x120")
    parser.add_argument("--depth", type=int, default=8)
    parser.add_argument("--time", type=float, default=1.0, help="longest render [s]")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--guide", action="store_true",
                        help="light paths of the sky start where they are needed")
    parser.add_argument("--reference-spp", type=int, default=8192)
    parser.add_argument("--sheet", action="store_true", help="pictures of all")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    results = {}
    for scene in arguments.scenes:
        file = arguments.output / f"{scene}.json"
        print(f"{scene} ...", file=sys.stderr, flush=True)
        converge(arguments, scene, file)
        results[scene] = json.loads(file.read_text())
        for warning in results[scene]["warnings"]:
            print(f"  {warning}", file=sys.stderr)
    print(table(results))
    if arguments.sheet:
        write_sheet(arguments.output / "sheet.png",
                    [picture(arguments, scene, contestant)
                     for scene, result in results.items() for contestant in result["strategies"]],
                    len(INTEGRATORS))


if __name__ == "__main__":
    main()
