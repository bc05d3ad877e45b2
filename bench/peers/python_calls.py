"""Calls the programs that have an interface for Python: Cycles, Mitsuba, LuxCoreRender."""

import json
import os
from pathlib import Path

import formats
from calling import Failed, found, in_environment, run, seconds_by_difference

HERE = Path(__file__).resolve().parent


def write_job(session, job, seed, picture, **more):
    """Returns the file that the scripts of this folder read, and removes an old picture."""
    picture.unlink(missing_ok=True)
    described = session.make(f"{job.scene}.json", lambda file: formats.write_json(
        session.folder, job.scene, session.scenes[job.scene]))
    file = session.file("job.json")
    file.write_text(json.dumps(
        {**json.loads(described.read_text()), "picture": str(picture),
         "map_width": session.map_widths[job.scene], "size": session.size,
         "threads": session.threads, "depth": job.depth, "samples": job.samples, "seed": seed,
         **more}))
    return file


def measured(picture, **figures):
    if not picture.is_file():
        raise Failed(f"{picture.name} was not written")
    return {"picture": picture, **figures}


def cycles_seconds(text, samples):
    one, = found(r"peers: one sample ([\d.]+)", text, "the time of one sample")
    whole, = found(r"peers: all samples ([\d.]+)", text, "the time of all samples")
    return seconds_by_difference(float(one), float(whole), samples)


def cycles(session, job, seed, name, command):
    picture = session.file(f"{job.name}_{name}.exr")
    file = write_job(session, job, seed, picture)
    text = run([*command, HERE / "blender_render.py", "--", file])
    return measured(picture, seconds=cycles_seconds(text, job.samples))


def cycles_of_system(session, job, seed):
    return cycles(session, job, seed, "cycles",
                  ["blender", "-b", "--factory-startup", "-noaudio", "--python-exit-code", "1",
                   "--python"])


def cycles_of_module(session, job, seed):
    return cycles(session, job, seed, "cycles_bpy",
                  [in_environment("blender")(session.environment)])


def llvm_library(environment):
    """Returns the LLVM that setup.sh took from Debian, if it did."""
    return next((str(file) for file in sorted(environment.glob("llvm/**/libLLVM*.so*"))
                 if not file.is_symlink()), None)


def mitsuba(session, job, seed, variant):
    picture = session.file(f"{job.name}_mitsuba_{variant}.pfm")
    library = llvm_library(session.environment)
    known = "DRJIT_LIBLLVM_PATH" in os.environ or library is None
    text = run([in_environment("mitsuba")(session.environment), "-B", HERE / "mitsuba_render.py",
                write_job(session, job, seed, picture, variant=variant)],
               variables={} if known else {"DRJIT_LIBLLVM_PATH": library})
    seconds, = found(r"peers: seconds ([\d.]+)", text, "the time of the render")
    return measured(picture, seconds=float(seconds))


def luxcore_seconds(text, samples):
    """Returns the time of `samples`; the program ends with slightly more than it was asked for."""
    seconds, = found(r"peers: seconds ([\d.]+)", text, "the time of the render")
    taken, = found(r"peers: samples ([\d.]+)", text, "the number of samples")
    return float(seconds) * samples / float(taken)


def luxcore(session, job, seed):
    picture = session.file(f"{job.name}_luxcore.pfm")
    text = run([in_environment("luxcore")(session.environment), "-B", HERE / "luxcore_render.py",
                write_job(session, job, seed, picture)])
    pixels = session.size[0] * session.size[1]
    return measured(picture, seconds=luxcore_seconds(text, pixels * job.samples))


