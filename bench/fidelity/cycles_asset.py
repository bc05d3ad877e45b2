"""Runs in a Python with bpy: renders one glTF asset with Cycles for fidelity.py.

    python cycles_asset.py JOB.json

The job names the file, the map, the camera (in the axes of glTF: y up) and the picture to write, an
EXR. Everything of the asset is what Blender's own importer makes of it.
"""

import json
import math
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "peers"))
from blender_scene import (  # noqa: E402
    add_camera, blender_axes, look, set_film, set_light_paths, set_world)

JOB = json.loads(Path(sys.argv[1]).read_text())

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=JOB["file"])
SCENE = bpy.context.scene
set_world(SCENE, JOB["map"])
camera = add_camera(SCENE, JOB["field_of_view"], JOB["size"])
distance = math.dist(JOB["eye"], JOB["target"])
camera.data.clip_start, camera.data.clip_end = distance * 1e-3, distance * 1e3
look(camera, blender_axes(JOB["eye"]), blender_axes(JOB["target"]))

set_film(SCENE, JOB["size"])
set_light_paths(SCENE, JOB["depth"])
SCENE.cycles.samples = JOB["samples"]
SCENE.cycles.transmission_bounces = JOB["depth"] - 1
SCENE.cycles.transparent_max_bounces = 64
SCENE.cycles.caustics_refractive = True
bpy.ops.render.render()
bpy.data.images["Render Result"].save_render(JOB["picture"])
