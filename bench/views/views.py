#!/usr/bin/env python3
"""Views an hour of a glTF file under a map, as data sets have them by the thousand: skywave batch
beside Cycles, which Kubric and BlenderProc render with.

    bench/views/views.py helmet.glb --env studio.hdr --blender PYTHON

PYTHON is one that imports bpy (bench/peers/setup.sh blender makes one). The error of a setting is
that of its first view against a converged picture by the same program, so materials and filters may
differ: mean of (x - r)^2 / (r^2 + 0.01), as `skywave compare` has it. The map lights the object and
is not seen, because the lamps of a map are sharper than any filter. Times are those of a view once
the scene is loaded: of Skywave a batch of some views less one of a single view. The machine should
do nothing else, and both should have Open Image Denoise.
"""
import argparse
import json
import math
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
# What blenderproc.python.utility.DefaultConfig sets.
BLENDERPROC = {"samples": 1024, "threshold": 0.01, "denoise": True, "bounces": {
    "diffuse_bounces": 3, "glossy_bounces": 0, "max_bounces": 3, "transmission_bounces": 0,
    "transparent_max_bounces": 8, "volume_bounces": 0}}
CYCLES = {
    "Cycles, 128 samples, OIDN": {"samples": 128, "threshold": 0, "denoise": True},
    "Cycles, 32 samples, OIDN": {"samples": 32, "threshold": 0, "denoise": True},
    "BlenderProc's defaults": BLENDERPROC,
}
SKYWAVE = {
    f"skywave batch, {samples} samples, {by}": {"spp": samples, "denoise": by}
    for by in ("quick", "best") for samples in (16, 32, 64, 128)
}


def eyes_around(count, distance):
    """Returns places around the origin, above the horizon, by the golden angle."""
    places = []
    for i in range(count):
        height = 0.1 + 0.7 * (i + 0.5) / count
        angle, radius = i * math.pi * (3 - math.sqrt(5)), math.sqrt(1 - height * height)
        places.append([round(distance * x, 4) for x in
                       (radius * math.sin(angle), height, radius * math.cos(angle))])
    return places


def relative_error(picture, reference):
    """Returns the relative mean square error of the values of a picture."""
    return statistics.fmean((x - r) ** 2 / (r * r + 0.01) for x, r in zip(picture, reference))


class Skywave:
    def __init__(self, given, folder):
        self.given, self.folder = given, folder

    def batch(self, name, eyes, **settings):
        """Returns seconds and processor seconds of a batch, and the name of its first picture."""
        folder = self.folder / name
        job = {"scene": str(Path(self.given.scene).resolve()),
               "env": str(Path(self.given.env).resolve()),
               "size": f"{self.given.size}x{self.given.size}", "target": "0,0,0",
               "fov": self.given.field_of_view, "background": "transparent", **settings}
        places = [",".join(map(str, eye)) for eye in eyes]
        lines = ["[base]", *(f"{key} = {json.dumps(value)}" for key, value in job.items()),
                 "[axes]", "eye = " + json.dumps(places),
                 "[output]", f'path = "{folder}/{{eye}}.exr"']
        file = self.folder / f"{name}.toml"
        file.write_text("\n".join(lines) + "\n")
        before, start = os.times(), time.perf_counter()
        done = subprocess.run([self.given.program, "batch", file], stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE, text=True)
        if done.returncode:
            sys.exit(f"skywave batch failed:\n{done.stderr[-2000:]}")
        seconds, after = time.perf_counter() - start, os.times()
        processor = (after.children_user + after.children_system - before.children_user
                     - before.children_system)
        return seconds, processor, folder / f"{places[0]}.exr"

    def measure(self, number, settings, eyes):
        one = self.batch(f"one_{number}", eyes[:1], **settings)
        all_views = self.batch(f"all_{number}", eyes, **settings)
        more = len(eyes) - 1
        if all_views[0] < 2 * one[0]:
            print(f"{more} more views took {all_views[0] - one[0]:.2g} s, and the first one "
                  f"{one[0]:.2g} s: more --views are needed", file=sys.stderr)
        return (all_views[0] - one[0]) / more, (all_views[1] - one[1]) / more, one[2]

    def reference(self, eyes):
        return self.batch("reference", eyes[:1], spp=self.given.reference)[2]


