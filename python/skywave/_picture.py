"""Rendered pictures."""
import json
import os

from . import _convert, _core
from ._errors import as_file_error, bad_argument


class Picture:
    """A rendered picture, as render() returns it. Its arrays are read-only; copy them for changes.

    rgb: linear radiance, (height, width, 3), float32; rows from the top.
    layers: arrays (height, width) or (height, width, channels) by the name of the layer.
    statistics: times, rays and stages, as `skywave render --stats` writes them.
    warnings: a line for each thing that is not rendered as the scene asks.
    notes: a line for each thing that was assumed or repaired.
    """

    def __init__(self, renderer):
        self._renderer = renderer
        self.width, self.height = renderer.width(), renderer.height()
        self.rgb = renderer.picture()
        self.rgb.flags.writeable = False
        self.layers = {}
        for name, channels in renderer.layers():
            layer = renderer.layer(name, len(channels))
            layer.flags.writeable = False
            self.layers[name] = layer
        self.warnings = renderer.warnings()
        self.notes = renderer.notes()

    @property
    def statistics(self):
        """Times, rays and stages, as `skywave render --stats` writes them."""
        return json.loads(self._renderer.statistics())

    @property
    def summary(self):
        """The statistics as text for people."""
        return self._renderer.summary()

    @property
    def object_names(self):
        """The names of the meshes: number i of the layer object-id is object_names[i - 1]. Empty
        without such a layer."""
        return self._renderer.object_names()

    @property
    def material_names(self):
        """The names of the materials, as object_names has those of meshes."""
        return self._renderer.material_names()

    def save(self, path, *, exposure=None, tone=None):
        """Writes an EXR with all layers and the command that repeats it, a PNG, or a film.

        A PNG is exposed as the options of the render say (exposure, tone, shutter, f_number, iso).
        If `exposure` (in stops) or `tone` (a value of that option) is given, these two replace all
        of those options. The command is left out if the scene was not only read. A film holds the
        sums of the samples, which `skywave merge` adds to those of other parts of the same picture.
        """
        ending = os.path.splitext(os.fsdecode(_convert.path(path, "path")))[1]
        if ending == ".png" and exposure is None and tone is None:
            self._renderer.write_png(_convert.path(path, "path"))
        elif ending == ".png":
            write_png(path, self, exposure=0 if exposure is None else exposure,
                      tone="clip" if tone is None else tone)
        elif ending not in (".exr", ".film"):
            raise bad_argument("path",
                               f"the name ends in {ending!r}, and .exr, .png or .film is needed")
        elif exposure is not None or tone is not None:
            raise bad_argument("exposure" if tone is None else "tone",
                               "only a PNG is exposed and tone-mapped; the others hold radiance")
        elif ending == ".film":
            self._renderer.write_film(_convert.path(path, "path"))
        else:
            self._renderer.write_exr(_convert.path(path, "path"))

    def __array__(self, dtype=None, copy=None):
        array = self.rgb if dtype is None else self.rgb.astype(dtype, copy=False)
        if copy is False and array is not self.rgb:
            raise ValueError("another dtype needs a copy")
        return array.copy() if copy else array

    def _repr_png_(self):
        return self._renderer.encode_png()

    def __repr__(self):
        layers = f", layers {', '.join(self.layers)}" if self.layers else ""
        return f"<skywave.Picture of {self.width} x {self.height} pixels{layers}>"


def write_png(path, image, *, exposure=0, tone="clip"):
    """Writes 8-bit sRGB; radiance is multiplied by 2^exposure, `tone` is a value of that option."""
    name = _convert.path(path, "path")
    data = encode_png(image, exposure=exposure, tone=tone)
    with as_file_error(name), open(name, "wb") as file:
        file.write(data)


def encode_png(image, *, exposure=0, tone="clip"):
    """Returns the bytes of the file that write_png writes."""
    return _core.encode_png(_convert.image(image, "image"), _convert.number(exposure, "exposure"),
                            _convert.text(tone, "tone"))


def read_image(path):
    """Reads OpenEXR, Radiance HDR or PFM: (height, width, 3), float32, rows from the top."""
    return _core.read_image(_convert.path(path, "path"))
