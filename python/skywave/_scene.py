"""Scenes: files, or meshes, materials and lights from arrays."""
from . import _convert, _core
from ._camera import Camera
from ._errors import bad_argument, keywords, renamed


def _looks(colors, alphas, material, name, object):
    """Returns what add_mesh and add_points say of all vertices, for the extension module."""
    return (None if colors is None else _convert.rows(colors, "colors", 3),
            None if alphas is None else _convert.column(alphas, "alphas"),
            _convert.index(material, "material"), _convert.text(name, "name"),
            -1 if object is None else _convert.index(object, "object"))


class Scene:
    """Triangles, materials, textures, lights and a camera.

    Scene() is empty, with y up; it needs a mesh before it can be rendered. Scene("model.glb") reads
    a pbrt, OBJ, glTF or PLY file or makes a built-in scene, to which more can be added; the options
    are those of reading: `strict`, `max_triangles`, `instances`, `frame`, `fps` and `animation`.
    Material 0 always exists; that of an empty scene is grey and diffuse.

    Space is right-handed. Arrays are copied. A method returns the scene itself if there is nothing
    else to return.
    """

    _size = None  # of the pictures of its camera

    def __init__(self, path=None, **options):
        if path is None and options:
            raise bad_argument(next(iter(options)), "an empty scene has no options of reading")
        if path is None:
            self._core = _core.Scene()
        else:
            with keywords(options):
                self._core = _core.Scene(_convert.path(path, "path"), _convert.options(options))

    def copy(self):
        """Returns a scene that can be changed without changing this one."""
        scene = Scene.__new__(Scene)
        scene._core = self._core.copy()
        scene._size = self._size
        return scene

    __copy__ = copy

    def __deepcopy__(self, memo):
        return self.copy()

    def __repr__(self):
        return f"<skywave.Scene of {self.triangles} triangles>"

    @property
    def triangles(self):
        """The number of triangles."""
        return self._core.triangles()

    def add_mesh(self, vertices, faces=None, *, normals=None, uvs=None, colors=None, alphas=None,
                 material=0, name="", object=None):
        """Adds triangles: positions (n, 3) and indices (m, 3), counter-clockwise seen from outside.

        One object with `.vertices` and `.faces`, such as a trimesh.Trimesh, can stand for both.
        Without `normals` (n, 3), which may have any length but 0, shading is flat; those of such an
        object are not taken unless they are given. In `uvs` (n, 2), (0, 0) is the top left of an
        image. `colors` (n, 3) are factors of the reflectance and `alphas` (n), in [0, 1], of the
        opacity. `material` is a number that add_material has returned. `name` appears in errors.
        With the number of an `object`, which add_object has returned, the mesh is seen where that
        has instances.
        """
        if faces is None:
            if not (hasattr(vertices, "vertices") and hasattr(vertices, "faces")):
                raise bad_argument("faces", "they are missing, and the first argument has no "
                                            ".vertices and .faces")
            vertices, faces = vertices.vertices, vertices.faces
        positions = _convert.rows(vertices, "vertices", 3)
        arguments = (positions, _convert.indices(faces, "faces", 3, len(positions)),
                     None if normals is None else _convert.rows(normals, "normals", 3),
                     None if uvs is None else _convert.rows(uvs, "uvs", 2),
                     *_looks(colors, alphas, material, name, object))
        with renamed(positions="vertices", triangles="faces"):
            self._core.add_mesh(*arguments)
        return self

    def add_points(self, points, size, *, lines=None, colors=None, alphas=None, material=0,
                   name="", object=None):
        """Adds points (n, 3) as spheres of the diameter `size`, or with `lines` (m, 2), pairs of
        their indices, tubes of that diameter with round ends.

        All else is as for add_mesh. Points of colours are brighter on a material whose reflectance
        is 1 than on material 0.
        """
        arguments = (_convert.rows(points, "points", 3), _convert.number(size, "size"),
                     None if lines is None else _convert.indices(lines, "lines", 2, len(points)),
                     *_looks(colors, alphas, material, name, object))
        with renamed(positions="points", diameter="size"):
            self._core.add_points(*arguments)
        return self

    def add_object(self, name=""):
        """Adds an empty object; returns its number for add_mesh and add_instances."""
        return self._core.add_object(_convert.text(name, "name"))

    def add_instances(self, object, matrices):
        """Adds instances of an object: matrices (n, 4, 4) or (n, 3, 4) that take it to the world.

        They share its triangles if copies would take much more memory.
        """
        self._core.add_instances(_convert.index(object, "object"),
                                 _convert.matrices(matrices, "matrices"))
        return self

    def add_texture(self, image, use="color"):
        """Adds an image (height, width, 3) or (height, width); returns its number for materials.

        `use`: "color" (linear), "opacity", "normals" (of a tangent-space map, [0, 1] for [-1, 1])
        or "heights".
        """
        uses = _core.TextureUse.__members__
        return self._core.add_texture(_convert.image(image, "image"),
                                      uses[_convert.choice(use, "use", uses)])

    def add_material(self, bsdf="lambert", *, name="", **parameters):
        """Adds a material of a BSDF (docs/design/bsdfs.md); returns its number for meshes.

        The parameters are those that `skywave info --json` prints: reflectance, alpha, ior,
        emission, opacity, color_texture and others; a colour is three numbers or one.
        """
        return self._core.add_material(
            _convert.text(bsdf, "bsdf"),
            [(_convert.text(key, "parameter"), _convert.values(value, key))
             for key, value in parameters.items() if value is not None],
            _convert.text(name, "name"))

    def add_point_light(self, position, intensity):
        """Adds a point light of `intensity` [W/sr], a colour or a number."""
        self._core.add_point_light(_convert.vector(position, "position"),
                                   _convert.color(intensity, "intensity"))
        return self

    def add_spot_light(self, position, axis, intensity, full_degrees, dark_degrees):
        """Adds a spot of `intensity` [W/sr], a colour or a number.

        It is full up to `full_degrees` from its axis and dark from `dark_degrees` on.
        """
        self._core.add_spot_light(_convert.vector(position, "position"),
                                  _convert.vector(axis, "axis"),
                                  _convert.color(intensity, "intensity"),
                                  _convert.number(full_degrees, "full_degrees"),
                                  _convert.number(dark_degrees, "dark_degrees"))
        return self

    def add_distant_light(self, direction, irradiance):
        """Adds a light infinitely far away in `direction`, towards the light.

        It gives surfaces that face it `irradiance` [W/m^2], a colour or a number.
        """
        self._core.add_distant_light(_convert.vector(direction, "direction"),
                                     _convert.color(irradiance, "irradiance"))
        return self

    def set_environment(self, map):
        """Sets the illumination map: an array (height, width, 3), a Picture or a file.

        NaN and negative values become 0, infinite ones the largest, and the notes of a picture
        say so.
        """
        self._core.set_environment(_convert.image(map, "map"))
        return self

    def set_camera(self, eye, target=None, up=(0, 1, 0), fov=45):
        """Places the camera; `fov` is that of the shorter side of the picture, in degrees.

        A Camera in place of `eye` says all of that itself.
        """
        if isinstance(eye, Camera):
            return self._set_camera(eye)
        if target is None:
            raise bad_argument("target", "the camera looks somewhere")
        with renamed(fov_degrees="fov"):
            self._core.set_camera(_convert.vector(eye, "eye"), _convert.vector(target, "target"),
                                  _convert.vector(up, "up"), _convert.number(fov, "fov"))
        self._size = None
        return self

    def _set_camera(self, camera):
        k, _ = _convert.matrix(camera.K, "K", [(3, 3)])
        pose, shape = _convert.matrix(camera.world_from_camera, "world_from_camera",
                                      [(4, 4), (3, 4)])
        width, height = (_convert.index(side, "size") for side in camera.size)
        self._core.set_camera_matrix(k, pose if shape == (4, 4) else [*pose, 0, 0, 0, 1], width,
                                     height)
        self._size = (width, height)
        return self

    def set_up(self, axis):
        """Sets the axis "x", "y" or "z" that is up for the map and for an automatic camera."""
        self._core.set_up(_convert.choice(axis, "axis", ("x", "y", "z")))
        return self
