"""Scenes from the meshes of other packages, which are recognised by what they offer: none of them
is imported before a caller has brought one of its objects."""
import numpy

from . import _convert
from ._camera import FLIP, Camera
from ._color import linear
from ._errors import bad_argument, left_out
from ._scene import Scene

# The colour of what has none in trimesh.
_TRIMESH_GREY = (102, 102, 102, 255)


def _fractions(values):
    """Returns numbers in [0, 1]: integers count by their largest value."""
    values = numpy.asarray(values)
    if numpy.issubdtype(values.dtype, numpy.integer):
        return values / numpy.iinfo(values.dtype).max
    return values.astype(float)


def _corners(vertices, faces, *by_vertex):
    """Returns what belongs to each corner, (3 m, ...), and faces of corners."""
    flat = numpy.asarray(faces).reshape(-1)
    taken = [None if values is None else numpy.asarray(values)[flat] for values in
             (vertices, *by_vertex)]
    return taken, numpy.arange(len(flat)).reshape(-1, 3)


def flipped(uvs):
    """Returns coordinates with (0, 0) at the top left from ones with it at the bottom left."""
    return None if uvs is None else numpy.asarray(uvs, float) * [1, -1] + [0, 1]


class Materials:
    """Adds each material of a package once to a scene."""

    def __init__(self, scene):
        self.scene, self.known = scene, {}

    def of(self, material, make):
        """Returns the number of what `make` adds for an object of the package."""
        if id(material) not in self.known:
            self.known[id(material)] = make(), material  # which must live as long as its id counts
        return self.known[id(material)][0]

    def texture(self, image, srgb):
        """Returns the number of a texture of a PIL image or array, or None; and of its alpha."""
        if image is None:
            return None, None
        if hasattr(image, "convert"):  # of PIL: palettes and two channels become three or four
            image = image.convert("RGBA" if "A" in image.getbands() or
                                  "transparency" in image.info else "RGB")
        pixels = _fractions(image)
        if pixels.ndim == 2:
            pixels = numpy.repeat(pixels[..., None], 3, axis=2)
        color = linear(pixels[..., :3]) if srgb else pixels[..., :3]
        alpha = pixels[..., 3] if pixels.shape[2] == 4 else None
        opaque = alpha is None or (alpha == 1).all()
        return (self.scene.add_texture(color, "color"),
                None if opaque else self.scene.add_texture(alpha, "opacity"))


def metallic_roughness(materials, *, name="", color=(1, 1, 1, 1), metallic=1.0, roughness=1.0,
                       color_image=None, roughness_image=None, normal_image=None,
                       emission=(0, 0, 0), emission_image=None, alpha_mode="OPAQUE", cutoff=0.5,
                       one_sided=False):
    """Adds a material of glTF 2.0, section 3.9; `color` and `emission` are linear."""
    scene = materials.scene
    color = numpy.asarray(color, float)
    texture, opacity_texture = materials.texture(color_image, srgb=True)
    parameters = {
        "reflectance": numpy.clip(color[:3], 0, 1),
        "metallic": metallic,
        "alpha": max(float(roughness) ** 2, 1e-3),
        "color_texture": texture,
        "roughness_texture": materials.texture(roughness_image, srgb=False)[0],
        "one_sided": one_sided,
    }
    if normal_image is not None:
        parameters["normal_texture"] = scene.add_texture(_fractions(normal_image)[..., :3],
                                                         "normals")
    if numpy.any(emission):
        parameters["emission"] = emission
        parameters["emission_texture"] = materials.texture(emission_image, srgb=True)[0]
    if alpha_mode != "OPAQUE":
        parameters["opacity"] = float(color[3]) if len(color) > 3 else 1
        parameters["opacity_texture"] = opacity_texture
        if alpha_mode == "MASK":
            parameters["opacity_cutoff"] = cutoff
    return scene.add_material("metallic-roughness", name=name, **parameters)


