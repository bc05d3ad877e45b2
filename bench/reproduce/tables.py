"""Tables 8.2 to 8.6 of the thesis on hybrid sampling, with the rows translated to --strategy;
photon_tables.py has 8.7 to 8.9.

The rows are written as the thesis prints them, one per line; '-' is an empty cell. Direct lighting:
  N method seconds euclidean luminance area-of-A[%] clustering lights IS MPA
path tracing:
  N method integrator seconds euclidean paths area-of-A[%] clustering lights IS MPA
OS:48 means 48 lights of the Penrose tiling, MC:64 is 64 of median cut; OS(360):32 means 32 samples
of a map pre-sampled with 360.
"""

import math
import re
from dataclasses import dataclass, field, replace

# Camera samples per pixel of the direct lighting rows; docs/reproduction_tables.md explains their
# origin.
CAMERA_SAMPLES = 4

# Lights before clustering over lights after it. The tables give only the remaining ones; the one
# example of the thesis (figure 7.18) merges 304 into 200.
BEFORE_CLUSTERING = 1.5

# Cells that cannot mean what is printed, and what is rendered. 8.5's PT2 of "4x61" paths takes
# twice the time of that of 4x64 for 24 more lights, and has half the error; the other tables have
# 8x29 and 8x63.
MISPRINTS = {"4x61": "8x61"}


@dataclass
class Recipe:
    """The parameters of one render of Skywave."""
    strategy: str
    samples: int        # per pixel
    light_samples: int  # per hit (direct lighting) or first hit (paths that split)
    mis: bool = False
    split: int = 0      # continuations per camera sample; 0: paths do not split
    behind: str = ""    # strategy for the light samples of continuations, if different
    flags: list = field(default_factory=list)  # further flags of the program


@dataclass
class Row:
    name: str
    method: str
    parameters: str              # as the thesis prints them
    recipe: Recipe | None        # None: Skywave has no counterpart
    note: str = ""               # the reason, or how the recipe deviates
    seconds: float | None = None  # time in the thesis; None below the line
    euclidean: float | None = None
    luminance: float | None = None
    lights: int = 0              # used at every hit
    drawn: int = 0               # light samples per camera sample, or paths per pixel
    presampled: bool = False

    @property
    def plain(self):
        """Plain importance sampling of the whole map, in the thesis rather than below the line."""
        return self.method == "I.S." and self.seconds is not None


@dataclass
class Table:
    name: str
    title: str
    scene: str
    probe: str
    integrator: str
    base: str                   # row of plain importance sampling, the base of ratios
    pairs: list                 # (row, plain row) that the thesis compares
    reference: tuple            # samples per pixel, light samples
    quick_reference: tuple
    turn: int = 0               # rotation of the map, degrees
    camera: list = field(default_factory=list)  # flags; empty: the scene's own
    reference_strategy: str = "importance"
    rows: list = field(default_factory=list)

    def row(self, name):
        return next((row for row in self.rows if row.name == name), None)


def angle_for_area(percent, lights):
    """Returns the degrees between `lights` lights for which A fills `percent` of the sphere.

    This is the inverse of equation 7.15: area = lights (1 - cos(angle / 2)) / 2 of the sphere.
    """
    return 2 * math.degrees(math.acos(1 - 2 * percent / 100 / lights))


def light_parameters(cell, clustering):
    """Parses a cell such as OS:48 to (strategy, lights before clustering, parameters)."""
    source, count = re.fullmatch(r"(OS|MC):(\d+)", cell).groups()
    name = {"OS": "penrose", "MC": "median-cut"}[source]
    if clustering == "-":
        longest = ["longest=uv"] if source == "MC" else []  # (T 6.2)
        return name, int(count), [f"lights={count}", "position=sample"] + longest
    before = round(BEFORE_CLUSTERING * int(count))
    return name, before, [f"lights={before}", f"cluster={clustering}", f"clusters={count}",
                          "position=sample"]


def hybrid_strategy(area, clustering, lights, presampled, pick="all", rest=()):
    source, before, parameters = light_parameters(lights, clustering)
    parameters = ["strata=lights", f"angle={angle_for_area(area, before):.5f}",
                  f"from={source}"] + parameters
    if presampled:
        parameters += ["rest=presampled", f"rest-samples={presampled}", *rest]
    if pick != "all":
        parameters.append(f"pick={pick}")
    return "hybrid:" + ",".join(parameters)


