"""Runs inside Blender, or with its module bpy: renders a job of peers.py with Cycles.

    blender -b --factory-startup --python blender_render.py -- JOB.json
    python blender_render.py -- JOB.json

Prints the time of each render. Settings that change the amount of work are made here. Sampling
pattern, roulette, the threshold of light samples, tiles and tree are Cycles's defaults, as its
users have them.
"""

import json
import math
import sys
import time
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))
from blender_scene import (  # noqa: E402
    add_camera, look, set_film, set_light_paths, set_world)
from scene import read_ply  # noqa: E402

JOB = json.loads(Path(sys.argv[sys.argv.index("--") + 1]).read_text())
bpy.ops.wm.read_factory_settings(use_empty=True)
SCENE = bpy.context.scene


def add_mesh(name, file, material):
    data = read_ply(Path(file))

    def threes(values):
        return [tuple(values[i:i + 3]) for i in range(0, len(values), 3)]

    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(threes(data.positions), [], threes(data.triangles))
    if data.normals:
        mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
        if hasattr(mesh, "use_auto_smooth"):  # before Blender 4.1, enables the normals of the file
            mesh.use_auto_smooth = True
        mesh.normals_split_custom_set_from_vertices(threes(data.normals))
    mesh.materials.append(material)
    SCENE.collection.objects.link(bpy.data.objects.new(name, mesh))


def reflectance(eta, k):
    """Returns Fresnel's reflectance of a metal at normal incidence."""
    return ((eta - 1) ** 2 + k * k) / ((eta + 1) ** 2 + k * k)


def metal(nodes, described):
    """Returns a node; Blender before 4.3 has no Fresnel of metals but a constant reflectance.

    Cycles squares the roughness to get the width of GGX.
    """
    if hasattr(bpy.types, "ShaderNodeBsdfMetallic"):
        node = nodes.new("ShaderNodeBsdfMetallic")
        node.fresnel_type = "PHYSICAL_CONDUCTOR"
        node.inputs["IOR"].default_value = described["eta"]
        node.inputs["Extinction"].default_value = described["k"]
    else:
        node = nodes.new("ShaderNodeBsdfGlossy")
        node.inputs["Color"].default_value = (
            *map(reflectance, described["eta"], described["k"]), 1)
    node.distribution = "GGX"
    node.inputs["Roughness"].default_value = math.sqrt(described["alpha"])
    return node


def diffuse(nodes, described):
    node = nodes.new("ShaderNodeBsdfDiffuse")
    node.inputs["Color"].default_value = (*described["color"], 1)
    node.inputs["Roughness"].default_value = 0
    return node


def add_material(described):
    material = bpy.data.materials.new("material")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    node = (diffuse if described["alpha"] is None else metal)(nodes, described)
    output = nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(node.outputs[0], output.inputs["Surface"])
    return material


def set_render():
    set_film(SCENE, JOB["size"])
    set_light_paths(SCENE, JOB["depth"])
    SCENE.render.threads_mode = "FIXED"
    SCENE.render.threads = JOB["threads"]
    SCENE.cycles.time_limit = 0
    SCENE.cycles.caustics_refractive = False
    SCENE.cycles.film_exposure = 1


def render(samples, seed):
    """Returns the seconds of the whole call."""
    SCENE.cycles.samples, SCENE.cycles.seed = samples, seed
    start = time.perf_counter()
    bpy.ops.render.render()
    return time.perf_counter() - start


for index, one in enumerate(JOB["meshes"]):
    add_mesh(f"mesh {index}", one["file"], add_material(one["material"]))
world = set_world(SCENE, JOB["map"])
world.cycles.sampling_method = "MANUAL"
world.cycles.sample_map_resolution = JOB["map_width"]
look(add_camera(SCENE, JOB["field_of_view"], JOB["size"]), JOB["eye"], JOB["target"])
set_render()
render(1, 0)  # loads kernels
print("peers: one sample {:.6f}".format(render(1, JOB["seed"])), flush=True)
print("peers: all samples {:.6f}".format(render(JOB["samples"], JOB["seed"])), flush=True)
bpy.data.images["Render Result"].save_render(JOB["picture"])
