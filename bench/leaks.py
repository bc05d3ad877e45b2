#!/usr/bin/env python3
"""Counts the light that comes into a closed room through edges that triangles share.

    bench/leaks.py                      # some 10^9 rays, by AVX2 and by AVX-512: minutes
    bench/leaks.py --instance           # the same of a room that stands there as an instance
    bench/leaks.py --rays 1e7           # does it work?
    bench/leaks.py --rays 1e7 --integrator bdpt   # light paths come in: docs/robustness.md

The room is a box of 43 200 triangles with shared corners, at random places but for those of the
rims, under a sky of radiance 1. A camera in it looks into a corner; paths have up to three bounces,
with light samples of the sky at each. Each pixel that is not black has got light through an edge.
With --instance the room is turned, by the matrix of one of two instances of it.
"""

import argparse
import json
import math
import random
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from reporting import lines_of_table, processor  # noqa: E402

CELLS = 60
SIDE = 1600  # of the picture [pixels]
VIEW = ["--eye", "0.1,0.05,0.02", "--target", "1,0.3,0.2", "--fov", 100]
RAYS_OF_A_SAMPLE = 5.4  # about


def write_room(path, missing=0):
    """Writes the box [-1, 1]^3 as PLY, without the last `missing` triangles."""
    draw = random.Random(5)
    corners, triangles = [], []
    for axis in range(3):
        for end in (-1, 1):
            first = len(corners)
            for j in range(CELLS + 1):
                for i in range(CELLS + 1):
                    place = [end, end, end]
                    inside = 0 < i < CELLS and 0 < j < CELLS
                    for number, of in ((i, (axis + 1) % 3), (j, (axis + 2) % 3)):
                        jitter = draw.uniform(-0.3, 0.3) if inside else 0
                        place[of] = 2 * (number + jitter) / CELLS - 1
                    corners.append(place)
            line = CELLS + 1
            for j in range(CELLS):
                for i in range(CELLS):
                    at = first + j * line + i
                    triangles.append((at, at + 1, at + line + 1))
                    triangles.append((at, at + line + 1, at + line))
    triangles = triangles[:len(triangles) - missing]
    lines = ["ply", "format ascii 1.0", f"element vertex {len(corners)}", "property float x",
             "property float y", "property float z", f"element face {len(triangles)}",
             "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(f"{x:.9g}" for x in corner) for corner in corners]
    lines += ["3 " + " ".join(map(str, triangle)) for triangle in triangles]
    path.write_text("\n".join(lines) + "\n")


def write_instances(path, room):
    """Writes a scene with the room turned and once more beside it."""
    path.write_text(f'''WorldBegin
ObjectBegin "room"
Shape "plymesh" "string filename" "{room}"
ObjectEnd
AttributeBegin
Rotate 31 1 2 3
ObjectInstance "room"
AttributeEnd
Translate 10 0 0
ObjectInstance "room"
''')


def write_gray(path, width, height, value):
    """Writes a PFM of one value."""
    path.write_bytes(f"Pf\n{width} {height}\n-1\n".encode()
                     + struct.pack("<f", value) * (width * height))


def run(*command):
    return subprocess.run([str(word) for word in command], check=True, capture_output=True,
                          text=True).stdout


def count(args, isa, scene, side=SIDE):
    """Renders a room of its folder; returns the number of rays, of lit pixels, and of millions of
    rays a second."""
    folder = scene.parent
    samples = math.ceil(args.rays / RAYS_OF_A_SAMPLE / side**2)
    picture, stats = folder / "room.exr", folder / "stats.json"
    write_gray(folder / "sky.pfm", 4, 2, 1)
    write_gray(folder / "black.pfm", side, side, 0)
    run(args.program, "render", scene, "--env", folder / "sky.pfm", "--size", f"{side}x{side}",
        "--spp", samples, "--max-depth", 3, *VIEW, "--integrator", args.integrator,
        "--embree-config", f"isa={isa}", "--quiet", "--stats", stats, "-o", picture)
    said = json.loads(stats.read_text())
    differing = [line.split()[1] for line in run(args.program, "compare", picture,
                                                 folder / "black.pfm").splitlines()
                 if line.startswith("different_pixels")]
    rays = sum(kind["count"] for kind in said["rays"].values())
    return rays, int(differing[0]), rays / said["seconds"]["render"] / 1e6


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--program", default="build/release/skywave")
    parser.add_argument("--rays", type=float, default=1e9, help="about so many")
    parser.add_argument("--integrator", default="path")
    parser.add_argument("--instance", action="store_true", help="turn the room by an instance")
    parser.add_argument("--isa", nargs="+", default=["avx2", "avx512"])
    args = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scene = folder / ("room.pbrt" if args.instance else "room.ply")
        write_room(folder / "room.ply")
        write_instances(folder / "room.pbrt", "room.ply")
        for isa in args.isa:
            rays, lit, speed = count(args, isa, scene)
            rows.append([isa, f"{rays:.3g}", f"{lit}", f"{speed:.1f}"])
    print(run(args.program, "--version").strip(), "on", processor())
    print("\n".join(lines_of_table(["Embree's isa", "rays", "pixels with light",
                                    "million rays a second"], rows, right_from=1)))


if __name__ == "__main__":
    main()
