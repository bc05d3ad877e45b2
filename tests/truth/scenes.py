"""The scenes of the truth test: one feature each, small, with the arrangement of which pbrt-v4's
figures are known (pbrt_blocks.json)."""

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

SCENES = [
    Scene("09_lights", "all kinds of lights, by radiance, scale and power", all_lights()),
    Scene("14_textures", "image, invert, checkerboard, scale, mix; wraps and encodings",
          all_textures(), block=7.5, reason=SOFT),
    Scene("15_bump_normal", "normal maps and displacement; mirrored, reversed, on spheres",
          all_reliefs(), reason="light from below a triangle does not count, however its normal is "
          "bent; pbrt lets it through"),
    Scene("18_saturated", "a room of saturated walls", coloured_box(),
          total=(-1, 1), reason=SPECTRA),
    Scene("alpha_nouv", "alpha by an image on triangles without uv",
          room(quad("-.5 .3 0", ".5 .3 0", ".5 1.3 0", "-.5 1.3 0", "", '"texture alpha" "a"'),
               before=image("a", "mask.pfm", type="float"))),
    Scene("aniso", "anisotropic conductor, no texture in the scene", highlight(),
          reason=COMPENSATED, options=SINGLE),
    Scene("anisotex", "the same with a texture", highlight(image("img", "squares.png")),
          reason=COMPENSATED, options=SINGLE),
    Scene("areascale", "area light of a scale alone",
          round_lamp(UP, shape='Shape "sphere" "float radius" .5',
                     lamp='AreaLightSource "diffuse" "float scale" 3')),
    Scene("attrlight", "Attribute of lights",
          dusk(BALL, before='Attribute "light" "float scale" 2\n'
               'LightSource "distant" "rgb L" [1 1 1]\n')),
    Scene("bl", "lamp that is a bilinear patch", dusk(bilinear_lamp())),
    Scene("blmirrev", "the same, mirrored and reversed",
          dusk(bilinear_lamp("ReverseOrientation Scale -1 1 1"))),
    Scene("blnorm", "emissionfilename without an area light",
          room('Shape "bilinearmesh" "string emissionfilename" "squares.png" '
               '"point3 P" [-.5 .3 0  .5 .3 0  -.5 1.3 0  .5 1.3 0]')),
    Scene("bq", "displacement", heights()),
    Scene("bqmirz", "displacement, mirrored in depth", heights("Scale 1 1 -1")),
    Scene("bqrevmir", "displacement, mirrored and reversed",
          heights("ReverseOrientation Scale -1 1 1")),
    Scene("brushed", "conductor that is rough in one direction alone",
          room('Material "conductor" "rgb reflectance" [.8 .8 .8] "float uroughness" .3',
               within(TILTED_BALL, 'Shape "sphere"'),
               light='LightSource "infinite" "rgb L" [.3 .3 .3]\n'),
          reason=COMPENSATED, options=SINGLE),
    Scene("bumpcond", "displacement of a rough conductor",
          room('Material "conductor" "rgb reflectance" [.8 .8 .8] "float roughness" .1 '
               '"texture displacement" "h"', within(TILTED_BALL, 'Shape "sphere"'),
               before=image("h", "height.pfm", '"float scale" .1 "float uscale" 3', "float")),
          reason=COMPENSATED, options=SINGLE),
    Scene("camsys", "a shape in the space of the camera",
          room('CoordSysTransform "camera" Translate .5 -.2 3 Shape "sphere" "float radius" .3')),
    Scene("cap", "lamp inside a part of a sphere",
          round_lamp("ReverseOrientation", LIGHTS_UP, "Rotate 180 1 0 0", lamp=FAINT,
                     shape=SPHERE_PART.format(.3, "zmax", .1)), reason=MIRRORED,
          instead=round_lamp("ReverseOrientation", LIGHTS_UP, lamp=FAINT,
                             shape=SPHERE_PART.format(.3, "zmin", -.1))),
    Scene("capout", "lamp outside of a part of a sphere",
          round_lamp(UP, "Rotate 180 1 0 0", lamp=FAINT,
                     shape=SPHERE_PART.format(.5, "zmax", .1)), reason=MIRRORED,
          instead=round_lamp(UP, lamp=FAINT, shape=SPHERE_PART.format(.5, "zmin", -.1))),
    Scene("check3d", "checkerboard in space",
          ball_textured(texture("p", "checkerboard", '"integer dimension" 3 '
                                '"rgb tex1" [.1 .1 .1] "rgb tex2" [.9 .9 .9]'))),
    Scene("coatimage", "coateddiffuse with an image of its roughness, under an even sky",
          ball_of('Material "coateddiffuse" "rgb reflectance" [.5 .5 .5] "texture roughness" "r" ' +
                  THICK, depth=8, light='LightSource "infinite" "rgb L" [1 1 1]\n',
                  before=image("r", "height.pfm", '"float scale" .5', "float")), reason=COAT),
    Scene("condAu", "gold by name",
          ball_of('Material "conductor" "spectrum eta" "metal-Au-eta" '
                  '"spectrum k" "metal-Au-k" "float roughness" .01'),
          total=(-1.5, 1.5), reason=SPECTRA),
    Scene("condeta", "metal-TiO2 by name",
          ball_of('Material "conductor" "spectrum eta" "metal-TiO2-eta" '
                  '"spectrum k" "metal-TiO2-k"')),
    Scene("constA", "sky of stdillum-A", sky('LightSource "infinite" "spectrum L" "stdillum-A"\n')),
    Scene("constD65", "sky of stdillum-D65",
          sky('LightSource "infinite" "spectrum L" "stdillum-D65"\n'), exact=1),
    Scene("constE", "sky by its illuminance, 2 lux",
          sky('LightSource "infinite" "rgb L" [1 1 1] "float illuminance" 2\n'),
          exact=0.63662),
    Scene("constF11", "sky of stdillum-F11",
          sky('LightSource "infinite" "spectrum L" "stdillum-F11"\n')),
    Scene("crop2", "cropwindow",
          room('Shape "sphere"', of_film=film(160, 120, '"float cropwindow" [.3 .6 .2 .7]'))),
    Scene("cuzn", "metal-CuZn by name",
          ball_of('Material "conductor" "spectrum eta" "metal-CuZn-eta" '
                  '"spectrum k" "metal-CuZn-k"')),
    Scene("def_filter", "the default filter", room('Shape "sphere"', filter="")),
    Scene("depth1", "maxdepth 1", room('Shape "sphere"', depth=1)),
    Scene("directionmix", "directionmix",
          ball_textured(texture("p", "directionmix", '"rgb tex1" [.1 .1 .1] "rgb tex2" [.9 .9 .9] '
                                '"vector3 dir" [0 1 0]'))),
    Scene("distrgbE", "coloured distant light by its illuminance",
          dusk(BALL, before='LightSource "distant" "rgb L" [1 .5 .2] "float illuminance" 3 '
               '"point3 from" [1 4 -2] "point3 to" [0 0 0]\n')),
    Scene("dtscale", "diffusetransmission with a scale above 1",
          room('Material "diffusetransmission" "rgb reflectance" [.5 .5 .5] '
               '"rgb transmittance" [.5 .5 .5] "float scale" 1.5', SCREEN),
          total=(-10.6, -9.6), reason="no surface sends back more light than it gets: both "
          "shares are scaled down together"),
    Scene("dots", "dots", room(of_texture("d") + SCREEN, before=texture(
        "d", "dots", '"float uscale" 6 "float vscale" 4 "rgb inside" [.8 .2 .1] '
        '"rgb outside" [.1 .3 .6]'))),
    Scene("emitglass", "a lamp of glass",
          dusk(within(LAMP, 'Material "dielectric" "float eta" 1.5', UP,
                      'Shape "sphere" "float radius" .5'))),
    Scene("f_cc0", "coatedconductor by its reflectance, in a furnace",
          furnace('Material "coatedconductor" "rgb reflectance" [.7 .7 .7] '
                  f'"float conductor.roughness" .05 "float interface.roughness" 0 {NOT_REMAPPED} '
                  + THICK), reason=COAT),
    Scene("f_cc1", "coatedconductor by its index, in a furnace",
          furnace(f'Material "coatedconductor" {METAL.format("conductor.")} '
                  f'"float conductor.roughness" .05 "float interface.roughness" 0 {NOT_REMAPPED} '
                  + THICK), reason=COAT),
    Scene("f_cd0", "coateddiffuse .5, in a furnace",
          furnace('Material "coateddiffuse" "rgb reflectance" [.5 .5 .5] "float roughness" 0 '
                  + THICK), reason=COAT, exact=coat_in_furnace(.5)),
    Scene("f_cd15", "coateddiffuse .2, in a furnace",
          furnace('Material "coateddiffuse" "rgb reflectance" [.2 .2 .2] "float roughness" 0 '
                  + THICK), reason=COAT, exact=coat_in_furnace(.2)),
    Scene("f_cd8", "coateddiffuse .8, in a furnace",
          furnace('Material "coateddiffuse" "rgb reflectance" [.8 .8 .8] "float roughness" 0 '
                  + THICK), total=(1, 2.3), reason=COAT + "; and its walk ends after 10 steps",
          exact=coat_in_furnace(.8)),
    Scene("f_cr15", "rough conductor, alpha .15, in a furnace",
          furnace(f'Material "conductor" {METAL.format("")} "float roughness" .15 {NOT_REMAPPED}'),
          reason=COMPENSATED, options=SINGLE),
    Scene("f_cr1g", "rough conductor by its reflectance, alpha .3, in a furnace",
          furnace('Material "conductor" "rgb reflectance" [.5 .5 .5] "float roughness" .3 '
                  + NOT_REMAPPED), reason=COMPENSATED, options=SINGLE),
    Scene("f_cr2", "rough conductor, roughness .2 (alpha .45), in a furnace",
          furnace(f'Material "conductor" {METAL.format("")} "float roughness" .2'),
          reason=COMPENSATED, options=SINGLE),
    Scene("f_rd5", "rough glass, in a furnace",
          furnace('Material "dielectric" "float eta" 1.5 "float roughness" .25'),
          reason=COMPENSATED, options=SINGLE),
    Scene("floatcol", "image with colours as an amount",
          room(of_texture("p") + SCREEN,
               before=image("f", "colours.png", type="float") +
               texture("p", "mix", '"rgb tex1" [.1 .1 .1] "rgb tex2" [.9 .9 .9] '
                       '"texture amount" "f"'))),
    Scene("floatrgba", "image with alpha as an amount",
          room(of_texture("p") + SCREEN,
               before=image("f", "alpha.png", type="float") +
               texture("p", "mix", '"rgb tex1" [.1 .1 .1] "rgb tex2" [.9 .9 .9] '
                       '"texture amount" "f"'))),
    Scene("glassF11", "glass-F11",
          ball_of('Material "dielectric" "spectrum eta" "glass-F11"', depth=12)),
    Scene("glassrev", "glass with reversed normals",
          room('Material "dielectric" "float eta" 1.5',
               within(UP, "ReverseOrientation", 'Shape "sphere"'))),
    Scene("medium", "volpath, a medium that no ray enters",
          room(within('MakeNamedMedium "fog" "string type" "homogeneous" '
                      '"rgb sigma_s" [.1 .1 .1] "rgb sigma_a" [0 0 0]', 'MediumInterface "fog" ""',
                      BALL)).replace('"path"', '"volpath"')),
    Scene("mgo", "metal-MgO by name",
          ball_of('Material "conductor" "spectrum eta" "metal-MgO-eta" "spectrum k" "metal-MgO-k" '
                  '"float roughness" .1'), reason=COMPENSATED, options=SINGLE),
    Scene("mircyl", "mirrored lamp: cylinder",
          round_lamp("Translate 0 .5 0 Scale 1 -1 1 Rotate -90 1 0 0", shape=CYLINDER),
          reason=MIRRORED, instead=round_lamp("Translate 0 .5 0 Rotate -90 1 0 0", shape=CYLINDER)),
    Scene("mirdisk", "mirrored lamp: disk",
          round_lamp(UP, "Scale -1 1 1 Rotate 160 0 1 0", shape=DISK), reason=MIRRORED,
          instead=round_lamp(UP, "Rotate -160 0 1 0", shape=DISK)),
    Scene("mirdisk2", "mirrored lamp: disk, turned away",
          round_lamp(UP, "Scale -1 1 1 Rotate -20 0 1 0", shape=DISK), reason=MIRRORED,
          instead=round_lamp(UP, "Rotate 20 0 1 0", shape=DISK)),
    Scene("mirsph", "mirrored lamp: sphere",
          round_lamp(UP, "Scale 1 1 -1", shape='Shape "sphere" "float radius" .5'),
          reason=MIRRORED, instead=round_lamp(UP, shape='Shape "sphere" "float radius" .5')),
    Scene("mixtex", "mix by an image",
          room(mixture('"texture amount" "a"', '"diffuse" "rgb reflectance" [.9 .9 .9]',
                       '"diffuse" "rgb reflectance" [.1 .1 .1]'), tile(1, 0),
               before=image("a", "mask.pfm", type="float"))),
    Scene("mixuv", "mix of an image and a rough conductor",
          room(mixture('"float amount" .6', '"diffuse" "texture reflectance" "img"',
                       '"conductor" "float roughness" .2 "rgb reflectance" [.8 .8 .8]'),
               within("Translate 0 .8 0", 'Shape "sphere" "float radius" .8'),
               before=image("img", "squares.png")), reason=COMPENSATED, options=SINGLE),
    Scene("nm", "normal map", normal_map()),
    Scene("nmNflip", "normal map, shading normals the other way",
          normal_map(shape=quad("-1 0 0", "1 0 0", "1 1.6 0", "-1 1.6 0",
                                more='"normal N" [0 0 1  0 0 1  0 0 1  0 0 1]'))),
    Scene("nmrevmir", "normal map, mirrored and reversed",
          normal_map("ReverseOrientation Scale -1 1 1")),
    Scene("nmsph", "normal map on a sphere", normal_map(TILTED_BALL, shape='Shape "sphere"'),
          block=16, reason="bent normals that look away from the eye are bent back until they "
          "face it; pbrt turns them over, which is dark"),
    Scene("nmsphmir", "normal map on a mirrored sphere",
          normal_map("Translate 0 1 0 Scale -1 1 1 Rotate -60 1 0 0", shape='Shape "sphere"')),
    Scene("nmuvmir", "normal map, u to the left",
          normal_map(shape=quad("-1 0 0", "1 0 0", "1 1.6 0", "-1 1.6 0", "1 0  0 0  0 1  1 1"))),
    Scene("nmuvmirN", "the same with shading normals",
          normal_map(shape=quad("-1 0 0", "1 0 0", "1 1.6 0", "-1 1.6 0", "1 0  0 0  0 1  1 1",
                                '"normal N" [0 0 -1  0 0 -1  0 0 -1  0 0 -1]'))),
    Scene("point16", "nearest texels of a coarse image of 16 bits",
          room(of_texture("c") + SCREEN,
               before=image("c", "coarse16.png", '"string filter" "point"'))),
    Scene("proj", "projection light inside a ball",
          dusk(BALL, before='LightSource "projection" "float power" 100 '
               '"string filename" "squares.png"\n')),
    Scene("revmircap", "lamp inside a part of a mirrored sphere",
          round_lamp("ReverseOrientation", UP, "Scale -1 1 1",
                     shape=SPHERE_PART.format(.5, "zmax", .1)), reason=MIRRORED,
          instead=round_lamp("ReverseOrientation", UP, shape=SPHERE_PART.format(.5, "zmax", .1))),
    Scene("revsph", "lamp inside a sphere",
          round_lamp("ReverseOrientation", UP, shape='Shape "sphere" "float radius" .5')),
    Scene("rgbrefl_over", "saturated reflectance, once",
          ball_of('Material "diffuse" "rgb reflectance" [.9 .2 .1]')),
    Scene("scaleddistant", "distant light in a stretched space",
          dusk('Shape "sphere"', before=within(
              "Scale 1 3 1", 'LightSource "distant" "rgb L" [2 2 2] "point3 from" [1 1 -1] '
              '"point3 to" [0 0 0]'))),
    Scene("scaletex", "scale of scale of an image",
          room(of_texture("s2") + SCREEN,
               before=image("img", "squares.png") +
               texture("s", "scale", '"texture tex" "img" "float scale" .7') +
               texture("f", "constant", '"float value" .8', "float") +
               texture("s2", "scale", '"texture tex" "s" "texture scale" "f"'))),
    Scene("shutter", "times of the shutter, nothing moves",
          room(BALL, camera='"float shutteropen" 0 "float shutterclose" 1')),
    Scene("shutter2", "half the time, and twice the speed of the film",
          room(BALL, of_film=film(80, 60, '"float iso" 200'),
               camera='"float shutteropen" .25 "float shutterclose" .5')),
    Scene("sinc", "filter sinc", room(BALL, filter='PixelFilter "sinc"\n')),
    Scene("smoothcoat", "coateddiffuse, smooth, in the sun",
          ball_of('Material "coateddiffuse" "rgb reflectance" [.5 .5 .5] ' + THICK, depth=8),
          reason=COAT),
    Scene("specrefl", "reflectance by a spectrum",
          ball_of('Material "diffuse" "spectrum reflectance" [400 .1 550 .4 700 .8]')),
    Scene("spot1", "spot in a stretched space",
          room(light=within("Scale 1 1 3", 'LightSource "spot" "rgb I" [20 20 20] '
                            '"point3 from" [0 4 0] "point3 to" [0 0 0] "float coneangle" 15')),
          total=(152.5, 154.6), reason="pbrt's tree of lights bounds the stretched cone by the "
          "round one, and leaves out the light beyond that"),
    Scene("tbegin", "TransformBegin and a material",
          room("TransformBegin", grey(.1), UP, 'Shape "sphere" "float radius" .5', "TransformEnd",
               "Translate 1 .5 0", 'Shape "sphere" "float radius" .5')),
    Scene("t_marble", "marble", ball_textured(texture("p", "marble", ""))),
    Scene("tex_bluv", "image on a bilinear patch",
          room(of_texture("img"), 'Shape "bilinearmesh" "point3 P" [-1 .3 0  1 .3 0  -.5 1.3 0  '
               '.8 1.8 .4] "point2 uv" [0 0  .5 0  0 2  .5 2]',
               before=image("img", "squares.png"))),
    Scene("tex_cyl", "image on a part of a cylinder",
          room(of_texture("img"),
               within("Translate 0 .8 0", "Rotate -90 1 0 0", 'Shape "cylinder" "float radius" .6 '
                      '"float zmin" -.5 "float zmax" .6 "float phimax" 300'),
               before=image("img", "squares.png"))),
    Scene("tex_nouv", "image on triangles without uv",
          room(of_texture("img"), quad("-.5 .3 0", ".5 .3 0", ".5 1.3 0", "-.5 1.3 0", ""),
               before=image("img", "squares.png"))),
    Scene("tri", "lamp of triangles", dusk(small_lamp())),
    Scene("triN-1revmirz", "lamp: normals, reversed, mirrored in depth",
          dusk(small_lamp("ReverseOrientation Scale 1 1 -1", n="0 0 -1"))),
    Scene("triN1mirz", "lamp: normals the other way, mirrored in depth",
          dusk(small_lamp("Scale 1 1 -1", n="0 0 1"))),
    Scene("triN1rev", "lamp: normals the other way, reversed",
          dusk(small_lamp("ReverseOrientation", n="0 0 1"))),
    Scene("triN1revmirz", "lamp: normals the other way, reversed, mirrored in depth",
          dusk(small_lamp("ReverseOrientation Scale 1 1 -1", n="0 0 1"))),
    Scene("tri_filter", "filter triangle",
          room('Shape "sphere"',
               filter='PixelFilter "triangle" "float xradius" 2 "float yradius" 2\n')),
    Scene("trimir", "lamp, mirrored", dusk(small_lamp("Scale -1 1 1"))),
    Scene("trimirrev", "lamp, mirrored and reversed",
          dusk(small_lamp("Scale -1 1 1 ReverseOrientation"))),
    Scene("trirev", "lamp, reversed", dusk(small_lamp("ReverseOrientation"))),
    Scene("whitebal", "sensor of a camera",
          room(BALL, of_film=film(80, 60, '"string sensor" "canon_eos_5d" "float iso" 100')),
          total=(0.2, 2.1), reason="sensors of cameras are not rendered"),
]
