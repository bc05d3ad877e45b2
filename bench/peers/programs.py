"""Defines the programs: how each is called for a job, and how its render time is extracted.

Each measures one render with `(session, job, seed)` and returns a dict with `seconds` (of the
render alone), `picture` (EXR or PPM) and further figures that it reports.
"""

import json
import re
import shutil
import subprocess
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Callable

import scene

HERE = Path(__file__).resolve().parent


class Failed(Exception):
    """A program refused, or printed something that is not understood."""


def run(command):
    """Returns output and errors of a command together."""
    result = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, text=True)
    if result.returncode:
        said = result.stdout.strip().splitlines()
        raise Failed(f"{Path(command[0]).name}: "
                     + (said[-1] if said else f"exit code {result.returncode}"))
    return result.stdout


def found(pattern, text, what):
    match = re.search(pattern, text)
    if not match:
        raise Failed(f"{what} is not in the program's output")
    return match.groups()


@dataclass
class Job:
    """Work that several programs do alike."""
    name: str
    title: str
    integrator: str
    samples: int    # per pixel
    depth: int      # surfaces per path
    lights: int     # directional, all used at every hit; 0: the map itself


@dataclass
class Session:
    """Files and settings that all programs share."""
    program: Path       # skywave
    folder: Path
    map: Path
    map_width: int
    bunny: scene.Mesh
    size: tuple
    threads: int        # 0: all available
    lights: list        # {"direction": [right, forward, up], "irradiance": [r, g, b]}

    def file(self, name):
        return self.folder / name


def skywave_strategy(job):
    if not job.lights:
        return "importance"
    return f"median-cut:lights={job.lights},position=centroid"


def skywave(session, job, seed, samples=None, control="irradiance", layers=None):
    # Lights have no density, so a control variate is for maps only.
    control = "none" if job.lights else control
    picture = session.file(f"{job.name}_skywave_{control}.exr")
    stats = session.file("stats.json")
    run([session.program, "render", session.file("bunny.pbrt"), "--env", session.map,
         "--integrator", job.integrator, "--max-depth", job.depth, "--strategy",
         skywave_strategy(job), "--control", control, "--spp", samples or job.samples, "--filter",
         "box", "--size", "{}x{}".format(*session.size), "--threads", session.threads, "--seed",
         seed,
         *(["--aovs", layers] if layers else []),
         "--stats", stats, "-o", picture, "-q"])
    read = json.loads(stats.read_text())
    rays = sum(kind["count"] for kind in read["rays"].values())
    return {"seconds": read["seconds"]["render"], "picture": picture,
            "rays_per_sample": rays / read["samples"]}


def skywave_denoised(session, job, seed):
    result = skywave(session, job, seed, layers="denoiser")
    clean = session.file(f"{job.name}_skywave_clean.exr")
    start = time.monotonic()
    run([session.program, "denoise", result["picture"], "-o", clean, "-q"])
    return {"seconds": result["seconds"] + time.monotonic() - start, "picture": clean}


def cycles_seconds(text, samples):
    """Returns the time of all samples. The preparation is the same as for one sample."""
    one, = found(r"peers: one sample ([\d.]+)", text, "the time of one sample")
    whole, = found(r"peers: all samples ([\d.]+)", text, "the time of all samples")
    seconds = (float(whole) - float(one)) * samples / (samples - 1)
    if seconds <= 0:
        raise Failed("the samples take too little time to be told from the rest: take more")
    return seconds


def cycles(session, job, seed):
    picture, job_file = session.file(f"{job.name}_cycles.exr"), session.file("blender.json")
    picture.unlink(missing_ok=True)
    job_file.write_text(json.dumps(
        {**scene.blender_scene(session.bunny), "map": str(session.map), "picture": str(picture),
         "map_width": session.map_width, "size": session.size, "threads": session.threads,
         "depth": job.depth, "samples": job.samples, "seed": seed}))
    text = run(["blender", "-b", "--factory-startup", "-noaudio", "--python-exit-code", "1",
                "--python", HERE / "blender_render.py", "--", job_file])
    if not picture.is_file():
        raise Failed("blender wrote no picture")
    return {"seconds": cycles_seconds(text, job.samples), "picture": picture}


def embree_factor(lights):
    """Keeps the tutorial's 8-bit picture below 1; no surface faces all lights at once."""
    total = max(sum(light["irradiance"][c] for light in lights) for c in range(3))
    return 3.14159 / scene.ALBEDO / total / 1.2


def embree_seconds(text):
    frames, = found(r"BENCHMARK_RENDER_AVG ([\d.]+)", text, "the speed of a frame")
    return 1 / float(frames)


