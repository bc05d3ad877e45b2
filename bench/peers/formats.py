"""Writes a scene of scene.py for programs: as text of their own, or as JSON and PLY files."""

import json
import struct
from array import array

import scene as scenes


def rows(values, separator=" "):
    """Formats three numbers per line."""
    return [separator.join(f"{x:.9g}" for x in values[i:i + 3]) for i in range(0, len(values), 3)]


def words(values):
    return " ".join(f"{x:.9g}" for x in values)


def ply_bytes(mesh):
    vertices, faces = len(mesh.positions) // 3, len(mesh.triangles) // 3
    names = ("x", "y", "z", "nx", "ny", "nz") if mesh.normals else ("x", "y", "z")
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\n"
              + "".join(f"property float {name}\n" for name in names)
              + f"element face {faces}\nproperty list uchar int vertex_indices\nend_header\n")
    values = mesh.positions
    if mesh.normals:
        values = array("f", (x for i in range(0, len(mesh.positions), 3)
                             for part in (mesh.positions, mesh.normals) for x in part[i:i + 3]))
    return (header.encode() + struct.pack(f"<{len(values)}f", *values)
            + b"".join(struct.pack("<B3i", 3, *mesh.triangles[i:i + 3])
                       for i in range(0, len(mesh.triangles), 3)))


def write_meshes(folder, stem, meshes):
    """Returns the names of the PLY files in `folder`."""
    names = [f"{stem}_{i}.ply" for i in range(len(meshes))]
    for name, mesh in zip(names, meshes):
        (folder / name).write_bytes(ply_bytes(mesh))
    return names


def pbrt_material(material):
    if material.alpha is None:
        return f'Material "diffuse" "rgb reflectance" [{words(material.color)}]\n'
    return (f'Material "conductor" "rgb eta" [{words(material.eta)}]\n'
            f'  "rgb k" [{words(material.k)}]\n'
            f'  "float roughness" [{material.alpha:.9g}] "bool remaproughness" false\n')


def pbrt_camera(scene):
    return ("LookAt {} {} {}  {} {} {}  {} {} {}\n".format(*scene.eye, *scene.target, *scene.up)
            + f'Camera "perspective" "float fov" [{scene.field_of_view}]\n')


def write_pbrt(folder, stem, scene):
    """Writes FOLDER/STEM.pbrt for Skywave, and STEM_world.pbrt, which the file of pbrt includes.

    Returns all files that it has written.
    """
    names = write_meshes(folder, stem + "_left", scene.meshes)
    (folder / f"{stem}_world.pbrt").write_text("".join(
        pbrt_material(mesh.material) + f'Shape "plymesh" "string filename" ["{name}"]\n'
        for name, mesh in zip(names, scene.meshes)))
    (folder / f"{stem}.pbrt").write_text(
        pbrt_camera(scene) + f'Integrator "path"\nWorldBegin\nInclude "{stem}_world.pbrt"\n')
    return [folder / name for name in (f"{stem}.pbrt", f"{stem}_world.pbrt", *names)]


def write_pbrt_job(file, stem, scene, square_map, size, depth):
    """Writes pbrt-v4's own file, whose square map has z up and is a mirror image of this world."""
    file.write_text(
        pbrt_camera(scene)
        + f'Film "rgb" "integer xresolution" [{size[0]}] "integer yresolution" [{size[1]}]\n'
        '  "bool savefp16" false\n'
        'PixelFilter "box" "float xradius" [0.5] "float yradius" [0.5]\n'
        'Sampler "zsobol"\n'
        f'Integrator "path" "integer maxdepth" [{depth}]\nWorldBegin\nAttributeBegin\n'
        'Scale -1 1 1 Rotate -90 1 0 0 Rotate 180 0 0 1\n'
        f'LightSource "infinite" "string filename" ["{square_map}"]\nAttributeEnd\n'
        f'Include "{stem}_world.pbrt"\n')


def material_json(material):
    return {"color": material.color, "eta": material.eta, "k": material.k, "alpha": material.alpha}


def write_json(folder, stem, scene):
    """Writes FOLDER/STEM.json and PLY files for the scripts of right-handed programs."""
    scene = scenes.for_right_handed(scene)
    names = write_meshes(folder, stem + "_right", scene.meshes)
    file = folder / f"{stem}.json"
    file.write_text(json.dumps(
        {"meshes": [{"file": str(folder / name), "smooth": bool(mesh.normals),
                     "material": material_json(mesh.material)}
                    for name, mesh in zip(names, scene.meshes)],
         "eye": scene.eye, "target": scene.target, "up": scene.up,
         "field_of_view": scene.field_of_view, "map": str(scene.map)}, indent=1) + "\n")
    return file


