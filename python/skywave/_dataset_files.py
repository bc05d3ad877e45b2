"""Files of data sets: masks, depths and flow, HDF5 containers as BlenderProc has them, folders of
BOP, cameras of NeRF."""
import contextlib
import json
import os
import pathlib
import struct
import zlib

import numpy

from . import _convert
from ._camera import FLIP
from ._color import bytes_of, srgb
from ._errors import as_file_error, bad_argument

_FAR = 1e10  # depth where nothing is hit
_MOST = 65535
# Layers by their names in a container. Normals are in [0, 1] there, as in a PNG.
_CONTAINED = {"depth": "depth", "distance": "distance", "camera-normal": "normals",
              "object-id": "instance_segmaps", "flow": "forward_flow",
              "flow-back": "backward_flow"}


def box_of(mask):
    """Returns (left, top, width, height) [pixels] of what is true in a mask."""
    y, x = numpy.nonzero(mask)
    return int(x.min()), int(y.min()), int(numpy.ptp(x)) + 1, int(numpy.ptp(y)) + 1


def silhouette_of(picture, numbers):
    """Returns the mask of objects by their numbers, from 1 on, with what others hide of them."""
    return (numpy.isin(picture.layers["object-id"], numbers)
            | numpy.isin(picture.layers["hidden-id"], numbers).any(axis=2))


def write_png16(path, values):
    """Writes whole numbers (height, width) of at most 65535 as a grey PNG of 16 bits."""
    values = numpy.asarray(values)
    if values.ndim != 2 or values.size == 0:
        raise bad_argument("values", f"its shape is {values.shape}, and (height, width) is needed")
    if not (values.min() >= 0 and values.max() <= _MOST and (values == numpy.rint(values)).all()):
        raise bad_argument("values", f"a PNG of 16 bits holds whole numbers from 0 to {_MOST}")
    _write_grey(path, values.astype(">u2"))


def write_mask(path, mask):
    """Writes a mask (height, width) as a grey PNG of 8 bits: 255 where it is true, else 0."""
    _write_grey(path, numpy.where(numpy.asarray(mask, dtype=bool), 255, 0).astype(numpy.uint8))


def _write_grey(path, values):
    height, width = values.shape
    size = values.dtype.itemsize
    lines = numpy.zeros((height, 1 + size * width), dtype=numpy.uint8)  # filter 0 before each
    lines[:, 1:] = numpy.ascontiguousarray(values).view(numpy.uint8)

    def chunk(kind, body):
        return (struct.pack(">I", len(body)) + kind + body
                + struct.pack(">I", zlib.crc32(kind + body)))

    data = (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height,
                                                              8 * size, 0, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(lines.tobytes())) + chunk(b"IEND", b""))
    name = _convert.path(path, "path")
    with as_file_error(name), open(name, "wb") as file:
        file.write(data)


def write_depth(path, depth, unit=0.001):
    """Writes the layer `depth` or `distance` as a PNG of 16 bits in steps of `unit`, 0 where
    nothing is hit; with lengths in metres the steps are millimetres. Raises Error if a depth does
    not fit.
    """
    write_png16(path, _depth_steps(depth, unit))


def _depth_steps(depth, unit):
    depth = numpy.asarray(depth, dtype=float)
    steps = numpy.where(depth < _FAR, numpy.rint(depth / unit), 0)
    if steps.max(initial=0) > _MOST:
        needed = depth[depth < _FAR].max() / _MOST
        raise bad_argument("unit", f"a depth of {depth[depth < _FAR].max():g} is more than {_MOST} "
                                   f"steps of {unit:g}: take at least {needed:.3g}")
    return steps


def write_flow(path, flow):
    """Writes the layer flow or flow-back (height, width, 3) as a .flo file of Middlebury (Baker et
    al. 2011): the motion of each pixel, 1e10 where it is not known."""
    flow = numpy.asarray(flow)
    if flow.ndim != 3 or flow.shape[2] != 3:
        raise bad_argument("flow", f"its shape is {flow.shape}, and (height, width, 3) is needed")
    motion = numpy.where(flow[..., 2:] > 0, flow[..., :2], _FAR).astype("<f4")
    name = _convert.path(path, "path")
    with as_file_error(name), open(name, "wb") as file:
        file.write(b"PIEH" + struct.pack("<ii", flow.shape[1], flow.shape[0]) + motion.tobytes())


@contextlib.contextmanager
def _replacing(path):
    """Gives the name of a file that takes the place of `path` at the end of the block, and that is
    removed if the block raises; an OSError becomes a FileError."""
    part = f"{path}.{os.getpid()}.part"
    with as_file_error(path):
        try:
            yield part
            os.replace(part, path)
        finally:
            if os.path.exists(part):
                os.remove(part)


