"""Pictures of the package are those of the command line, bit by bit."""
import json
import os
import pathlib
import signal
import unittest

import numpy

import skywave
from support import Case, SMALL, exr_channels, sky, write_obj, write_pfm


class RenderTest(Case):
    def test_picture_is_that_of_the_command_line(self):
        self.command("render", "gallery", "--size", "40x30", "--spp", "2", "--strategy", "product",
                     "--max-depth", "3", "--no-mis", "--eye", "0,1,4", "--crop", "24x16+5+7", "-q",
                     "-o", "a.exr")
        picture = skywave.render("gallery", **SMALL, strategy="product", max_depth=3, mis=False,
                                 eye=numpy.array([0, 1, 4]), crop=(24, 16, 5, 7))
        self.assertEqual((picture.width, picture.height), (24, 16))
        self.assertEqual((picture.rgb.shape, picture.rgb.dtype), ((16, 24, 3), numpy.float32))
        self.assertGreater(picture.rgb.mean(), 0.01)
        # The file says where the crop lies in the whole picture.
        self.assert_same_bits(picture.rgb, skywave.read_image("a.exr")[7:23, 5:29])

    def test_layers_and_files_are_those_of_the_command_line(self):
        self.command("render", "lamps", "--size", "40x30", "--spp", "2", "--aovs", "all", "-q",
                     "-o", "a.exr")
        picture = skywave.render("lamps", **SMALL, aovs="all")
        picture.save("b.exr")
        picture.save(pathlib.Path("b.png"))
        channels = exr_channels("a.exr")
        self.assertEqual(exr_channels("b.exr").keys(), channels.keys())
        self.assertEqual(pathlib.Path("a.exr").read_bytes(), pathlib.Path("b.exr").read_bytes())
        self.assertEqual(pathlib.Path("a.png").read_bytes(), pathlib.Path("b.png").read_bytes())
        self.assertEqual(pathlib.Path("a.png").read_bytes(), picture._repr_png_())

        named = {name.rpartition(".")[0] for name in channels} - {""}
        self.assertEqual(set(picture.layers), named)
        letters = {"depth": "Z", "coverage": "V", "albedo": "RGB", "normal": "XYZ", "uv": "UVA"}
        for name, of_layer in letters.items():
            expected = numpy.stack([channels[f"{name}.{letter}"] for letter in of_layer], axis=-1)
            if len(of_layer) == 1:
                expected = expected[:, :, 0]
            self.assert_same_bits(picture.layers[name], expected)

    def test_mattes_are_layers_and_holdouts_have_none(self):
        whole = skywave.render("spheres", **SMALL, aovs="crypto-object")
        held = skywave.render("spheres", **SMALL, aovs="crypto-object", holdout="floor")
        matte = whole.layers["crypto_object00"]
        self.assertEqual(matte.shape, (30, 40, 4))
        self.assertGreater((matte[..., 0] == matte[-1, 0, 0]).sum(), 100)
        self.assertEqual(held.layers["crypto_object00"][-1, 0].tolist(), [0, 0, 0, 0])
        self.assertEqual(held.layers["alpha"][-1, 0], 0)

    def test_pictures_with_catchers_have_alpha(self):
        picture = skywave.render("spheres", **SMALL, catcher="floor")
        picture.save("caught.exr")
        channels = exr_channels("caught.exr")
        self.assertEqual(set(picture.layers), {"alpha", "shadow", "difference"})
        self.assert_same_bits(picture.layers["alpha"], channels["A"])
        self.assertTrue(((picture.layers["alpha"] > 0.1) & (picture.layers["alpha"] < 0.9)).any())

    def test_a_list_of_layers(self):
        picture = skywave.render("furnace", **SMALL, aovs=["albedo", "depth"])
        self.assertEqual(list(picture.layers), ["albedo", "depth"])
        self.assertEqual(picture.layers["albedo"].shape, (30, 40, 3))
        self.assertEqual(picture.layers["depth"].shape, (30, 40))
        for layer in picture.layers.values():
            with self.assertRaisesRegex(ValueError, "read-only"):
                layer[0] = 1

    def test_a_map_may_be_an_array_or_a_picture(self):
        write_obj("mesh.obj")
        write_pfm("map.pfm", sky())
        from_file = skywave.render("mesh.obj", env="map.pfm", env_rotate=31.7, **SMALL)
        self.command("render", "mesh.obj", "--env", "map.pfm", "--env-rotate", "31.7", "--size",
                     "40x30", "--spp", "2", "-q", "-o", "a.exr")
        self.assert_same_bits(from_file.rgb, skywave.read_image("a.exr"))
        for array in (sky(), sky().astype(numpy.float64), numpy.asfortranarray(sky()),
                      skywave.read_image("map.pfm"), numpy.repeat(sky(), 2, axis=1)[:, ::2]):
            picture = skywave.render("mesh.obj", env=array, env_rotate=31.7, **SMALL)
            self.assert_same_bits(picture.rgb, from_file.rgb)
        probe = skywave.render("gallery", camera="latlong", size=(32, 16), spp=1)
        self.assert_same_bits(skywave.render("mesh.obj", env=probe, **SMALL).rgb,
                              skywave.render("mesh.obj", env=probe.rgb.copy(), **SMALL).rgb)

    def test_a_scene_is_not_changed_by_a_render(self):
        write_obj("mesh.obj")
        write_pfm("map.pfm", sky())
        scene = skywave.Scene("mesh.obj")
        first = skywave.render(scene, env=sky(), **SMALL)
        with self.assertRaises(skywave.Error):
            skywave.render(scene, **SMALL)  # nothing shines
        again = skywave.render(scene, env="map.pfm", threads=1, **SMALL)
        self.assert_same_bits(first.rgb, again.rgb)

    def test_options_of_reading_go_to_the_reader(self):
        pathlib.Path("scene.pbrt").write_text('WorldBegin\nLightSource "infinite"\n'
                                              'Material "quux"\nShape "sphere"\n')
        with self.assertRaisesRegex(skywave.Error, "scene.pbrt:3"):
            skywave.render("scene.pbrt", strict=True, **SMALL)
        skywave.render("scene.pbrt", strict=False, **SMALL)
        with self.assertRaisesRegex(skywave.Error, "max_triangles"):
            skywave.Scene("scene.pbrt", max_triangles=0)
        still = skywave.render("scene.pbrt", frame=12.5, fps=25, **SMALL)
        self.assertTrue(any("no animation" in note for note in still.notes), still.notes)

    def test_changes_of_materials_are_a_list(self):
        changes = ["glass=mirror", "plaster=:reflectance=0.8/0.1/0.1"]
        picture = skywave.render("gallery", material=changes, orbit=30, **SMALL)
        joined = skywave.render("gallery", material=";".join(changes), orbit=30, **SMALL)
        self.assert_same_bits(picture.rgb, joined.rgb)
        plain = skywave.render("gallery", orbit=30, **SMALL)
        self.assertFalse(numpy.array_equal(picture.rgb, plain.rgb))

    def test_picture(self):
        write_obj("mesh.obj")
        picture = skywave.render("mesh.obj", sky(), **SMALL)
        self.assert_same_bits(numpy.asarray(picture), picture.rgb)
        self.assertEqual(numpy.asarray(picture, dtype=float).dtype, numpy.float64)
        with self.assertRaises(ValueError):
            picture.rgb[0] = 1
        self.assertIsInstance(picture.statistics, dict)
        self.assertIn("samples", picture.summary)
        self.assertTrue(all(isinstance(note, str) for note in picture.notes))
        picture.save("bright.png", exposure=2, tone="filmic")
        self.assertEqual(pathlib.Path("bright.png").read_bytes(),
                         skywave.encode_png(picture.rgb, exposure=2, tone="filmic"))
        self.assertNotEqual(picture._repr_png_(), skywave.encode_png(picture, exposure=2))
        # Either of both replaces the two options of the render; the other is that of encode_png.
        graded = skywave.render("mesh.obj", sky(), exposure=1, tone="aces", **SMALL)
        for option in ({"exposure": 2}, {"tone": "filmic"}):
            graded.save("one.png", **option)
            self.assertEqual(pathlib.Path("one.png").read_bytes(),
                             skywave.encode_png(graded, **option))

    def test_statistics_have_the_keys_of_the_command_line(self):
        self.command("render", "furnace", "--size", "40x30", "--spp", "2", "-q", "--stats",
                     "a.json")
        keys = json.loads(pathlib.Path("a.json").read_text()).keys()
        statistics = skywave.render("furnace", **SMALL).statistics
        self.assertEqual(keys - {"write_seconds"}, statistics.keys() - {"write_seconds"})

    def test_progress(self):
        shares = []
        skywave.render("gallery", size=(160, 120), spp=32, progress=shares.append)
        self.assertTrue(shares)
        self.assertEqual(shares, sorted(shares))
        self.assertTrue(0 <= shares[0] and shares[-1] <= 1)

    def test_a_stopped_render_goes_on_to_the_same_bits(self):
        picture = {"size": (160, 120), "spp": 48, "threads": 1}
        with self.assertRaises(skywave.Canceled):
            skywave.render("gallery", **picture, checkpoint="a.checkpoint",
                           progress=lambda done: False)
        whole = skywave.render("gallery", **picture)
        resumed = skywave.render("gallery", **picture, checkpoint=pathlib.Path("a.checkpoint"),
                                 resume=True)
        self.assert_same_bits(resumed.rgb, whole.rgb)
        with self.assertRaisesRegex(skywave.Error, "a.checkpoint.*seed"):
            skywave.render("gallery", **picture, seed=1, checkpoint="a.checkpoint", resume=True)
        with self.assertRaisesRegex(skywave.Error, "checkpoint"):
            skywave.render("gallery", **picture, checkpoint=1)

    def test_a_checkpoint_is_written_while_the_render_runs(self):
        # It would take hours. A checkpoint that is not there after 30 s never will be.
        kept = pathlib.Path("a.checkpoint")
        seen = []

        def progress(done):
            seen.append(kept.exists())
            return not (seen[-1] or len(seen) > 300)

        with self.assertRaises(skywave.Canceled):
            skywave.render("gallery", size=(400, 300), spp=1 << 16, checkpoint=kept,
                           checkpoint_seconds=0.01, progress=progress)
        self.assertTrue(seen[-1])

    def test_films_of_parts_are_merged(self):
        for name, samples in (("a.film", "0:1"), ("b.film", "1:2")):
            skywave.render("gallery", **SMALL, sample_range=samples).save(name)
        self.command("merge", "b.film", "a.film", "-o", "merged.exr", "-q")
        skywave.render("gallery", **SMALL).save("whole.exr")
        self.assertEqual(pathlib.Path("merged.exr").read_bytes(),
                         pathlib.Path("whole.exr").read_bytes())

    def test_measures_are_those_of_the_command_line(self):
        write_pfm("map.pfm", sky())
        for name, seed in (("a.exr", "1"), ("b.exr", "2")):
            self.command("render", "gallery", "--size", "40x30", "--spp", "1", "--seed", seed, "-q",
                         "-o", name)
        self.command("compare", "a.exr", "b.exr", "--json", "compare.json")
        expected = json.loads(pathlib.Path("compare.json").read_text())
        self.assertEqual(skywave.compare("a.exr", "b.exr"), expected)
        self.assertEqual(skywave.compare(skywave.read_image("a.exr"), "b.exr"), expected)
        self.assertEqual(skywave.compare("a.exr", "a.exr")["mse"], 0)
        self.command("probe", "info", "map.pfm", "--json", "probe.json")
        expected = json.loads(pathlib.Path("probe.json").read_text())
        measured = skywave.probe(sky())
        self.assertEqual({key: value for key, value in measured.items() if key in expected
                          and isinstance(value, (int, float)) and not isinstance(value, bool)},
                         {key: value for key, value in expected.items()
                          if isinstance(value, (int, float)) and not isinstance(value, bool)})

    def test_converge(self):
        shares = []
        table = skywave.converge("gallery", strategies=["importance", "product"], budgets=[1, 2],
                                 repeats=2, size=(24, 16), reference_spp=8, progress=shares.append)
        self.assertIsInstance(table, dict)
        text = json.dumps(table)
        self.assertIn("importance", text)
        self.assertIn("product", text)
        table = skywave.converge("gallery", integrators=["path", "direct"], budgets=[1], repeats=2,
                                 size=(24, 16), reference_spp=8)
        self.assertEqual([contestant["integrator"] for contestant in table["strategies"]],
                         ["path", "direct"])

    def test_processes_that_are_forked_render_too(self):
        expected = skywave.render("spheres", sky(), **SMALL).rgb
        child = os.fork()
        if child == 0:  # as multiprocessing does
            signal.alarm(60)
            same = (skywave.render("spheres", sky(), **SMALL).rgb == expected).all()
            os._exit(0 if same else 1)
        self.assertEqual(os.waitpid(child, 0)[1], 0)

    def test_version(self):
        self.assertTrue(skywave.version().startswith(skywave.__version__ + " (Embree "))


if __name__ == "__main__":
    unittest.main()
