"""Holds the scene of the comparison as plain data and writes its text for every program.

World: y up, left-handed as in pbrt and POV-Ray, metres. The middle of the map lies along +z, its
right half along +x; the camera looks towards -z. The scene is the one that scripts/data_scenes.sh
writes, except that the bunny has the plane's grey.
"""

import struct
from array import array
from dataclasses import dataclass

EYE, TARGET, UP = (-0.03, 0.14, 0.32), (-0.016, 0.072, 0), (0, 1, 0)
FIELD_OF_VIEW = 38  # degrees, of the shorter side
ALBEDO = 0.5
PLANE = ([(-2, 0, -2), (2, 0, -2), (2, 0, 2), (-2, 0, 2)], [(0, 1, 2), (2, 3, 0)])


@dataclass
class Mesh:
    positions: array  # x y z of each vertex [m]
    normals: array    # likewise, unit length
    triangles: array  # three vertices per triangle


def read_ply(path):
    """Reads the mesh of a binary PLY with float vertices x y z nx ny nz and triangular faces."""
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    words = data[:end].decode().split()
    properties = [words[i + 2] for i, word in enumerate(words) if word == "property"][:6]
    if "binary_little_endian" not in words or properties != ["x", "y", "z", "nx", "ny", "nz"]:
        raise ValueError(f"{path}: not a binary PLY of x y z nx ny nz")
    vertices, faces = (int(words[words.index(name) + 1]) for name in ("vertex", "face"))
    values = array("f", data[end:end + 24 * vertices])
    mesh = Mesh(array("f"), array("f"), array("i"))
    for i in range(0, len(values), 6):
        mesh.positions.extend(values[i:i + 3])
        mesh.normals.extend(values[i + 3:i + 6])
    for count, a, b, c in struct.iter_unpack("<B3i", data[end + 24 * vertices:][:13 * faces]):
        if count != 3:
            raise ValueError(f"{path}: a face of {count} vertices")
        mesh.triangles.extend((a, b, c))
    return mesh


def rows(values, separator=" "):
    """Formats three numbers per line."""
    return [separator.join(f"{x:.9g}" for x in values[i:i + 3]) for i in range(0, len(values), 3)]


def flat(rows_of_three):
    return [x for row in rows_of_three for x in row]


def write_pbrt(file, bunny_ply):
    points, triangles = PLANE
    file.write_text(
        "LookAt {} {} {}  {} {} {}  {} {} {}\n".format(*EYE, *TARGET, *UP)
        + f'Camera "perspective" "float fov" [{FIELD_OF_VIEW}]\n'
        'Integrator "path"\nWorldBegin\n'
        f'Material "matte" "rgb Kd" [{ALBEDO} {ALBEDO} {ALBEDO}]\n'
        f'Shape "trianglemesh" "point P" [{" ".join(map(str, flat(points)))}]\n'
        f'  "integer indices" [{" ".join(map(str, flat(triangles)))}]\n'
        f'Shape "plymesh" "string filename" ["{bunny_ply}"]\nWorldEnd\n')


def write_embree(file, bunny):
    """Writes Embree's XML; lights are passed by flag."""
    def block(name, lines):
        return f"<{name}>\n" + "\n".join(lines) + f"\n</{name}>\n"

    points, triangles = PLANE
    file.write_text(
        '<?xml version="1.0"?>\n<scene>\n<TriangleMesh>\n<material id="0"><code>"Matte"</code>'
        f'<parameters><float3 name="reflectance">{ALBEDO} {ALBEDO} {ALBEDO}</float3></parameters>'
        "</material>\n" + block("positions", rows(flat(points)))
        + block("triangles", rows(flat(triangles)))
        + '</TriangleMesh>\n<TriangleMesh>\n<material id="0"/>\n'
        + block("positions", rows(bunny.positions)) + block("normals", rows(bunny.normals))
        + block("triangles", rows(bunny.triangles)) + "</TriangleMesh>\n</scene>\n")


def write_povray(file, bunny, lights_file, aspect):
    """Writes POV-Ray 3.7: no ambient light, diffuse only, lights from `skywave probe lights`."""
    def block(name, lines):
        return f"{name} {{ {len(lines)},\n" + ",\n".join(f"<{line}>" for line in lines) + " }\n"

    def point(p):
        return "<{}, {}, {}>".format(*p)

    a, b, c, d = PLANE[0]
    angle = f"2 * degrees(atan({aspect:.9g} * tan(radians({FIELD_OF_VIEW}) / 2)))"
    grey = f"pigment {{ rgb {ALBEDO} }} finish {{ ambient 0 diffuse 1 }}"
    file.write_text(
        "#version 3.7;\nglobal_settings { assumed_gamma 1 max_trace_level 5 }\n"
        f'#include "{lights_file}"\n'
        f"camera {{ perspective location {point(EYE)} sky {point(UP)} right x*{aspect:.9g} up y\n"
        f"  angle {angle} look_at {point(TARGET)} }}\n"
        f"#declare Grey = texture {{ {grey} }}\n"
        f"mesh {{ triangle {{ {point(a)}, {point(b)}, {point(c)} }}\n"
        f"  triangle {{ {point(c)}, {point(d)}, {point(a)} }} texture {{ Grey }} }}\n"
        "mesh2 {\n" + block("vertex_vectors", rows(bunny.positions, ", "))
        + block("normal_vectors", rows(bunny.normals, ", "))
        + block("face_indices", rows(bunny.triangles, ", ")) + "texture { Grey } }\n")


def blender_mesh(points, triangles, normals=()):
    """Writes JSON for blender_render.py, in Blender's right-handed world with z up.

    The exchange of y and z is a reflection, so triangles must reverse their winding, which the same
    exchange of their second and third vertex does: otherwise their sides would contradict the
    normals, and surfaces would be black.
    """
    def turned(values):
        return flat((values[i], values[i + 2], values[i + 1]) for i in range(0, len(values), 3))

    return {"positions": turned(points), "normals": turned(normals), "triangles": turned(triangles)}


def blender_scene(bunny):
    points, triangles = PLANE
    return {"meshes": [blender_mesh(flat(points), flat(triangles)),
                       blender_mesh(bunny.positions, bunny.triangles, bunny.normals)],
            "eye": [EYE[0], EYE[2], EYE[1]], "target": [TARGET[0], TARGET[2], TARGET[1]],
            "field_of_view": FIELD_OF_VIEW, "albedo": ALBEDO}
