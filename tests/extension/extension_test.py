#!/usr/bin/env python3
"""Adds a BSDF, a light strategy, an integrator with an option, a table and a pass of its own, a
policy that a pilot teaches, a layer and a flag to a copy of the tree, each as one new file and one
line (docs/how_to_add.md), builds the program there and renders with them.

    extension_test.py SOURCE BUILD

SOURCE is the tree, BUILD a folder for the copy and its build, which is kept for the next run. Each
addition is a twin of something that exists under another name, so its pictures have to be those of
the original, to the last bit.
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import unittest

SOURCE, BUILD = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
TREE, OBJECTS = BUILD / "tree", BUILD / "build"
FOLDERS = ["base", "kernels", "image", "lights", "scene", "wavefront", "job", "api",
           "bench/measure", "cli", "cmake", "scripts/tables"]

SCENE = """LookAt 0 1 4  0 0.5 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
LightSource "infinite" "rgb L" [1 0.8 0.6]
Material "{}" "rgb reflectance" [0.7 0.4 0.2]
Shape "sphere" "float radius" 1
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3]
  "point3 P" [-9 -1 -9  9 -1 -9  9 -1 9  -9 -1 9]
"""

BUILD_FLAGS = ["-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DBUILD_TESTING=OFF",
               "-DSKYWAVE_BENCH=OFF", "-DSKYWAVE_TARGETS=AVX2",
               "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG"]


def write(path, text):
    """Writes a file unless it has that text already, so that it is not compiled again."""
    if not path.exists() or path.read_text() != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


class Additions:
    """The files and lines that are added; everything else is the tree's."""

    def __init__(self):
        self.files, self.lines, self.fields = {}, {}, {}

    def file(self, name, text):
        self.files[name] = text

    def line(self, name, after, line):
        self.lines.setdefault(name, []).append((after, line))

    def text(self, name):
        """The text of a file of the tree with its added lines."""
        text = (SOURCE / name).read_text()
        for after, line in self.lines.get(name, []):
            assert text.count(after) == 1, f"{name}: {text.count(after)} places of {after!r}"
            text = text.replace(after, after + line)
        return text


def twin(name, *renames):
    """The text of a file of the tree with words replaced."""
    text = (SOURCE / name).read_text()
    for old, new in renames:
        assert old in text, f"{name} has no {old}"
        text = text.replace(old, new)
    return text


def added(name):
    """The text of a file that lies beside this test."""
    return (pathlib.Path(__file__).parent / name).read_text()


def additions():
    add = Additions()
    # A BSDF, and the line of a reader that maps a material to it.
    add.file("kernels/bsdf/twin.cc",
             twin("kernels/bsdf/lambert.cc", ("Lambert", "Twin"), ("lambert", "twin")))
    add.line("kernels/columns.h", "  BSDF(Measured)", " BSDF(Twin)")
    add.line("scene/pbrt/materials.cc", '  if (type == "diffuse") return Lambert(context);\n',
             '  if (type == "twin") { Material m = Lambert(context); m.bsdf = BsdfKind::kTwin; '
             "return m; }\n")
    # A light strategy.
    add.file("lights/strategies/twin.cc", added("twin_strategy.cc"))
    add.line("lights/strategies/strategies.cc", "  STRATEGY(Hybrid)", " STRATEGY(Twin)")
    # An integrator, and a policy.
    add.file("wavefront/integrators/twin.cc", added("twin_integrator.cc"))
    add.file("wavefront/policies/twin.cc", added("twin_policy.cc"))
    add.line("wavefront/policy.h", "  POLICY(Guide)", " POLICY(Twin)")
    add.line("wavefront/integrator.h", '  INTEGRATOR(IrradianceCache, "irradiance-cache")',
             ' INTEGRATOR(Twin, "twin")')
    # A layer.
    add.line("wavefront/film/aovs.cc", "constexpr Aov kAovs[] = {\n",
             '    {"twin", "V", AovSum::kMeanOfHits, "one half at every hit", '
             "[](const FirstSurfaces& first, const AovColumns& out) "
             "{ std::fill_n(out[0], first.count, 0.5f); }},\n")
    # A flag: its field and its line.
    add.line("wavefront/frame.h", "struct RenderOptions {\n", "  std::uint32_t twin = 7;\n")
    add.line("job/options.cc", "std::vector<JobOption> CommonRows() {\n"
             "  // clang-format off\n  return {\n",
             '    Plain({.name = "twin", .help = "a number", .scope = kPixels, '
             '.example = "--twin 3"}, FIELD(options.twin), Numbers(0u, 9u)),\n')
    return add


def make_tree(add):
    for folder in FOLDERS:
        for path in (SOURCE / folder).rglob("*"):
            name = path.relative_to(SOURCE)
            if path.is_file() and str(name) not in add.lines:
                destination = TREE / name
                if not destination.exists() or destination.read_bytes() != path.read_bytes():
                    destination.parent.mkdir(parents=True, exist_ok=True)
                    shutil.copyfile(path, destination)
    write(TREE / "CMakeLists.txt", (SOURCE / "CMakeLists.txt").read_text())
    for name in add.lines:
        write(TREE / name, add.text(name))
    for name, text in add.files.items():
        write(TREE / name, text)
    # Files of the tree that are gone.
    for folder in FOLDERS:
        for path in (TREE / folder).rglob("*"):
            name = path.relative_to(TREE)
            if path.is_file() and str(name) not in add.files and not (SOURCE / name).exists():
                path.unlink()


