#!/usr/bin/env python3
"""Measures time and memory of loading a large mesh: writes a binary PLY of a hilly square, reads it
and builds its BVH with `skywave info`, and prints both next to what BVH and mesh need in any
renderer.

usage: scripts/load_bench.py FOLDER [MILLIONS_OF_TRIANGLES=10] [PROGRAM=build/release/skywave]

FOLDER receives the mesh (13 bytes per triangle and 12 per vertex) and keeps it for the next time.
"""
import array
import json
import math
import os
import resource
import subprocess
import sys

MIB = 1024.0 * 1024.0


def write_ply(path, side):
    """Writes side x side vertices, and two triangles for each square between them."""
    vertices, squares = side * side, (side - 1) * (side - 1)
    with open(path + ".part", "wb") as out:
        out.write(
            (
                "ply\nformat binary_little_endian 1.0\n"
                f"element vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n"
                f"element face {2 * squares}\nproperty list uchar int vertex_indices\nend_header\n"
            ).encode()
        )
        for row in range(side):
            line = array.array("f")
            for column in range(side):
                x, z = column / (side - 1), row / (side - 1)
                line.extend((x, 0.05 * math.sin(31 * x) * math.cos(23 * z + 5 * x), z))
            out.write(line.tobytes())
        for row in range(side - 1):
            line = bytearray()
            for corner in range(row * side, row * side + side - 1):
                below = corner + side
                for triangle in ((corner, below, corner + 1), (corner + 1, below, below + 1)):
                    line += b"\3" + array.array("i", triangle).tobytes()
            out.write(line)
    os.rename(path + ".part", path)


def main():
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        print(__doc__.strip())
        return 64
    folder = sys.argv[1]
    millions = float(sys.argv[2]) if len(sys.argv) > 2 else 10.0
    program = sys.argv[3] if len(sys.argv) > 3 else "build/release/skywave"
    side = int(math.sqrt(millions * 1e6 / 2)) + 1
    mesh, report = (os.path.join(folder, f"hills_{side}.{end}") for end in ("ply", "json"))
    if not os.path.exists(mesh):
        write_ply(mesh, side)
    subprocess.run([program, "info", mesh, "--json", report], check=True, stdout=subprocess.DEVNULL)
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024
    with open(report) as text:
        info = json.load(text)
    needed = info["bytes"]["bvh"] + info["bytes"]["meshes"]
    print(f"triangles {info['triangles']}, file {os.path.getsize(mesh) / MIB:.0f} MiB")
    print(f"load {info['seconds']['load']:.2f} s, build {info['seconds']['build']:.2f} s")
    print(
        f"BVH {info['bytes']['bvh'] / MIB:.0f} MiB, mesh {info['bytes']['meshes'] / MIB:.0f} MiB, "
        f"peak {peak / MIB:.0f} MiB: {peak / needed:.2f} times both"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
