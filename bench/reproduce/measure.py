"""Scenes, references and rows: everything that starts the program."""

import json
import os
import re
import subprocess
from pathlib import Path

from tables import Recipe

# Light samples per hit of the picture against which light errors are measured.
LIGHT_REFERENCE = 2048
# The same for photons: light samples per first hit, continuations per pixel.
PHOTON_REFERENCE = (64, 1024)

HERE = Path(__file__).resolve().parent
REPOSITORY = HERE.parents[1]


class Absent(Exception):
    """A required file does not exist."""


class Failed(Exception):
    """The program refused."""


def run(command):
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if result.returncode:
        said = (result.stderr.strip() or result.stdout.strip()).splitlines()
        raise Failed(said[-1] if said else f"exit code {result.returncode}")
    return result


def existing(path):
    if not path.is_file():
        raise Absent(str(path))
    return path


def scene_arguments(table, data, folder):
    """Returns scene, map and camera of a table as arguments of the program; writes scene files."""
    probe = existing(data / "probes" / "latlong" / f"{table.probe}_latlong.exr")
    if table.scene == "killeroo":
        existing(data / "models" / "killeroo.pbrt")
        run([REPOSITORY / "scripts" / "data_scenes.sh", data, folder / "scenes"])
        arguments = [folder / "scenes" / "killeroo.pbrt", "--env-up", "z"]
    elif table.scene == "buddha":
        arguments = [existing(data / "models" / "buddha.obj"), "--ground"]
    elif table.scene == "sponza":
        arguments = [existing(data / "models" / "sponza.obj")]
    elif table.scene == "three-spheres":
        arguments = [table.scene]
    else:
        arguments = [existing(HERE / f"{table.scene}.pbrt")]
    if table.turn:
        arguments += ["--env-rotate", table.turn]
    return arguments + table.camera + ["--env", probe]


class Session:
    """One table at one size: its reference and its renders."""

    def __init__(self, program, table, data, folder, size, threads, reference, busy=False):
        self.program, self.table, self.folder, self.size = program, table, folder, size
        self.busy = busy
        self.reference_samples = reference
        self.scene = scene_arguments(table, data, folder)
        self.common = ["--size", size, "--threads", threads]
        self.pictures = folder / "pictures" / f"table_{table.name}"
        self.pictures.mkdir(parents=True, exist_ok=True)

    def reference(self, say):
        """Returns (file, facts). `converge` renders it once and also reports its noise."""
        table, (samples, light_samples) = self.table, self.reference_samples
        # Photons are compared with paths, which have no bias.
        integrator = "direct" if table.integrator == "direct" else "path"
        view = [f"table{table.name}"] if table.camera else []
        stem = "_".join([table.scene, table.probe, integrator, *view, self.size,
                         f"{samples}x{light_samples}"])
        folder = self.folder / "references"
        folder.mkdir(exist_ok=True)
        picture, facts = folder / f"{stem}.exr", folder / f"{stem}.json"
        if not (picture.is_file() and facts.is_file()):
            say(f"reference {stem}")
            half_done = folder / f"{stem}.part.json"
            run([self.program, "converge", *self.scene, *self.common, "--integrator", integrator,
                 "--light-samples", light_samples, "--strategies", "importance", "--budgets", 1,
                 "--repeats", 2, "--reference-spp", samples,
                 "--reference-strategy", table.reference_strategy,
                 "--seed", 1000003, "--save-reference", picture,
                 "--json", half_done, "-q"])
            os.replace(half_done, facts)
        read = json.loads(facts.read_text())
        # This also holds for a reference that existed already.
        strategy = re.search(r"--reference-strategy '?([^ ']+)", read["command"])
        return picture, {"samples_per_pixel": samples, "light_samples": light_samples,
                         "strategy": strategy.group(1) if strategy else "importance",
                         "mse": read["reference"]["mse"],
                         "seconds": read["reference"]["seconds"],
                         "scene_hash": read["scene"]["hash"], "version": read["version"]}

    def light_references(self, seed, say):
        """Returns {camera samples: a picture with those of the rows and far more of all else}.

        The film positions of a seed, and paths through mirrors and glass, are the same for every
        strategy, for photons, and for paths that split, so compared with such a picture rows differ
        only by what happens after their first hits. It uses `warp`, because the points of
        `importance` would share errors with the rows. The result is empty for path tracing, where
        all dimensions go together.
        """
        if self.table.integrator == "path":
            return {}
        samples = {row.recipe.samples for row in self.table.rows if row.recipe}
        return {n: self.light_reference(seed, n, say) for n in sorted(samples)}

    def light_reference(self, seed, samples, say):
        table, photons = self.table, self.table.integrator == "photon"
        lights, split = PHOTON_REFERENCE if photons else (LIGHT_REFERENCE, 0)
        view = [f"table{table.name}"] if table.camera else []
        picture = self.folder / "references" / "_".join(
            [table.scene, table.probe, *view, self.size, f"seed{seed}",
             f"{samples}x{lights}" + (f"x{split // samples}" if split else "") + ".exr"])
        if not picture.is_file():
            say(f"light reference {picture.stem}")
            part = picture.with_suffix(".part.exr")
            recipe = Recipe("warp", samples, lights, mis=True, split=split // samples,
                            behind=table.reference_strategy if photons else "")
            run(self.render_command(recipe, seed, part, self.pictures / "stats.json",
                                    "path" if photons else table.integrator))
            part.with_suffix(".png").unlink(missing_ok=True)
            os.replace(part, picture)
        return picture

    def errors(self, picture, reference, error_map=None):
        file = self.pictures / "errors.json"
        shown = ["--map", error_map, "--measure", "log"] if error_map else []
        run([self.program, "compare", picture, reference, "--json", file, *shown])
        return json.loads(file.read_text())

    def render_command(self, recipe, seed, picture, stats, integrator):
        command = [self.program, "render", *self.scene, *self.common, "--integrator", integrator,
                   "--strategy", recipe.strategy, "--spp", recipe.samples, *recipe.flags]
        if integrator != "path" or recipe.split:
            command += ["--light-samples", recipe.light_samples]
        if recipe.split:
            command += ["--split", recipe.split]
        if recipe.behind:
            command += ["--continuation-strategy", recipe.behind]
        if not recipe.mis:
            command.append("--no-mis")
        return command + ["--seed", seed, "--stats", stats, "--tone", "contrast", "-o", picture,
                          "-q"]

    def measure(self, row, seed, reference, scene_hash, light_references):
        picture, stats = self.pictures / f"{row.name}.exr", self.pictures / "stats.json"
        run(self.render_command(row.recipe, seed, picture, stats, self.table.integrator))
        stats = json.loads(stats.read_text())
        errors = self.errors(picture, reference, picture.with_suffix(".error.png"))
        if stats["scene"]["hash"] != scene_hash:
            raise Failed("the scene has changed since the reference was made: remove "
                         f"{reference.parent}")
        # On a busy machine, wall time means nothing; the processor time spent on the render does.
        render = stats["seconds"]["render_processor"] / stats["settings"]["threads"] if self.busy \
            else stats["seconds"]["render"]
        result = {"seed": seed, "seconds": render,
                  "table_seconds": stats["seconds"]["tables"],
                  "shadow_rays": stats["rays"]["shadow"]["count"]}
        for key in ("mse", "relative_mse", "squared_channel_sum", "thesis_luminance"):
            result[key] = errors[key]
        own = light_references.get(row.recipe.samples)
        if own:
            result["light_error"] = 3 * self.errors(picture, own)["mse"]
        return result
