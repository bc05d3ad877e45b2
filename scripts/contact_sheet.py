#!/usr/bin/env python3
"""Renders every model of a data folder under its illumination maps, in small size, and puts the
pictures on one sheet: one row per model, one column per map.

    scripts/contact_sheet.py DATA OUT [--program build/release/skywave] [--spp 64]

DATA holds models/ (OBJ, PLY, and the pbrt models of scripts/data_scenes.sh), glb/, and maps in
hdri/ and probes/latlong/. OUT receives one PNG per picture, sheet.png, and sheet.jpg if cjpeg is
installed. Needs Python 3 only.
"""
import argparse
import pathlib
import subprocess
import sys

from sheet import read_png, write_sheet

ROOT = pathlib.Path(__file__).resolve().parent.parent
WIDTH, HEIGHT = 160, 120

# Settings that a file cannot contain; files that are not listed stand on a plane.
FLAGS = {
    "killeroo.pbrt": ["--env-up", "z"],
    "killeroo_loop1.ply": ["--env-up", "z", "--ground", "--eye=650,-250,60", "--target=0,-40,-50",
                           "--fov", "30"],
    "bunny.pbrt": [],
    "sponza.obj": ["--eye=-11,3,0", "--target=10,4.5,0", "--fov", "65"],
    "cornellBox.glb": [],
}
# Exposures in stops that bring the maps to a similar brightness.
STOPS = {"noon_grass_1k": -0.7, "venice_sunset_1k": -0.3, "studio_small_03_1k": -2.5,
         "potsdamer_platz_1k": -0.7, "grace_latlong": 0, "galileo_latlong": -1.2}
MAPS = ["hdri/*.hdr", "probes/latlong/grace_latlong.exr", "probes/latlong/galileo_latlong.exr"]


def find(folder, patterns):
    return [path for pattern in patterns for path in sorted(folder.glob(pattern))]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("data", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/release/skywave")
    parser.add_argument("--spp", type=int, default=64)
    args = parser.parse_args()

    args.out.mkdir(parents=True, exist_ok=True)
    scenes = args.out / "scenes"
    subprocess.run([ROOT / "scripts/data_scenes.sh", args.data, scenes], check=True,
                   stdout=subprocess.DEVNULL)
    models = (find(scenes, ["*.pbrt"]) + find(args.data / "models", ["*.ply", "*.obj"]) +
              find(args.data / "glb", ["*.glb"]))
    maps = find(args.data, MAPS)
    if not maps:
        sys.exit(f"{args.data}: no map in hdri/ or probes/latlong/")

    pictures = []
    for model in models:
        for light in maps:
            picture = args.out / f"{model.name}.{light.stem}.exr"
            command = [args.program, "render", model, "--env", light, "--size", f"{WIDTH}x{HEIGHT}",
                       "--spp", str(args.spp), "--tone", "filmic", "-q", "-o", picture,
                       f"--exposure={STOPS.get(light.stem, 0)}",
                       *FLAGS.get(model.name, ["--ground"])]
            subprocess.run(command, check=True)
            pictures.append(read_png(picture.with_suffix(".png")))
    write_sheet(args.out / "sheet.png", pictures, len(maps))
    print("rows:   ", ", ".join(model.name for model in models))
    print("columns:", ", ".join(light.stem for light in maps))


if __name__ == "__main__":
    main()