def write_hdf5(path, picture, *, exposure=0):
    """Writes a picture and its layers as one HDF5 file with the names of BlenderProc: colors
    (uint8, sRGB of the radiance times 2^exposure), depth, distance, normals ((n + 1) / 2 in the
    camera), instance_segmaps with instance_attribute_maps (JSON), forward_flow and backward_flow (x
    right, y down). Needs h5py."""
    try:
        import h5py
    except ImportError as error:
        raise ImportError("write_hdf5 needs h5py: pip install h5py") from error
    data = {"colors": bytes_of(srgb(picture.rgb * 2.0**exposure))}
    for layer, name in _CONTAINED.items():
        if layer in picture.layers:
            data[name] = _contained(layer, picture.layers[layer])
    with _replacing(os.fsdecode(_convert.path(path, "path"))) as part, h5py.File(part, "w") as file:
        for name, values in data.items():
            file.create_dataset(name, data=values, compression="gzip")
        if "object-id" in picture.layers:
            instances = [{"idx": i, "name": name} for i, name in enumerate(picture.object_names, 1)]
            file.create_dataset("instance_attribute_maps",
                                data=numpy.bytes_(json.dumps(instances)))


def _contained(layer, values):
    if layer == "camera-normal":
        hit = numpy.any(values != 0, axis=2, keepdims=True)
        return numpy.where(hit, 0.5 * (values + 1), 0).astype(numpy.float32)
    if layer == "object-id":
        return values.astype(numpy.uint32)
    return values[..., :2] if layer.startswith("flow") else values


def _write_json(path, content):
    with _replacing(os.fspath(path)) as part, open(part, "w", encoding="utf-8") as file:
        file.write(json.dumps(content, indent=1) + "\n")


def _pose(matrix, argument):
    """Returns a matrix (4, 4) that turns and moves."""
    pose, shape = _convert.matrix(matrix, argument, [(4, 4), (3, 4)])
    pose = numpy.asarray(pose, float).reshape(shape)
    turn = pose[:3, :3]
    if not numpy.allclose(turn @ turn.T, numpy.eye(3), atol=1e-4) or numpy.linalg.det(turn) < 0:
        raise bad_argument(argument, "its first three columns are no rotation")
    return numpy.vstack([pose[:3], [0, 0, 0, 1]])


class Bop:
    """Writes pictures with the poses of their objects as a scene of BOP (Hodan et al. 2018).

    `folder` gets rgb, depth and mask_visib, and at save() scene_camera.json and scene_gt.json; it
    is made if it is not there. A unit of the scene is `metres` long; depths are in steps of
    `depth_scale` [mm]. Of pictures with the layer hidden-id it also gets whole silhouettes (mask)
    and scene_gt_info.json, with boxes and counts of pixels; both end at the edges of the picture.
    """

    def __init__(self, folder, *, metres=1.0, depth_scale=0.1):
        self.folder = pathlib.Path(os.fsdecode(_convert.path(folder, "folder")))
        self.millimetres, self.depth_scale = 1000 * metres, depth_scale
        self.cameras, self.objects, self.infos = {}, {}, {}
        for name in ("rgb", "depth", "mask_visib"):
            with as_file_error(os.fsencode(self.folder / name)):
                (self.folder / name).mkdir(parents=True, exist_ok=True)

    def add(self, picture, camera, poses):
        """Adds a picture with the layers object-id and depth that a Camera has seen; returns its
        number. `poses` has for names of objects their number in BOP and world_from_model (4, 4);
        objects of other names are not annotated, and those that the picture does not show are left
        out."""
        for layer in ("object-id", "depth"):
            if layer not in picture.layers:
                raise bad_argument("picture", f"it has no layer {layer}: render with "
                                              'aovs=["object-id", "depth"]')
        unknown = set(poses) - set(picture.object_names)
        if unknown:
            raise bad_argument("poses", f"the picture has no object '{sorted(unknown)[0]}', but "
                                        f"{', '.join(picture.object_names)}")
        if (picture.width, picture.height) != tuple(camera.size):
            raise bad_argument("camera", f"its pictures are of {camera.size[0]} x {camera.size[1]} "
                                         f"pixels, and this one is of {picture.width} x "
                                         f"{picture.height}")
        steps = _depth_steps(picture.layers["depth"], self.depth_scale / self.millimetres)
        world_from_camera = _pose(camera.world_from_camera, "camera")
        camera_from_world = numpy.linalg.inv(world_from_camera)
        seen = []
        for number, name in enumerate(picture.object_names, 1):
            mask = picture.layers["object-id"] == number
            if name in poses and mask.any():
                kind, world_from_model = poses[name]
                seen.append((number, mask, int(kind),
                             camera_from_world @ _pose(world_from_model, name)))
        image = len(self.cameras)
        picture.save(self.folder / "rgb" / f"{image:06}.png")
        write_png16(self.folder / "depth" / f"{image:06}.png", steps)
        for i, (_, mask, _, _) in enumerate(seen):
            write_mask(self.folder / "mask_visib" / f"{image:06}_{i:06}.png", mask)
        if "hidden-id" in picture.layers:
            self._add_silhouettes(image, picture, seen)
        self.cameras[image] = {
            "cam_K": numpy.asarray(camera.K, float).ravel().tolist(),
            "depth_scale": self.depth_scale,
            "cam_R_w2c": camera_from_world[:3, :3].ravel().tolist(),
            "cam_t_w2c": (self.millimetres * camera_from_world[:3, 3]).tolist()}
        self.objects[image] = [
            {"cam_R_m2c": pose[:3, :3].ravel().tolist(),
             "cam_t_m2c": (self.millimetres * pose[:3, 3]).tolist(), "obj_id": kind}
            for _, _, kind, pose in seen]
        return image

    def _add_silhouettes(self, image, picture, seen):
        with as_file_error(os.fsencode(self.folder / "mask")):
            (self.folder / "mask").mkdir(exist_ok=True)
        self.infos[image] = []
        for i, (number, visible, _, _) in enumerate(seen):
            whole = silhouette_of(picture, [number])
            write_mask(self.folder / "mask" / f"{image:06}_{i:06}.png", whole)
            self.infos[image].append({
                "px_count_all": int(whole.sum()), "px_count_visib": int(visible.sum()),
                "px_count_valid": int((whole & (picture.layers["depth"] < _FAR)).sum()),
                "visib_fract": float(visible.sum() / whole.sum()),
                "bbox_obj": box_of(whole), "bbox_visib": box_of(visible)})

    def save(self):
        """Writes scene_camera.json and scene_gt.json, and scene_gt_info.json if there are
        silhouettes."""
        _write_json(self.folder / "scene_camera.json", self.cameras)
        _write_json(self.folder / "scene_gt.json", self.objects)
        if self.infos:
            _write_json(self.folder / "scene_gt_info.json", self.infos)


