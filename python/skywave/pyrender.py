"""A stand-in for pyrender.OffscreenRenderer that needs no OpenGL and no display: the same call
renders the same pyrender.Scene by light paths, with shadows and reflections.

    from skywave.pyrender import OffscreenRenderer
    color, depth = OffscreenRenderer(640, 480, spp=64).render(scene)
"""
import numpy

from . import _packages, render
from ._camera import FLIP, Camera
from ._color import bytes_of, linear, srgb
from ._errors import bad_argument, left_out
from ._scene import Scene

# Of pyrender.RenderFlags. What is not here says how OpenGL draws, or is always so (shadows).
_DEPTH_ONLY, _RGBA, _SEG = 1, 2048, 8192
_REFUSED = {4: "FLIP_WIREFRAME", 8: "ALL_WIREFRAME", 4096: "FLAT"}
_SKIP_CULL_FACES = 1024
_TRIANGLES = 4
# Options of skywave.render that make a picture of pyrender.
_OWN = {"size", "background", "aovs"}


def from_pyrender(source, size, *, cull=True):
    """Returns a Scene of a pyrender.Scene, seen by its main camera in pictures of `size` = (width,
    height). Meshes are named "NUMBER NAME" by the order of `source.mesh_nodes`.

    Ambient light is a map of that radiance. Factors, textures and vertex colours are those of
    pyrender, which takes colours of vertices as linear. With `cull`, the backs of materials that
    are not double-sided are not seen. Points and lines, and orthographic cameras, raise Error;
    wireframes and ranges of lights are a warning.
    """
    scene = Scene()
    materials = _packages.Materials(scene)
    for number, node in enumerate(source.mesh_nodes):
        pose = source.get_pose(node)
        for primitive in node.mesh.primitives:
            _add_primitive(scene, materials, primitive, pose, f"{number} {node.name or ''}".strip(),
                           cull)
    for node in source.light_nodes:
        _packages.add_light(scene, node.light, source.get_pose(node))
    ambient = numpy.asarray(source.ambient_light, float)[:3]
    if numpy.any(ambient > 0):
        scene.set_environment(numpy.broadcast_to(ambient, (2, 4, 3)))
    node = source.main_camera_node
    if node is None:
        raise bad_argument("source", "the scene has no camera")
    scene.set_camera(Camera(_matrix_of(node.camera, size),
                            source.get_pose(node) @ FLIP, size))
    return scene


def _matrix_of(camera, size):
    """Returns K of a camera of pyrender; pixels have their centres at whole numbers."""
    width, height = size
    if hasattr(camera, "fx"):
        # Its places count from the corners of pixels.
        return [[camera.fx, 0, camera.cx - 0.5], [0, camera.fy, camera.cy - 0.5], [0, 0, 1]]
    if not hasattr(camera, "yfov"):
        raise bad_argument("source", f"a camera of the type {type(camera).__name__}: perspective "
                                     "and intrinsics cameras are rendered")
    aspect = width / height if camera.aspectRatio is None else camera.aspectRatio
    fy = 0.5 * height / numpy.tan(0.5 * camera.yfov)
    fx = 0.5 * width / (aspect * numpy.tan(0.5 * camera.yfov))
    return [[fx, 0, 0.5 * width - 0.5], [0, fy, 0.5 * height - 0.5], [0, 0, 1]]


def _add_primitive(scene, materials, primitive, pose, name, cull):
    if primitive.mode != _TRIANGLES:
        raise bad_argument("source", f"mesh '{name}' is of points or lines")
    positions = primitive.positions
    faces = numpy.arange(len(positions)) if primitive.indices is None else primitive.indices
    faces = numpy.asarray(faces).astype(int).reshape(-1, 3)  # pyrender keeps them as floats
    colors, alphas = None, None
    if primitive.color_0 is not None:
        rgba = numpy.asarray(primitive.color_0, float)
        colors = rgba[:, :3]
        if rgba.shape[1] == 4 and (rgba[:, 3] < 1).any():
            alphas = rgba[:, 3]
    number = scene.add_object(name)
    scene.add_mesh(positions, faces, normals=primitive.normals,
                   uvs=_packages.flipped(primitive.texcoord_0), colors=colors, alphas=alphas,
                   material=materials.of(primitive.material,
                                         lambda: _material(materials, primitive.material, cull)),
                   name=name, object=number)
    poses = [pose] if primitive.poses is None else [pose @ each for each in primitive.poses]
    scene.add_instances(number, numpy.stack(poses))


