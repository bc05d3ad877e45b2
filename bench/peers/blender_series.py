"""Runs with Blender's module bpy: renders a job of time_to_error.py with Cycles, as often as asked.

    python blender_series.py JOB.json

Each line of standard input is a number of samples: writes the picture of the job, and prints the
processor seconds of the render. One of one sample loads kernels before and is not counted.
"""

import json
import os
import sys
import time
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))
from blender_scene import build  # noqa: E402

JOB = json.loads(Path(sys.argv[-1]).read_text())


def render(scene, samples):
    """Returns the processor seconds of the whole call, those of the denoiser among them."""
    scene.cycles.samples = samples
    start = time.process_time()
    bpy.ops.render.render()
    return time.process_time() - start


def main():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    build(scene, JOB)
    render(scene, 1)
    scene.cycles.seed = JOB["seed"]
    scene.cycles.use_denoising = JOB["denoise"]
    if JOB["denoise"]:
        scene.cycles.denoiser = "OPENIMAGEDENOISE"
    for line in sys.stdin:
        seconds = render(scene, int(line))
        bpy.data.images["Render Result"].save_render(JOB["picture"])
        print(f"series: {seconds:.4f}", flush=True)


main()
os._exit(0)  # some versions of bpy crash when Python ends
