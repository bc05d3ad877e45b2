"""Scenes from arrays are those from files, bit by bit, whatever the arrays look like in memory."""
import copy
import types
import unittest

import numpy

import skywave
from support import Case, FACES, SMALL, VERTICES, sky, write_obj, write_ply


def render(scene):
    return skywave.render(scene, env=sky(), **SMALL).rgb


class SceneTest(Case):
    def test_a_mesh_of_arrays_is_that_of_a_file(self):
        write_ply("mesh.ply")
        expected = render("mesh.ply")
        self.assertGreater(expected.mean(), 0.01)
        self.assert_same_bits(render(skywave.Scene().add_mesh(VERTICES, FACES)), expected)
        whole = types.SimpleNamespace(vertices=VERTICES, faces=FACES)
        self.assert_same_bits(render(skywave.Scene().add_mesh(whole)), expected)

    def test_arrays_of_any_layout(self):
        expected = render(skywave.Scene().add_mesh(VERTICES, FACES))
        wide = numpy.zeros((10, 7))
        wide[::2, 1:7:2] = VERTICES
        for vertices in (VERTICES.tolist(), VERTICES.astype(numpy.float64), wide[::2, 1:7:2],
                         numpy.ascontiguousarray(VERTICES.T).T, VERTICES[::-1].copy()[::-1],
                         VERTICES.astype(">f4")):
            self.assert_same_bits(render(skywave.Scene().add_mesh(vertices, FACES)), expected)
        for faces in (FACES.tolist(), FACES.astype(numpy.int64), FACES.astype(numpy.uint8),
                      numpy.asfortranarray(FACES), FACES.astype(">i4"),
                      numpy.repeat(FACES, 2, axis=0)[::2]):
            self.assert_same_bits(render(skywave.Scene().add_mesh(VERTICES, faces)), expected)

    def test_instances_are_moved_copies(self):
        moved = numpy.eye(4, dtype=numpy.float32)
        moved[:3, 3] = (0.5, 0.25, -1)
        expected = render(skywave.Scene().add_mesh(VERTICES, FACES)
                          .add_mesh(VERTICES + moved[:3, 3], FACES))
        for matrices in (numpy.stack([numpy.eye(4), moved]),
                         numpy.stack([numpy.eye(4), moved])[:, :3].astype(numpy.float64)):
            scene = skywave.Scene()
            part = scene.add_object("pyramid")
            scene.add_mesh(VERTICES, FACES, object=part).add_instances(part, matrices)
            self.assert_same_bits(render(scene), expected)

    def test_many_instances_share_their_triangles(self):
        scene = skywave.Scene()
        part = scene.add_object()
        scene.add_mesh(VERTICES, numpy.repeat(FACES, 1000, axis=0), object=part)
        places = numpy.tile(numpy.eye(4, dtype=numpy.float32), (1000, 1, 1))
        places[:, 0, 3] = numpy.arange(1000)
        scene.add_instances(part, places)
        picture = skywave.render(scene, env=sky(), eye=(0, 2, 6), target=(0, 0.5, 0), **SMALL)
        self.assertLess(picture.statistics["scene"]["geometry_bytes"], 2_000_000)
        self.assertGreater(picture.rgb.mean(), 0.01)

    def test_normals_and_uvs_are_those_of_a_file(self):
        normals = VERTICES / numpy.linalg.norm(VERTICES, axis=1, keepdims=True)
        normals = normals.astype(numpy.float32)
        lines = ["v %.9g %.9g %.9g" % tuple(v) for v in VERTICES]
        lines += ["vn %.9g %.9g %.9g" % tuple(n) for n in normals]
        lines += ["f " + " ".join(f"{i + 1}//{i + 1}" for i in face) for face in FACES]
        with open("smooth.obj", "w") as file:
            file.write("\n".join(lines))
        smooth = render(skywave.Scene().add_mesh(VERTICES, FACES, normals=normals))
        self.assert_same_bits(smooth, render("smooth.obj"))
        flat = render(skywave.Scene().add_mesh(VERTICES, FACES))
        self.assertNotEqual(smooth.tobytes(), flat.tobytes())

    def test_materials_textures_and_colors(self):
        scene = skywave.Scene()
        texture = scene.add_texture(numpy.full((4, 4, 3), [0.9, 0.1, 0.1], numpy.float32))
        red = scene.add_material("lambert", reflectance=1, color_texture=texture, name="red")
        plain = scene.add_material("lambert", reflectance=[0.9, 0.1, 0.1])
        metal = scene.add_material("conductor", alpha=0.1)
        self.assertEqual((red, plain, metal), (1, 2, 3))
        self.assertEqual(scene.add_material(emission=1, emits_on_both_sides=True), 4)
        uvs = VERTICES[:, [0, 2]]
        pictures = [render(scene.copy().add_mesh(VERTICES, FACES, uvs=uvs, material=number))
                    for number in (0, red, plain, metal)]
        # Texels are rounded to nine bits, so both pictures are not the same.
        numpy.testing.assert_allclose(pictures[1], pictures[2], rtol=0.02)
        self.assertEqual(len({picture.tobytes() for picture in pictures}), 4)
        colors = numpy.tile(numpy.float32([0.5, 0.5, 0.5]), (5, 1))
        darker = render(skywave.Scene().add_mesh(VERTICES, FACES, colors=colors))
        self.assertLess(darker.sum(), pictures[0].sum())
        thin = skywave.Scene().add_mesh(VERTICES, FACES, alphas=numpy.full(5, 0.25))
        whole, quarter = (
            skywave.render(each, sky(), **{**SMALL, "spp": 64}, background="transparent",
                           aovs=["alpha"], integrator="direct").layers["alpha"].sum()
            for each in (skywave.Scene().add_mesh(VERTICES, FACES), thin))
        # A ray goes through one or two triangles.
        self.assertGreater(quarter, 0.25 * whole)
        self.assertLess(quarter, 0.45 * whole)

    def test_points_and_lines_have_their_size(self):
        scene = skywave.Scene().add_points([[-1, 0, 0]], 0.5, colors=[[1, 0, 0]])
        scene.add_points([[0, 0, 0], [1, 0, 0]], 0.5, lines=[[0, 1]])
        picture = skywave.render(scene, sky(), size=(60, 40), spp=16, eye=(0, 0, 100), fov=2.3,
                                 target=(0, 0, 0), aovs=["coverage", "albedo"])
        pixel = (2 * 100 * numpy.tan(numpy.radians(2.3 / 2)) / 40) ** 2
        seen = picture.layers["coverage"].sum(axis=0) * pixel
        ball = numpy.pi / 16
        self.assertAlmostEqual(seen[:25].sum(), ball, delta=0.03 * ball)
        self.assertAlmostEqual(seen[25:].sum(), ball + 0.5, delta=0.03 * (ball + 0.5))
        self.assertEqual(picture.layers["albedo"][20, 15, 1], 0)

    def test_lights_and_camera(self):
        base = skywave.Scene().add_mesh(VERTICES, FACES).set_camera((0, 2, 5), (0, 0.5, 0), fov=30)
        pictures = []
        for light in (lambda s: s.add_point_light((0, 4, 1), 10),
                      lambda s: s.add_spot_light((0, 4, 1), (0, -1, 0), [10, 5, 1], 20, 40),
                      lambda s: s.add_distant_light((0, 1, 1), 2),
                      lambda s: s.set_environment(sky())):
            scene = light(base.copy())
            pictures.append(skywave.render(scene, **SMALL).rgb)
            self.assertGreater(pictures[-1].max(), 0)
        self.assertEqual(len({picture.tobytes() for picture in pictures}), 4)
        moved = copy.deepcopy(scene).set_camera((0, 2, 5), (0, 0.5, 0), up=(1, 1, 0), fov=30)
        self.assertNotEqual(skywave.render(moved, **SMALL).rgb.tobytes(), pictures[-1].tobytes())
        turned = copy.copy(scene).set_up("z")
        self.assertNotEqual(skywave.render(turned, **SMALL).rgb.tobytes(), pictures[-1].tobytes())
        self.assert_same_bits(skywave.render(scene, **SMALL).rgb, pictures[-1])

    def test_lights_shine_as_their_formulas(self):
        # A grey square in the plane y = 0, of which the film sees about one point.
        square = [[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]]
        colors = numpy.array([1, 2, 4])
        for light, irradiance in (
                # The cosine of a triangle of sides 3, 4 and 5.
                (lambda s: s.add_point_light((3, 4, 0), 25 * colors), 25 / 5**2 * 0.8),
                (lambda s: s.add_distant_light((3, 4, 0), 2 * colors), 2 * 0.8),
                (lambda s: s.add_spot_light((0, 4, 0), (0, -1, 0), 16 * colors, 20, 30), 16 / 4**2),
                (lambda s: s.add_spot_light((0, 4, 0), (1, -1, 0), 16 * colors, 20, 30), 0)):
            scene = skywave.Scene()
            grey = scene.add_material(reflectance=0.5)
            scene.add_mesh(square, [[0, 1, 2], [0, 2, 3]], material=grey)
            scene.set_camera((0, 2, 0.001), (0, 0, 0), fov=0.01)
            light(scene)
            rgb = skywave.render(scene, size=(4, 4), spp=16, filter="box", max_depth=1).rgb
            expected = numpy.broadcast_to(0.5 / numpy.pi * irradiance * colors, rgb.shape)
            numpy.testing.assert_allclose(rgb, expected, rtol=2e-3)

    def test_a_camera_has_the_defaults_of_its_signature(self):
        scene = skywave.Scene().add_mesh(VERTICES, FACES)
        eye, target = (0, 2, 5), (0, 0.5, 0)
        expected = render(scene.copy().set_camera(eye, target, (0, 1, 0), 45))
        self.assert_same_bits(render(scene.copy().set_camera(eye, target)), expected)
        self.assertNotEqual(render(scene.set_camera(eye, target, fov=46)).tobytes(),
                            expected.tobytes())

    def test_a_camera_of_vision_sees_points_where_its_matrix_says(self):
        K = numpy.array([[70, 0, 21.25], [0, 60, 12.5], [0, 0, 1]])
        angle = 0.3
        R = numpy.array([[numpy.cos(angle), 0, numpy.sin(angle)], [0, -1, 0],
                         [numpy.sin(angle), 0, -numpy.cos(angle)]])  # y down
        t = numpy.array([0.1, 0.2, 4])
        camera = skywave.Camera.from_world_to_camera(K, R, t, (48, 32))
        scene = skywave.Scene().add_mesh(VERTICES, FACES).set_camera(camera)
        picture = skywave.render(scene, env=sky(), spp=1, filter="box", filter_radius=0.01,
                                 aovs=["position", "coverage"])
        self.assertEqual((picture.width, picture.height), (48, 32))
        y, x = numpy.nonzero(picture.layers["coverage"])
        self.assertGreater(len(x), 20)
        seen = R @ picture.layers["position"][y, x].astype(float).T + t[:, None]
        pixels = K @ (seen / seen[2])
        numpy.testing.assert_allclose(pixels[0], x, atol=0.02)
        numpy.testing.assert_allclose(pixels[1], y, atol=0.02)
        # The size of the picture may be given, and a camera of its own forgets that of the matrix.
        self.assertEqual(skywave.render(scene.copy(), sky(), size=(24, 16), spp=1).width, 24)
        scene.set_camera((0, 2, 5), (0, 0, 0))
        self.assertEqual(skywave.render(scene, sky(), spp=1).width, 640)

    def test_images_of_one_channel_are_grey(self):
        ramp = numpy.linspace(0.1, 0.9, 16, dtype=numpy.float32).reshape(8, 2)
        pictures = []
        for image in (ramp, numpy.repeat(ramp[:, :, None], 3, axis=2)):
            scene = skywave.Scene()
            painted = scene.add_material(color_texture=scene.add_texture(image))
            scene.add_mesh(VERTICES, FACES, uvs=VERTICES[:, :2], material=painted)
            pictures.append(render(scene))
        self.assert_same_bits(*pictures)

    def test_textures_are_what_they_are_used_for(self):
        # As a normal map it tilts normals; as heights it is a plane, which tilts nothing.
        image = numpy.full((4, 4, 3), [0.8, 0.5, 0.9], numpy.float32)
        pictures = {}
        for use in (None, "normals", "heights"):
            scene = skywave.Scene()
            relief = {} if use is None else {"normal_texture": scene.add_texture(image, use)}
            scene.add_mesh(VERTICES, FACES, uvs=VERTICES[:, :2],
                           material=scene.add_material(**relief))
            pictures[use] = render(scene).tobytes()
        self.assertEqual(pictures["heights"], pictures[None])
        self.assertNotEqual(pictures["normals"], pictures[None])

    def test_more_is_added_to_a_file(self):
        write_obj("mesh.obj")
        scene = skywave.Scene("mesh.obj")
        scene.add_mesh(VERTICES + [3, 0, 0], FACES)
        self.assertEqual(scene.triangles, 12)
        self.assertIn("12", repr(scene))

    def test_places_are_those_of_a_file_that_is_far_away(self):
        pictures = []
        pyramid = numpy.round(VERTICES * 4) / 4  # exact as floats, also far away
        for at in (numpy.zeros(3), numpy.array([16384.0, -8192.0, 32768.0])):
            write_obj("mesh.obj", pyramid + at)
            scene = skywave.Scene("mesh.obj")
            scene.add_mesh((pyramid + at + [2.25, 0, 0]).astype(numpy.float32), FACES)
            blob = scene.add_object()
            scene.add_mesh(pyramid / 4, FACES, object=blob)
            scene.add_instances(blob, [numpy.block([[numpy.eye(3), (at + [0, 2, 0])[:, None]],
                                                    [numpy.zeros((1, 3)), 1]])])
            scene.add_points(numpy.float32([at + [-2, 1, 0]]), 0.5)
            scene.add_point_light(at + [1, 3, 2], 5)
            scene.add_spot_light(at + [-1, 3, 2], (0, -1, -0.5), 5, 20, 40)
            scene.set_camera(at + [1, 3, 7], at + [1, 0.5, 0])
            pictures.append(render(scene))
        self.assertLess(numpy.abs(pictures[0] - pictures[1]).max(), 1e-3 * pictures[0].max())
        self.assertGreater(pictures[0].max(), 0.1)


if __name__ == "__main__":
    unittest.main()
