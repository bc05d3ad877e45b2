"""Runs inside Blender, or with its module bpy: renders a job of peers.py with Cycles.

    blender -b --factory-startup --python blender_render.py -- JOB.json
    python blender_render.py -- JOB.json

Prints the time of each render. Settings that change the amount of work are made here. Sampling
pattern, roulette, the threshold of light samples, tiles and tree are Cycles's defaults, as its
users have them.
"""

import json
import sys
import time
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))
from blender_scene import build  # noqa: E402

JOB = json.loads(Path(sys.argv[sys.argv.index("--") + 1]).read_text())
bpy.ops.wm.read_factory_settings(use_empty=True)
SCENE = bpy.context.scene


def render(samples, seed):
    """Returns the seconds of the whole call."""
    SCENE.cycles.samples, SCENE.cycles.seed = samples, seed
    start = time.perf_counter()
    bpy.ops.render.render()
    return time.perf_counter() - start


build(SCENE, JOB)
render(1, 0)  # loads kernels
print("peers: one sample {:.6f}".format(render(1, JOB["seed"])), flush=True)
print("peers: all samples {:.6f}".format(render(JOB["samples"], JOB["seed"])), flush=True)
bpy.data.images["Render Result"].save_render(JOB["picture"])
