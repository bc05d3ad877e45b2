"""Runs with Blender's module bpy: renders a job of measure.py with the shadow catcher of Cycles.

    python blender_catcher.py -- JOB.json
"""

import json
import math
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "peers"))
from blender_scene import add_camera, look, set_world  # noqa: E402

JOB = json.loads(Path(sys.argv[sys.argv.index("--") + 1]).read_text())
bpy.ops.wm.read_factory_settings(use_empty=True)
SCENE = bpy.context.scene


def material_of(name, node_type, settings):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    node = nodes.new(node_type)
    for key, value in settings.items():
        node.inputs[key].default_value = value
    output = nodes.new("ShaderNodeOutputMaterial")
    links.new(node.outputs[0], output.inputs["Surface"])
    return material, node


def add_table():
    table = JOB["table"]
    bpy.ops.mesh.primitive_plane_add(size=2 * table["half"])
    plane = bpy.context.object
    bright, dark = ((*color, 1) for color in table["colors"])
    if table["coat"] is None:
        material, node = material_of("table", "ShaderNodeBsdfDiffuse", {"Roughness": 0})
        color = node.inputs["Color"]
    else:
        material, node = material_of("table", "ShaderNodeBsdfPrincipled", {
            "Roughness": math.sqrt(table["coat"]), "IOR": 1.5})
        color = node.inputs["Base Color"]
    nodes, links = material.node_tree.nodes, material.node_tree.links
    checker = nodes.new("ShaderNodeTexChecker")
    checker.inputs["Scale"].default_value = table["tiles"]
    checker.inputs["Color1"].default_value, checker.inputs["Color2"].default_value = bright, dark
    coordinates = nodes.new("ShaderNodeTexCoord")
    links.new(coordinates.outputs["UV"], checker.inputs["Vector"])
    links.new(checker.outputs["Color"], color)
    plane.data.materials.append(material)
    plane.is_shadow_catcher = True


def add_ball(ball):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=180, ring_count=90, radius=ball["radius"],
                                         location=ball["centre"])
    bpy.ops.object.shade_smooth()
    color = (*ball["color"], 1)
    if "roughness" in ball:  # Cycles squares it to get alpha
        material, node = material_of("ball", "ShaderNodeBsdfGlossy", {
            "Color": color, "Roughness": math.sqrt(ball["roughness"])})
        node.distribution = "GGX"
    else:
        material, _ = material_of("ball", "ShaderNodeBsdfDiffuse", {"Color": color, "Roughness": 0})
    bpy.context.object.data.materials.append(material)


def set_render():
    render, cycles = SCENE.render, SCENE.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = JOB["size"]
    render.resolution_percentage = 100
    render.film_transparent = True
    render.use_compositing = render.use_sequencer = False
    settings = render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGBA", "32"
    settings.exr_codec = "ZIP"
    SCENE.view_settings.view_transform = "Raw"
    cycles.device = "CPU"
    cycles.samples, cycles.seed = JOB["samples"], 1
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = 7
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = 0


add_table()
for one in JOB["balls"]:
    add_ball(one)
set_world(SCENE, JOB["map"])
look(add_camera(SCENE, JOB["field_of_view"], JOB["size"]), JOB["eye"], JOB["target"])
set_render()
bpy.ops.render.render()
bpy.data.images["Render Result"].save_render(JOB["picture"])