def _pinhole(name, camera):
    """Returns (width, height, fx, fy, cx, cy) of the camera of a picture. Places count from the
    corners of pixels in the files of others, and from their centres here."""
    k, _ = _convert.matrix(camera.K, "K", [(3, 3)])
    (fx, skew, cx), (_, fy, cy), _ = numpy.asarray(k, float).reshape(3, 3).tolist()
    if skew != 0:
        raise bad_argument("cameras", f"the camera of {name} is skewed, which the file has no "
                                      "place for")
    width, height = (int(side) for side in camera.size)
    return width, height, fx, fy, cx + 0.5, cy + 0.5


def write_transforms(path, cameras):
    """Writes transforms.json of NeRF data, which --camera-from and other programs read: `cameras`
    has a Camera for each name of a picture."""
    frames = []
    for name, camera in cameras.items():
        pose = _pose(camera.world_from_camera, f"the camera of {name}") @ FLIP
        frames.append({"file_path": str(name),
                       **dict(zip(("w", "h", "fl_x", "fl_y", "cx", "cy"), _pinhole(name, camera))),
                       "transform_matrix": pose.tolist()})
    _write_json(pathlib.Path(os.fsdecode(_convert.path(path, "path"))), {"frames": frames})


def _quaternion(turn):
    """Returns (w, x, y, z) of a rotation (3, 3), from its largest component (Shepperd 1978)."""
    trace = numpy.trace(turn)
    squares = numpy.array([trace, *numpy.diag(turn)])
    largest = int(numpy.argmax(squares))
    if largest == 0:
        parts = [1 + trace, turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0],
                 turn[1, 0] - turn[0, 1]]
    else:
        i = largest - 1
        j, k = (i + 1) % 3, (i + 2) % 3
        parts = [turn[k, j] - turn[j, k], 0, 0, 0]
        parts[1 + i] = 1 + turn[i, i] - turn[j, j] - turn[k, k]
        parts[1 + j] = turn[j, i] + turn[i, j]
        parts[1 + k] = turn[k, i] + turn[i, k]
    return numpy.array(parts) / numpy.linalg.norm(parts)


def write_colmap(folder, cameras):
    """Writes cameras.txt and images.txt of COLMAP (and points3D.txt, which is empty), which
    --camera-from and other programs read, into a folder: `cameras` has a Camera for each name of a
    picture."""
    lenses, lines = {}, []
    for number, (name, camera) in enumerate(cameras.items(), 1):
        camera_from_world = numpy.linalg.inv(
            _pose(camera.world_from_camera, f"the camera of {name}"))
        lens = lenses.setdefault(_pinhole(name, camera), len(lenses) + 1)
        if any(c.isspace() for c in str(name)):
            raise bad_argument("cameras", f"'{name}' has spaces, which end a name in those files")
        pose = [*_quaternion(camera_from_world[:3, :3]), *camera_from_world[:3, 3]]
        # The second line of a picture has the points that it shows: none.
        lines.append(f"{number} {' '.join(f'{value:.17g}' for value in pose)} {lens} {name}\n\n")
    folder = pathlib.Path(os.fsdecode(_convert.path(folder, "folder")))
    with as_file_error(os.fsencode(folder)):
        folder.mkdir(parents=True, exist_ok=True)
    for file, text in (
            ("cameras.txt", "".join(f"{number} PINHOLE {' '.join(f'{v:.17g}' for v in lens)}\n"
                                    for lens, number in lenses.items())),
            ("images.txt", "".join(lines)), ("points3D.txt", "")):
        with _replacing(os.fspath(folder / file)) as part, open(part, "w",
                                                                encoding="utf-8") as opened:
            opened.write(text)
