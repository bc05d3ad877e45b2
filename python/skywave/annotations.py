"""Annotations of pictures, as data sets for computer vision have them.

    picture = skywave.render("spheres", "sky.hdr", aovs=["object-id", "depth"])
    coco = Coco({"ball": ["red", "mirror*"], "floor": ["floor"]})
    coco.add("0000.png", picture)
    coco.save("annotations.json")
    write_depth("0000_depth.png", picture.layers["depth"])

A pixel belongs to the object that its sample nearest to the middle sees, so masks have no soft
edges and share no pixel.
"""
import fnmatch
import json
import warnings

import numpy

from . import _convert
from ._dataset_files import box_of, silhouette_of
from ._dataset_files import (  # noqa: F401 (offered here)
    Bop, write_colmap, write_depth, write_flow, write_hdf5, write_mask, write_png16,
    write_transforms)
from ._errors import as_file_error, bad_argument


def boxes(ids):
    """Returns (left, top, width, height) [pixels] of what each number but 0 covers, by number."""
    found = {}
    for number in numpy.unique(ids):
        if number == 0:
            continue
        found[int(number)] = box_of(ids == number)
    return found


def run_lengths(mask):
    """Returns a mask (height, width) as COCO has it: the lengths of its runs of 0 and 1 by turns,
    column by column, 0 first."""
    values = numpy.asarray(mask, dtype=bool).ravel(order="F")
    changes = numpy.flatnonzero(values[1:] != values[:-1]) + 1
    edges = numpy.concatenate([[0], changes, [len(values)]])
    counts = numpy.diff(edges).tolist()
    if len(values) and values[0]:
        counts = [0, *counts]
    return {"size": [int(mask.shape[0]), int(mask.shape[1])], "counts": counts}


def class_ids(ids, names, classes):
    """Returns the number of its class for each pixel, from 1 on; 0: of none.

    `names` are those of numbers 1, 2, ... of `ids`. `classes` has patterns of names (with * and ?)
    by class; the first class with a pattern that matches takes a name.
    """
    table = numpy.zeros(len(names) + 1, dtype=numpy.uint16)
    for number, patterns in enumerate(classes.values(), 1):
        for i, name in enumerate(names, 1):
            if table[i] == 0 and any(fnmatch.fnmatchcase(name, p) for p in patterns):
                table[i] = number
    return table[numpy.asarray(ids, dtype=numpy.int64)]


def object_coordinates(picture, boxes):
    """Returns normalised object coordinates (height, width, 3), float32 (Wang et al. 2019): where
    in the box of its model a pixel's place is, from 0 to 1 along each axis; nan elsewhere.

    `boxes` has (world_from_model (4, 4), low (3), high (3)) by the names of objects; `picture` has
    the layers object-id and position. Positions are means over the samples of a pixel, so edges
    mix with what is behind them: a picture of one sample (spp=1, filter="box") has exact ones.
    """
    for layer in ("object-id", "position"):
        if layer not in picture.layers:
            raise bad_argument("picture", f"it has no layer {layer}: render with "
                                          'aovs=["object-id", "position"]')
    coordinates = numpy.full((*picture.layers["object-id"].shape, 3), numpy.nan, numpy.float32)
    for name, (world_from_model, low, high) in boxes.items():
        if name not in picture.object_names:
            raise bad_argument("boxes", f"the picture has no object '{name}', but "
                                        f"{', '.join(picture.object_names)}")
        mask = picture.layers["object-id"] == picture.object_names.index(name) + 1
        matrix, shape = _convert.matrix(world_from_model, name, [(4, 4)])
        model_from_world = numpy.linalg.inv(numpy.reshape(matrix, shape))
        places = (picture.layers["position"][mask] @ model_from_world[:3, :3].T
                  + model_from_world[:3, 3])
        low = numpy.asarray(low, float)
        coordinates[mask] = (places - low) / (numpy.asarray(high, float) - low)
    return coordinates


def silhouette(picture, name):
    """Returns the mask (height, width) of an object with what others hide of it, as far as it is in
    the picture, which has the layers object-id and hidden-id; meshes of one name are one object. A
    pixel where eight meshes stand one behind the other may miss further ones."""
    for layer in ("object-id", "hidden-id"):
        if layer not in picture.layers:
            raise bad_argument("picture", f"it has no layer {layer}: render with "
                                          'aovs=["object-id", "hidden-id"]')
    if name not in picture.object_names:
        raise bad_argument("name", f"the picture has no object '{name}', but "
                                   f"{', '.join(picture.object_names)}")
    return silhouette_of(picture, _numbers(picture, name))


def _numbers(picture, name):
    return [number for number, of in enumerate(picture.object_names, 1) if of == name]


def visibility(picture):
    """Returns the share of its silhouette that is seen of each object in a picture, by name."""
    shares = {}
    for name in dict.fromkeys(picture.object_names):
        whole = silhouette(picture, name).sum()
        if whole:
            seen = numpy.isin(picture.layers["object-id"], _numbers(picture, name)).sum()
            shares[name] = float(seen / whole)
    return shares


class Coco:
    """Collects annotations of pictures in the format of COCO: a box, a mask and an area for each
    object that a picture shows, and its visibility if there is the layer hidden-id. The names of
    the objects go to classes as class_ids says."""

    def __init__(self, classes):
        self.classes = {name: [patterns] if isinstance(patterns, str) else list(patterns)
                        for name, patterns in classes.items()}
        self.images, self.annotations = [], []
        self._names = set()  # of all pictures

    def add(self, file_name, picture):
        """Adds a picture with the layer object-id; returns the number of its annotations."""
        if "object-id" not in picture.layers:
            raise bad_argument("picture", 'it has no layer object-id: render with '
                                          'aovs=["object-id"]')
        ids, names = picture.layers["object-id"], picture.object_names
        classes = class_ids(numpy.arange(len(names) + 1), names, self.classes)
        self._names.update(names)
        image = len(self.images) + 1
        self.images.append({"id": image, "file_name": str(file_name), "width": picture.width,
                            "height": picture.height})
        before = len(self.annotations)
        for number, box in boxes(ids).items():
            if classes[number] == 0:
                continue
            mask = ids == number
            self.annotations.append({
                "id": len(self.annotations) + 1, "image_id": image,
                "category_id": int(classes[number]), "iscrowd": 0, "bbox": list(box),
                "area": int(mask.sum()), "segmentation": run_lengths(mask),
                "object": names[number - 1]})
            if "hidden-id" in picture.layers:
                whole = silhouette_of(picture, [number]).sum()
                self.annotations[-1]["visibility"] = float(mask.sum() / whole)
        return len(self.annotations) - before

    def save(self, path):
        """Writes the JSON that pycocotools reads. Warns of classes that have taken no name."""
        categories = [{"id": i, "name": name} for i, name in enumerate(self.classes, 1)]
        name = _convert.path(path, "path")
        with as_file_error(name), open(name, "w", encoding="utf-8") as file:
            json.dump({"images": self.images, "annotations": self.annotations,
                       "categories": categories}, file)
        names = sorted(self._names)
        taken = set(class_ids(numpy.arange(len(names) + 1), names, self.classes).tolist())
        for i, (name, patterns) in enumerate(self.classes.items(), 1):
            if i not in taken:
                warnings.warn(f"the class '{name}' ({', '.join(patterns)}) takes none of the names "
                              f"{', '.join(names)}", stacklevel=2)
