"""Runs with Blender's module bpy: renders views of a glTF file under a map with Cycles.

    python blender_views.py JOB.json

JOB has scene, map, size, eyes, target, field_of_view, settings (see views.py) and pictures, the
names of the EXR files. Prints the seconds of each view; one more before them loads kernels and
builds the tree, which stays (persistent data).
"""
import json
import os
import sys
import time
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "peers"))
from blender_scene import add_camera, blender_axes, look, set_film, set_world  # noqa: E402

JOB = json.loads(Path(sys.argv[-1]).read_text())
SETTINGS = JOB["settings"]


def set_render(scene):
    set_film(scene, JOB["size"])
    scene.render.use_persistent_data = scene.render.film_transparent = True
    cycles = scene.cycles
    cycles.samples = SETTINGS["samples"]
    cycles.use_denoising = SETTINGS["denoise"]
    cycles.use_adaptive_sampling = SETTINGS["threshold"] > 0
    if SETTINGS["threshold"] > 0:
        cycles.adaptive_threshold = SETTINGS["threshold"]
    if SETTINGS["denoise"]:
        cycles.denoiser = "OPENIMAGEDENOISE"
    for name, value in SETTINGS.get("bounces", {}).items():
        setattr(cycles, name, value)


def main():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.import_scene.gltf(filepath=JOB["scene"])
    set_world(scene, JOB["map"])
    camera = add_camera(scene, JOB["field_of_view"], JOB["size"])
    set_render(scene)
    for number, eye in enumerate([JOB["eyes"][0], *JOB["eyes"]]):
        look(camera, blender_axes(eye), blender_axes(JOB["target"]))
        scene.cycles.seed = number
        start, processor = time.perf_counter(), time.process_time()
        bpy.ops.render.render()
        if number == 0:
            continue
        print("views: {:.4f} {:.4f}".format(time.perf_counter() - start,
                                            time.process_time() - processor), flush=True)
        if JOB["pictures"]:
            bpy.data.images["Render Result"].save_render(JOB["pictures"][number - 1])


main()
os._exit(0)  # some versions of bpy crash when Python ends
