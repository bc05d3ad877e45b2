"""Runs in a Python with bpy: renders one glTF asset with Cycles for fidelity.py.

    python cycles_asset.py JOB.json

The job names the file, the map, the camera (in the axes of glTF: y up) and the picture to write, an
EXR. Everything of the asset is what Blender's own importer makes of it.
"""

import json
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "peers"))
from blender_scene import add_camera, look, set_world  # noqa: E402

JOB = json.loads(Path(sys.argv[1]).read_text())


def blender_axes(point):
    """Returns a point of glTF as the importer places it: z up."""
    x, y, z = point
    return x, -z, y


bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=JOB["file"])
SCENE = bpy.context.scene
set_world(SCENE, JOB["map"])
camera = add_camera(SCENE, JOB["field_of_view"], JOB["size"])
distance = sum((a - b) ** 2 for a, b in zip(JOB["eye"], JOB["target"])) ** 0.5
camera.data.clip_start, camera.data.clip_end = distance * 1e-3, distance * 1e3
look(camera, blender_axes(JOB["eye"]), blender_axes(JOB["target"]))

SCENE.render.engine = "CYCLES"
SCENE.render.resolution_x, SCENE.render.resolution_y = JOB["size"]
SCENE.render.resolution_percentage = 100
SCENE.render.use_compositing = SCENE.render.use_sequencer = False
SCENE.render.image_settings.file_format = "OPEN_EXR"
SCENE.render.image_settings.color_mode = "RGB"
SCENE.render.image_settings.color_depth = "32"
SCENE.render.image_settings.exr_codec = "ZIP"
SCENE.view_settings.view_transform = "Raw"
cycles = SCENE.cycles
cycles.device = "CPU"
cycles.samples = JOB["samples"]
cycles.use_denoising = cycles.use_adaptive_sampling = False
# The counts are of surfaces after the first one.
cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = JOB["depth"] - 1
cycles.transmission_bounces = JOB["depth"] - 1
cycles.transparent_max_bounces = 64
cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
cycles.blur_glossy = 0  # would make glossy surfaces rougher behind diffuse ones
cycles.caustics_reflective = cycles.caustics_refractive = True
cycles.pixel_filter_type = "BOX"
bpy.ops.render.render()
bpy.data.images["Render Result"].save_render(JOB["picture"])