def embree_pathtracer(session, job, seed):
    scene_file, picture = session.file("bunny.xml"), session.file(f"{job.name}_embree.ppm")
    if not scene_file.is_file():
        scene.write_embree(scene_file, session.bunny)
    factor = embree_factor(session.lights)
    command = ["pathtracer", "-i", scene_file, "--size", *session.size, "--vp", *scene.EYE, "--vi",
               *scene.TARGET, "--vu", *scene.UP, "--fov", scene.FIELD_OF_VIEW, "--lefthanded",
               "--spp", job.samples, "--max-path-length", job.depth]
    for light in session.lights:
        right, forward, up = light["direction"]
        command += ["--directionallight", -right, -up, -forward,
                    *(factor * x for x in light["irradiance"])]
    if session.threads:
        command += ["--threads", session.threads]
    text = run([*command, "--legacy", "--benchmark", 1, 2])
    if seed == 1:  # the tutorial has only one seed
        run([*command, "-o", picture])
    rays, = found(r"BENCHMARK_RENDER_MRAYPS_AVG ([\d.]+)", text, "the number of rays")
    seconds = embree_seconds(text)
    paths = session.size[0] * session.size[1] * job.samples
    return {"seconds": seconds, "picture": picture, "exposure": 1 / factor,
            "rays_per_sample": float(rays) * 1e6 * seconds / paths}


def povray_figures(text):
    """Returns (seconds of tracing, samples); without antialiasing a sample is a pixel."""
    seconds, = found(r"Trace Time:.*\(([\d.]+) seconds\)", text, "the trace time")
    samples, = found(r"Pixels:\s*(\d+)", text, "the number of pixels")
    return float(seconds), int(samples)


def povray(session, job, seed):
    scene_file, picture = session.file("bunny.pov"), session.file(f"{job.name}_povray.exr")
    if not scene_file.is_file():
        run([session.program, "probe", "lights", session.map, "--method", "median-cut", "-n",
             job.lights, "--position", "centroid", "--format", "povray", "-o",
             session.file("lights.inc")])
        scene.write_povray(scene_file, session.bunny, "lights.inc",
                           session.size[0] / session.size[1])
    threads = [f"+WT{session.threads}"] if session.threads else []
    text = run(["povray", f"+I{scene_file}", f"+L{session.folder}", f"+O{picture}", "+FE",
                f"+W{session.size[0]}", f"+H{session.size[1]}", "-D", "-A", *threads])
    seconds, samples = povray_figures(text)
    if samples != session.size[0] * session.size[1] * job.samples:
        raise Failed(f"povray took {samples} samples")
    return {"seconds": seconds, "picture": picture}


@dataclass
class Program:
    name: str
    executable: str | None     # None: skywave, given by flag
    package: str | None        # Debian package
    jobs: tuple                # names of the jobs that it supports
    measure: Callable
    timing: str                # how its time is measured
    settings: str              # settings that differ from the others, or were chosen for it

    def is_installed(self):
        return self.executable is None or shutil.which(self.executable) is not None

    def version(self):
        """Returns the version as Debian counts it, or nothing."""
        if not (self.package and shutil.which("dpkg-query")):
            return ""
        result = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", self.package],
                                capture_output=True, text=True)
        return result.stdout.strip() if result.returncode == 0 else ""


PROGRAMS = [
    Program("Skywave", None, None, ("map", "lights", "direct"), skywave,
            "`seconds.render` of its statistics",
            "`importance` with MIS and `--control irradiance` for the map, `median-cut` for lights; "
            "roulette from the fourth surface"),
    Program("Skywave without control", None, None, ("map",), partial(skywave, control="none"),
            "the same", "the same but for `--control`"),
    Program("Skywave, denoised", None, None, ("map",), skywave_denoised,
            "the same, with the layers of the denoiser, plus all of `skywave denoise`, files "
            "included",
            "the same; a denoiser for Cycles is not in Debian's Blender"),
    Program("Cycles", "blender", "blender", ("map",), cycles,
            "the render of all samples less that of one, in one process, times n / (n - 1)",
            "CPU; no denoising, adaptive sampling, clamping or caustics; map sampled at its full "
            "resolution with MIS; its own samples (progressive multi-jitter), roulette, tile size "
            "and Embree tree, as installed; map interpolated between texels"),
    Program("Embree pathtracer", "pathtracer", "embree-tools", ("lights",), embree_pathtracer,
            "mean of two frames after one, its `--benchmark`",
            "single rays, virtual materials; no map lights, so directional lights, and its ambient "
            "light counts twice (light sample and escape without weights); independent samples; "
            "no roulette, but ends paths below a throughput of 0.01; 8-bit output"),
    Program("POV-Ray", "povray", "povray", ("direct",), povray, "its `Trace Time`",
            "no path tracer (radiosity caches and interpolates), so camera and shadow rays only; "
            "sample in the middle of a pixel; half-float output"),
]
