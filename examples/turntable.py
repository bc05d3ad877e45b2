#!/usr/bin/env python3
"""A turntable: a torus knot made of arrays, under a probe, its frames on one contact sheet.

    python3 examples/turntable.py [--map MAP] [--frames N] [--width PIXELS] [--spp N] [-o PNG]

Without a map, a studio with three soft boxes is made of an array. Needs NumPy and skywave.
"""
import argparse
import math

import numpy

import skywave


def torus_knot(p=2, q=3, around=900, across=64, tube=0.33):
    """Returns vertices, faces and normals of a tube around a (p, q) torus knot with the axis z."""
    t = numpy.linspace(0, 2 * math.pi, around, endpoint=False)

    def curve(t):
        radius = 2 + 0.75 * numpy.cos(q * t)
        x, y = radius * numpy.cos(p * t), radius * numpy.sin(p * t)
        return numpy.stack([x, y, 0.75 * numpy.sin(q * t)], axis=-1)

    def unit(v):
        return v / numpy.linalg.norm(v, axis=-1, keepdims=True)

    centre = curve(t)
    tangent = unit(curve(t + 1e-4) - curve(t - 1e-4))
    # The direction from the core of the torus is never along the knot, so it makes a smooth frame.
    outward = centre - 2 * unit(centre * [1, 1, 0])
    side = unit(numpy.cross(tangent, outward))
    outward = numpy.cross(side, tangent)

    angle = numpy.linspace(0, 2 * math.pi, across, endpoint=False)[None, :, None]
    normals = outward[:, None] * numpy.cos(angle) + side[:, None] * numpy.sin(angle)
    vertices = centre[:, None] + tube * normals

    # Every cell of the grid is two triangles; the grid wraps around in both directions.
    number = numpy.arange(around * across).reshape(around, across)
    right, up = numpy.roll(number, -1, axis=0), numpy.roll(number, -1, axis=1)
    both = numpy.roll(right, -1, axis=1)
    faces = numpy.stack([number, both, right, number, up, both], axis=-1).reshape(-1, 3)
    return vertices.reshape(-1, 3), faces, normals.reshape(-1, 3)


def disc(radius, y, sides=256):
    """Returns vertices and faces of a disc that looks up."""
    angle = numpy.linspace(0, 2 * math.pi, sides, endpoint=False)
    rim = numpy.stack([radius * numpy.cos(angle), numpy.full(sides, y), radius * numpy.sin(angle)],
                      axis=-1)
    number = numpy.arange(sides)
    faces = numpy.stack([numpy.full(sides, sides), numpy.roll(number, -1), number], axis=-1)
    return numpy.vstack([rim, [[0, y, 0]]]), faces


def studio(height=256):
    """Returns a lat-long map of three soft boxes in dim grey, (height, 2 * height, 3)."""
    y, x = numpy.mgrid[0:height, 0:2 * height]
    elevation = 90 - 180 * (y + 0.5) / height
    azimuth = 180 * (x + 0.5) / height  # [degrees] from the left edge of the map
    pixels = (0.05 + 0.12 * abs(elevation) / 90)[..., None] * [0.8, 0.95, 1.2]
    boxes = (((60, 40), (26, 24), (13, 11.5, 9)),  # the middle, half the size [degrees], radiance
             ((320, 32), (14, 26), (2.5, 4, 7)),
             ((190, 62), (50, 12), (6, 5.5, 5)))
    for (of_azimuth, of_elevation), (wide, high), radiance in boxes:
        across = (azimuth - of_azimuth + 180) % 360 - 180
        inside = (abs(across) < wide) & (abs(elevation - of_elevation) < high)
        pixels = numpy.where(inside[..., None], radiance, pixels)
    return pixels


def contact_sheet(frames, columns, gap=4):
    """Returns a picture of equally large frames in rows, with `gap` pixels of dark grey between."""
    height, width, _ = frames[0].shape
    rows = -(-len(frames) // columns)
    sheet = numpy.full((rows * (height + gap) + gap, columns * (width + gap) + gap, 3), 0.02)
    for number, frame in enumerate(frames):
        row, column = divmod(number, columns)
        y, x = gap + row * (height + gap), gap + column * (width + gap)
        sheet[y:y + height, x:x + width] = frame
    return sheet


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--map", help="illumination map (EXR, HDR, PFM)")
    parser.add_argument("--frames", type=int, default=12)
    parser.add_argument("--width", type=int, default=320, help="of a frame [pixels]")
    parser.add_argument("--spp", type=int, default=128)
    parser.add_argument("-o", "--output", default="turntable.png")
    arguments = parser.parse_args()

    stage = skywave.Scene()
    gold = stage.add_material("conductor", reflectance=(1.0, 0.72, 0.32), alpha=0.18, name="gold")
    slate = stage.add_material("lambert", reflectance=(0.10, 0.11, 0.13), name="slate")
    stage.add_mesh(*disc(3.7, -3.15), material=slate)
    stage.set_environment(arguments.map or studio())
    stage.set_camera(eye=(0, 3, 12.5), target=(0, -0.45, 0), fov=35)

    vertices, faces, normals = torus_knot()
    frames = []
    for number in range(arguments.frames):
        angle = 2 * math.pi * number / arguments.frames
        turn = numpy.array([[math.cos(angle), 0, math.sin(angle)], [0, 1, 0],
                            [-math.sin(angle), 0, math.cos(angle)]])
        scene = stage.copy()
        scene.add_mesh(vertices @ turn.T, faces, normals=normals @ turn.T, material=gold)
        picture = skywave.render(scene, size=(arguments.width, arguments.width * 3 // 4),
                                 spp=arguments.spp, strategy="product")
        frames.append(picture.rgb)
        print(f"frame {number + 1} of {arguments.frames}")
    columns = math.ceil(math.sqrt(arguments.frames))
    skywave.write_png(arguments.output, contact_sheet(frames, columns), tone="filmic")
    print(f"wrote {arguments.output}")


if __name__ == "__main__":
    main()
