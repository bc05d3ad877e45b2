"""Skywave: a wavefront renderer for scenes under illumination maps.

    import skywave
    picture = skywave.render("model.glb", env="sky.hdr", spp=64, strategy="product")
    picture.save("model.png", tone="filmic")

Every option of the command line is a keyword: `--max-depth 8` is max_depth=8, `--no-mis` is
mis=False, `--size 640x480` is size=(640, 480), `--eye 0,1,5` is eye=(0, 1, 5), and
`--aovs albedo,depth` is aovs=["albedo", "depth"]. The bits are those of the command line.
"""
import json

from . import _convert, _core
from ._camera import Camera
from ._errors import Canceled, Error, FileError, keywords
from ._packages import from_cadquery, from_open3d, from_pyvista, from_trimesh
from ._picture import Picture, encode_png, read_image, write_png
from ._scene import Scene

__all__ = ["Camera", "Canceled", "Error", "FileError", "Picture", "Scene", "compare", "converge",
           "encode_png", "from_cadquery", "from_open3d", "from_pyvista", "from_trimesh", "probe",
           "read_image", "render", "version", "write_png"]


def version():
    """Returns the versions of the library and of Embree, such as "0.1.0 (Embree 3.13.5)"."""
    return _core.version()


__version__ = version().split()[0]

_READING = tuple(name.replace("-", "_") for name in _core.options_of_reading())


def _scene_and_options(scene, env, options):
    """Returns the scene lit by `env`, and the options as text."""
    own = not isinstance(scene, Scene)
    if own:
        reading = {name: options[name] for name in _READING if name in options}
        scene = Scene(scene, **reading)
        options = {name: value for name, value in options.items() if name not in _READING}
    elif scene._size is not None:
        options = {"size": scene._size, **options}
    if env is not None and not _convert.is_path(env):
        lit = (scene if own else scene.copy()).set_environment(env)
        return lit._core, _convert.options(options)
    return scene._core, _convert.options({"env": env, **options})


def render(scene, env=None, *, progress=None, checkpoint=None, checkpoint_seconds=0, resume=False,
           **options):
    """Renders a file, a built-in scene or a Scene under the map `env`; returns a Picture.

    `env` is a file or an array (height, width, 3) of linear radiance. `progress` is called about
    ten times a second with the share that is done, and stops the render with Canceled by returning
    False. Ctrl-C stops it with KeyboardInterrupt.

    The file `checkpoint` keeps what is rendered when the render is stopped and, if
    `checkpoint_seconds` is not 0, as often as that. With `resume` a render goes on from it, if it
    exists, to the same bits. It stays until you remove it.

    All other keywords are options, such as size, spp, integrator, strategy, aovs, eye, target, fov,
    max_depth, seed and threads.
    """
    keeps = (b"" if checkpoint is None else _convert.path(checkpoint, "checkpoint"),
             _convert.number(checkpoint_seconds, "checkpoint_seconds"), bool(resume))
    with keywords(options):
        renderer = _core.Renderer(*_scene_and_options(scene, env, options))
    renderer.render(progress, *keeps)
    return Picture(renderer)


def converge(scene, strategies=None, budgets=None, env=None, *, progress=None, **options):
    """Measures strategies by error at equal time; returns what `skywave converge --json` writes.

    The others are compared with the first of the list `strategies`; `budgets` is a list of samples
    per pixel. `progress` sees the share of the reference from 0 to 1, then that of the measurement.
    All other keywords are options of `skywave converge`.
    """
    options = {"strategies": strategies, "budgets": budgets, **options}
    with keywords(options):
        return json.loads(_core.converge(*_scene_and_options(scene, env, options), progress))


def compare(image, reference):
    """Returns what `skywave compare --json` writes about two pictures, arrays or files."""
    return json.loads(_core.compare(_convert.image(image, "image"),
                                    _convert.image(reference, "reference")))


def probe(map, projection=""):
    """Returns what `skywave probe info --json` writes about a map: size, energy, suns, strata.

    `map` is an array, a Picture or a file; `projection` is a value of the option env_projection. If
    it is empty, it follows from the shape of the map.
    """
    return json.loads(_core.describe_map(_convert.image(map, "map"),
                                         _convert.text(projection, "projection")))
