"""Bad input ends in an exception that says which argument and why, and never in a crash. This also
runs under AddressSanitizer."""
import os
import pathlib
import pickle
import types
import unittest

import numpy

import skywave
from support import Case, FACES, SMALL, VERTICES, sky, write_obj

NAN, INFINITE = float("nan"), float("inf")


def changed(array, at, value, dtype=None):
    array = numpy.array(array, dtype)
    array[at] = value
    return array


class BadInputTest(Case):
    def refuse(self, place, reason, function, *arguments, error=skywave.Error, **keywords):
        """Asserts that the call raises an Error of that place, with that reason (both: regular
        expressions)."""
        with self.subTest(place=place, reason=reason):
            with self.assertRaisesRegex(error, reason) as caught:
                function(*arguments, **keywords)
            self.assertRegex(caught.exception.place, place)
            self.assertIn(caught.exception.kind, ("usage", "bad-input", "io"))
            self.assertTrue(str(caught.exception).startswith(caught.exception.place))

    def test_vertices(self):
        add = skywave.Scene().add_mesh
        self.refuse("^vertices$", r"shape is \(15,\)", add, VERTICES.ravel(), FACES)
        self.refuse("^vertices$", r"shape is \(5, 2\)", add, VERTICES[:, :2], FACES)
        self.refuse("^vertices$", r"shape is \(3, 5\)", add, VERTICES.T, FACES)
        self.refuse("^vertices$", r"shape is \(1, 5, 3\)", add, VERTICES[None], FACES)
        self.refuse("^vertices$", "empty", add, VERTICES[:0], FACES)
        self.refuse("^vertices$", "empty", add, [], FACES)
        self.refuse("^vertices$", "empty", add, numpy.empty((0, 1 << 40, 3)), FACES)
        for wrong in (VERTICES.astype(complex), VERTICES.astype(str), VERTICES.astype(object),
                      VERTICES.astype(bool), [[{}, 1, 2]], None, "mesh", 3.5,
                      numpy.zeros(5, [("x", float), ("y", float)]),
                      numpy.zeros((5, 3), "datetime64[s]")):
            self.refuse("^vertices$", "", add, wrong, FACES)
        self.refuse("^vertices$", "", add, [[0, 0, 0], [1, 1]], FACES)
        for value in (NAN, INFINITE, -INFINITE, 1e300):
            self.refuse("^vertices$", "nan|inf", add,
                        changed(VERTICES, (3, 1), value, float), FACES)

    def test_points(self):
        add = skywave.Scene().add_points
        self.refuse("^points$", r"shape is \(5, 2\)", add, VERTICES[:, :2], 0.1)
        self.refuse("^points$", "nan", add, changed(VERTICES, (3, 1), NAN, float), 0.1)
        for size in (0, -1, NAN, INFINITE):
            self.refuse("^size$", "is no length", add, VERTICES, size)
        self.refuse("^size$", "not a number", add, VERTICES, "wide")
        self.refuse("^lines$", "point 5, and there are 5", add, VERTICES, 0.1, lines=[[0, 5]])
        self.refuse("^lines$", r"\(n, 2\)", add, VERTICES, 0.1, lines=[[0, 1, 2]])
        self.refuse("^alphas$", r"\(n,\)", add, VERTICES, 0.1, alphas=[[1]])
        self.refuse("^alphas$", "4 values, and 5", add, VERTICES, 0.1, alphas=[1] * 4)
        self.refuse("^alphas$", r"not in \[0, 1\]", add, VERTICES, 0.1, alphas=[1, 1, 1, 1, 2])

    def test_faces(self):
        add = skywave.Scene().add_mesh
        self.refuse("^faces$", r"shape is \(18,\)", add, VERTICES, FACES.ravel())
        self.refuse("^faces$", r"shape is \(6, 2\)", add, VERTICES, FACES[:, :2])
        self.refuse("^faces$", r"shape is \(6, 4\)", add, VERTICES, FACES[:, [0, 1, 2, 0]])
        self.refuse("^faces$", "float64", add, VERTICES, FACES.astype(float))
        self.refuse("^faces$", "bool", add, VERTICES, FACES > 2)
        self.refuse("^faces$", "object", add, VERTICES, [[0, 1, 10**30]])
        self.refuse("^faces$", "empty", add, VERTICES, [])
        self.refuse("^faces$", "missing", add, VERTICES)
        self.refuse("^faces$", "missing", add, types.SimpleNamespace(vertices=VERTICES))
        for value in (5, 2**31 - 1):
            self.refuse("faces", "", add, VERTICES, changed(FACES, (4, 2), value))
        # As 32 bits these would be good indices.
        for value in (-1, -2**63, -2**32, 2**32, 2**32 + 1):
            self.refuse("^faces$", f"row 4 has the index {value}", add, VERTICES,
                        changed(FACES, (4, 2), value, numpy.int64))
        self.refuse("^faces$", "row 4", add, VERTICES,
                    changed(FACES, (4, 2), 2**64 - 1, numpy.uint64))

    def test_instances(self):
        scene = skywave.Scene()
        part = scene.add_object()
        good = numpy.eye(4)[None]
        scene.add_instances(part, good)
        self.refuse("^object$", "none with number 3", scene.add_instances, 3, good)
        self.refuse("^object$", "none with number -2", scene.add_mesh, VERTICES, FACES, object=-2)
        self.refuse("^object$", "whole number", scene.add_instances, "o", good)
        self.refuse("^matrices$", r"shape is \(4, 4\)", scene.add_instances, part, good[0])
        self.refuse("^matrices$", r"shape is \(1, 4, 3\)", scene.add_instances, part,
                    good[:, :, :3])
        self.refuse("^matrices$", "last row", scene.add_instances, part, 2 * good)
        self.refuse("^matrices$", "nan", scene.add_instances, part,
                    changed(good, (0, 1, 2), NAN))
        self.refuse("^name$", "str", scene.add_object, 7)

    def test_attributes_of_vertices(self):
        add = skywave.Scene().add_mesh
        for name, columns in (("normals", 3), ("uvs", 2), ("colors", 3)):
            good = numpy.ones((5, columns), numpy.float32)
            skywave.Scene().add_mesh(VERTICES, FACES, **{name: good})
            self.refuse(f"^{name}$", "shape is", add, VERTICES, FACES, **{name: good[:, 1:]})
            self.refuse(f"^{name}$", "complex", add, VERTICES, FACES, **{name: good * 1j})
            self.refuse(f"^{name}$", "empty", add, VERTICES, FACES, **{name: []})
            self.refuse(name, "", add, VERTICES, FACES, **{name: good[1:]})
            self.refuse(name, "", add, VERTICES, FACES, **{name: changed(good, (2, 1), NAN)})
        self.refuse("normals", "", add, VERTICES, FACES, normals=numpy.zeros((5, 3)))
        self.refuse("colors", "", add, VERTICES, FACES, colors=numpy.full((5, 3), -1.0))

    def test_numbers_of_a_mesh(self):
        scene = skywave.Scene()
        for material in (-1, 1, 2**31 - 1):
            self.refuse("material", "", scene.add_mesh, VERTICES, FACES, material=material)
        for material in (2**31, -2**63, 10**400, 0.0, "red", None):
            self.refuse("^material$", "", scene.add_mesh, VERTICES, FACES, material=material)
        self.refuse("^name$", "str", scene.add_mesh, VERTICES, FACES, name=3)
        self.refuse("^name$", "no text", scene.add_mesh, VERTICES, FACES, name="\ud800")
        self.assertEqual(scene.triangles, 0)  # what was refused is not there
        scene.add_mesh(VERTICES, FACES)
        self.assertEqual(scene.triangles, 6)

    def test_materials_and_textures(self):
        scene = skywave.Scene()
        self.refuse("bsdf", "lambert", scene.add_material, "lambertian")
        self.refuse("bsdf", "str", scene.add_material, None)
        self.refuse("alhpa", "alpha", scene.add_material, "conductor", alhpa=0.1)
        for texture in (0, 1e30):
            self.refuse("material", "texture", scene.add_material, color_texture=texture)
        self.refuse("color_texture", "", scene.add_material, color_texture=-1)
        for value in (NAN, INFINITE, [1, 2], [1, 2, 3, 4], -1):
            self.refuse("reflectance", "", scene.add_material, reflectance=value)
        for value in ("red", [], [[1, 2, 3]], [[1], [1, 2]], [1j, 0, 0], {}, 10**400):
            self.refuse("^reflectance$", "", scene.add_material, reflectance=value)
        self.refuse("emission", "", scene.add_material, emission=NAN)

        image = numpy.full((4, 4, 3), 0.5)
        self.refuse("^image$", r"shape is \(4, 4, 4\)", scene.add_texture, numpy.ones((4, 4, 4)))
        self.refuse("^image$", "8-bit", scene.add_texture, numpy.ones((4, 4, 3), numpy.uint8))
        self.refuse("^image$", "empty", scene.add_texture, numpy.ones((0, 4, 3)))
        self.refuse("^use$", "'colour' is not one of color", scene.add_texture, image, use="colour")
        self.refuse("^use$", "", scene.add_texture, image, use=["color"])
        self.refuse("image", "", scene.add_texture, changed(image, (1, 2, 0), NAN))
        self.refuse("no.exr", "", scene.add_texture, "no.exr", error=OSError)

    def test_lights_and_camera(self):
        scene = skywave.Scene().add_mesh(VERTICES, FACES)
        up, one = (0, 1, 0), 1
        for bad in ((0, 1), (0, 1, NAN), 1, "xyz", (1j, 0, 0), None):
            self.refuse("position", "", scene.add_point_light, bad, one)
            self.refuse("direction", "", scene.add_distant_light, bad, one)
            self.refuse("axis", "", scene.add_spot_light, up, bad, one, 10, 20)
            self.refuse("eye", "", scene.set_camera, bad, up)
            self.refuse("target", "", scene.set_camera, up, bad)
            self.refuse("up", "", scene.set_camera, up, (0, 0, 0), up=bad)
        self.refuse("direction", "", scene.add_distant_light, (0, 0, 0), one)
        self.refuse("axis", "", scene.add_spot_light, up, (0, 0, 0), one, 10, 20)
        for bad in (-1, NAN, INFINITE, (1, 2), "bright", None):
            self.refuse("intensity", "", scene.add_point_light, up, bad)
            self.refuse("irradiance", "", scene.add_distant_light, up, bad)
        for full, dark in ((30, 20), (NAN, 20), (-10, 20), (10, 200), (10, 10**400), (10, "wide")):
            self.refuse("degrees", "", scene.add_spot_light, up, up, one, full, dark)
        for fov in (0, -10, 180, 1000, NAN, "wide"):
            self.refuse("fov", "", scene.set_camera, (0, 2, 5), (0, 0, 0), fov=fov)
        self.refuse("eye|target", "", scene.set_camera, up, up)
        self.refuse("target", "looks somewhere", scene.set_camera, up)
        K, pose = numpy.diag([50.0, 50, 1]), numpy.eye(4)
        for word, K_of, pose_of, size in (
                ("shape", numpy.eye(4), pose, (8, 8)), ("shape", K, K, (8, 8)),
                ("focal", numpy.diag([0.0, 50, 1]), pose, (8, 8)),
                ("right angles", K, numpy.diag([1.0, 0, 1, 1]), (8, 8)),
                ("last row", K, numpy.diag([1.0, 1, 1, 2]), (8, 8)), ("8 by 0", K, pose, (8, 0))):
            self.refuse(".", word, scene.set_camera, skywave.Camera(K_of, pose_of, size))
        self.refuse("up", "", scene.set_camera, (0, 2, 5), (0, 0, 5), up=(0, 0, 0))
        for axis in ("w", "", "xy", 1, None):
            self.refuse("^axis$", "", scene.set_up, axis)

    def test_maps(self):
        write_obj("mesh.obj")
        def render(map):
            return skywave.render("mesh.obj", env=map, **SMALL)
        self.refuse("^map$", "empty", render, sky()[:0])
        self.refuse("^map$", r"shape is \(3,\)", render, numpy.ones(3))
        self.refuse("^map$", r"shape is \(16, 32, 4\)", render, numpy.ones((16, 32, 4)))
        self.refuse("^map$", "floats are needed", render, numpy.ones((16, 32, 3), int))
        self.refuse("^map$", "complex", render, sky() * 1j)
        self.refuse("^map$", "", render, 1)
        self.refuse("^map$", "", render, {})
        self.refuse("^map$", "black", render, numpy.zeros((16, 32, 3)))
        self.refuse("^map$", "black", render, numpy.full((16, 32, 3), NAN))
        self.refuse("^map$", "5 x 7.*projection", render, numpy.ones((7, 5, 3)))
        self.refuse("none.hdr", "", render, "none.hdr", error=OSError)
        pathlib.Path("broken.hdr").write_bytes(b"#?RADIANCE\n\n-Y 4 +X 8\n")
        self.refuse("broken.hdr", "", render, "broken.hdr")
        # Single values are repaired, and the notes say so.
        picture = render(changed(sky(), (3, 4, 1), NAN))
        self.assertIn("map: 1 NaN", " ".join(picture.notes))
        self.assertTrue(numpy.isfinite(picture.rgb).all())
        self.refuse("map", "", skywave.probe, numpy.ones((0, 0, 3)))
        self.refuse("projection", "", skywave.probe, sky(), "round")

    def test_options(self):
        def render(**options):
            return skywave.render("furnace", **{**SMALL, **options})
        self.refuse("^max_dept$", "did you mean max_depth", render, max_dept=3)
        self.refuse("quux", "no such option|unknown", render, quux=3)
        for name, value in (("spp", 0), ("spp", -1), ("spp", 64.5), ("spp", 10**30),
                            ("spp", "many"), ("spp", True), ("size", (0, 4)), ("size", (4,)),
                            ("size", 640),
                            ("size", []),
                            ("size", (10**30, 1)), ("size", [[1, 2], 3]),
                            ("eye", (1, 2)), ("eye", (1, 2, NAN)), ("fov", NAN), ("fov", INFINITE),
                            ("crop", (10, 10)), ("mis", 3),
                            ("integrator", "paths"), ("strategy", "produkt"), ("aovs", ["albido"]),
                            ("filter", "\0"), ("threads", -1), ("seed", -1)):
            self.refuse(name, "", render, **{name: value})
        for value in ({}, {1, 2}, object(), 1j, lambda: 1, 10**5000):
            self.refuse("^spp$", "", render, spp=value)
        around = []
        around.append(around)
        with self.assertRaises(RecursionError):
            render(eye=around)
        self.refuse("furnace", "1000000 x 1000000", render, size=(10**6, 10**6))
        self.refuse("furnace", "1000", render, crop=(10, 10, 1000, 1000))
        self.refuse("paths 0,0", "", render, integrator="bdpt", paths=(0, 0))
        self.refuse("split 2", "integrator=bdpt", render, integrator="bdpt", split=2)

    def test_files(self):
        for name in ("none.obj", pathlib.Path("none.obj"), b"none.obj"):
            self.refuse("none.obj", "no such file", skywave.Scene, name)
        os.mkdir("folder.obj")
        self.refuse("folder.obj", "", skywave.Scene, "folder.obj", error=skywave.FileError)
        self.refuse("no-such-scene", "gallery", skywave.render, "no-such-scene")
        self.refuse("^path$", "zero byte", skywave.Scene, "a\0.obj")
        for wrong in (3, [], object(), 1.5):
            self.refuse("^path$", "file name", skywave.Scene, wrong)
        self.refuse("strict", "", skywave.Scene, strict=True)
        self.refuse("spp", "", skywave.Scene, "gallery", spp=3)
        pathlib.Path("broken.obj").write_text("v 0 0 0\nf 1 2 x\n")
        self.refuse("broken.obj:2", "", skywave.Scene, "broken.obj")
        strange = os.fsdecode(b"\xff\xfe.obj")
        self.refuse(strange, "no such file", skywave.Scene, strange)
        self.refuse("none.exr", "", skywave.read_image, "none.exr", error=OSError)
        pathlib.Path("broken.exr").write_bytes(b"v/1\1" * 10)
        self.refuse("broken.exr", "", skywave.read_image, "broken.exr")

    def test_scenes_that_cannot_be_rendered(self):
        self.refuse("scene", "no triangle", skywave.render, skywave.Scene(), env=sky())
        self.refuse("scene", "light", skywave.render, skywave.Scene().add_mesh(VERTICES, FACES))

    def test_outputs(self):
        picture = skywave.render("furnace", **SMALL)
        self.refuse("^path$", ".exr, .png or .film", picture.save, "a.jpg")
        self.refuse("^exposure$", "", picture.save, "a.exr", exposure=1)
        self.refuse("none/a.exr", "", picture.save, "none/a.exr", error=OSError)
        self.refuse("none/a.png", "", picture.save, "none/a.png", error=OSError)
        for write in (lambda name: picture.save(name, exposure=1),
                      lambda name: skywave.write_png(name, picture)):
            self.refuse("none/a.png", "No such file", write, "none/a.png", error=skywave.FileError)
        self.refuse("tone", "", picture.save, "a.png", tone="film")
        self.refuse("^tone$", "", skywave.encode_png, picture, tone=3)
        self.refuse("exposure", "", skywave.encode_png, picture, exposure=NAN)
        self.refuse("^exposure$", "", skywave.encode_png, picture, exposure="1")
        self.refuse("^image$", "shape", skywave.encode_png, numpy.ones((4, 4, 2)))
        self.refuse("compare", "size", skywave.compare, picture, numpy.ones((3, 4, 3)))
        self.refuse("^image$", "", skywave.compare, None, picture)
        self.assertEqual(os.listdir(), [])

    def test_converge(self):
        def converge(**options):
            return skywave.converge("gallery", **{"size": (24, 16), "budgets": [1], **options})
        self.refuse("budgets", "", converge, budgets=[0])
        self.refuse("budgets", "", converge, budgets=[])
        for strategies in ("", " "):
            self.refuse("^strategies$", "needs a value", converge, strategies=strategies)
        self.refuse("strateg", "produkt", converge, strategies=["importance", "produkt"])
        self.refuse("^reference_sp$", "did you mean reference_spp", converge, reference_sp=3)

    def test_errors_survive_pickling(self):
        for kind, cls in (("bad-input", skywave.Error), ("io", skywave.FileError)):
            error = cls("a.obj:3: why", kind, "a.obj:3")
            copy = pickle.loads(pickle.dumps(error))
            self.assertEqual((type(copy), str(copy), copy.kind, copy.place),
                             (cls, str(error), kind, "a.obj:3"))
        self.assertTrue(issubclass(skywave.Error, ValueError))

    def test_the_extension_module_checks_what_it_is_given(self):
        scene = skywave.Scene()._core
        for arguments in ((VERTICES.astype(float), FACES), (VERTICES, FACES.astype(int)),
                          (numpy.asfortranarray(VERTICES), FACES), (VERTICES[::2], FACES)):
            with self.assertRaises(TypeError):
                scene.add_mesh(*arguments, None, None, None, 0, "")
        with self.assertRaises(ValueError):
            skywave._core.encode_png(numpy.ones((2, 3, 4), numpy.float32), 0, b"clip")


if __name__ == "__main__":
    unittest.main()
