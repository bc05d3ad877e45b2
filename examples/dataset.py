#!/usr/bin/env python3
"""A data set: random views of balls on a table, with masks and boxes for COCO and depths as PNG.

    python3 examples/dataset.py [--pictures N] [--size PIXELS] [--spp N] [--map MAP] [-o FOLDER]

Each picture is a function of its number, so two runs of half of the pictures make the whole. Needs
NumPy and skywave.
"""
import argparse
import pathlib

import numpy

import skywave
from skywave import annotations

COLORS = {"red": (0.8, 0.1, 0.1), "green": (0.1, 0.6, 0.2), "blue": (0.1, 0.2, 0.7)}


def ball(radius, rows=24):
    """Returns vertices, faces and normals of a ball."""
    theta = numpy.linspace(0, numpy.pi, rows + 1)[:, None]
    phi = numpy.linspace(0, 2 * numpy.pi, 2 * rows, endpoint=False)[None, :]
    normals = numpy.stack([numpy.sin(theta) * numpy.cos(phi), numpy.cos(theta) + 0 * phi,
                           numpy.sin(theta) * numpy.sin(phi)], axis=-1)
    number = numpy.arange((rows + 1) * 2 * rows).reshape(rows + 1, 2 * rows)
    right = numpy.roll(number, -1, axis=1)
    a, b, c, d = number[:-1], right[:-1], number[1:], right[1:]
    faces = numpy.concatenate([numpy.stack([a, b, d], -1)[1:], numpy.stack([a, d, c], -1)[:-1]])
    normals = normals.reshape(-1, 3)
    return radius * normals, faces.reshape(-1, 3), normals


def place_balls(random, count):
    """Returns places and radii of balls on the table that do not touch each other."""
    balls = []
    while len(balls) < count:
        radius = random.uniform(0.1, 0.35)
        x, z = random.uniform(-1.2, 1.2, 2)
        if all(numpy.hypot(x - other[0], z - other[1]) > radius + other[2] for other in balls):
            balls.append((x, z, radius))
    return balls


def make_scene(random):
    scene = skywave.Scene()
    wood = scene.add_material(name="table", reflectance=(0.5, 0.4, 0.3))
    corners = [[-2, 0, -2], [-2, 0, 2], [2, 0, 2], [2, 0, -2]]
    scene.add_mesh(corners, [[0, 1, 2], [0, 2, 3]], material=wood, name="table")
    paints = {name: scene.add_material(name=name, reflectance=color)
              for name, color in COLORS.items()}
    for i, (x, z, radius) in enumerate(place_balls(random, int(random.integers(2, 7)))):
        vertices, faces, normals = ball(radius)
        color = str(random.choice(list(COLORS)))
        scene.add_mesh(vertices + [x, radius, z], faces, normals=normals, material=paints[color],
                       name=f"{color} ball {i}")
    return scene


def make_camera(random, size):
    """Returns a camera of vision that looks at the table from a random place above it."""
    azimuth, height = random.uniform(0, 2 * numpy.pi), random.uniform(0.25, 0.9)
    eye = random.uniform(3.5, 5) * numpy.array([
        numpy.sqrt(1 - height**2) * numpy.cos(azimuth), height,
        numpy.sqrt(1 - height**2) * numpy.sin(azimuth)])
    forward = -eye / numpy.linalg.norm(eye)
    right = numpy.cross(forward, [0, 1, 0])
    right /= numpy.linalg.norm(right)
    down = numpy.cross(forward, right)
    K = [[1.2 * size, 0, (size - 1) / 2], [0, 1.2 * size, (size - 1) / 2], [0, 0, 1]]
    return skywave.Camera(K, numpy.column_stack([right, down, forward, eye]), (size, size))


def sky(random):
    """Returns a lat-long map: a sky with a sun in a random place."""
    up = numpy.linspace(1, -1, 64)[:, None, None]
    pixels = numpy.repeat(0.4 + numpy.maximum(up, 0) * [0.1, 0.3, 0.6], 128, axis=1)
    pixels[int(random.integers(5, 25)), int(random.integers(128))] = 800
    return pixels.astype(numpy.float32)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pictures", type=int, default=500)
    parser.add_argument("--first", type=int, default=0, help="number of the first picture")
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--spp", type=int, default=32)
    parser.add_argument("--map", help="instead of random skies")
    parser.add_argument("-o", "--output", type=pathlib.Path, default=pathlib.Path("dataset"))
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    coco = annotations.Coco({name: f"{name} ball*" for name in COLORS})
    for number in range(args.first, args.first + args.pictures):
        random = numpy.random.default_rng([1, number])
        scene = make_scene(random).set_camera(make_camera(random, args.size))
        light = args.map or sky(random)
        picture = skywave.render(scene, light, spp=args.spp, denoise=True, seed=number,
                                 aovs=["object-id", "depth"])
        picture.save(args.output / f"{number:04}.png", exposure=0)
        annotations.write_depth(args.output / f"{number:04}_depth.png", picture.layers["depth"])
        annotations.write_png16(args.output / f"{number:04}_objects.png",
                                picture.layers["object-id"])
        found = coco.add(f"{number:04}.png", picture)
        print(f"{number:04}.png: {found} balls", flush=True)
    coco.save(args.output / f"annotations_{args.first:04}.json")


if __name__ == "__main__":
    main()
