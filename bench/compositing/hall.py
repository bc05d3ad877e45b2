"""A hall with a table, and objects to put on it: as pbrt files and as data for Cycles.

World: y up, left-handed as in pbrt. The hall is a thousand times as large as the objects, so that
its light comes from far away, as that of a light probe does. (In a hall of a tenth of that, the
errors at the edges of shadows are those of the probe: the lamp is not where it is seen from the
middle.)"""

EYE, TARGET, FIELD_OF_VIEW = (0.3, 1.5, -3.2), (0, 0.2, 0), 34
HALF = 300                  # of the hall
FLOOR, CEILING = -160, 200  # the table is at 0

# Sides by name: a corner, two edges, reflectance.
WALLS = {
    "left": ((-HALF, FLOOR, -HALF), (0, 0, 2 * HALF), (0, CEILING - FLOOR, 0), (0.6, 0.2, 0.15)),
    "right": ((HALF, FLOOR, -HALF), (0, CEILING - FLOOR, 0), (0, 0, 2 * HALF), (0.2, 0.35, 0.6)),
    "back": ((-HALF, FLOOR, HALF), (2 * HALF, 0, 0), (0, CEILING - FLOOR, 0), (0.5, 0.5, 0.45)),
    "front": ((-HALF, FLOOR, -HALF), (0, CEILING - FLOOR, 0), (2 * HALF, 0, 0), (0.4, 0.4, 0.4)),
    "ceiling": ((-HALF, CEILING, -HALF), (2 * HALF, 0, 0), (0, 0, 2 * HALF), (0.7, 0.7, 0.7)),
    "floor": ((-HALF, FLOOR, -HALF), (0, 0, 2 * HALF), (2 * HALF, 0, 0), (0.35, 0.28, 0.2)),
}
# What shines, inwards alone: a corner, two edges, radiance.
LIGHTS = {"window": ((-HALF + 1, -20, -120), (0, 140, 0), (0, 0, 200), (3, 4, 6)),
          "lamp": ((130, CEILING - 1, -90), (20, 0, 0), (0, 0, 20), (500, 430, 330))}
TABLE_HALF = 1.6

# The colour of the table; "polished" has a clear coat of this alpha of GGX.
TABLES = {"matt": {"colors": ((0.55, 0.42, 0.28), (0.35, 0.27, 0.2)), "coat": None},
          "polished": {"colors": ((0.3, 0.2, 0.13),) * 2, "coat": 0.15}}
TILES = 8  # of the table, along a side

# Balls: centre, radius, colour; with `roughness` (alpha of GGX) a metal of this reflectance.
BALLS = [
    {"centre": (-0.62, 0.28, 0.1), "radius": 0.28, "color": (0.75, 0.08, 0.06)},
    {"centre": (0.05, 0.3, 0.35), "radius": 0.3, "color": (1.0, 0.78, 0.34), "roughness": 0.15},
    {"centre": (0.6, 0.22, -0.15), "radius": 0.22, "color": (0.95, 0.93, 0.88), "roughness": 0.1},
    {"centre": (-0.1, 0.14, -0.45), "radius": 0.14, "color": (0.1, 0.5, 0.15)},
]


def numbers(values):
    return " ".join(f"{value:g}" for value in values)


def quad(corner, a, b, uv=""):
    def at(u, v):
        return [c + u * x + v * y for c, x, y in zip(corner, a, b)]

    points = [*at(0, 0), *at(1, 0), *at(1, 1), *at(0, 1)]
    return (f'Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [{numbers(points)}]'
            f'{uv}\n')


def place():
    """Returns the hall."""
    text = ""
    for corner, a, b, color in WALLS.values():
        text += f'Material "diffuse" "rgb reflectance" [{numbers(color)}]\n' + quad(corner, a, b)
    for corner, a, b, radiance in LIGHTS.values():
        text += (f'AttributeBegin AreaLightSource "diffuse" "rgb L" [{numbers(radiance)}] '
                 f'\n{quad(corner, a, b)}AttributeEnd\n')
    return text


def table(name):
    described = TABLES[name]
    bright, dark = described["colors"]
    text = (f'Texture "tiles" "spectrum" "checkerboard" "rgb tex1" [{numbers(bright)}] '
            f'"rgb tex2" [{numbers(dark)}] "float uscale" {TILES} "float vscale" {TILES}\n')
    kind = ('"string type" "diffuse"' if described["coat"] is None else
            f'"string type" "coateddiffuse" "float roughness" {described["coat"] ** 2:g} '
            '"float eta" 1.5 "float thickness" 0')
    text += (f'MakeNamedMaterial "table" {kind} "texture reflectance" "tiles"\n'
             'NamedMaterial "table"\n')
    half = TABLE_HALF
    return text + quad((-half, 0, -half), (0, 0, 2 * half), (2 * half, 0, 0),
                       ' "point2 uv" [0 0 0 1 1 1 1 0]')


def balls():
    text = ""
    for ball in BALLS:
        color = numbers(ball["color"])
        if "roughness" in ball:
            text += (f'Material "conductor" "rgb reflectance" [{color}] "float roughness" '
                     f'{ball["roughness"]:g} "bool remaproughness" false\n')
        else:
            text += f'Material "diffuse" "rgb reflectance" [{color}]\n'
        text += (f'AttributeBegin Translate {numbers(ball["centre"])} '
                 f'Shape "sphere" "float radius" {ball["radius"]}\nAttributeEnd\n')
    return text


def scene(name, of_table):
    """Returns the pbrt file of the "place", of the "objects" on the table, or of "all"."""
    parts = {"place": (place(), table(of_table)), "objects": (table(of_table), balls()),
             "all": (place(), table(of_table), balls())}
    return (f'LookAt {numbers(EYE)} {numbers(TARGET)} 0 1 0\n'
            f'Camera "perspective" "float fov" {FIELD_OF_VIEW}\nFilm "rgb"\nWorldBegin\n'
            + "".join(parts[name]))


def for_blender(of_table):
    """Returns objects and table as data; exchanging y and z makes the world right-handed, z up."""
    def exchanged(point):
        return [point[0], point[2], point[1]]

    return {"eye": exchanged(EYE), "target": exchanged(TARGET), "field_of_view": FIELD_OF_VIEW,
            "table": {"half": TABLE_HALF, "tiles": TILES, **TABLES[of_table]},
            "balls": [ball | {"centre": exchanged(ball["centre"])} for ball in BALLS]}
