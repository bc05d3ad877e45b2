"""What the scripts that run inside Blender share: map, camera, film and lengths of paths."""
import math
import sys
from pathlib import Path

import bpy
from mathutils import Vector

sys.path.insert(0, str(Path(__file__).resolve().parent))
from scene import read_ply  # noqa: E402


def set_world(scene, file):
    """Sets the map: its middle along +y, its right half along +x, as stored."""
    world = scene.world = bpy.data.worlds.new("world")
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    coordinates, mapping, texture, background, output = (
        nodes.new("ShaderNode" + name)
        for name in ("TexCoord", "Mapping", "TexEnvironment", "Background", "OutputWorld"))
    mapping.inputs["Rotation"].default_value = (0, 0, -math.pi / 2)
    texture.image = bpy.data.images.load(str(file))
    background.inputs["Strength"].default_value = 1
    links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    links.new(texture.outputs["Color"], background.inputs["Color"])
    links.new(background.outputs[0], output.inputs["Surface"])
    return world


def add_camera(scene, field_of_view, size):
    """Adds the camera of a scene; the field of view [degrees] is that of the shorter side."""
    data = bpy.data.cameras.new("camera")
    width, height = size
    data.sensor_fit = "VERTICAL" if height <= width else "HORIZONTAL"
    data.angle = math.radians(field_of_view)
    data.clip_start, data.clip_end = 1e-4, 1e4
    camera = bpy.data.objects.new("camera", data)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return camera


def set_film(scene, size):
    """Has Cycles render pictures of linear floats, without post-processing, on the CPU."""
    render = scene.render
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = size
    render.resolution_percentage = 100
    render.use_compositing = render.use_sequencer = False
    image = render.image_settings
    image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGB", "32"
    image.exr_codec = "ZIP"
    scene.view_settings.view_transform = "Raw"
    scene.cycles.device = "CPU"


def set_light_paths(scene, depth):
    """Sets the number of surfaces of a path, and has no light clamped or blurred away."""
    cycles = scene.cycles
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    # The counts are of surfaces after the first one.
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = depth - 1
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = 0  # would make glossy surfaces rougher behind diffuse ones
    cycles.caustics_reflective = True
    cycles.pixel_filter_type = "BOX"


def blender_axes(point):
    """Returns the place in Blender's world, whose z is up, of a point of glTF."""
    x, y, z = point
    return x, -z, y


def look(camera, eye, target):
    """Places a camera, in Blender's world, whose z is up."""
    eye, target = Vector(eye), Vector(target)
    camera.location = eye
    camera.rotation_mode = "QUATERNION"
    camera.rotation_quaternion = (target - eye).to_track_quat("-Z", "Y")


def add_mesh(scene, name, file, material):
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
    scene.collection.objects.link(bpy.data.objects.new(name, mesh))


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


def build(scene, job):
    """Builds the meshes, map, camera and settings of a job of peers.py."""
    for index, one in enumerate(job["meshes"]):
        add_mesh(scene, f"mesh {index}", one["file"], add_material(one["material"]))
    world = set_world(scene, job["map"])
    world.cycles.sampling_method = "MANUAL"
    world.cycles.sample_map_resolution = job["map_width"]
    look(add_camera(scene, job["field_of_view"], job["size"]), job["eye"], job["target"])
    set_film(scene, job["size"])
    set_light_paths(scene, job["depth"])
    scene.render.threads_mode = "FIXED"
    scene.render.threads = job["threads"]
    scene.cycles.time_limit = 0
    scene.cycles.caustics_refractive = False
    scene.cycles.film_exposure = 1
