"""Renders a job of peers.py with LuxCoreRender: python luxcore_render.py JOB.json

Prints the seconds of a render, without loading, and the number of samples taken in them.
"""

import json
import math
import sys
import time
from array import array
from pathlib import Path

import pyluxcore

JOB = json.loads(Path(sys.argv[1]).read_text())
# The map's own world has its middle along -x and its right half along -y.
TO_WORLD = [0, -1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]


def properties(values):
    made = pyluxcore.Properties()
    for name, value in values.items():
        made.Set(pyluxcore.Property(name, value))
    return made


def material(described):
    if described["alpha"] is None:
        return {"type": "matte", "kd": described["color"]}
    # The facets are Schlick's, whose distribution is GGX of this width; their shadows differ.
    return {"type": "metal2", "n": described["eta"], "k": described["k"],
            "uroughness": described["alpha"], "vroughness": described["alpha"]}


def field_of_view():
    """Returns that of the longer side, which is what LuxCore asks for."""
    width, height = JOB["size"]
    return math.degrees(2 * math.atan(width / height
                                      * math.tan(math.radians(JOB["field_of_view"]) / 2)))


def window():
    """Returns the window of the camera, a pixel lower: LuxCore's picture is a line too low."""
    width, height = JOB["size"]
    return [-1, 1, (-height - 2) / width, (height - 2) / width]


def scene():
    values = {"scene.camera.lookat.orig": JOB["eye"], "scene.camera.lookat.target": JOB["target"],
              "scene.camera.up": JOB["up"], "scene.camera.fieldofview": field_of_view(),
              "scene.camera.screenwindow": window(),
              "scene.lights.map.type": "infinite", "scene.lights.map.file": JOB["map"],
              "scene.lights.map.gamma": 1.0, "scene.lights.map.transformation": TO_WORLD}
    for i, mesh in enumerate(JOB["meshes"]):
        for key, value in material(mesh["material"]).items():
            values[f"scene.materials.material_{i}.{key}"] = value
        values[f"scene.objects.mesh_{i}.ply"] = mesh["file"]
        values[f"scene.objects.mesh_{i}.material"] = f"material_{i}"
    made = pyluxcore.Scene()
    made.Parse(properties(values))
    return made


def configuration():
    depth = JOB["depth"] + 1  # segments, so light on the first surface is 2
    return pyluxcore.RenderConfig(properties({
        "renderengine.type": "PATHCPU", "renderengine.seed": JOB["seed"],
        "sampler.type": "SOBOL", "native.threads.count": JOB["threads"],
        "path.pathdepth.total": depth, "path.pathdepth.diffuse": depth,
        "path.pathdepth.glossy": depth, "path.pathdepth.specular": depth,
        "path.clamping.variance.maxvalue": 0.0, "film.width": JOB["size"][0],
        "film.height": JOB["size"][1], "film.filter.type": "NONE",
        "batch.haltspp": JOB["samples"], "film.outputs.0.type": "RGB",
        "film.outputs.0.filename": "not_written.exr"}), scene())


pyluxcore.Init()
SESSION = pyluxcore.RenderSession(configuration())
SESSION.Start()
while not SESSION.HasDone():
    SESSION.UpdateStats()
    time.sleep(0.01)
SESSION.UpdateStats()
for name, key in (("seconds", "stats.renderengine.time"),
                  ("samples", "stats.renderengine.total.samplecount")):
    print(f"peers: {name} {SESSION.GetStats().Get(key).GetFloat():.6f}", flush=True)
SESSION.Stop()
WIDTH, HEIGHT = JOB["size"]
PIXELS = array("f", bytes(12 * WIDTH * HEIGHT))  # from below, as PFM has them
SESSION.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, PIXELS)
Path(JOB["picture"]).write_bytes(f"PF\n{WIDTH} {HEIGHT}\n-1.0\n".encode() + PIXELS.tobytes())
