"""Describes the scenes of the comparison once, as plain data; formats.py writes them for programs.

World: y up, left-handed as in pbrt and POV-Ray, metres. The middle of the map lies along +z, its
right half along +x. `for_right_handed` makes the description that the right-handed programs get.
"""

import struct
from array import array
from dataclasses import dataclass, field, replace
from pathlib import Path

UP = (0, 1, 0)
ALBEDO = 0.5
PLANE = ([(-2, 0, -2), (2, 0, -2), (2, 0, 2), (-2, 0, 2)], [(0, 1, 2), (2, 3, 0)])


@dataclass
class Material:
    """Lambert of `color`, on both sides; with `alpha` a metal, whose facets are GGX's."""
    color: tuple = (ALBEDO, ALBEDO, ALBEDO)
    eta: tuple = ()           # refractive index of a metal in r, g, b
    k: tuple = ()             # its absorption
    alpha: float | None = None  # width of GGX, as in Walter et al. 2007


# Index of copper in the middles of red, green and blue.
COPPER = Material((0.9548, 0.6379, 0.5382), (0.2, 0.924, 1.102), (3.912, 2.452, 2.142), 0.2)


@dataclass
class Mesh:
    positions: array  # x y z of each vertex [m]
    normals: array    # likewise, unit length; empty: those of the triangles
    triangles: array  # three vertices per triangle
    material: Material = field(default_factory=Material)


@dataclass
class Scene:
    meshes: list
    eye: tuple
    target: tuple
    up: tuple
    field_of_view: float  # degrees, of the shorter side
    map: Path


def flat(rows_of_three):
    return [x for row in rows_of_three for x in row]


def read_ply(path):
    """Reads the mesh of a binary PLY with float vertices x y z [nx ny nz] and triangular faces."""
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    words = data[:end].decode().split()
    properties = [words[i + 2] for i, word in enumerate(words) if word == "property"][:-1]
    names = ["x", "y", "z", "nx", "ny", "nz"]
    if "binary_little_endian" not in words or properties not in (names, names[:3]):
        raise ValueError(f"{path}: not a binary PLY of x y z or x y z nx ny nz")
    vertices, faces = (int(words[words.index(name) + 1]) for name in ("vertex", "face"))
    width = len(properties)
    values = array("f", data[end:end + 4 * width * vertices])
    mesh = Mesh(array("f"), array("f"), array("i"))
    for i in range(0, len(values), width):
        mesh.positions.extend(values[i:i + 3])
        mesh.normals.extend(values[i + 3:i + width])
    faces = data[end + 4 * width * vertices:][:13 * faces]
    for count, a, b, c in struct.iter_unpack("<B3i", faces):
        if count != 3:
            raise ValueError(f"{path}: a face of {count} vertices")
        mesh.triangles.extend((a, b, c))
    return mesh


def read_mtl(path):
    """Returns {name: Kd}; images are left out."""
    colors, name = {}, None
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["newmtl"]:
            name = words[1]
            colors[name] = (ALBEDO, ALBEDO, ALBEDO)
        elif words[:1] == ["Kd"]:
            colors[name] = tuple(map(float, words[1:4]))
    return colors


def area_is_zero(a, b, c):
    u, v = [y - x for x, y in zip(a, b)], [y - x for x, y in zip(a, c)]
    normal = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
    return not any(normal)