def method_name(method):
    return {"IS": "I.S.", "MPA": "M.P.A.", "HIB": "HIB.", "DL": "D.L."}[method]


def as_printed(area, clustering, lights, importance, presampled):
    parts = []
    if lights != "-":
        parts.append(lights + ("" if clustering == "-" else f" {clustering}"))
        if area != "100":
            parts.append(f"A {area} %")
    if importance != "-":
        parts.append(f"IS {importance}")
    if presampled != "-":
        parts.append(presampled)
    return ", ".join(parts)


def read_direct_row(line):
    name, method, seconds, euclidean, luminance, area, clustering, lights, importance, mpa = \
        line.split()
    row = Row(name, method_name(method), as_printed(area, clustering, lights, importance, mpa),
              None, seconds=float(seconds), euclidean=float(euclidean),
              luminance=float(luminance))
    row.lights = 0 if lights == "-" else int(lights.split(":")[1])
    cells, rest = 0, []
    if mpa != "-":
        cells, row.drawn = map(int, re.fullmatch(r"(?:IS/)?OS\((\d+)\):(\d+)", mpa).groups())
        row.presampled = True
    if mpa.startswith("IS/"):
        rest = ["rest-mode=jittered"]
        row.note = "a guess: B is sampled directly, inside the cells of a map of that size"
    elif cells and lights.startswith("MC"):
        rest = ["rest-from=penrose"]
    elif importance != "-":
        row.drawn = int(importance)
    if method == "IS":
        strategy = "importance"
    elif method == "MPA":
        strategy = f"presampled:mode=fixed,lights={cells},position=sample"
    elif method == "DL":
        source, _, parameters = light_parameters(lights, clustering)
        strategy = f"{source}:" + ",".join(parameters)
    else:
        strategy = hybrid_strategy(float(area), clustering, lights, cells, rest=rest)
    row.recipe = Recipe(strategy, CAMERA_SAMPLES, max(row.drawn, 1))
    return row


def read_path_row(line):
    name, method, integrator, seconds, euclidean, paths, area, clustering, lights, _, mpa = \
        line.split()
    presampled = "-" if mpa == "-" else mpa
    row = Row(name, method_name(method),
              f"{integrator}, {paths} paths"
              + ("" if lights == "-"
                 else ", " + as_printed(area, clustering, lights, "-", presampled)),
              None, seconds=float(seconds), euclidean=float(euclidean))
    row.lights = 0 if lights == "-" else int(lights.split(":")[1])
    if method == "IS":
        row.drawn = int(paths)
        row.recipe = Recipe("importance", row.drawn, 1)
        return row
    row.presampled = True
    cells, light_samples = re.fullmatch(r"OS\((\d+)\)(?::(\d+))?", mpa).groups()
    drawn = hybrid_strategy(float(area), clustering, lights, cells, "power")
    if integrator == "PT1":
        row.drawn = int(paths)
        row.recipe = Recipe(drawn, row.drawn, 1)
        return row
    if paths in MISPRINTS:
        row.note = f"{paths} is a misprint: rendered as {MISPRINTS[paths]}"
    samples, split = map(int, MISPRINTS.get(paths, paths).split("x"))
    row.drawn = samples * split
    row.recipe = Recipe(hybrid_strategy(float(area), clustering, lights, cells), samples,
                        int(light_samples), split=split, behind=drawn)
    return row


# Importance sampling under MIS is compensated unless it is switched off.
PLAIN = "importance:compensate=0"


def compensated(light_samples):
    """Returns the strategy that leaves light to the one BSDF sample per `light_samples`."""
    return f"importance:compensate={1 / light_samples:g}"


def with_mis(rows, integrator):
    """Returns the thesis's rows that have a density, again with multiple importance sampling.

    With direct light each light sample has a BSDF sample beside it (T 4.2.1); a path has one at
    every vertex. Lights have no density that a BSDF sample could meet, so rows of lights alone
    would be the same.
    """
    again = []
    for row in rows:
        if row.method not in ("I.S.", "HIB.") or "presampled" in row.recipe.strategy:
            continue
        recipe = replace(row.recipe, mis=True)
        if recipe.strategy == "importance":
            recipe.strategy = PLAIN
        if integrator == "direct":
            recipe.split = recipe.light_samples
        again.append(Row(row.name + "m", "with MIS", row.parameters, recipe, lights=row.lights,
                         drawn=row.drawn))
    return again