class Cycles:
    def __init__(self, given, folder):
        self.given, self.folder = given, folder

    def render(self, name, settings, eyes):
        """Returns seconds and processor seconds of each view, and the name of the first picture."""
        pictures = [str(self.folder / f"cycles_{name}_{i}.exr") for i in range(len(eyes))]
        job = self.folder / f"cycles_{name}.json"
        job.write_text(json.dumps({
            "scene": str(Path(self.given.scene).resolve()),
            "map": str(Path(self.given.env).resolve()), "size": [self.given.size] * 2,
            "eyes": eyes, "target": [0, 0, 0], "field_of_view": self.given.field_of_view,
            "settings": settings, "pictures": pictures}))
        text = subprocess.run([self.given.blender, HERE / "blender_views.py", job], check=True,
                              capture_output=True, text=True).stdout
        times = [(float(a), float(b)) for a, b in re.findall(r"views: ([\d.]+) ([\d.]+)", text)]
        if len(times) != len(eyes):
            sys.exit(f"bpy rendered {len(times)} of {len(eyes)} views:\n{text[-2000:]}")
        return times, pictures[0]

    def measure(self, number, settings, eyes):
        times, picture = self.render(number, settings, eyes)
        seconds, processor = (sum(column) / len(times) for column in zip(*times))
        return seconds, processor, picture

    def reference(self, eyes):
        settings = {"samples": self.given.reference, "threshold": 0, "denoise": False}
        return self.render("reference", settings, eyes[:1])[1]


def rows_of(program, settings, eyes, read):
    """Returns a row (name, seconds, processor seconds, error) for each setting."""
    reference = read(program.reference(eyes))
    rows = []
    for number, (name, values) in enumerate(settings.items()):
        seconds, processor, picture = program.measure(number, values, eyes)
        rows.append((name, seconds, processor, relative_error(read(picture), reference)))
    return rows


def table(ours, theirs):
    """Returns the table as Markdown. The last column compares each row of theirs with our fastest
    row that has no greater error."""
    lines = ["| program | views an hour | processor seconds a view | relative mse | Skywave at no "
             "greater error |", "| --- | ---: | ---: | ---: | ---: |"]
    for name, seconds, processor, error in [*ours, *theirs]:
        better = [row[1] for row in ours if row[3] <= error]
        ratio = "" if (name, seconds, processor, error) in ours else (
            f"{seconds / min(better):.0f} times as fast" if better else "none has it")
        lines.append(f"| {name} | {3600 / seconds:.0f} | {processor:.3g} | {error:.2g} | {ratio} |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", help="a glTF file about the origin")
    parser.add_argument("--env", required=True, metavar="MAP")
    parser.add_argument("--blender", metavar="PYTHON", help="without it Skywave is alone")
    parser.add_argument("--program", default="skywave")
    parser.add_argument("--size", type=int, default=512, metavar="PIXELS")
    parser.add_argument("--views", type=int, default=9)
    parser.add_argument("--blender-views", type=int, default=3)
    parser.add_argument("--reference", type=int, default=4096, metavar="SAMPLES")
    parser.add_argument("--distance", type=float, default=4)
    parser.add_argument("--field-of-view", type=float, default=35, metavar="DEGREES")
    given = parser.parse_args()
    import skywave

    def read(path):
        return skywave.read_image(path).ravel().tolist()

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        ours = rows_of(Skywave(given, folder), SKYWAVE, eyes_around(given.views, given.distance),
                       read)
        theirs = []
        if given.blender:
            theirs = rows_of(Cycles(given, folder), CYCLES,
                             eyes_around(given.blender_views, given.distance), read)
    print(table(ours, theirs))


if __name__ == "__main__":
    main()
