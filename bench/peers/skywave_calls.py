"""Calls Skywave for a job."""

import json
import time

from calling import run


def strategy(job):
    if not job.lights:
        return "importance"
    return f"median-cut:lights={job.lights},position=centroid"


def skywave(session, job, seed, samples=None, control="none", layers=None):
    picture = session.file(f"{job.name}_skywave_{control}.exr")
    stats = session.file("stats.json")
    # Other programs have no compensation of light that facets of a metal reflect twice.
    run([session.program, "render", session.file(f"{job.scene}.pbrt"), "--env",
         session.scenes[job.scene].map, "--integrator", job.integrator, "--max-depth", job.depth,
         "--strategy", strategy(job), "--control", control, "--no-energy-compensation", "--strict",
         "--spp", samples or job.samples, "--filter", "box", "--size",
         "{}x{}".format(*session.size), "--threads", session.threads, "--seed", seed,
         *(["--aovs", layers] if layers else []), "--stats", stats, "-o", picture, "-q"])
    read = json.loads(stats.read_text())
    rays = sum(kind["count"] for kind in read["rays"].values())
    return {"seconds": read["seconds"]["render"], "picture": picture,
            "rays_per_sample": rays / read["samples"]}


def denoised(session, job, seed, **options):
    result = skywave(session, job, seed, layers="denoiser", **options)
    clean = session.file(f"{job.name}_skywave_clean.exr")
    start = time.monotonic()
    run([session.program, "denoise", result["picture"], "-o", clean, "-q"])
    return {"seconds": result["seconds"] + time.monotonic() - start, "picture": clean}
