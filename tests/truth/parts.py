"""What the scenes of the truth test (scenes.py) are put together from."""

import dataclasses
import math


@dataclasses.dataclass
class Scene:
    name: str
    feature: str
    text: str
    # A difference by design: its reason. `text` may then ask for what pbrt does anyway, in words
    # that both understand, or `options` may; the comparison stays as narrow as for all others.
    reason: str = ""
    options: tuple = ()
    # Where pbrt contradicts itself, this text has the same light without the feature that confuses
    # it, and the picture is held to ours of it.
    instead: str = ""
    # Where pictures differ by more than the bounds and the reason says why: what the total may
    # differ by [percent, from, to]; blocks are not compared.
    total: tuple = ()
    # What a block may differ by [percent] where the reason says why.
    block: float = 3
    exact: float = 0  # the mean of the picture, where there is a formula


def film(width=80, height=60, more=""):
    return f"""
Film "rgb" "integer xresolution" {width} "integer yresolution" {height} {more}
"""


BOX = 'PixelFilter "box" "float xradius" .5 "float yradius" .5\n'


def path(depth):
    return f'Integrator "path" "integer maxdepth" {depth}\n'


def grey(value):
    return f'Material "diffuse" "rgb reflectance" [{value} {value} {value}]\n'


def quad(a, b, c, d, uv="0 0  1 0  1 1  0 1", more=""):
    coordinates = f'"point2 uv" [{uv}]' if uv else ""
    return (f'Shape "trianglemesh" "integer indices" [0 1 2  0 2 3] '
            f'"point3 P" [{a}  {b}  {c}  {d}] {coordinates} {more}\n')


def within(*lines):
    return "AttributeBegin\n" + "\n".join(lines) + "\nAttributeEnd\n"


# The room of most scenes: a grey floor below a camera, and either a sky with a sun or a faint sky.
SUN = ('LightSource "infinite" "rgb L" [.3 .3 .3]\n'
       'LightSource "distant" "rgb L" [2 2 2] "point3 from" [1 2 -2] "point3 to" [0 0 0]\n')
DUSK = 'LightSource "infinite" "rgb L" [.05 .05 .05]\n'
FLOOR = grey(.4) + quad("-9 0 -9", "-9 0 9", "9 0 9", "9 0 -9") + grey(.6)
BALL = within("Translate 0 1 0", 'Shape "sphere"')
TILTED_BALL = "Translate 0 1 0 Rotate -60 1 0 0"
SCREEN = quad("-1 0 0", "1 0 0", "1 1.6 0", "-1 1.6 0")
LAMP = 'AreaLightSource "diffuse" "rgb L" [5 5 5]'


def room(*parts, light=SUN, filter=BOX, depth=4, of_film=None, camera="", before="", floor=FLOOR):
    return (f'LookAt 0 2 -5  0 .7 0  0 1 0\nCamera "perspective" "float fov" 45 {camera}\n' +
            (of_film or film()) + filter + path(depth) + "WorldBegin\n" + light + before + floor +
            "".join(part + "\n" for part in parts))


def dusk(*parts, **others):
    return room(*parts, light=DUSK, **others)


def texture(name, kind, more, type="spectrum"):
    return f'Texture "{name}" "{type}" "{kind}" {more}\n'


def image(name, file, more="", type="spectrum"):
    return texture(name, "imagemap", f'"string filename" "{file}" {more}', type)


def small_lamp(*turns, n=""):
    """A square lamp above the floor, after some transforms."""
    return within(LAMP, *turns,
                  quad("-.5 .3 0", ".5 .3 0", ".5 1.3 0", "-.5 1.3 0", "",
                       f'"normal N" [{" ".join([n] * 4)}]' if n else ""))


def bilinear_lamp(*turns):
    return within(LAMP, *turns,
                  'Shape "bilinearmesh" "point3 P" [-.5 .3 0  .5 .3 0  -.5 1.3 0  .5 1.3 0]')


def furnace(material):
    """The middle of a sphere under an even white sky, from the front."""
    return ('LookAt 0 0 -5  0 0 0  0 1 0\n'
            'Camera "orthographic" "float screenwindow" [-.7 .7 -.7 .7]\n' + film(64, 64) + BOX +
            path(3) + 'WorldBegin\nLightSource "infinite" "rgb L" [1 1 1]\n' + material +
            '\nShape "sphere"\n')