def read_obj(path):
    """Reads polygons of an OBJ as one mesh for each material, mirrored into the left-handed world.

    Polygons are cut into fans, and triangles without area, on which programs differ, are dropped.
    """
    points, meshes, colors, current = [], {}, {}, None
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            x, y, z = map(float, words[1:4])
            points.append((x, y, -z))
        elif words[:1] == ["mtllib"]:
            colors.update(read_mtl(path.parent / words[1]))
        elif words[:1] == ["usemtl"]:
            current = words[1]
        elif words[:1] == ["f"]:
            corners = [int(word.split("/")[0]) for word in words[1:]]
            corners = [i - 1 if i > 0 else len(points) + i for i in corners]
            used, mesh = meshes.setdefault(current, ({}, Mesh(
                array("f"), array("f"), array("i"), Material(colors.get(current, (ALBEDO,) * 3)))))
            for b, c in zip(corners[1:], corners[2:]):
                triangle = (corners[0], c, b)  # the mirror turns the winding round
                if area_is_zero(*(points[i] for i in triangle)):
                    continue
                for i in triangle:
                    if i not in used:
                        used[i] = len(used)
                        mesh.positions.extend(points[i])
                    mesh.triangles.append(used[i])
    return [mesh for _, mesh in meshes.values() if mesh.triangles]


def plane(scale=1):
    points, triangles = PLANE
    return placed(Mesh(array("f", flat(points)), array("f"), array("i", flat(triangles))), scale)


def placed(mesh, scale, up=0):
    """Scales a mesh, and then moves it up [m]."""
    positions = array("f", (scale * x for x in mesh.positions))
    for i in range(1, len(positions), 3):
        positions[i] += up
    return replace(mesh, positions=positions)


# Files of each scene in the folder of data: its model and its map.
FILES = {"bunny": ("models/bunny.ply", "probes/latlong/grace_latlong.exr"),
         "metal": ("models/bunny.ply", "probes/latlong/grace_latlong.exr"),
         "sponza": ("models/sponza.obj", "probes/latlong/galileo_latlong.exr"),
         "killeroo": ("models/killeroo_loop1.ply", "probes/latlong/rnl_latlong.exr"),
         "buddha": ("models/buddha.obj", "probes/latlong/kitchen_latlong.exr"),
         "copper-buddha": ("models/buddha.obj", "probes/latlong/rnl_latlong.exr")}


def make(name, data):
    """Returns the scene `name` of the files in the folder `data`."""
    model, probe = (data / file for file in FILES[name])
    if name == "sponza":
        return Scene(read_obj(model), (-12, 2, 0), (10, 4, 0), UP, 60, probe)
    if name == "killeroo":
        beast = reflected(read_ply(model))
        beast.material = Material((0.4, 0.25, 0.15))
        return Scene([plane(10), placed(beast, 0.01, 1.404)], (3.5, 2, -3.5), (0, 0.7, -0.4), UP,
                     38, probe)
    if "buddha" in name:
        statue, = read_obj(model)
        if name != "buddha":
            statue.material = COPPER
        return Scene([plane(10), placed(statue, 1, 1.002)], (0.8, 1.6, -4), (0, 0.95, 0), UP, 38,
                     probe)
    bunny = read_ply(model)
    if name == "metal":
        bunny.material = COPPER
    return Scene([plane(), bunny], (-0.03, 0.14, 0.32), (-0.016, 0.072, 0), UP, 38, probe)


def exchanged(values):
    """Exchanges the second and the third of every three."""
    return array(values.typecode, flat((values[i], values[i + 2], values[i + 1])
                                       for i in range(0, len(values), 3)))


def reflected(mesh):
    """Exchanges y and z, between a left-handed world with y up and a right-handed one with z up.

    That is a reflection, so triangles reverse their winding, which the exchange of their second and
    third vertex does: otherwise their sides would contradict the normals, and surfaces would be
    black.
    """
    return Mesh(exchanged(mesh.positions), exchanged(mesh.normals), exchanged(mesh.triangles),
                mesh.material)


def for_right_handed(scene):
    """Returns the scene in a right-handed world with z up.

    The middle of the map lies along +y then, its right half along +x as before.
    """
    def point(p):
        return (p[0], p[2], p[1])

    return replace(scene, meshes=[reflected(mesh) for mesh in scene.meshes], eye=point(scene.eye),
                   target=point(scene.target), up=point(scene.up))