def _add(scene, materials, mesh, name, number, point_size):
    """Adds a geometry of trimesh to the object `number` of a scene."""
    if not hasattr(mesh, "faces"):
        if not hasattr(mesh, "vertices"):
            raise bad_argument("source", f"{type(mesh).__name__} has no triangles and no points")
        if hasattr(mesh, "entities"):
            _add_path(scene, mesh, name, number, point_size)
            return
        colors = getattr(mesh, "colors", None)
        colors = _fractions(colors) if colors is not None and len(colors) else None
        _add_cloud(scene, numpy.asarray(mesh.vertices, float), colors, point_size, name,
                   object=number)
        return
    vertices, faces = mesh.vertices, mesh.faces
    # trimesh would compute those that no file gave, smooth across edges.
    normals = mesh.vertex_normals if "vertex_normals" in mesh._cache.cache else None
    uvs, colors, alphas, material = None, None, None, None
    visual = mesh.visual
    kind = getattr(visual, "kind", None)
    if kind == "texture":
        uvs = flipped(visual.uv) if visual.uv is not None else None
        material = materials.of(visual.material, lambda: _trimesh_material(materials, visual))
    elif kind in ("vertex", "face"):
        rgba = _fractions(visual.vertex_colors if kind == "vertex" else visual.face_colors)
        if kind == "face":
            (vertices, normals), faces = _corners(vertices, faces, normals)
            rgba = numpy.repeat(rgba, 3, axis=0)
        colors = linear(rgba[:, :3])
        alphas = rgba[:, 3] if (rgba[:, 3] < 1).any() else None
    if material is None:
        material = scene.add_material("metallic-roughness", alpha=1, metallic=0,
                                      reflectance=0.5 if colors is None else 1, name=name)
    scene.add_mesh(vertices, faces, normals=normals, uvs=uvs, colors=colors, alphas=alphas,
                   material=material, name=name, object=number)


def _add_path(scene, path, name, number, point_size):
    """Adds a path of trimesh, whose arcs and splines become as many lines as it makes of them."""
    scale = path.scale if len(path.vertices) else 1
    curves = [numpy.asarray(entity.discrete(path.vertices, scale=scale))
              for entity in path.entities]
    lengths = [len(curve) for curve in curves]
    if 0 in lengths:
        left_out(f"{name}: {lengths.count(0)} of its entities are text or have no points")
    if not sum(lengths):
        raise bad_argument("source", f"{name} is a path without lines")
    points = numpy.concatenate([curve for curve in curves if len(curve)]).astype(float)
    if points.shape[1] == 2:
        points = numpy.pad(points, ((0, 0), (0, 1)))
    lines = numpy.stack([numpy.arange(len(points) - 1), numpy.arange(1, len(points))], axis=1)
    of_entities = numpy.repeat(numpy.arange(len(curves)), lengths)
    lines = lines[of_entities[:-1] == of_entities[1:]]  # none from one entity to the next
    colors = None if path.colors is None else _fractions(path.colors)[of_entities]
    _add_cloud(scene, points, colors, point_size, name, lines, number)


def _trimesh_material(materials, visual):
    material = visual.material
    if not hasattr(material, "metallicFactor"):
        material = material.to_pbr()
    color = material.baseColorFactor
    # A simple material that has an image and says no colour gets this grey, which is no factor.
    if material.baseColorTexture is not None and color is not None and (
            tuple(color) == _TRIMESH_GREY):
        color = None
    given = {
        "name": material.name or "",
        "color": None if color is None else _fractions(color),
        "metallic": material.metallicFactor,
        "roughness": material.roughnessFactor,
        "color_image": material.baseColorTexture,
        "roughness_image": material.metallicRoughnessTexture,
        "normal_image": material.normalTexture,
        "emission": material.emissiveFactor,
        "emission_image": material.emissiveTexture,
        "alpha_mode": material.alphaMode,
        "cutoff": material.alphaCutoff,
    }
    return metallic_roughness(materials, **{k: v for k, v in given.items() if v is not None})


def add_light(scene, light, pose):
    """Adds a light of trimesh or pyrender at a pose (4, 4), whose -z it looks along."""
    color = _fractions(light.color)[:3] * light.intensity
    kind = type(light).__name__
    if getattr(light, "range", None):
        left_out(f"the {kind} '{light.name or ''}' has a range of {light.range:g}, which is not "
                 "used: light falls off by the square of the distance alone")
    if kind == "DirectionalLight":
        scene.add_distant_light(pose[:3, 2], color)
    elif kind == "SpotLight":
        inner, outer = numpy.degrees([light.innerConeAngle, light.outerConeAngle])
        scene.add_spot_light(pose[:3, 3], -pose[:3, 2], color, inner, outer)
    else:
        scene.add_point_light(pose[:3, 3], color)


def _add_cloud(scene, points, colors, size, name, lines=None, object=None):
    """Adds points, or lines between them, of the colours (n, 3 or 4) of sRGB in [0, 1] or None."""
    if size is None:
        raise bad_argument("point_size", f"{name} has points or lines, which need a diameter")
    material = scene.add_material("lambert", reflectance=0.5 if colors is None else 1, name=name)
    alphas = colors[:, 3] if colors is not None and colors.shape[1] == 4 else None
    scene.add_points(points, size, lines=lines,
                     colors=None if colors is None else linear(colors[:, :3]),
                     alphas=None if alphas is None or (alphas == 1).all() else alphas,
                     material=material, name=name, object=object)