def fresnel(cosine, eta):
    """What a smooth boundary of relative index `eta` reflects of unpolarized light."""
    sine2 = (1 - cosine * cosine) / (eta * eta)
    if sine2 >= 1:
        return 1
    transmitted = math.sqrt(1 - sine2)
    s = (cosine - eta * transmitted) / (cosine + eta * transmitted)
    p = (eta * cosine - transmitted) / (eta * cosine + transmitted)
    return (s * s + p * p) / 2


def coat_in_furnace(reflectance, eta=1.5, thickness=.01):
    """The mean of furnace() for a smooth coat that absorbs exp(-thickness / cosine) a way, on a
    Lambertian body: the light that goes to and fro below it is a geometric series, and a furnace
    shows the albedo of the direction to the eye."""
    steps = 2000
    cosines = [(i + .5) / steps for i in range(steps)]
    up = [2 * c * math.exp(-thickness / c) * (1 - fresnel(c, 1 / eta)) for c in cosines]
    back = [2 * c * math.exp(-2 * thickness / c) * fresnel(c, 1 / eta) for c in cosines]
    body = reflectance * sum(up) / steps / (1 - reflectance * sum(back) / steps)
    total, side = 0, 100
    for i in range(side * side):
        x, y = .7 * (i % side + .5) / side, .7 * (i // side + .5) / side
        cosine = math.sqrt(1 - x * x - y * y)
        below = math.sqrt(1 - (1 - cosine * cosine) / eta ** 2)
        reflected = fresnel(cosine, eta)
        total += reflected + (1 - reflected) * math.exp(-thickness / below) * body
    return total / side ** 2


def sky(light):
    """An even sky by itself."""
    return ('LookAt 0 0 0  0 1 0  0 0 1\nCamera "spherical" "string mapping" "equirectangular"\n' +
            film(160, 80) + BOX + path(1) + "WorldBegin\n" + light +
            within("Translate 0 0 -50", 'Shape "disk" "float radius" .001'))


def highlight(*textures):
    """A brushed ball and the highlight of a lamp."""
    at = "-.5 -.5 {0}", ".5 -.5 {0}", ".5 .5 {0}", "-.5 .5 {0}"
    lamp = (quad(*(corner.format("0") for corner in at)) +
            quad(*(at[i].format(".01") for i in (0, 3, 2, 1))))
    return ('LookAt 0 1.5 -4  0 0 0  0 1 0\nCamera "perspective" "float fov" 32\n' +
            film(160, 120) + BOX + path(2) + "WorldBegin\n" + "".join(textures) +
            'LightSource "infinite" "rgb L" [.1 .1 .1]\n' +
            within('AreaLightSource "diffuse" "rgb L" [8 8 8]', "Translate 2 3 -3",
                   "Rotate 45 1 0 0 Rotate 30 0 1 0", lamp) +
            within('Material "conductor" "rgb reflectance" [.6 .6 .6] "float uroughness" .02 '
                   '"float vroughness" .3 "bool remaproughness" false', "Rotate -90 1 0 0",
                   'Shape "sphere"'))


def normal_map(*turns, shape=SCREEN):
    return room('Material "diffuse" "rgb reflectance" [.6 .6 .6] "string normalmap" "normal.png"',
                within(*turns, shape))


def heights(*turns):
    return room('Material "diffuse" "rgb reflectance" [.6 .6 .6] "texture displacement" "h"',
                within(*turns, SCREEN),
                before=image("h", "height.pfm", '"float scale" .1', "float"))


def ball_of(material, **others):
    return room(material, BALL, **others)


def ball_textured(texture):
    return ball_of('Material "diffuse" "texture reflectance" "p"', before=texture)


def tile(column, row, more=""):
    """One of 3 x 3 rectangles; rows from the top."""
    x, y = (-3, -1, 1)[column], (.75, -.75, -2.25)[row]
    return quad(f"{x} {y} 0", f"{x + 1.9} {y} 0", f"{x + 1.9} {y + 1.4} 0", f"{x} {y + 1.4} 0",
                more=more)


def tiles(light, textures, *parts, backdrop=grey(.5)):
    return ('LookAt 0 0 -6  0 0 0  0 1 0\nCamera "perspective" "float fov" 42\n' + film(160, 120) +
            BOX + path(3) + "WorldBegin\n" + light + textures + "".join(parts) + backdrop +
            quad("-9 -6 1", "9 -6 1", "9 6 1", "-9 6 1"))


def of_texture(name):
    return f'Material "diffuse" "texture reflectance" "{name}"\n'


TEXTURES = (
    image("img", "squares.png") +
    image("img2", "squares.png", '"float uscale" 2.5 "float vscale" 1.5 "float udelta" .2 '
          '"float vdelta" .3 "string encoding" "linear" "float scale" .8') +
    image("imgc", "squares.png", '"string wrap" "clamp" "float uscale" 2 "float udelta" -.5 '
          '"string encoding" "gamma 1.8"') +
    image("inv", "squares.png", '"bool invert" true') +
    texture("ch", "checkerboard", '"float uscale" 4 "float vscale" 6 "rgb tex1" [.8 .8 .8] '
            '"rgb tex2" [.1 .1 .1]') +
    image("m", "squares1.png", '"string encoding" "linear"', "float") +
    texture("sc", "scale", '"texture tex" "ch" "texture scale" "m"') +
    texture("mx", "mix", '"texture tex1" "img" "texture tex2" "ch" "texture amount" "m"') +
    texture("mx2", "mix", '"rgb tex1" [.1 .1 .1] "rgb tex2" [.9 .9 .9] "float amount" .25') +
    texture("chi", "checkerboard", '"float uscale" 2 "float vscale" 4 "texture tex1" "img" '
            '"rgb tex2" [.5 .5 .5]'))


def all_textures():
    grid = [("img", "img2", "imgc"), ("inv", "ch", "sc")]
    parts = [of_texture(name) + tile(column, row) for row, names in enumerate(grid)
             for column, name in enumerate(names)]
    parts += [of_texture("mx") + tile(0, 2), of_texture("chi") + tile(1, 2), of_texture("img"),
              within("Translate 1.5 -1.5 0", "Rotate -90 1 0 0 Rotate 30 0 0 1",
                     'Shape "sphere" "float radius" .55'),
              within("Translate 2.6 -1.5 0", "Rotate -90 1 0 0",
                     'Shape "cylinder" "float radius" .4 "float zmin" -.6 "float zmax" .6')]
    return tiles('LightSource "point" "rgb I" [60 60 60] "point3 from" [1 1 -5]\n'
                 'LightSource "infinite" "rgb L" [.5 .5 .5]\n', TEXTURES, *parts,
                 backdrop=of_texture("mx2"))


def all_reliefs():
    textures = (image("h", "height.pfm", type="float") +
                texture("hs", "scale", '"texture tex" "h" "float scale" .1', "float") +
                image("hs2", "height.pfm", '"float scale" .05 "float uscale" 2 "float vscale" 1',
                      "float"))
    body = 'Material "diffuse" "rgb reflectance" [.6 .6 .6] '
    return tiles(
        'LightSource "distant" "rgb L" [2 2 2] "point3 from" [1 .6 -.7] "point3 to" [0 0 0]\n'
        'LightSource "infinite" "rgb L" [.2 .2 .2]\n', textures,
        body + '"string normalmap" "normal.png"\n', tile(0, 0),
        within("Translate -.05 0 0 Scale -1 1 1 Translate .05 0 0", tile(1, 0)),
        within("ReverseOrientation", tile(2, 0)),
        within("Translate -2 0 0", "Rotate -90 1 0 0 Rotate 40 0 0 1",
               'Shape "sphere" "float radius" .7'),
        body + '"texture displacement" "hs"\n', tile(1, 1),
        within("ReverseOrientation", tile(2, 1)),
        within("Translate 0 -1.55 0 Scale 1 -1 1 Translate 0 1.55 0", tile(0, 2)),
        body + '"texture displacement" "hs2"\n', tile(1, 2),
        within("Translate 2 -1.5 0", "Rotate -90 1 0 0", 'Shape "sphere" "float radius" .6'))


def all_lights():
    def lamp(colour, more, *turns, shape):
        return within(*turns, f'AreaLightSource "diffuse" "rgb L" [{colour}] {more}', shape)
    lights = (
        'LightSource "infinite" "blackbody L" 6500 "float scale" .1\n'
        'LightSource "point" "rgb I" [2 2 2] "float power" 40 "point3 from" [-2 1.5 -1]\n'
        'LightSource "point" "rgb I" [1 1 1] "float scale" 3 "point3 from" [2 2 -2]\n' +
        within("Translate 2 3 1 Rotate 90 1 0 0",
               'LightSource "spot" "rgb I" [1 1 1] "float power" 60') +
        'LightSource "distant" "rgb L" [1 1 1] "float illuminance" 1.5 "point3 from" [-1 2 -1] '
        '"point3 to" [0 0 0]\n' +
        within("Rotate 120 1 1 0", 'LightSource "distant" "rgb L" [.5 .5 .5] "float scale" 2') +
        lamp("3 3 3", '"float power" 10', "Translate 0 2.2 0",
             shape='Shape "sphere" "float radius" .2') +
        lamp("1 1 1", '"float power" 8 "bool twosided" true', "Translate -1.5 .5 1.5",
             shape='Shape "bilinearmesh" "point3 P" [-.5 0 0  .5 0 0  -.5 1 .2  .5 1 .2]') +
        lamp("6 6 6", '"float scale" .5', "Translate 1.5 .2 1.6 Rotate 200 0 1 0",
             shape='Shape "cylinder" "float radius" .2 "float zmin" 0 "float zmax" .8 '
             '"float phimax" 200'))
    return ('LookAt 0 3.2 -5  0 .8 0  0 1 0\nCamera "perspective" "float fov" 50\n' +
            film(160, 120) + BOX + path(5) + "WorldBegin\n" + lights + grey(.5) +
            quad("-9 0 -9", "-9 0 9", "9 0 9", "9 0 -9") + grey(.6) +
            within("Translate 0 .5 0", 'Shape "sphere" "float radius" .5') +
            within("Translate -1.5 .3 0",
                   'Shape "sphere" "float radius" .3 "float zmax" .2 "float phimax" 250'))


def coloured_box():
    def wall(colour, *corners):
        return f'Material "diffuse" "rgb reflectance" [{colour}]\n' + quad(*corners)
    white = ".7 .7 .7"
    return ('LookAt 0 2.5 -3.8  0 2.3 1  0 1 0\nCamera "perspective" "float fov" 75\n' +
            film(160, 120) + BOX + path(6) + "WorldBegin\n" +
            wall(white, "-4 0 -4", "-4 0 4", "4 0 4", "4 0 -4") +
            wall(white, "-4 5 -4", "4 5 -4", "4 5 4", "-4 5 4") +
            wall(white, "-4 0 4", "-4 5 4", "4 5 4", "4 0 4") +
            wall(".65 .05 .05", "-4 0 -4", "-4 5 -4", "-4 5 4", "-4 0 4") +
            wall(".1 .5 .1", "4 0 -4", "4 0 4", "4 5 4", "4 5 -4") +
            wall(white, "-4 0 -4", "4 0 -4", "4 5 -4", "-4 5 -4") +
            within('AreaLightSource "diffuse" "rgb L" [10 8 4]',
                   quad("-1 4.9 -1", "1 4.9 -1", "1 4.9 1", "-1 4.9 1")) +
            grey(.6) + within("Translate -1 1 .5", 'Shape "sphere"'))


def mixture(amount, first, second):
    return (f'MakeNamedMaterial "p" "string type" {first}\n'
            f'MakeNamedMaterial "q" "string type" {second}\n'
            f'Material "mix" "string materials" ["p" "q"] {amount}')


def round_lamp(*turns, shape, lamp=LAMP):
    return dusk(within(lamp, *turns, shape))


METAL = '"spectrum {0}eta" [360 .2 830 .2] "spectrum {0}k" [360 3.9 830 3.9]'
NOT_REMAPPED = '"bool remaproughness" false'
TRIANGLES_N = "0 0 1", "0 0 -1"
SPHERE_PART = 'Shape "sphere" "float radius" {0} "float {1}" {2}'
FAINT = 'AreaLightSource "diffuse" "rgb L" [4 4 4]'
UP = "Translate 0 1 0"
LIGHTS_UP = 'Translate 1.2 2.4 1'
DISK = 'Shape "disk" "float radius" .5'
CYLINDER = 'Shape "cylinder" "float radius" .3 "float zmin" -.5 "float zmax" .5'
MIRRORED = ("pbrt contradicts itself on lamps that are mirrored or parts of quadrics; held to the "
            "same lamp without that")
COMPENSATED = ("rough surfaces keep the light that facets scatter twice; with "
               "`--no-energy-compensation`")
SINGLE = ("--no-energy-compensation",)
THICK = '"float thickness" .01'
COAT = "pbrt's coat absorbs by default; with its thickness of 0.01 asked for"
SOFT = "edges of checks are as soft as 1/64 of a check, and images are filtered"
SPECTRA = "pbrt renders spectra, Skywave the three means of each over its channel"