def _material(materials, material, cull):
    def image(texture):
        return None if texture is None else texture.source

    if material.wireframe:
        left_out(f"the material '{material.name or ''}' is a wireframe, which is rendered as a "
                 "surface")
    return _packages.metallic_roughness(
        materials, name=material.name or "", color=material.baseColorFactor,
        metallic=material.metallicFactor, roughness=material.roughnessFactor,
        color_image=image(material.baseColorTexture),
        roughness_image=image(material.metallicRoughnessTexture),
        normal_image=image(material.normalTexture), emission=material.emissiveFactor,
        emission_image=image(material.emissiveTexture),
        alpha_mode=material.alphaMode, cutoff=material.alphaCutoff or 0.5,
        one_sided=cull and not material.doubleSided)


def _warn_of_range(depth, camera):
    seen = depth[depth > 0]
    for name, beyond in (("znear", seen.min(initial=numpy.inf) < (camera.znear or 0)),
                         ("zfar", seen.max(initial=0) > (camera.zfar or numpy.inf))):
        if beyond:
            left_out(f"the camera's {name} of {getattr(camera, name):g} is not used: what lies "
                     "outside is seen")


class OffscreenRenderer:
    """Renders pyrender.Scene objects with the signature of pyrender.OffscreenRenderer.

    All further keywords are options of skywave.render: spp, strategy, denoise and others.
    `point_size` is not used.
    """

    def __init__(self, viewport_width, viewport_height, point_size=1.0, **options):
        self.viewport_width, self.viewport_height = int(viewport_width), int(viewport_height)
        self.point_size = point_size
        for name in sorted(_OWN & options.keys()):
            raise bad_argument(name, "the renderer sets it: its pictures have size, colour and "
                                     "depth as pyrender's")
        self.options = options

    def render(self, scene, flags=0, seg_node_map=None):
        """Returns (color, depth): uint8 (h, w, 3), or (h, w, 4) with RGBA, and float32 (h, w).

        Depth is that along the axis of the camera, 0 where nothing is. With DEPTH_ONLY it is
        returned alone. With SEG the colours are those of `seg_node_map`, {node: (r, g, b)}, black
        elsewhere. ALL_WIREFRAME, FLIP_WIREFRAME and FLAT raise Error; what lies outside of the
        camera's znear and zfar is seen, with a warning.
        """
        for flag, name in _REFUSED.items():
            if flags & flag:
                raise bad_argument("flags", f"{name} is not rendered")
        size = (self.viewport_width, self.viewport_height)
        options = dict(self.options)
        if flags & (_DEPTH_ONLY | _SEG):
            options = {"spp": 1}  # no light is asked for
        source = from_pyrender(scene, size, cull=not flags & _SKIP_CULL_FACES)
        picture = render(source, size=size, background="transparent", aovs=["depth", "object-id"],
                         **options)
        depth = numpy.where(picture.layers["object-id"] > 0, picture.layers["depth"],
                            0).astype(numpy.float32)
        _warn_of_range(depth, scene.main_camera_node.camera)
        if flags & _DEPTH_ONLY:
            return depth
        if flags & _SEG:
            return _segments(picture, list(scene.mesh_nodes), seg_node_map or {}), depth
        alpha = numpy.clip(picture.layers["alpha"], 0, 1)[..., None]
        behind = numpy.asarray(scene.bg_color, float)
        behind = numpy.append(behind, 1.0)[:4]
        color = srgb(picture.rgb + (1 - alpha) * linear(behind[:3]))
        if flags & _RGBA:
            color = numpy.concatenate([color, alpha + (1 - alpha) * behind[3]], axis=2)
        return bytes_of(color), depth

    def delete(self):
        """Does nothing: there is no OpenGL to be freed."""


def _segments(picture, nodes, colors):
    ids = picture.layers["object-id"].astype(int)
    table = numpy.zeros((len(picture.object_names) + 1, 3), numpy.uint8)
    for number, name in enumerate(picture.object_names):
        node = nodes[int(name.split()[0])]
        table[number + 1] = colors.get(node, (0, 0, 0))
    return table[ids]