def from_trimesh(source, *, up="y", point_size=None):
    """Returns a Scene of a trimesh.Trimesh or trimesh.Scene.

    Transforms (what is seen several times is shared), PBR and simple materials with their textures,
    colours of vertices and faces, the normals that a file had or that the mesh has been asked for,
    the camera and the lights are taken.
    `up` is the axis that is up: "z" for most STL files. Point clouds, and the lines of paths, are
    spheres and tubes of the diameter `point_size`, without which they raise Error.
    """
    scene = Scene().set_up(up)
    materials = Materials(scene)
    if not hasattr(source, "graph"):
        _add(scene, materials, source, "mesh", None, point_size)
        return scene
    places = {}
    for node in source.graph.nodes_geometry:
        pose, name = source.graph[node]
        places.setdefault(name, []).append(pose)
    for name, poses in places.items():
        number = scene.add_object(name)
        _add(scene, materials, source.geometry[name], name, number, point_size)
        scene.add_instances(number, numpy.stack(poses))
    if source.has_camera:
        camera = source.camera
        # Its places count from the corners of pixels.
        scene.set_camera(Camera(camera.K - [[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]],
                                source.camera_transform @ FLIP,
                                [int(side) for side in camera.resolution]))
    for light in getattr(source, "_lights", None) or []:
        add_light(scene, light, source.graph[light.name][0])
    return scene


def from_open3d(source, *, up="y", point_size=None):
    """Returns a Scene of an open3d.geometry.TriangleMesh, PointCloud or LineSet, a list of them, or
    a TriangleMeshModel.

    Normals and colours of vertices, coordinates and textures of triangles, and of the materials of
    a model (open3d.io.read_triangle_model) colour, alpha, emission, metal and roughness with their
    textures and normal maps are taken. What else a material has is a warning. Points and lines are
    spheres and tubes of the diameter `point_size`, with the colours of points.
    """
    scene = Scene().set_up(up)
    materials = Materials(scene)
    if hasattr(source, "meshes") and hasattr(source, "materials"):
        for part in source.meshes:
            record = source.materials[part.material_idx]
            _add_open3d(scene, materials, part.mesh, part.mesh_name, record)
        return scene
    for number, mesh in enumerate(source if isinstance(source, (list, tuple)) else [source]):
        if hasattr(mesh, "triangles"):
            _add_open3d(scene, materials, mesh, f"mesh {number}", None)
        elif hasattr(mesh, "points"):
            points, lines = numpy.asarray(mesh.points), None
            colors = numpy.asarray(mesh.colors) if mesh.has_colors() else None
            if hasattr(mesh, "lines"):  # which have the colours, so each gets points of its own
                points = points[numpy.asarray(mesh.lines).ravel()]
                lines = numpy.arange(len(points)).reshape(-1, 2)
                colors = None if colors is None else numpy.repeat(colors, 2, axis=0)
            _add_cloud(scene, points, colors, point_size, f"mesh {number}", lines)
        else:
            raise bad_argument("source", f"{type(mesh).__name__} has no triangles and no points")
    return scene


# Fields of its materials that no parameter of ours stands for, and what they are where nobody has
# set them.
_OPEN3D_UNUSED = {"base_reflectance": 0.5, "base_clearcoat": 0, "base_anisotropy": 0,
                  "ao_img": None, "clearcoat_img": None, "anisotropy_img": None,
                  "roughness_img": None, "metallic_img": None, "reflectance_img": None}


def _add_open3d(scene, materials, mesh, name, record):
    faces = numpy.asarray(mesh.triangles)
    normals = numpy.asarray(mesh.vertex_normals) if mesh.has_vertex_normals() else None
    colors = linear(mesh.vertex_colors) if mesh.has_vertex_colors() else None
    vertices, uvs = numpy.asarray(mesh.vertices), None
    if mesh.has_triangle_uvs():
        (vertices, normals, colors), faces = _corners(vertices, faces, normals, colors)
        uvs = numpy.asarray(mesh.triangle_uvs)  # the rows of its textures begin at the bottom
    if record is not None:
        uvs = flipped(uvs)  # those of a model begin at the top
        color_image, roughness_image, normal_image = (
            None if image is None else numpy.asarray(image)
            for image in (record.albedo_img, record.ao_rough_metal_img, record.normal_img))
        unused = [field for field, plain in _OPEN3D_UNUSED.items()
                  if getattr(record, field, plain) != plain]
        if unused:
            left_out(f"mesh '{name}': {', '.join(unused)} of its material "
                     f"{'is' if len(unused) == 1 else 'are'} not used")
        material = metallic_roughness(
            materials, name=name, color=record.base_color, metallic=record.base_metallic,
            roughness=record.base_roughness, color_image=color_image,
            roughness_image=roughness_image, normal_image=normal_image,
            emission=numpy.asarray(record.emissive_color)[:3],
            alpha_mode="BLEND" if record.has_alpha else "OPAQUE")
        scene.add_mesh(vertices, faces, normals=normals, uvs=uvs, colors=colors, material=material,
                       name=name)
        return
    textures = mesh.textures if mesh.has_textures() else []
    of_face = (numpy.asarray(mesh.triangle_material_ids) if mesh.has_triangle_material_ids()
               else numpy.zeros(len(faces), int))
    plain = scene.add_material("lambert", reflectance=0.5 if colors is None else 1, name=name)
    for number in numpy.unique(of_face):
        material = plain
        if uvs is not None and number < len(textures):
            texture, _ = materials.texture(numpy.asarray(textures[number]), srgb=True)
            if texture is not None:
                material = scene.add_material("lambert", reflectance=1, color_texture=texture,
                                              name=name)
        scene.add_mesh(vertices, faces[of_face == number], normals=normals, uvs=uvs, colors=colors,
                       material=material, name=name)


