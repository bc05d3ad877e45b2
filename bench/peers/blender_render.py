"""Runs inside Blender: renders a job of peers.py with Cycles and prints the time of each render.

    blender -b --factory-startup --python blender_render.py -- JOB.json

Settings that change the amount of work are made here. Sampling pattern, roulette, the threshold of
light samples, tiles and tree are Cycles's defaults, as its users have them.
"""

import json
import math
import sys
import time

import bpy
from mathutils import Vector

with open(sys.argv[sys.argv.index("--") + 1]) as file:
    JOB = json.load(file)
SCENE = bpy.context.scene


def add_mesh(name, data, material):
    mesh = bpy.data.meshes.new(name)
    positions, triangles = data["positions"], data["triangles"]
    mesh.from_pydata([positions[i:i + 3] for i in range(0, len(positions), 3)], [],
                     [triangles[i:i + 3] for i in range(0, len(triangles), 3)])
    if data["normals"]:
        normals = data["normals"]
        mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
        mesh.use_auto_smooth = True  # enables the normals of the file
        mesh.normals_split_custom_set_from_vertices(
            [normals[i:i + 3] for i in range(0, len(normals), 3)])
    mesh.materials.append(material)
    SCENE.collection.objects.link(bpy.data.objects.new(name, mesh))


def grey(albedo):
    material = bpy.data.materials.new("grey")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    diffuse = nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (albedo, albedo, albedo, 1)
    diffuse.inputs["Roughness"].default_value = 0
    output = nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
    return material


def set_world(file):
    """Sets the map: its middle along +y, its right half along +x, as stored."""
    world = SCENE.world
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    coordinates = nodes.new("ShaderNodeTexCoord")
    mapping = nodes.new("ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value = (0, 0, -math.pi / 2)
    texture = nodes.new("ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.load(file)
    links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    background = next(node for node in nodes if node.type == "BACKGROUND")
    background.inputs["Strength"].default_value = 1
    links.new(texture.outputs["Color"], background.inputs["Color"])
    world.cycles.sampling_method = "MANUAL"
    world.cycles.sample_map_resolution = JOB["map_width"]


def set_camera():
    camera = bpy.data.cameras.new("camera")
    width, height = JOB["size"]
    camera.sensor_fit = "VERTICAL" if height <= width else "HORIZONTAL"
    camera.angle = math.radians(JOB["field_of_view"])
    camera.clip_start, camera.clip_end = 1e-4, 1e4
    eye = bpy.data.objects.new("camera", camera)
    direction = Vector(JOB["target"]) - Vector(JOB["eye"])
    eye.location = JOB["eye"]
    eye.rotation_mode = "QUATERNION"
    eye.rotation_quaternion = direction.to_track_quat("-Z", "Y")
    SCENE.collection.objects.link(eye)
    SCENE.camera = eye


def set_render():
    SCENE.render.engine = "CYCLES"
    SCENE.render.resolution_x, SCENE.render.resolution_y = JOB["size"]
    SCENE.render.resolution_percentage = 100
    SCENE.render.threads_mode = "FIXED" if JOB["threads"] else "AUTO"
    if JOB["threads"]:
        SCENE.render.threads = JOB["threads"]
    SCENE.render.use_compositing = SCENE.render.use_sequencer = False
    SCENE.render.image_settings.file_format = "OPEN_EXR"
    SCENE.render.image_settings.color_mode = "RGB"
    SCENE.render.image_settings.color_depth = "32"
    SCENE.render.image_settings.exr_codec = "ZIP"
    SCENE.view_settings.view_transform = "Raw"
    cycles = SCENE.cycles
    cycles.device = "CPU"
    cycles.use_denoising = False
    cycles.use_adaptive_sampling = False
    cycles.time_limit = 0
    # `max_bounces` counts the surfaces after the first one.
    cycles.max_bounces = cycles.diffuse_bounces = JOB["depth"] - 1
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.caustics_reflective = cycles.caustics_refractive = False
    cycles.film_exposure = 1
    cycles.pixel_filter_type = "BOX"


def render(samples, seed):
    """Returns the seconds of the whole call."""
    SCENE.cycles.samples, SCENE.cycles.seed = samples, seed
    start = time.perf_counter()
    bpy.ops.render.render()
    return time.perf_counter() - start


for thing in list(bpy.data.objects):
    bpy.data.objects.remove(thing)
MATERIAL = grey(JOB["albedo"])
for index, one in enumerate(JOB["meshes"]):
    add_mesh(f"mesh {index}", one, MATERIAL)
set_world(JOB["map"])
set_camera()
set_render()
render(1, 0)  # loads kernels
print("peers: one sample {:.6f}".format(render(1, JOB["seed"])), flush=True)
print("peers: all samples {:.6f}".format(render(JOB["samples"], JOB["seed"])), flush=True)
bpy.data.images["Render Result"].save_render(JOB["picture"])
