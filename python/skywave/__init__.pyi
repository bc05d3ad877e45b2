import os
from collections.abc import Callable, Sequence
from typing import Any, Literal, Protocol, TypeAlias

import numpy
from numpy.typing import ArrayLike, NDArray

__version__: str

_Path: TypeAlias = str | bytes | os.PathLike[str] | os.PathLike[bytes]
_Floats: TypeAlias = NDArray[numpy.float32]
_Image: TypeAlias = ArrayLike | Picture | _Path
_Color: TypeAlias = float | ArrayLike
_Option: TypeAlias = bool | float | str | os.PathLike[str] | Sequence[Any] | NDArray[Any] | None
_Progress: TypeAlias = Callable[[float], object] | None

class _Mesh(Protocol):
    @property
    def vertices(self) -> Any: ...
    @property
    def faces(self) -> Any: ...

class Error(ValueError):
    kind: Literal["usage", "bad-input", "io"]
    place: str
    def __init__(self, message: str, kind: str = ..., place: str = ...) -> None: ...

class FileError(Error, OSError): ...
class Canceled(Exception): ...

class Camera:
    K: ArrayLike
    world_from_camera: ArrayLike
    size: tuple[int, int]
    def __init__(
        self, K: ArrayLike, world_from_camera: ArrayLike, size: tuple[int, int]
    ) -> None: ...
    @classmethod
    def from_world_to_camera(
        cls, K: ArrayLike, R: ArrayLike, t: ArrayLike, size: tuple[int, int]
    ) -> Camera: ...

class Scene:
    def __init__(self, path: _Path | None = None, **options: _Option) -> None: ...
    @property
    def triangles(self) -> int: ...
    def copy(self) -> Scene: ...
    def add_mesh(
        self,
        vertices: ArrayLike | _Mesh,
        faces: ArrayLike | None = None,
        *,
        normals: ArrayLike | None = None,
        uvs: ArrayLike | None = None,
        colors: ArrayLike | None = None,
        alphas: ArrayLike | None = None,
        material: int = 0,
        name: str = "",
        object: int | None = None,
    ) -> Scene: ...
    def add_points(
        self,
        points: ArrayLike,
        size: float,
        *,
        lines: ArrayLike | None = None,
        colors: ArrayLike | None = None,
        alphas: ArrayLike | None = None,
        material: int = 0,
        name: str = "",
        object: int | None = None,
    ) -> Scene: ...
    def add_object(self, name: str = "") -> int: ...
    def add_instances(self, object: int, matrices: ArrayLike) -> Scene: ...
    def add_texture(
        self, image: _Image, use: Literal["color", "opacity", "normals", "heights"] = "color"
    ) -> int: ...
    def add_material(
        self, bsdf: str = "lambert", *, name: str = "", **parameters: _Color | None
    ) -> int: ...
    def add_point_light(self, position: ArrayLike, intensity: _Color) -> Scene: ...
    def add_spot_light(
        self,
        position: ArrayLike,
        axis: ArrayLike,
        intensity: _Color,
        full_degrees: float,
        dark_degrees: float,
    ) -> Scene: ...
    def add_distant_light(self, direction: ArrayLike, irradiance: _Color) -> Scene: ...
    def set_environment(self, map: _Image) -> Scene: ...
    def set_camera(
        self,
        eye: ArrayLike | Camera,
        target: ArrayLike | None = None,
        up: ArrayLike = (0, 1, 0),
        fov: float = 45,
    ) -> Scene: ...
    def set_up(self, axis: Literal["x", "y", "z"]) -> Scene: ...

class Picture:
    width: int
    height: int
    rgb: _Floats
    layers: dict[str, _Floats]
    warnings: list[str]
    notes: list[str]
    @property
    def statistics(self) -> dict[str, Any]: ...
    @property
    def summary(self) -> str: ...
    @property
    def object_names(self) -> list[str]: ...
    @property
    def material_names(self) -> list[str]: ...
    def save(
        self,
        path: _Path,
        *,
        exposure: float | None = None,
        tone: Literal["clip", "filmic"] | None = None,
    ) -> None: ...
    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]: ...
    def _repr_png_(self) -> bytes: ...

def from_trimesh(
    source: Any, *, up: Literal["x", "y", "z"] = "y", point_size: float | None = None
) -> Scene: ...
def from_open3d(
    source: Any, *, up: Literal["x", "y", "z"] = "y", point_size: float | None = None
) -> Scene: ...
def from_pyvista(
    source: Any,
    *,
    scalars: str | None = None,
    cmap: str = "viridis",
    clim: tuple[float, float] | None = None,
    color: ArrayLike | None = None,
    up: Literal["x", "y", "z"] = "z",
) -> Scene: ...
def from_cadquery(
    source: Any,
    *,
    tolerance: float = 0.1,
    angle: float = 0.1,
    up: Literal["x", "y", "z"] = "z",
) -> Scene: ...
def version() -> str: ...
def render(
    scene: _Path | Scene,
    env: _Image | None = None,
    *,
    progress: _Progress = None,
    checkpoint: _Path | None = None,
    checkpoint_seconds: float = 0,
    resume: bool = False,
    **options: _Option,
) -> Picture: ...
def converge(
    scene: _Path | Scene,
    strategies: Sequence[str] | str | None = None,
    budgets: Sequence[int] | str | None = None,
    env: _Image | None = None,
    *,
    progress: _Progress = None,
    **options: _Option,
) -> dict[str, Any]: ...
def compare(image: _Image, reference: _Image) -> dict[str, Any]: ...
def probe(map: _Image, projection: str = "") -> dict[str, Any]: ...
def read_image(path: _Path) -> _Floats: ...
def write_png(
    path: _Path,
    image: _Image,
    *,
    exposure: float = 0,
    tone: Literal["clip", "filmic"] = "clip",
) -> None: ...
def encode_png(
    image: _Image, *, exposure: float = 0, tone: Literal["clip", "filmic"] = "clip"
) -> bytes: ...