def from_pyvista(source, *, scalars=None, cmap="viridis", clim=None, color=None, up="z"):
    """Returns a Scene of a data set of PyVista, or a MultiBlock, by its surface.

    The data array `scalars` of points or cells, or else the active one, gives colours by the map
    `cmap` between the two values of `clim`; arrays of three or four columns are colours. Without
    data, or with `color` (three numbers of sRGB in [0, 1]), the surface has one colour.
    """
    scene = Scene().set_up(up)
    blocks = [source] if not hasattr(source, "n_blocks") else [
        block for block in source if block is not None]
    for number, block in enumerate(blocks):
        surface = _surface(block)
        faces = numpy.asarray(surface.faces).reshape(-1, 4)[:, 1:]
        vertices, colors = numpy.asarray(surface.points), None
        array = None if color is not None else _scalars(surface, scalars)
        if array is not None:
            of_cells = len(array) != len(vertices)
            colors = linear(_mapped(array, cmap, clim))
            if of_cells:
                (vertices,), faces = _corners(vertices, faces)
                colors = numpy.repeat(colors, 3, axis=0)
        normals = surface.point_data.get("Normals")
        if normals is not None and len(normals) != len(vertices):
            normals = None
        reflectance = 1 if colors is not None else linear(0.8 if color is None else color)
        material = scene.add_material("lambert", reflectance=reflectance)
        scene.add_mesh(vertices, faces, normals=normals, colors=colors, material=material,
                       name=f"block {number}")
    return scene


def _surface(block):
    """Returns the triangles of a data set's surface."""
    try:
        return block.extract_surface(algorithm=None).triangulate()
    except TypeError:  # before PyVista 0.47
        return block.extract_surface().triangulate()


def _scalars(surface, name):
    if name is not None:
        if name in surface.point_data or name in surface.cell_data:
            return numpy.asarray(surface[name])
        raise bad_argument("scalars", f"the data set has no array '{name}'")
    active = surface.active_scalars
    return None if active is None or active.ndim == 2 and active.shape[1] not in (3, 4) else (
        numpy.asarray(active))


def _mapped(array, cmap, clim):
    if array.ndim == 2:
        return _fractions(array)[:, :3]
    import pyvista  # whose object it is, so it is there

    low, high = (numpy.nanmin(array), numpy.nanmax(array)) if clim is None else clim
    table = pyvista.LookupTable(cmap, scalar_range=(low, high if high > low else low + 1))
    return _fractions(table(numpy.asarray(array, float)))[:, :3]


def from_cadquery(source, *, tolerance=0.1, angle=0.1, up="z"):
    """Returns a Scene of a shape, a Workplane or an Assembly of CadQuery, or a shape of build123d.

    Curved faces become triangles that are within `tolerance` (in units of the model) and `angle`
    [rad] of them. The colours of an assembly are taken.
    """
    scene = Scene().set_up(up)
    for name, shape, color in _shapes(source):
        if not hasattr(shape, "tessellate"):
            raise bad_argument("source", f"{type(shape).__name__} cannot be made of triangles")
        vertices, faces = shape.tessellate(tolerance, angle)
        rgba = (0.5, 0.5, 0.5, 1) if color is None else color
        material = scene.add_material("lambert", reflectance=linear(rgba[:3]), opacity=rgba[3],
                                      name=name)
        scene.add_mesh([(v.x, v.y, v.z) if hasattr(v, "x") else (v.X, v.Y, v.Z) for v in vertices],
                       faces, material=material, name=name)
    return scene


def _shapes(source):
    """Yields (name, shape, colour or None) of what CadQuery and build123d have."""
    if hasattr(source, "toCompound") and hasattr(source, "objects"):  # an assembly
        for shape, name, place, color in source:
            yield name, shape.moved(place), None if color is None else color.toTuple()
    elif hasattr(source, "vals"):  # a workplane
        for number, shape in enumerate(source.vals()):
            yield f"shape {number}", shape, None
    else:
        color = getattr(source, "color", None)
        yield getattr(source, "label", "") or "shape", source, None if color is None else tuple(
            color)
