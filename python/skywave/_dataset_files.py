"""Files of data sets: HDF5 containers as BlenderProc has them, folders of BOP, cameras of NeRF."""
import json
import os
import pathlib

import numpy

from . import _convert
from ._camera import FLIP
from ._color import bytes_of, srgb
from ._errors import as_file_error, bad_argument

# Layers by their names in a container. Normals are in [0, 1] there, as in a PNG.
_CONTAINED = {"depth": "depth", "distance": "distance", "camera-normal": "normals",
              "object-id": "instance_segmaps", "flow": "forward_flow",
              "flow-back": "backward_flow"}


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
    names = os.fsdecode(_convert.path(path, "path"))
    part = f"{names}.{os.getpid()}.part"
    with as_file_error(os.fsencode(names)):
        try:
            with h5py.File(part, "w") as file:
                for name, values in data.items():
                    file.create_dataset(name, data=values, compression="gzip")
                if "object-id" in picture.layers:
                    instances = [{"idx": i, "name": name}
                                 for i, name in enumerate(picture.object_names, 1)]
                    file.create_dataset("instance_attribute_maps",
                                        data=numpy.bytes_(json.dumps(instances)))
            os.replace(part, names)
        finally:
            if os.path.exists(part):
                os.remove(part)


def _contained(layer, values):
    if layer == "camera-normal":
        hit = numpy.any(values != 0, axis=2, keepdims=True)
        return numpy.where(hit, 0.5 * (values + 1), 0).astype(numpy.float32)
    if layer == "object-id":
        return values.astype(numpy.uint32)
    return values[..., :2] if layer.startswith("flow") else values


def _write_json(path, content):
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    with as_file_error(os.fsencode(path)):
        part.write_text(json.dumps(content, indent=1) + "\n")
        os.replace(part, path)


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
    `depth_scale` [mm]. Whole silhouettes (mask) and scene_gt_info.json are made by bop_toolkit.
    """

    def __init__(self, folder, *, metres=1.0, depth_scale=0.1):
        self.folder = pathlib.Path(os.fsdecode(_convert.path(folder, "folder")))
        self.millimetres, self.depth_scale = 1000 * metres, depth_scale
        self.cameras, self.objects = {}, {}
        for name in ("rgb", "depth", "mask_visib"):
            (self.folder / name).mkdir(parents=True, exist_ok=True)

    def add(self, picture, camera, poses):
        """Adds a picture with the layers object-id and depth that a Camera has seen; returns its
        number. `poses` has for names of objects their number in BOP and world_from_model (4, 4);
        objects of other names are not annotated, and those that the picture does not show are left
        out."""
        from .annotations import write_depth, write_mask

        for layer in ("object-id", "depth"):
            if layer not in picture.layers:
                raise bad_argument("picture", f"it has no layer {layer}: render with "
                                              'aovs=["object-id", "depth"]')
        unknown = set(poses) - set(picture.object_names)
        if unknown:
            raise bad_argument("poses", f"the picture has no object '{sorted(unknown)[0]}', but "
                                        f"{', '.join(picture.object_names)}")
        world_from_camera = _pose(camera.world_from_camera, "camera")
        camera_from_world = numpy.linalg.inv(world_from_camera)
        seen = []
        for number, name in enumerate(picture.object_names, 1):
            mask = picture.layers["object-id"] == number
            if name in poses and mask.any():
                kind, world_from_model = poses[name]
                seen.append((mask, int(kind), camera_from_world @ _pose(world_from_model, name)))
        image = len(self.cameras)
        picture.save(self.folder / "rgb" / f"{image:06}.png")
        write_depth(self.folder / "depth" / f"{image:06}.png", picture.layers["depth"],
                    unit=self.depth_scale / self.millimetres)
        for i, (mask, _, _) in enumerate(seen):
            write_mask(self.folder / "mask_visib" / f"{image:06}_{i:06}.png", mask)
        self.cameras[image] = {
            "cam_K": numpy.asarray(camera.K, float).ravel().tolist(),
            "depth_scale": self.depth_scale,
            "cam_R_w2c": camera_from_world[:3, :3].ravel().tolist(),
            "cam_t_w2c": (self.millimetres * camera_from_world[:3, 3]).tolist()}
        self.objects[image] = [
            {"cam_R_m2c": pose[:3, :3].ravel().tolist(),
             "cam_t_m2c": (self.millimetres * pose[:3, 3]).tolist(), "obj_id": kind}
            for _, kind, pose in seen]
        return image

    def save(self):
        """Writes scene_camera.json and scene_gt.json."""
        _write_json(self.folder / "scene_camera.json", self.cameras)
        _write_json(self.folder / "scene_gt.json", self.objects)


def write_transforms(path, cameras):
    """Writes transforms.json of NeRF data, which --camera-from and other programs read: `cameras`
    has a Camera for each name of a picture."""
    frames = []
    for name, camera in cameras.items():
        k, _ = _convert.matrix(camera.K, "K", [(3, 3)])
        (fx, skew, cx), (_, fy, cy), _ = numpy.asarray(k, float).reshape(3, 3).tolist()
        if skew != 0:
            raise bad_argument("cameras", f"the camera of {name} is skewed, which the file has no "
                                          "place for")
        pose = _pose(camera.world_from_camera, f"the camera of {name}") @ FLIP
        width, height = (int(side) for side in camera.size)
        # Places count from the corners of pixels there.
        frames.append({"file_path": str(name), "w": width, "h": height, "fl_x": fx, "fl_y": fy,
                       "cx": cx + 0.5, "cy": cy + 0.5, "transform_matrix": pose.tolist()})
    _write_json(pathlib.Path(os.fsdecode(_convert.path(path, "path"))), {"frames": frames})
