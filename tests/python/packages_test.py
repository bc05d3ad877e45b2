"""Scenes from the meshes of other packages hold what those say: a test of each real package, run by
scripts/test_python_packages.sh, which installs them."""
import importlib
import json
import tempfile
import unittest
import warnings

import numpy

import skywave
from skywave import annotations

WHITE = numpy.ones((4, 8, 3))
# A quad in the plane z = 0, and its corners in an image whose (0, 0) is at the bottom left.
QUAD = numpy.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
QUAD_FACES = numpy.array([[0, 1, 2], [0, 2, 3]])
QUAD_UVS = numpy.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
# Rows from the top: red, green; blue, white.
IMAGE = numpy.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 255]]], numpy.uint8)
IMAGE = IMAGE.repeat(8, axis=0).repeat(8, axis=1)


def linear(srgb):
    srgb = numpy.asarray(srgb, float)
    return numpy.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def package(name):
    """Returns a module, or skips the test."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise unittest.SkipTest(f"{name} is not installed") from None


def look(scene, eye=(0, 0, 4), up=(0, 1, 0), size=(40, 40)):
    """Returns a picture of 2 by 2 units around the origin, under white light from everywhere."""
    fov = 2 * numpy.degrees(numpy.arctan(1 / numpy.linalg.norm(eye)))
    return skywave.render(scene.copy().set_environment(WHITE), size=size, spp=4, eye=eye,
                          target=(0, 0, 0), up=up, fov=fov,
                          aovs=["albedo", "depth", "object-id", "shading-normal"])


class PackagesTest(unittest.TestCase):
    def assert_quarters(self, picture):
        """The albedo is that of IMAGE, upright."""
        for row, column, color in ((10, 10, (1, 0, 0)), (10, 30, (0, 1, 0)), (30, 10, (0, 0, 1)),
                                   (30, 30, (1, 1, 1))):
            numpy.testing.assert_allclose(picture.layers["albedo"][row, column], color, atol=1e-3)


class Trimesh(PackagesTest):
    def setUp(self):
        self.trimesh = package("trimesh")
        self.moved = self.trimesh.transformations.translation_matrix

    def quad(self, **visual):
        mesh = self.trimesh.Trimesh(QUAD, QUAD_FACES, process=False)
        if visual:
            mesh.visual = self.trimesh.visual.TextureVisuals(**visual)
        return mesh

    def test_parts_stand_where_the_graph_puts_them(self):
        scene = self.trimesh.Scene()
        box = self.trimesh.creation.box((0.5, 0.5, 0.5))
        scene.add_geometry(box, geom_name="box", transform=self.moved([-0.5, 0.5, 0]))
        scene.graph.update("second", geometry="box", matrix=self.moved([0.5, -0.5, 0]))
        picture = look(skywave.from_trimesh(scene), eye=(0, 0, 40))
        ids = picture.layers["object-id"]
        for row, column, there in ((10, 10, True), (30, 30, True), (10, 30, False),
                                   (30, 10, False)):
            self.assertEqual(ids[row, column] > 0, there, (row, column))
        self.assertAlmostEqual(picture.layers["depth"][10, 10], 39.75, delta=1e-3)

    def test_materials_and_textures(self):
        material = self.trimesh.visual.material.PBRMaterial(
            baseColorTexture=_pil(IMAGE), metallicFactor=0, roughnessFactor=1)
        self.assert_quarters(look(skywave.from_trimesh(self.quad(uv=QUAD_UVS, material=material))))
        material = self.trimesh.visual.material.PBRMaterial(
            baseColorFactor=[0.5, 0.25, 1, 1], metallicFactor=0, roughnessFactor=1,
            emissiveFactor=[0, 2, 0])
        picture = look(skywave.from_trimesh(self.quad(uv=QUAD_UVS, material=material)))
        numpy.testing.assert_allclose(picture.layers["albedo"][20, 20], [0.5, 0.25, 1], atol=3e-3)
        self.assertGreater(picture.rgb[20, 20, 1], 2)
        simple = self.trimesh.visual.material.SimpleMaterial(image=_pil(IMAGE))
        self.assert_quarters(look(skywave.from_trimesh(self.quad(uv=QUAD_UVS, material=simple))))

    def test_transparency_of_a_texture(self):
        alpha = numpy.full((16, 16, 1), 255, numpy.uint8)
        alpha[:8] = 0
        material = self.trimesh.visual.material.PBRMaterial(
            baseColorTexture=_pil(numpy.concatenate([IMAGE, alpha], axis=2)), alphaMode="MASK",
            alphaCutoff=0.5, metallicFactor=0, roughnessFactor=1)
        ids = look(skywave.from_trimesh(self.quad(uv=QUAD_UVS, material=material))).layers[
            "object-id"]
        self.assertEqual((ids[10, 10] > 0, ids[30, 30] > 0), (False, True))

    def test_colors_of_faces_and_vertices_are_srgb(self):
        mesh = self.quad()
        mesh.visual.face_colors = [[255, 128, 0, 255], [0, 128, 255, 255]]
        albedo = look(skywave.from_trimesh(mesh)).layers["albedo"]
        numpy.testing.assert_allclose(albedo[30, 25], linear([1, 128 / 255, 0]), atol=2e-3)
        numpy.testing.assert_allclose(albedo[10, 15], linear([0, 128 / 255, 1]), atol=2e-3)
        mesh = self.quad()
        mesh.visual.vertex_colors = [[128, 128, 128, 255]] * 4
        albedo = look(skywave.from_trimesh(mesh)).layers["albedo"]
        numpy.testing.assert_allclose(albedo[20, 20], linear([128 / 255] * 3), atol=2e-3)

    def test_alphas_of_vertices_are_their_own(self):
        mesh = self.quad()
        mesh.visual.vertex_colors = [[255, 255, 255, 0], [255, 255, 255, 255]] * 2
        mesh.visual.vertex_colors[[0, 3], 3] = 0
        mesh.visual.vertex_colors[[1, 2], 3] = 255
        picture = skywave.render(skywave.from_trimesh(mesh).set_environment(WHITE), spp=256,
                                 size=(40, 40), eye=(0, 0, 4), target=(0, 0, 0),
                                 fov=2 * numpy.degrees(numpy.arctan(0.25)),
                                 background="transparent", aovs=["alpha"])
        numpy.testing.assert_allclose(picture.layers["alpha"].mean(axis=0)[2:-2],
                                      ((numpy.arange(40) + 0.5) / 40)[2:-2], atol=0.02)

    def test_normals_are_smooth_where_a_file_gives_them(self):
        ball = self.trimesh.creation.icosphere(0)
        smooth = self.trimesh.Trimesh(ball.vertices, ball.faces, vertex_normals=ball.vertices,
                                      process=False)
        for mesh, normals in ((ball, 1), (smooth, 16)):
            eye = 4 * ball.face_normals[0]
            seen = look(skywave.from_trimesh(mesh), eye).layers["shading-normal"]
            middle = seen[18:22, 18:22].reshape(-1, 3).round(5)
            self.assertEqual(len(numpy.unique(middle, axis=0)), normals)

    def test_the_camera_sees_what_its_matrix_says(self):
        scene = self.trimesh.Scene(self.trimesh.creation.box((0.2, 0.2, 0.2)))
        scene.camera = self.trimesh.scene.Camera(resolution=(80, 60), fov=(60, 46.8))
        pose = self.trimesh.transformations.rotation_matrix(0.3, [0, 1, 0])
        pose[:3, 3] = [1.5, 0.3, 4]
        scene.camera_transform = pose
        ids = skywave.render(skywave.from_trimesh(scene), WHITE, spp=1,
                             aovs=["object-id"]).layers["object-id"]
        self.assertEqual(ids.shape, (60, 80))
        rows, columns = numpy.nonzero(ids > 0)
        x, y, z = (numpy.linalg.inv(pose) @ [0, 0, 0, 1])[:3]
        k = scene.camera.K
        self.assertAlmostEqual(columns.mean() + 0.5, k[0, 0] * x / -z + k[0, 2], delta=0.6)
        self.assertAlmostEqual(rows.mean() + 0.5, -k[1, 1] * y / -z + k[1, 2], delta=0.6)

    def test_lights_shine_as_they_say(self):
        scene = self.trimesh.Scene(self.quad())
        material = self.trimesh.visual.material.PBRMaterial(
            baseColorFactor=[255, 255, 255, 255], metallicFactor=0, roughnessFactor=1)
        scene.geometry["geometry_0"].visual = self.trimesh.visual.TextureVisuals(
            uv=QUAD_UVS, material=material)
        light = self.trimesh.scene.lighting.PointLight(color=[255, 128, 0, 255], intensity=8)
        scene.lights = [light]
        scene.graph.update(light.name, matrix=self.moved([0, 0, 2]))
        picture = skywave.render(skywave.from_trimesh(scene), spp=4, size=(21, 21), eye=(0, 0, 4),
                                 target=(0, 0, 0), fov=10)
        red, green, blue = picture.rgb[10, 10]
        self.assertAlmostEqual(green / red, 128 / 255, delta=1e-3)
        self.assertEqual(blue, 0)
        # A white body under its gloss reflects about 8 / 2^2 / pi towards the light.
        self.assertAlmostEqual(red, 8 / 4 / numpy.pi, delta=0.1)

    def test_what_has_no_triangles_is_refused(self):
        with self.assertRaisesRegex(skywave.Error, "point_size: mesh has points or lines"):
            skywave.from_trimesh(self.trimesh.PointCloud(QUAD))

    def test_clouds_and_paths_have_a_size(self):
        cloud = self.trimesh.PointCloud(QUAD / 2, colors=[[255, 0, 0, 255]] * 4)
        picture = look(skywave.from_trimesh(cloud, point_size=0.4))
        albedo = picture.layers["albedo"]
        numpy.testing.assert_allclose(albedo[10, 10], [1, 0, 0], atol=1e-3)
        self.assertEqual(picture.layers["object-id"][20, 20], 0)
        path = self.trimesh.load_path([[[-0.8, 0, 0], [0.8, 0, 0]]])
        ids = look(skywave.from_trimesh(path, point_size=0.2)).layers["object-id"]
        self.assertEqual((ids[20, 20] > 0, ids[10, 20] > 0), (True, False))

    def test_arcs_of_paths_are_round_and_entities_have_their_colours(self):
        path = self.trimesh.path.creation.circle(radius=0.75)
        line = self.trimesh.load_path([[[0, 0], [0.25, 0]]])
        path = self.trimesh.path.util.concatenate([path, line])
        path.colors = [[255, 0, 0, 255], [0, 0, 255, 255]]
        layers = look(skywave.from_trimesh(path, point_size=0.05)).layers
        ids, albedo = layers["object-id"], layers["albedo"]
        rows, columns = numpy.nonzero((ids > 0) & (albedo[..., 0] > albedo[..., 2]))
        # Half of the picture's height is one unit of the plane.
        radii = numpy.hypot(columns - (ids.shape[1] - 1) / 2, rows - (ids.shape[0] - 1) / 2)
        self.assertGreater(len(radii), 60)
        self.assertLess(numpy.ptp(radii), 4)
        self.assertGreater(((ids > 0) & (albedo[..., 2] > albedo[..., 0])).sum(), 1)


class Pyrender(PackagesTest):
    def setUp(self):
        self.pyrender = package("pyrender")
        self.trimesh = package("trimesh")
        from skywave.pyrender import OffscreenRenderer

        self.renderer = OffscreenRenderer(80, 60, spp=4)
        self.scene = self.pyrender.Scene(ambient_light=[0.25, 0.5, 0.125],
                                         bg_color=[0.2, 0.4, 0.6, 0.5])
        self.moved = self.trimesh.transformations.translation_matrix
        self.scene.add(self.pyrender.PerspectiveCamera(yfov=numpy.radians(60)),
                       pose=self.moved([0, 0, 3]))

    def ball(self, place=(0, 0, 0)):
        mesh = self.pyrender.Mesh.from_trimesh(self.trimesh.creation.icosphere(4, 0.5))
        for primitive in mesh.primitives:
            primitive.material = self.pyrender.MetallicRoughnessMaterial(
                baseColorFactor=[1.0, 1.0, 1.0, 1.0], metallicFactor=0, roughnessFactor=1)
        return self.scene.add(mesh, pose=self.moved(place))

    def test_colors_and_depths(self):
        self.ball()
        color, depth = self.renderer.render(self.scene)
        self.assertEqual((color.shape, color.dtype), ((60, 80, 3), numpy.uint8))
        self.assertEqual((depth.shape, depth.dtype), ((60, 80), numpy.float32))
        numpy.testing.assert_array_equal(color[0, 0], [51, 102, 153])
        self.assertEqual(depth[0, 0], 0)
        self.assertAlmostEqual(depth[30, 40], 2.5, delta=5e-3)
        # A white ball under even light has its radiance.
        expected = [137, 188, 99]  # of sRGB for 0.25, 0.5 and 0.125
        numpy.testing.assert_allclose(color[30, 40].astype(int), expected, atol=2)

    def test_flags(self):
        first, second = self.ball((-0.7, 0, 0)), self.ball((0.7, 0, 0))
        flags = self.pyrender.RenderFlags
        depth = self.renderer.render(self.scene, flags.DEPTH_ONLY)
        self.assertEqual(depth.shape, (60, 80))
        colors, _ = self.renderer.render(self.scene, flags.SEG, {first: (255, 0, 0),
                                                                 second: (0, 9, 0)})
        left, right = (40 - round(0.7 / 3 * 30 / numpy.tan(numpy.radians(30))),
                       40 + round(0.7 / 3 * 30 / numpy.tan(numpy.radians(30))))
        for column, color in ((left, (255, 0, 0)), (right, (0, 9, 0)), (40, (0, 0, 0))):
            numpy.testing.assert_array_equal(colors[30, column], color)
        rgba, _ = self.renderer.render(self.scene, flags.RGBA)
        numpy.testing.assert_array_equal(rgba[0, 0], [51, 102, 153, 128])
        self.assertEqual(rgba[30, left, 3], 255)
        for flag in ("FLAT", "ALL_WIREFRAME", "FLIP_WIREFRAME"):
            with self.assertRaisesRegex(skywave.Error, flag):
                self.renderer.render(self.scene, getattr(flags, flag))

    def test_lights_and_instances(self):
        quad = self.trimesh.Trimesh(QUAD, QUAD_FACES, process=False)
        places = numpy.stack([self.moved([-1.2, 0, 0]), self.moved([1.2, 0, 0])])
        mesh = self.pyrender.Mesh.from_trimesh(quad, poses=places, smooth=False)
        mesh.primitives[0].material = self.pyrender.MetallicRoughnessMaterial(
            baseColorFactor=[1.0, 1.0, 1.0, 1.0], metallicFactor=0, roughnessFactor=1)
        self.scene.add(mesh)
        self.scene.ambient_light = [0, 0, 0]
        self.scene.add(self.pyrender.DirectionalLight([1, 0.5, 0], 2))
        color, depth = self.renderer.render(self.scene)
        self.assertEqual(depth[30, 40], 0)
        for column in (20, 60):
            self.assertAlmostEqual(depth[30, column], 3, delta=1e-3)
            red, green, blue = linear(color[30, column] / 255)
            self.assertAlmostEqual(red, 2 / numpy.pi, delta=0.1)
            self.assertAlmostEqual(green / red, 0.5, delta=0.02)
            self.assertEqual(blue, 0)

    def test_intrinsics_place_the_picture(self):
        self.ball()
        self.scene.remove_node(self.scene.main_camera_node)
        self.scene.add(self.pyrender.IntrinsicsCamera(fx=60, fy=60, cx=20, cy=45),
                       pose=self.moved([0, 0, 3]))
        depth = self.renderer.render(self.scene, self.pyrender.RenderFlags.DEPTH_ONLY)
        rows, columns = numpy.nonzero(depth)
        self.assertAlmostEqual(columns.mean() + 0.5, 20, delta=0.3)
        self.assertAlmostEqual(rows.mean() + 0.5, 45, delta=0.3)

    def test_backs_are_culled_unless_materials_have_two_sides(self):
        def seen(double_sided, flags=0):
            mesh = self.pyrender.Mesh.from_trimesh(
                self.trimesh.Trimesh(QUAD, QUAD_FACES[:, ::-1], process=False), smooth=False)
            mesh.primitives[0].material = self.pyrender.MetallicRoughnessMaterial(
                doubleSided=double_sided)
            node = self.scene.add(mesh)
            depth = self.renderer.render(self.scene, self.pyrender.RenderFlags.DEPTH_ONLY | flags)
            self.scene.remove_node(node)
            return depth[30, 40] > 0

        self.assertFalse(seen(False))
        self.assertTrue(seen(True))
        self.assertTrue(seen(False, self.pyrender.RenderFlags.SKIP_CULL_FACES))

    def test_alphas_of_vertices_count(self):
        mesh = self.trimesh.Trimesh(QUAD, QUAD_FACES, process=False)
        mesh.visual.vertex_colors = [[255, 255, 255, 64]] * 4
        self.scene.add(self.pyrender.Mesh.from_trimesh(mesh, smooth=False))
        self.scene.bg_color = [0, 0, 0, 0]
        rgba, _ = self.renderer.render(self.scene, self.pyrender.RenderFlags.RGBA)
        self.assertAlmostEqual(rgba[20:40, 30:50, 3].mean(), 64, delta=6)

    def test_what_is_left_out_is_a_warning(self):
        node = self.ball()
        node.mesh.primitives[0].material.wireframe = True
        self.scene.add(self.pyrender.PointLight([1, 1, 1], 2, range=5, name="lamp"))
        self.scene.main_camera_node.camera.zfar = 2.75
        self.scene.main_camera_node.camera.znear = 2.625
        with self.assertWarns(UserWarning) as caught:
            self.renderer.render(self.scene)
        said = " ".join(str(warning.message) for warning in caught.warnings)
        for part in ("is a wireframe", "'lamp' has a range of 5", "znear of 2.625", "zfar of 2.75"):
            self.assertIn(part, said)
        self.assertEqual({warning.filename for warning in caught.warnings}, {__file__})

    def test_what_is_not_rendered_is_refused(self):
        for name in ("aovs", "background", "size"):
            with self.assertRaisesRegex(skywave.Error, f"{name}: the renderer sets it"):
                type(self.renderer)(8, 8, **{name: "depth"})
        self.scene.add(self.pyrender.Mesh.from_points(QUAD))
        with self.assertRaisesRegex(skywave.Error, "points or lines"):
            self.renderer.render(self.scene)


class Pyvista(PackagesTest):
    def setUp(self):
        self.pyvista = package("pyvista")

    def test_colors_are_those_of_the_map(self):
        plane = self.pyvista.Plane(i_size=2, j_size=2, i_resolution=40, j_resolution=1)
        plane["height"] = plane.points[:, 0]
        albedo = look(skywave.from_pyvista(plane, cmap="plasma", clim=(-1, 1))).layers["albedo"]
        table = self.pyvista.LookupTable("plasma", scalar_range=(-1, 1))
        for column in (5, 20, 35):
            value = (column + 0.5) / 20 - 1
            expected = linear(numpy.asarray(table(numpy.array([value])))[0, :3])
            numpy.testing.assert_allclose(albedo[20, column], expected, atol=0.02)

    def test_cells_have_one_color_each(self):
        plane = self.pyvista.Plane(i_size=2, j_size=2, i_resolution=2, j_resolution=1)
        plane.cell_data["rgb"] = numpy.array([[255, 0, 0], [0, 0, 255]], numpy.uint8)
        albedo = look(skywave.from_pyvista(plane, scalars="rgb")).layers["albedo"]
        numpy.testing.assert_allclose(albedo[20, 10], [1, 0, 0], atol=1e-3)
        numpy.testing.assert_allclose(albedo[20, 30], [0, 0, 1], atol=1e-3)

    def test_volumes_and_blocks_are_their_surface(self):
        blocks = self.pyvista.MultiBlock([self.pyvista.ImageData(dimensions=(3, 3, 3)), None,
                                          self.pyvista.Cube()])
        self.assertEqual(skywave.from_pyvista(blocks, color=(1, 0, 0)).triangles, 48 + 12)
        with self.assertRaisesRegex(skywave.Error, "no array 'wind'"):
            skywave.from_pyvista(self.pyvista.Cube(), scalars="wind")


class Open3d(PackagesTest):
    def setUp(self):
        self.open3d = package("open3d")
        vector = self.open3d.utility
        self.mesh = self.open3d.geometry.TriangleMesh(vector.Vector3dVector(QUAD),
                                                      vector.Vector3iVector(QUAD_FACES))

    def test_colors_and_normals(self):
        self.mesh.paint_uniform_color([0.5, 0.25, 1])
        albedo = look(skywave.from_open3d([self.mesh])).layers["albedo"]
        numpy.testing.assert_allclose(albedo[20, 20], linear([0.5, 0.25, 1]), atol=2e-3)

    def test_textures_by_triangle(self):
        # The rows of its pictures begin at the bottom, as read_triangle_mesh leaves them.
        uvs = QUAD_UVS[QUAD_FACES.reshape(-1)]
        self.mesh.triangle_uvs = self.open3d.utility.Vector2dVector(uvs)
        image = numpy.ascontiguousarray(IMAGE[::-1])
        self.mesh.textures = [self.open3d.geometry.Image(image)]
        self.mesh.triangle_material_ids = self.open3d.utility.IntVector([0, 0])
        self.assert_quarters(look(skywave.from_open3d(self.mesh)))

    def test_models_have_materials(self):
        trimesh = package("trimesh")
        quad = trimesh.Trimesh(QUAD, QUAD_FACES, process=False)
        quad.visual = trimesh.visual.TextureVisuals(
            uv=QUAD_UVS, material=trimesh.visual.material.PBRMaterial(
                baseColorTexture=_pil(IMAGE), metallicFactor=0.0, roughnessFactor=1.0))
        with tempfile.TemporaryDirectory() as folder:
            quad.export(folder + "/quad.glb")
            model = self.open3d.io.read_triangle_model(folder + "/quad.glb")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            self.assert_quarters(look(skywave.from_open3d(model)))
        record = model.materials[0]
        record.base_clearcoat, record.base_anisotropy = 0.5, 0.25
        record.emissive_color = [0, 2, 0, 1]
        with self.assertWarnsRegex(UserWarning, "base_clearcoat, base_anisotropy of its material "
                                                "are not used") as caught:
            scene = skywave.from_open3d(model)
        self.assertEqual(caught.filename, __file__)
        self.assertGreater(look(scene).rgb[20, 20, 1], 2)

    def test_what_has_no_triangles_is_refused(self):
        with self.assertRaisesRegex(skywave.Error, "Image has no triangles and no points"):
            skywave.from_open3d(self.open3d.geometry.Image())
        cloud = self.open3d.geometry.PointCloud(self.open3d.utility.Vector3dVector(QUAD))
        with self.assertRaisesRegex(skywave.Error, "point_size: mesh 0 has points or lines"):
            skywave.from_open3d(cloud)

    def test_clouds_and_lines_have_a_size(self):
        vector = self.open3d.utility
        cloud = self.open3d.geometry.PointCloud(vector.Vector3dVector(QUAD / 2))
        cloud.paint_uniform_color([0.5, 0.25, 1])
        lines = self.open3d.geometry.LineSet(vector.Vector3dVector([[-0.8, 0, 0], [0.8, 0, 0]]),
                                             vector.Vector2iVector([[0, 1]]))
        lines.colors = vector.Vector3dVector([[0, 1, 0]])
        albedo = look(skywave.from_open3d([cloud, lines], point_size=0.2)).layers["albedo"]
        numpy.testing.assert_allclose(albedo[10, 10], linear([0.5, 0.25, 1]), atol=2e-3)
        numpy.testing.assert_allclose(albedo[20, 20], [0, 1, 0], atol=1e-3)


class Cadquery(PackagesTest):
    def setUp(self):
        self.cadquery = package("cadquery")

    def test_parts_of_an_assembly_have_place_and_color(self):
        box = self.cadquery.Workplane().box(0.8, 0.8, 0.8)
        assembly = self.cadquery.Assembly()
        assembly.add(box, name="left", color=self.cadquery.Color(1, 0, 0),
                     loc=self.cadquery.Location((-0.5, 0, 0)))
        assembly.add(box, name="right", color=self.cadquery.Color(0, 0, 1),
                     loc=self.cadquery.Location((0.5, 0, 0)))
        picture = look(skywave.from_cadquery(assembly), eye=(0, -40, 0), up=(0, 0, 1))
        numpy.testing.assert_allclose(picture.layers["albedo"][20, 10], [1, 0, 0], atol=1e-3)
        numpy.testing.assert_allclose(picture.layers["albedo"][20, 30], [0, 0, 1], atol=1e-3)
        self.assertAlmostEqual(picture.layers["depth"][20, 10], 39.6, delta=1e-3)

    def test_curves_are_within_the_tolerance(self):
        ball = self.cadquery.Workplane().sphere(1)
        coarse, fine = (skywave.from_cadquery(ball, tolerance=t, angle=1).triangles
                        for t in (0.2, 0.001))
        self.assertGreater(fine, 4 * coarse)


class Hdf5(PackagesTest):
    def test_containers_have_the_names_of_blenderproc(self):
        h5py = package("h5py")
        picture = skywave.render("spheres", WHITE, size=(32, 24), spp=4,
                                 aovs=["depth", "camera-normal", "object-id"])
        with tempfile.TemporaryDirectory() as folder:
            annotations.write_hdf5(folder + "/0.hdf5", picture)
            with h5py.File(folder + "/0.hdf5") as file:
                data = {name: numpy.array(values) for name, values in file.items()}
        self.assertEqual(set(data), {"colors", "depth", "normals", "instance_segmaps",
                                     "instance_attribute_maps"})
        self.assertEqual((data["colors"].shape, data["colors"].dtype), ((24, 32, 3), numpy.uint8))
        numpy.testing.assert_array_equal(data["depth"], picture.layers["depth"])
        numpy.testing.assert_array_equal(data["instance_segmaps"], picture.layers["object-id"])
        row, column = numpy.argwhere(picture.layers["object-id"] > 0)[200]
        numpy.testing.assert_allclose(2 * data["normals"][row, column] - 1,
                                      picture.layers["camera-normal"][row, column], atol=1e-6)
        names = json.loads(data["instance_attribute_maps"].tobytes())
        self.assertEqual([entry["name"] for entry in names], picture.object_names)
        color = linear(data["colors"][row, column] / 255)
        numpy.testing.assert_allclose(color, numpy.clip(picture.rgb[row, column], 0, 1), atol=0.01)


def _pil(pixels):
    return package("PIL.Image").fromarray(pixels)


if __name__ == "__main__":
    unittest.main()