class Extension(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        make_tree(additions())
        log = BUILD / "build.log"
        with open(log, "w") as out:
            for command in (["cmake", "-S", TREE, "-B", OBJECTS, *BUILD_FLAGS],
                            ["cmake", "--build", OBJECTS, "-j", os.environ.get("JOBS", "2"),
                             "--target", "skywave"]):
                if subprocess.run(command, stdout=out, stderr=subprocess.STDOUT).returncode:
                    raise AssertionError("\n".join(log.read_text().splitlines()[-40:]))
        cls.folder = BUILD / "pictures"
        shutil.rmtree(cls.folder, ignore_errors=True)
        cls.folder.mkdir()
        for material in ("diffuse", "twin"):
            (cls.folder / f"{material}.pbrt").write_text(SCENE.format(material))

    def skywave(self, *arguments):
        result = subprocess.run([OBJECTS / "skywave", *arguments], cwd=self.folder,
                                capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, f"{arguments}\n{result.stderr}")
        return result.stdout

    def render(self, name, scene, *arguments):
        self.skywave("render", scene, "--size", "48x32", "--spp", "4", "-q", "-o", name + ".exr",
                     *arguments)
        return (self.folder / (name + ".png")).read_bytes()

    def compare(self, a, b):
        text = self.skywave("compare", a + ".exr", b + ".exr")
        return next(float(line.split()[1]) for line in text.splitlines()
                    if line.startswith("max_absolute"))

    def test_every_addition_is_one_line(self):
        add = additions()
        for name, lines in add.lines.items():
            for _, line in lines:
                self.assertLessEqual(line.rstrip("\n").count("\n"), 0, name)
        self.assertEqual(len(add.files), 4)
        # BSDF, what a reader maps to it, strategy, integrator, policy, layer, and field and line of
        # the flag.
        self.assertEqual(sum(len(lines) for lines in add.lines.values()), 8)

    def test_the_bsdf_renders_as_its_twin(self):
        self.render("diffuse", "diffuse.pbrt")
        self.render("twin_bsdf", "twin.pbrt")
        self.assertEqual(self.compare("twin_bsdf", "diffuse"), 0)
        self.assertIn(" twin ", self.skywave("info", "twin.pbrt"))

    def test_the_strategy_renders_as_its_twin(self):
        self.render("uniform", "gallery", "--strategy", "uniform")
        self.render("twin_strategy", "gallery", "--strategy", "twin")
        self.assertEqual(self.compare("twin_strategy", "uniform"), 0)
        self.assertIn("uniform under another name", self.skywave("strategies"))

    def test_the_integrator_renders_as_its_twin(self):
        arguments = ["--light-samples", "3"]
        self.render("direct", "gallery", "--integrator", "direct", *arguments)
        self.render("twin_integrator", "gallery", "--integrator", "twin", *arguments)
        self.assertEqual(self.compare("twin_integrator", "direct"), 0)
        self.assertIn("|photon|vcm|vpl|irradiance-cache|twin", self.skywave("render", "--help"))

    def test_the_integrator_has_an_option_a_table_and_a_pass(self):
        arguments = ["--integrator", "twin", "--light-samples", "3"]
        self.render("once", "gallery", *arguments)
        self.render("twice", "gallery", *arguments, "--twin-gain", "2")
        self.render("bright", "gallery", "--integrator", "direct", "--light-samples", "3",
                    "--env-intensity", "2")
        self.assertGreater(self.compare("twice", "once"), 0.1)
        # Films count in units that depend on the brightest light of a scene.
        self.assertLess(self.compare("twice", "bright"), 1e-5)
        self.assertIn(b" --twin-gain 2", (self.folder / "twice.exr").read_bytes())
        self.render("direct_gain", "gallery", "--integrator", "direct", "--twin-gain", "2")
        self.assertNotIn(b"--twin-gain", (self.folder / "direct_gain.exr").read_bytes())
        self.assertRegex(self.skywave("options"), r"--twin-gain[^\n]*\n?[^\n]*twin")

    def test_the_policy_learns_and_draws_as_its_twin(self):
        self.render("uniform_light", "gallery", "--strategy", "uniform")
        self.render("even", "gallery", "--evenly", "--stats", "even.json")
        self.assertEqual(self.compare("even", "uniform_light"), 0)
        learnt = json.loads((self.folder / "even.json").read_text())["evenly"]
        self.assertGreater(learnt["paths"], 1000)
        self.assertGreater(learnt["samples"], 0)

    def test_the_layer_is_kept(self):
        plain = self.render("plain", "gallery")
        self.assertEqual(self.render("layer", "gallery", "--aovs", "twin"), plain)
        self.assertIn(b"twin.V\0", (self.folder / "layer.exr").read_bytes())
        self.assertIn("one half at every hit", self.skywave("render", "--help"))

    def test_the_flag_is_read_listed_and_recorded(self):
        self.render("flag", "gallery", "--twin", "3")
        self.assertIn(b" --twin 3", (self.folder / "flag.exr").read_bytes())
        self.assertIn("--twin N", self.skywave("options"))
        refused = subprocess.run([OBJECTS / "skywave", "render", "gallery", "--twin", "10"],
                                 capture_output=True, text=True)
        self.assertEqual(refused.returncode, 64)


if __name__ == "__main__":
    BUILD.mkdir(parents=True, exist_ok=True)
    unittest.main(argv=sys.argv[:1])
