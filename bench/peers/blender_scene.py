"""What the scripts that run inside Blender share: a map around the scene, and a camera."""
import math

import bpy
from mathutils import Vector


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


def look(camera, eye, target):
    """Places a camera, in Blender's world, whose z is up."""
    eye, target = Vector(eye), Vector(target)
    camera.location = eye
    camera.rotation_mode = "QUATERNION"
    camera.rotation_quaternion = (target - eye).to_track_quat("-Z", "Y")
