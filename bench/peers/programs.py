"""Lists the programs of the comparison, with what is particular about each."""

from functools import partial

import command_calls
import python_calls
import skywave_calls
from calling import Program, debian_version, in_environment, on_path, package_version

MAPS = ("bunny", "metal", "sponza")
SETUP = "is not there: bench/peers/setup.sh"


def nothing(environment):
    return ""


def always(environment):
    return "skywave"


CYCLES = ("CPU; no denoising, adaptive sampling, clamping or filter of glossy surfaces; map "
          "sampled at its full resolution with MIS and interpolated between texels; its own "
          "samples, roulette, tile size and Embree tree, as installed")
DIFFERENCE = "the render of all samples less that of one, in one process, times n / (n - 1)"

PROGRAMS = [
    Program("Skywave", always, "", nothing, MAPS + ("lights", "direct"), skywave_calls.skywave,
            "`seconds.render` of its statistics",
            "`importance` with MIS for the map, `median-cut` for lights; roulette from the fourth "
            "surface; no compensation of what facets reflect twice; map not interpolated"),
    Program("Skywave, control", always, "", nothing, MAPS,
            partial(skywave_calls.skywave, control="irradiance"), "the same",
            "the same with `--control irradiance`"),
    Program("Skywave, denoised", always, "", nothing, ("bunny",),
            partial(skywave_calls.denoised, control="irradiance"),
            "the same, with the layers of the denoiser, plus all of `skywave denoise`, files "
            "included", "the same with control and denoiser; no other program denoises here"),
    Program("Cycles", on_path("blender"), "blender is not installed", debian_version("blender"),
            MAPS, python_calls.cycles_of_system, DIFFERENCE,
            CYCLES + "; before Blender 4.3 its metals have a constant reflectance"),
    Program("Cycles, bpy", in_environment("blender"), f"bpy {SETUP}",
            package_version("blender", "bpy"), MAPS, python_calls.cycles_of_module, DIFFERENCE,
            "the same of the newest Blender"),
    Program("Mitsuba, LLVM", in_environment("mitsuba"), f"Mitsuba {SETUP}",
            package_version("mitsuba", "mitsuba"), MAPS,
            partial(python_calls.mitsuba, variant="llvm_ad_rgb"),
            "the second of two renders, the first of which compiles",
            "`llvm_ad_rgb`: kernels for the vectors of the machine, compiled for the scene; `path` "
            "with its own roulette and `multijitter` samples, because `independent` ones, its "
            "default, have 3.7 times the variance for the grey bunny; map interpolated"),
    Program("Mitsuba, scalar", in_environment("mitsuba"), f"Mitsuba {SETUP}",
            package_version("mitsuba", "mitsuba"), MAPS,
            partial(python_calls.mitsuba, variant="scalar_rgb"), "the render",
            "`scalar_rgb`: path by path, otherwise the same"),
    Program("LuxCore", in_environment("luxcore"), f"LuxCore {SETUP}",
            package_version("luxcore", "pyluxcore"), MAPS, python_calls.luxcore,
            "its `stats.renderengine.time`, for the samples that were asked for",
            "`PATHCPU`, `SOBOL`, no clamping, filter `NONE`; its own roulette, which is biased (2 "
            "% too bright inside Sponza, 0.03 % without it); its metal has Schlick's shadows of "
            "facets; map interpolated"),
    Program("pbrt-v4", on_path("pbrt"), "pbrt is not installed", nothing, MAPS, command_calls.pbrt,
            "the whole process with all samples less that with one, times n / (n - 1)",
            "`path`, `zsobol`, spectral; map resampled to its equal-area square"),
    Program("Radiance", command_calls.radiance_folder, f"Radiance {SETUP}",
            package_version("radiance", "pyradiance"), ("bunny", "sponza"), command_calls.radiance,
            "the pipe with all samples less that with one, times n / (n - 1)",
            "as a path tracer: `rtrace -aa 0 -ad 1` without cache; it does not sample the map, "
            "whose light its paths have to find; map in RGBE; an eighth of the samples",
            share=1 / 8),
    Program("Embree pathtracer", on_path("pathtracer"), "pathtracer is not installed",
            debian_version("embree-tools"), ("lights",), command_calls.embree_pathtracer,
            "mean of two frames after one, its `--benchmark`",
            "single rays, virtual materials; no map lights, so directional lights, and its ambient "
            "light counts twice (light sample and escape without weights); independent samples; "
            "no roulette, but ends paths below a throughput of 0.01; 8-bit output",
            has_seeds=False),
    Program("POV-Ray", on_path("povray"), "povray is not installed", debian_version("povray"),
            ("direct",), command_calls.povray, "its `Trace Time`",
            "no path tracer (radiosity caches and interpolates), so camera and shadow rays only; "
            "sample in the middle of a pixel; half-float output", has_seeds=False),
]