def write_embree(file, scene):
    """Writes Embree's XML of diffuse meshes; lights and camera are passed by flag."""
    def block(name, lines):
        return f"<{name}>\n" + "\n".join(lines) + f"\n</{name}>\n"

    text = '<?xml version="1.0"?>\n<scene>\n'
    for i, mesh in enumerate(scene.meshes):
        text += (f'<TriangleMesh>\n<material id="{i}"><code>"Matte"</code>'
                 f'<parameters><float3 name="reflectance">{words(mesh.material.color)}</float3>'
                 "</parameters></material>\n" + block("positions", rows(mesh.positions))
                 + (block("normals", rows(mesh.normals)) if mesh.normals else "")
                 + block("triangles", rows(mesh.triangles)) + "</TriangleMesh>\n")
    file.write_text(text + "</scene>\n")


def write_povray(file, scene, lights_file, aspect):
    """Writes POV-Ray 3.7: no ambient light, diffuse only, lights from `skywave probe lights`."""
    def block(name, lines):
        return f"{name} {{ {len(lines)},\n" + ",\n".join(f"<{line}>" for line in lines) + " }\n"

    def point(p):
        return "<{}, {}, {}>".format(*p)

    angle = f"2 * degrees(atan({aspect:.9g} * tan(radians({scene.field_of_view}) / 2)))"
    text = ("#version 3.7;\nglobal_settings { assumed_gamma 1 max_trace_level 5 }\n"
            f'#include "{lights_file}"\n'
            f"camera {{ perspective location {point(scene.eye)} sky {point(scene.up)}\n"
            f"  right x*{aspect:.9g} up y angle {angle} look_at {point(scene.target)} }}\n")
    for mesh in scene.meshes:
        text += ("mesh2 {\n" + block("vertex_vectors", rows(mesh.positions, ", "))
                 + (block("normal_vectors", rows(mesh.normals, ", ")) if mesh.normals else "")
                 + block("face_indices", rows(mesh.triangles, ", "))
                 + f"texture {{ pigment {{ rgb {point(mesh.material.color)} }} "
                 "finish { ambient 0 diffuse 1 } } }\n")
    file.write_text(text)


# The map's middle lies along +y, its right half along +x; colorpict counts from below, and its unit
# is the shorter side.
RADIANCE_MAP = """{ direction to coordinates of a lat-long map }
map_u = 1 + atan2(Dx, Dy) / PI;
map_v = 1 - acos(Dz) / PI;
"""


def obj_text(mesh):
    """Writes OBJ for Radiance's obj2mesh."""
    corner = "{0}//{0}" if mesh.normals else "{0}"
    lines = [f"v {row}" for row in rows(mesh.positions)]
    lines += [f"vn {row}" for row in rows(mesh.normals)]
    lines += ["f " + " ".join(corner.format(i + 1) for i in mesh.triangles[j:j + 3])
              for j in range(0, len(mesh.triangles), 3)]
    return "\n".join(lines) + "\n"


def write_radiance(folder, stem, scene, map_file):
    """Writes FOLDER/STEM.rad of a scene for right-handed programs, and one OBJ for each mesh.

    Returns the stems of the OBJ files, which obj2mesh makes meshes of.
    """
    (folder / "map.cal").write_text(RADIANCE_MAP)
    text = (f"void colorpict picture\n7 red green blue {map_file} map.cal map_u map_v\n0\n0\n\n"
            "picture glow sky\n0\n0\n4 1 1 1 0\n\nsky source world\n0\n0\n4 0 0 1 360\n\n")
    stems = [f"{stem}_{i}" for i in range(len(scene.meshes))]
    for name, mesh in zip(stems, scene.meshes):
        (folder / f"{name}.obj").write_text(obj_text(mesh))
        text += (f"void plastic grey_{name}\n0\n0\n5 {words(mesh.material.color)} 0 0\n\n"
                 f"grey_{name} mesh {name}\n1 {name}.rtm\n0\n0\n\n")
    (folder / f"{stem}.rad").write_text(text)
    return stems