def ours_direct(counts):
    """Returns the rows below the line: Skywave's own, with multiple importance sampling."""
    recipes = []
    for strategy, samples in [(PLAIN, counts),
                              (None, counts[::2]),
                              ("product", counts[::2]),
                              ("ris", counts[::2]),
                              ("hybrid:lights=64", counts[:3]),
                              ("hybrid:lights=64,inside=1", counts[:3])]:
        recipes += [Recipe(strategy or compensated(drawn), CAMERA_SAMPLES, drawn, mis=True)
                    for drawn in samples]
    return name_ours(recipes, lambda recipe: (f"{recipe.light_samples} light samples",
                                              recipe.light_samples))


def ours_path(counts):
    recipes = [Recipe(strategy, paths, 1, mis=True)
               for strategy in (PLAIN, compensated(1), "product", "ris",
                                "hybrid:lights=64,pick=power")
               for paths in counts]
    recipes += [Recipe("hybrid:lights=16,inside=1", paths // 4, 1, mis=True) for paths in counts]
    # There are as many continuations as light samples, so that both see half of the direct light
    # each.
    recipes += [Recipe(compensated(1), paths // 8, 8, mis=True, split=8) for paths in counts]

    def describe(recipe):
        if not recipe.split:
            return f"{recipe.samples} paths", recipe.samples
        return (f"{recipe.samples}x{recipe.split} paths, {recipe.light_samples} light samples",
                recipe.samples * recipe.split)
    return name_ours(recipes, describe)


def name_ours(recipes, describe):
    """`describe(recipe)` returns (words, samples that count)."""
    rows = []
    for index, recipe in enumerate(recipes):
        words, drawn = describe(recipe)
        rows.append(Row(f"s{index + 1}", "ours", words, recipe,
                        lights=int((re.search(r"lights=(\d+)", recipe.strategy) or [0, 0])[1]),
                        drawn=drawn))
    return rows


KILLEROO_DIRECT = """
1 IS 81.1 0.051807 0.01542 0 - - 16 -
2 IS 156.4 0.021705 0.00654 0 - - 32 -
3 IS 312.4 0.012404 0.00373 0 - - 64 -
4 IS 604.3 0.009375 0.00284 0 - - 128 -
5 IS 1225.0 0.008154 0.00247 0 - - 256 -
6 MPA 69.0 0.046599 0.01399 0 - - - OS(1310):16
7 MPA 129.0 0.025096 0.00762 0 - - - OS(1310):32
8 MPA 255.0 0.011824 0.00360 0 - - - OS(1310):64
9 MPA 511.4 0.009452 0.00289 0 - - - OS(1310):128
10 HIB 223.3 0.010599 0.07155 0.331 F1 OS:48 32 -
11 HIB 191.8 0.012291 0.00371 0.331 F1 OS:48 - IS/OS(569):32
12 HIB 313.9 0.010054 0.00305 0.331 F1 OS:48 - IS/OS(569):64
13 HIB 190.7 0.009354 0.00284 0.331 F1 OS:48 - OS(569):32
14 HIB 313.9 0.008665 0.00264 0.331 F1 OS:48 - OS(569):64
15 HIB 128.8 0.010747 0.00329 0.864 F2 OS:48 - OS(519):16
16 HIB 190.2 0.008564 0.00262 0.864 F2 OS:48 - OS(519):32
17 HIB 314.2 0.008591 0.00262 0.864 F2 OS:48 - OS(519):64
18 HIB 128.9 0.011434 0.00350 0.864 F3 OS:48 - OS(519):16
19 HIB 119.9 0.010198 0.00312 0.864 F1 OS:40 - OS(512):16
20 HIB 184.0 0.008994 0.00275 0.864 F1 OS:40 - OS(512):32
21 HIB 310.8 0.008856 0.00271 0.864 F1 OS:40 - OS(512):64
22 HIB 120.4 0.010195 0.00312 0.864 F2 OS:40 - OS(512):16
23 HIB 185.4 0.008919 0.00273 0.864 F2 OS:40 - OS(512):32
24 HIB 309.3 0.008788 0.00268 0.864 F2 OS:40 - OS(512):64
25 HIB 133.1 0.010961 0.00334 0.864 F1 OS:50 - OS(512):16
26 HIB 196.1 0.008761 0.00268 0.864 F1 OS:50 - OS(512):32
27 HIB 328.0 0.009141 0.00279 0.864 F1 OS:50 - OS(512):64
28 HIB 197.8 0.008869 0.00271 0.864 F2 OS:50 - OS(512):32
29 HIB 327.0 0.009208 0.00281 0.864 F2 OS:50 - OS(512):64
30 HIB 151.6 0.009663 0.00296 0.864 F1 OS:64 - OS(512):16
31 HIB 214.5 0.008451 0.00258 0.864 F1 OS:64 - OS(512):32
32 HIB 340.2 0.008437 0.00258 0.864 F1 OS:64 - OS(512):64
33 HIB 153.0 0.009625 0.00294 0.864 F2 OS:64 - OS(512):16
34 HIB 215.9 0.008376 0.00256 0.864 F2 OS:64 - OS(512):32
35 HIB 338.9 0.008370 0.00256 0.864 F2 OS:64 - OS(512):64
36 HIB 120.8 0.009715 0.00298 0.864 F1 OS:40 - OS(360):16
37 HIB 182.3 0.008888 0.00272 0.864 F1 OS:40 - OS(360):32
38 HIB 310.6 0.008872 0.00271 0.864 F1 OS:40 - OS(360):64
39 HIB 91.8 0.013426 0.00414 0.864 F2 OS:40 - OS(360):8
40 HIB 122.7 0.009693 0.00297 0.864 F2 OS:40 - OS(360):16
41 HIB 183.5 0.008793 0.00269 0.864 F2 OS:40 - OS(360):32
42 HIB 308.3 0.008784 0.00268 0.864 F2 OS:40 - OS(360):64
43 HIB 196.7 0.008658 0.00264 0.864 F1 OS:50 - OS(360):32
44 HIB 151.0 0.009033 0.00277 0.864 F1 OS:64 - OS(360):16
45 HIB 339.7 0.008389 0.00256 0.864 F1 OS:64 - OS(360):64
46 HIB 214.2 0.008343 0.00255 0.864 F2 OS:64 - OS(360):32
47 HIB 338.3 0.008326 0.00254 0.864 F2 OS:64 - OS(360):64
48 HIB 492.3 0.007975 0.00242 1.275 F2 OS:128 64 -
"""

BUDDHA_GRACE = """
1 IS 80.5 0.129832 0.024133 0 - - 16 -
2 IS 163.6 0.077130 0.014590 0 - - 32 -
3 IS 311.2 0.059068 0.010880 0 - - 64 -
4 IS 611.4 0.045997 0.008769 0 - - 128 -
5 IS 1224.5 0.041945 0.008017 0 - - 256 -
6 HIB 149.3 0.065939 0.012014 1.39 - MC:64 - OS(476):16
7 HIB 210.7 0.051115 0.009802 1.39 - MC:64 - OS(476):32
8 HIB 337.1 0.049371 0.009554 1.39 - MC:64 - OS(476):64
9 HIB 151.2 0.063070 0.011258 1.39 F1 OS:64 - OS(476):16
10 HIB 213.6 0.048474 0.009083 1.39 F1 OS:64 - OS(476):32
11 HIB 334.5 0.046654 0.008810 1.39 F1 OS:64 - OS(476):64
12 HIB 148.9 0.062757 0.011162 1.39 F2 OS:64 - OS(476):16
13 HIB 209.0 0.048542 0.009077 1.39 F2 OS:64 - OS(476):32
14 HIB 149.5 0.063629 0.011403 1.39 F3 OS:64 - OS(476):16
15 HIB 209.6 0.049120 0.009256 1.39 F3 OS:64 - OS(476):32
16 HIB 232.2 0.050088 0.009268 1.39 F1 OS:80 - OS(476):32
17 HIB 231.6 0.050394 0.009324 1.39 F2 OS:80 - OS(476):32
"""

BUDDHA_RNL = """
1 IS 81.9 0.029390 0.008745 0 - - 16 -
2 IS 160.1 0.016434 0.005006 0 - - 32 -
3 IS 316.9 0.010649 0.003241 0 - - 64 -
4 IS 623.1 0.008355 0.002566 0 - - 128 -
5 MPA 67.9 0.021242 0.006399 0 - - - OS(613):16
6 MPA 131.8 0.014224 0.004332 0 - - - OS(613):32
7 MPA 255.8 0.009639 0.002945 0 - - - OS(613):64
8 HIB 157.4 0.010408 0.003083 3.71 F3 OS:70 - OS(437):16
9 HIB 223.9 0.008653 0.002624 3.71 F3 OS:70 - OS(437):32
10 HIB 259.2 0.008332 0.002527 3.71 F2 OS:92 - OS(437):32
11 HIB 253.6 0.008305 0.002516 3.71 F3 OS:92 - OS(437):32
12 DL 348.4 0.007966 0.002497 100 - MC:256 - -
13 DL 341.2 0.008744 0.002751 100 F3 OS:256 - -
"""

TWO_SPHERES_PATH = """
1 HIB PT1 387.6 0.029357 128 0.864 F2 OS:64 - OS(360)
2 IS PT 567.8 0.030331 128 0 - - 1 -
3 HIB PT1 761.3 0.015543 256 0.864 F2 OS:64 - OS(360)
4 IS PT 1068.9 0.016286 256 0 - - 1 -
5 HIB PT2 657.7 0.015988 4x64 0.864 F2 OS:40 - OS(360):16
6 HIB PT2 1269.3 0.009003 4x61 0.864 F2 OS:64 - OS(360):16
7 IS PT 2236.8 0.009123 512 0 - - 1 -
"""

KILLEROO_PATH = """
1 IS PT 1293.2 0.237848 256 0 - - 1 -
2 HIB PT2 689.6 0.214314 8x29 0.864 F2 OS:40 - OS(512):8
3 HIB PT1 1060.9 0.234260 256 0.864 F2 OS:64 - OS(360)
4 IS PT 2529.4 0.119027 512 0 - - 1 -
5 HIB PT2 1259.3 0.110049 8x63 0.864 F2 OS:40 - OS(360):8
"""


def read(text, read_row):
    return [read_row(line) for line in text.strip().splitlines()]


def direct_rows(text, counts):
    rows = read(text, read_direct_row)
    return rows + with_mis(rows, "direct") + ours_direct(counts)


def path_rows(text, counts):
    rows = read(text, read_path_row)
    return rows + with_mis(rows, "path") + ours_path(counts)


# The reference has as many light samples as the thesis's (64 x 512), but 16 times the camera
# samples, so that it adds no edge noise of its own.
DIRECT_REFERENCE = {"reference": (1024, 32), "quick_reference": (64, 16)}
PATH_REFERENCE = {"reference": (32768, 1), "quick_reference": (512, 1),
                  "reference_strategy": compensated(1)}
COUNTS = [16, 32, 64, 128, 256]

TABLES = {table.name: table for table in [
    Table("8.2", "Direct lighting, Killeroo under Galileo", "killeroo", "galileo", "direct",
          "5", [("46", "5"), ("46", "4"), ("39", "3")], **DIRECT_REFERENCE,
          rows=direct_rows(KILLEROO_DIRECT, COUNTS)),
    Table("8.3", "Direct lighting, Buddha under Grace", "buddha", "grace", "direct",
          "5", [("11", "4"), ("12", "3")], **DIRECT_REFERENCE,
          rows=direct_rows(BUDDHA_GRACE, COUNTS)),
    Table("8.4", "Direct lighting, Buddha under Rnl", "buddha", "rnl", "direct",
          "4", [("11", "4"), ("10", "4"), ("12", "4")], **DIRECT_REFERENCE,
          rows=direct_rows(BUDDHA_RNL, COUNTS)),
    Table("8.5", "Path tracing, two spheres in a box under Galileo", "two_spheres", "galileo",
          "path", "7", [("6", "7"), ("3", "4"), ("1", "2")], turn=270, **PATH_REFERENCE,
          rows=path_rows(TWO_SPHERES_PATH, [128, 512])),
    Table("8.6", "Path tracing, Killeroo under Galileo", "killeroo", "galileo", "path",
          "4", [("5", "4"), ("3", "1")], **PATH_REFERENCE,
          rows=path_rows(KILLEROO_PATH, [128, 512])),
]}
