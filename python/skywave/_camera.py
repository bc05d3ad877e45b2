"""Cameras as computer vision has them: a matrix K and a pose."""
from dataclasses import dataclass
from typing import Any

import numpy

# Cameras of OpenGL look along -z and have y up, those of OpenCV along z with y down.
FLIP = numpy.diag([1.0, -1.0, -1.0, 1.0])


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole camera for Scene.set_camera.

    `K` (3, 3) is the matrix of OpenCV [pixels], [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], whose pixels
    have their centres at whole numbers. The columns of `world_from_camera` (4, 4) or (3, 4) are the
    camera's x (right), y (down) and z (forward) in the world, and its place. Pictures have
    `size` = (width, height), unless `size` is given to render.
    """

    K: Any
    world_from_camera: Any
    size: tuple

    @classmethod
    def from_world_to_camera(cls, K, R, t, size):
        """Returns the camera that sees the point X of the world at R X + t, as OpenCV says it."""
        R, t = numpy.asarray(R, dtype=float), numpy.asarray(t, dtype=float).reshape(3)
        return cls(K, numpy.column_stack([R.T, -R.T @ t]), size)
