"""An independent decoder of Cryptomatte reads back what was rendered;
scripts/test_python_packages.sh installs it."""
import unittest

import cryptomatte_api
import numpy

import skywave
from support import Case, FACES, VERTICES, sky

SIZE = (40, 30)


def scene():
    """Returns two pyramids, one before the other, of two materials, whose names are no ASCII."""
    scene = skywave.Scene()
    materials = [scene.add_material(name=name) for name in ("brick", "grüner Lack")]
    for name, place, material in (("left", [-0.8, 0, 0], 0), ("right", [0.5, 0, 1], 1),
                                  ("far", [0.2, 1, -2], 0)):
        scene.add_mesh(VERTICES + numpy.float32(place), FACES, name=name,
                       material=materials[material])
    return scene.set_camera((0, 1.5, 6), (0, 0.7, 0))


def masks(path):
    """Returns the masks of each matte of a file, by name."""
    return {matte.metadata().name(): {name: numpy.asarray(mask)
                                                     for name, mask in matte.masks().items()}
            for matte in cryptomatte_api.Cryptomatte.load(path, load_preview=False)}


class MattesTest(Case):
    def test_one_sample_a_pixel_is_the_object_that_it_sees(self):
        picture = skywave.render(scene(), env=sky(), size=SIZE, spp=1, filter="box",
                                 aovs=["crypto-object", "crypto-material", "object-id",
                                       "material-id"])
        picture.save("a.exr")
        read = masks("a.exr")
        for layer, names, matte in (("object-id", picture.object_names, "crypto_object"),
                                    ("material-id", picture.material_names, "crypto_material")):
            ids = numpy.squeeze(picture.layers[layer])
            seen = {name: ids == number + 1 for number, name in enumerate(names)
                    if (ids == number + 1).any()}
            self.assertEqual(set(read[matte]), set(seen))
            for name, mask in seen.items():
                numpy.testing.assert_array_equal(read[matte][name], mask, name)

    def test_masks_share_the_coverage_of_a_pixel(self):
        skywave.render(scene(), env=sky(), size=SIZE, spp=16,
                       aovs=["crypto-object", "crypto-material", "coverage"]).save("a.exr")
        picture = skywave.render(scene(), env=sky(), size=SIZE, spp=16, aovs=["coverage"])
        coverage = numpy.squeeze(picture.layers["coverage"])
        self.assertTrue(((coverage > 0.1) & (coverage < 0.9)).any())
        for matte in masks("a.exr").values():
            numpy.testing.assert_allclose(sum(matte.values()), coverage, atol=2e-6)

    def test_parts_of_a_picture_have_the_masks_of_the_whole(self):
        for name, samples in (("a.film", "0:8"), ("b.film", "8:16")):
            skywave.render(scene(), env=sky(), size=SIZE, spp=16, sample_range=samples,
                           aovs=["crypto-object"]).save(name)
        self.command("merge", "a.film", "b.film", "-o", "merged.exr")
        skywave.render(scene(), env=sky(), size=SIZE, spp=16, aovs=["crypto-object"]).save("a.exr")
        merged, whole = masks("merged.exr"), masks("a.exr")
        self.assertEqual(merged.keys(), whole.keys())
        for name, mask in whole["crypto_object"].items():
            numpy.testing.assert_array_equal(merged["crypto_object"][name], mask, name)


if __name__ == "__main__":
    unittest.main()
