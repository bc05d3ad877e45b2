"""Renders a job of peers.py with Mitsuba 3: python mitsuba_render.py JOB.json

Prints the seconds of a render, without loading, and for the variants that compile kernels without
their compilation, which a render of the same job before it has done.
"""

import json
import sys
import time
from pathlib import Path

import mitsuba

JOB = json.loads(Path(sys.argv[1]).read_text())
mitsuba.set_variant(JOB["variant"])
import drjit  # noqa: E402


def bsdf(material):
    if material["alpha"] is None:
        inner = {"type": "diffuse", "reflectance": {"type": "rgb", "value": material["color"]}}
    else:
        inner = {"type": "roughconductor", "distribution": "ggx", "alpha": material["alpha"],
                 "eta": {"type": "rgb", "value": material["eta"]},
                 "k": {"type": "rgb", "value": material["k"]}}
    return {"type": "twosided", "inner": inner}


def environment():
    """Its middle lies along +z and its right half along -x in the map's own world with y up."""
    return {"type": "envmap", "filename": JOB["map"], "to_world": mitsuba.ScalarTransform4f(
        [[-1, 0, 0, 0], [0, 0, 1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])}


def sensor():
    width, height = JOB["size"]
    return {"type": "perspective", "fov": JOB["field_of_view"], "fov_axis": "smaller",
            "near_clip": 1e-4, "far_clip": 1e4,
            "to_world": mitsuba.ScalarTransform4f().look_at(
                origin=JOB["eye"], target=JOB["target"], up=JOB["up"]),
            "film": {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "rgb",
                     "component_format": "float32", "rfilter": {"type": "box"}},
            "sampler": {"type": "multijitter"}}


def description():
    # Mitsuba's depth counts segments, so light on the first surface is 2.
    scene = {"type": "scene", "sensor": sensor(), "environment": environment(),
             "integrator": {"type": "path", "max_depth": JOB["depth"] + 1}}
    for i, mesh in enumerate(JOB["meshes"]):
        scene[f"mesh_{i}"] = {"type": "ply", "filename": mesh["file"],
                              "face_normals": not mesh["smooth"], "bsdf": bsdf(mesh["material"])}
    return scene


def render(scene, seed):
    """Returns the picture and the seconds."""
    start = time.perf_counter()
    picture = mitsuba.render(scene, spp=JOB["samples"], seed=seed)
    drjit.eval(picture)
    drjit.sync_thread()
    return picture, time.perf_counter() - start


drjit.set_thread_count(JOB["threads"])
SCENE = mitsuba.load_dict(description())
if JOB["variant"].startswith("llvm"):
    render(SCENE, JOB["seed"] + 500000)
PICTURE, SECONDS = render(SCENE, JOB["seed"])
print(f"peers: seconds {SECONDS:.6f}", flush=True)
mitsuba.util.write_bitmap(JOB["picture"], PICTURE, write_async=False)
