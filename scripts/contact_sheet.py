#!/usr/bin/env python3
"""Renders every model of a data folder under its illumination maps, small, and puts the pictures on
one sheet: a row a model, a column a map.

    scripts/contact_sheet.py DATA OUT [--program build/release/skywave] [--spp 64]

DATA holds models/ (OBJ, PLY, and the pbrt models of scripts/data_scenes.sh), glb/, and maps in hdri/
and probes/latlong/. OUT gets a PNG a picture, sheet.png, and sheet.jpg where cjpeg is installed.
Python 3 and nothing else.
"""
import argparse
import pathlib
import shutil
import struct
import subprocess
import sys
import zlib

ROOT = pathlib.Path(__file__).resolve().parent.parent
WIDTH, HEIGHT = 160, 120

# What a file cannot say itself; files that are not named here stand on a plane.
FLAGS = {
    "killeroo.pbrt": ["--env-up", "z"],
    "killeroo_loop1.ply": ["--env-up", "z", "--ground", "--eye=650,-250,60", "--target=0,-40,-50",
                           "--fov", "30"],
    "bunny.pbrt": [],
    "sponza.obj": ["--eye=-11,3,0", "--target=10,4.5,0", "--fov", "65"],
    "cornellBox.glb": [],
}
# Stops that bring the maps to a similar brightness.
STOPS = {"noon_grass_1k": -0.7, "venice_sunset_1k": -0.3, "studio_small_03_1k": -2.5,
         "potsdamer_platz_1k": -0.7, "grace_latlong": 0, "galileo_latlong": -1.2}
MAPS = ["hdri/*.hdr", "probes/latlong/grace_latlong.exr", "probes/latlong/galileo_latlong.exr"]


def find(folder, patterns):
    return [path for pattern in patterns for path in sorted(folder.glob(pattern))]


def read_png(path):
    """(width, height, RGB bytes) of an 8-bit RGB PNG, as the renderer writes them."""
    data = path.read_bytes()
    at, compressed, width, height = 8, b"", 0, 0
    while at < len(data):
        (length,) = struct.unpack(">I", data[at:at + 4])
        kind, body = data[at + 4:at + 8], data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, color, _, _, interlaced = struct.unpack(">IIBBBBB", body)
            if (depth, color, interlaced) != (8, 2, 0):
                sys.exit(f"{path}: not an 8-bit RGB PNG")
        elif kind == b"IDAT":
            compressed += body
        at += 12 + length
    raw, stride = zlib.decompress(compressed), width * 3
    rows, above = [], bytes(stride)
    for y in range(height):
        mode, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            a, b, c = (row[i - 3] if i > 2 else 0), above[i], (above[i - 3] if i > 2 else 0)
            p = a + b - c
            paeth = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            row[i] = (row[i] + (0, a, b, (a + b) // 2, paeth)[mode]) & 255
        rows.append(bytes(row))
        above = row
    return width, height, b"".join(rows)


def write_png(path, width, height, rgb):
    def chunk(kind, body):
        return (struct.pack(">I", len(body)) + kind + body +
                struct.pack(">I", zlib.crc32(kind + body)))
    rows = b"".join(b"\0" + rgb[y * width * 3:(y + 1) * width * 3] for y in range(height))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" +
                     chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def tile(pictures, columns):
    """Pictures of one size, row by row, as one (width, height, RGB bytes)."""
    width, height, _ = pictures[0]
    stride, rows = width * 3, []
    for first in range(0, len(pictures), columns):
        line = pictures[first:first + columns]
        for y in range(height):
            rows += [rgb[y * stride:(y + 1) * stride] for _, _, rgb in line]
    return width * columns, height * (len(pictures) // columns), b"".join(rows)


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
    width, height, rgb = tile(pictures, len(maps))
    write_png(args.out / "sheet.png", width, height, rgb)
    if shutil.which("cjpeg"):
        subprocess.run(["cjpeg", "-quality", "80", "-outfile", args.out / "sheet.jpg"],
                       input=b"P6 %d %d 255\n" % (width, height) + rgb, check=True)
    print("rows:   ", ", ".join(model.name for model in models))
    print("columns:", ", ".join(light.stem for light in maps))


if __name__ == "__main__":
    main()
