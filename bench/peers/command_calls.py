"""Calls the programs of the command line: Embree's tutorial, POV-Ray, pbrt-v4, Radiance."""

import math
import os
import shutil
import time
from array import array
from pathlib import Path

import formats
import pictures
import scene as scenes
from calling import Failed, found, run, run_for_bytes, seconds_by_difference


def embree_factor(lights):
    """Keeps the tutorial's 8-bit picture below 1; no surface faces all lights at once."""
    total = max(sum(light["irradiance"][c] for light in lights) for c in range(3))
    return 3.14159 / scenes.ALBEDO / total / 1.2


def embree_seconds(text):
    frames, = found(r"BENCHMARK_RENDER_AVG ([\d.]+)", text, "the speed of a frame")
    return 1 / float(frames)


def embree_pathtracer(session, job, seed):
    scene = session.scenes[job.scene]
    scene_file = session.make(f"{job.scene}.xml", lambda file: formats.write_embree(file, scene))
    picture = session.file(f"{job.name}_embree.ppm")
    factor = embree_factor(session.lights)
    command = ["pathtracer", "-i", scene_file, "--size", *session.size, "--vp", *scene.eye, "--vi",
               *scene.target, "--vu", *scene.up, "--fov", scene.field_of_view, "--lefthanded",
               "--spp", job.samples, "--max-path-length", job.depth, "--threads", session.threads]
    for light in session.lights:
        right, forward, up = light["direction"]
        command += ["--directionallight", -right, -up, -forward,
                    *(factor * x for x in light["irradiance"])]
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
    scene = session.scenes[job.scene]

    def write(file):
        run([session.program, "probe", "lights", scene.map, "--method", "median-cut", "-n",
             job.lights, "--position", "centroid", "--format", "povray", "-o",
             session.file("lights.inc")])
        formats.write_povray(file, scene, "lights.inc", session.size[0] / session.size[1])

    scene_file = session.make(f"{job.scene}.pov", write)
    picture = session.file(f"{job.name}_povray.exr")
    text = run(["povray", f"+I{scene_file}", f"+L{session.folder}", f"+O{picture}", "+FE",
                f"+W{session.size[0]}", f"+H{session.size[1]}", "-D", "-A",
                f"+WT{session.threads}"])
    seconds, samples = povray_figures(text)
    if samples != session.size[0] * session.size[1] * job.samples:
        raise Failed(f"povray took {samples} samples")
    return {"seconds": seconds, "picture": picture}


def timed(command, **options):
    start = time.monotonic()
    run(command, **options)
    return time.monotonic() - start


def square_map(session, name):
    """Returns pbrt-v4's map: Skywave takes a picture of the sky with the camera of that map."""
    def write(file):
        speck = session.file("speck.pbrt")
        speck.write_text('WorldBegin\nShape "trianglemesh" "point3 P" '
                         "[0 -1e-6 1e3 1e-6 -1e-6 1e3 0 0 1e3]\n")
        side = session.map_widths[name]
        run([session.program, "render", speck, "--env", session.scenes[name].map, "--camera",
             "equal-area", "--eye", "0,0,0", "--target", "0,0,1", "--size", f"{side}x{side}",
             "--spp", 16, "--filter", "box", "-q", "-o", file])

    return session.make(f"{name}_square.exr", write)


def write_pbrt_job(session, job):
    file = session.file(f"{job.scene}_v4.pbrt")
    formats.write_pbrt_job(file, job.scene, session.scenes[job.scene],
                           square_map(session, job.scene).name, session.size, job.depth)
    return file


def pbrt(session, job, seed):
    picture = session.file(f"{job.name}_pbrt.exr")
    picture.unlink(missing_ok=True)
    file = write_pbrt_job(session, job)
    seconds = [timed(["pbrt", "--quiet", "--nthreads", session.threads, "--seed", seed, "--spp",
                      samples, "--outfile", picture, file]) for samples in (1, job.samples)]
    if not picture.is_file():
        raise Failed("pbrt wrote no picture")
    return {"seconds": seconds_by_difference(*seconds, job.samples), "picture": picture}


def radiance_folder(environment):
    """Returns the folder of Radiance's programs: on the PATH, or the package of setup.sh."""
    if shutil.which("rtrace"):
        return str(Path(shutil.which("rtrace")).parent)
    return next((str(file.parent) for file in sorted(environment.glob(
        "radiance/lib/python*/site-packages/pyradiance/bin/rtrace"))), None)


def prepare_radiance(session, job, folder, variables):
    """Returns the octree of the scene and the scene in Radiance's world."""
    scene = scenes.for_right_handed(session.scenes[job.scene])

    def write(octree):
        run([session.program, "probe", "convert", session.scenes[job.scene].map,
             session.file(f"{job.scene}_map.hdr"), "--to", "latlong"])
        for name in formats.write_radiance(session.folder, job.scene, scene,
                                           f"{job.scene}_map.hdr"):
            session.file(f"{name}.rtm").write_bytes(run_for_bytes(
                [f"{folder}/obj2mesh", f"{name}.obj"], session.folder, variables))
        octree.write_bytes(run_for_bytes([f"{folder}/oconv", f"{job.scene}.rad"], session.folder,
                                         variables))

    return session.make(f"{job.scene}.oct", write), scene


def radiance(session, job, seed):
    """Radiance as a path tracer: no cache (-aa 0), one direction of each hemisphere (-ad 1)."""
    folder = radiance_folder(session.environment)
    library = Path(folder).parent / "lib"
    variables = {"PATH": folder + os.pathsep + os.environ["PATH"],
                 "RAYPATH": os.environ.get("RAYPATH", f".:{library}:/usr/local/lib/ray:"
                                                      "/usr/share/radiance:/usr/lib/ray")}
    octree, scene = prepare_radiance(session, job, folder, variables)
    width, height = session.size
    vertical = scene.field_of_view
    horizontal = 2 * math.degrees(math.atan(width / height * math.tan(math.radians(vertical) / 2)))
    view = ["-vtv", "-vp", *scene.eye, "-vd", *(a - b for a, b in zip(scene.target, scene.eye)),
            "-vu", *scene.up, "-vh", horizontal, "-vv", vertical]

    def command(samples):
        rays = ["vwrays", "-ff", *view, "-x", width, "-y", height, "-pa", 0, "-pj", 1, "-c",
                samples]
        trace = ["rtrace", "-h", "-ff", "-n", session.threads, "-u+", "-ab", job.depth, "-aa", 0,
                 "-ad", 1, "-as", 0, "-lr", 2 * job.depth, "-lw", 1e-9, octree.name]
        mean = ["total", "-if3", "-of", f"-{samples}", "-m"]
        return " | ".join(" ".join(map(str, part)) for part in (rays, trace, mean))

    def render(samples):
        start = time.monotonic()
        data = run_for_bytes(["bash", "-o", "pipefail", "-c", command(samples)], session.folder,
                             variables)
        return time.monotonic() - start, data

    one, _ = render(1)
    whole, data = render(job.samples)
    if len(data) != 12 * width * height:
        raise Failed(f"Radiance wrote {len(data)} bytes")
    lines = [array("f", data[12 * width * y:12 * width * (y + 1)]) for y in range(height)]
    picture = session.file(f"{job.name}_radiance.pfm")
    pictures.write_pfm(picture, (width, height, lines))
    return {"seconds": seconds_by_difference(one, whole, job.samples), "picture": picture}
