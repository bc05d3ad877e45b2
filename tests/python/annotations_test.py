"""Annotations agree with exact values of simple scenes and with counts of their own."""
import json
import pathlib
import struct
import subprocess
import sys
import unittest
import zlib

import numpy

import skywave
from skywave import annotations
from support import Case, sky


def decoded_runs(runs):
    """Returns the mask of COCO's run lengths, value by value."""
    height, width = runs["size"]
    values = []
    for i, count in enumerate(runs["counts"]):
        values += [i % 2] * count
    return [[values[x * height + y] for x in range(width)] for y in range(height)]


def read_png16(path):
    data = pathlib.Path(path).read_bytes()
    width, height, depth, color = struct.unpack(">IIBB", data[16:26])
    assert (depth, color) == (16, 0)
    at = data.index(b"IDAT")
    size, = struct.unpack(">I", data[at - 4:at])
    raw = zlib.decompress(data[at + 4:at + 4 + size])
    line = 1 + 2 * width
    return [list(struct.unpack(f">{width}H", raw[y * line + 1:(y + 1) * line]))
            for y in range(height)]


def square(x, y, z, side):
    """Returns a square that faces +z, with its corner at (x, y, z)."""
    points = [[x, y, z], [x + side, y, z], [x + side, y + side, z], [x, y + side, z]]
    return points, [[0, 1, 2], [0, 2, 3]]


class FlowTest(Case):
    def test_flow_files_have_motions_and_say_where_there_is_none(self):
        flow = numpy.zeros((2, 3, 3), numpy.float32)
        flow[1, 2] = [1.5, -2.25, 1]
        annotations.write_flow("a.flo", flow)
        data = pathlib.Path("a.flo").read_bytes()
        self.assertEqual(struct.unpack("<fii", data[:12]), (202021.25, 3, 2))
        values = numpy.frombuffer(data[12:], "<f4").reshape(2, 3, 2)
        self.assertEqual(values[1, 2].tolist(), [1.5, -2.25])
        self.assertTrue((values[0] > 1e9).all())
        with self.assertRaisesRegex(skywave.Error, "flow: its shape"):
            annotations.write_flow("b.flo", flow[..., :2])


class FilesTest(Case):
    def scene(self):
        scene = skywave.Scene()
        scene.add_mesh(*square(-1, -1, 0, 2), name="plate")
        scene.add_mesh(*square(1.5, -1, 1, 0.5), name="chip")
        pose = numpy.array([[0.8, 0, -0.6, 4.5], [0, -1, 0, 0.25], [-0.6, 0, -0.8, 6],
                            [0, 0, 0, 1]])
        camera = skywave.Camera([[60, 0, 20.5], [0, 62, 13], [0, 0, 1]], pose, (40, 30))
        return scene.set_camera(camera), camera

    def test_transforms_are_read_back_as_the_same_camera(self):
        scene, camera = self.scene()
        annotations.write_transforms("transforms.json", {"a.png": camera, "b.png": camera})
        options = {"spp": 2, "aovs": ["position"]}
        one = skywave.render(scene, sky(), **options)
        other = skywave.render(scene, sky(), camera_from="transforms.json", scene_camera="b.png",
                               **options)
        self.assertEqual((other.width, other.height), (40, 30))
        numpy.testing.assert_allclose(other.layers["position"], one.layers["position"], atol=1e-4)
        skewed = skywave.Camera([[60, 1, 20.5], [0, 62, 13], [0, 0, 1]],
                                camera.world_from_camera, (40, 30))
        with self.assertRaisesRegex(skywave.Error, "c.png is skewed"):
            annotations.write_transforms("t.json", {"c.png": skewed})
        self.assertFalse(pathlib.Path("t.json").exists())

    def test_files_of_colmap_are_read_back_as_the_same_cameras(self):
        scene, camera = self.scene()
        rolled = numpy.array(camera.world_from_camera)
        rolled[:3, :3] = rolled[:3, :3] @ numpy.diag([-1, -1, 1])
        cameras = {"0.png": camera, "1.png": skywave.Camera(camera.K, rolled, camera.size)}
        annotations.write_colmap("sparse/0", cameras)
        lines = pathlib.Path("sparse/0/cameras.txt").read_text().splitlines()
        self.assertEqual(lines, ["1 PINHOLE 40 30 60 62 21 13.5"])
        for name, seen_by in cameras.items():
            options = {"spp": 1, "aovs": ["position", "depth"]}
            one = skywave.render(scene.copy().set_camera(seen_by), sky(), **options)
            other = skywave.render(scene, sky(), camera_from="sparse/0", scene_camera=name,
                                   **options)
            self.assertGreater((one.layers["depth"] < 100).sum(), 200)
            numpy.testing.assert_allclose(other.layers["depth"], one.layers["depth"], rtol=1e-5)
            numpy.testing.assert_allclose(other.layers["position"], one.layers["position"],
                                          atol=1e-4)
        with self.assertRaisesRegex(skywave.Error, "has spaces"):
            annotations.write_colmap("c", {"a b.png": camera})
        self.assertFalse(pathlib.Path("c").exists())

    def test_rotations_of_colmap_are_quaternions(self):
        def turn_of(quaternion):
            w, x, y, z = quaternion
            return numpy.array([
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])

        random = numpy.random.default_rng(1)
        for largest in range(4):  # each component is the largest one in turn
            for _ in range(20):
                quaternion = random.normal(size=4) + 4 * numpy.eye(4)[largest]
                quaternion /= numpy.linalg.norm(quaternion)
                pose = numpy.eye(4)
                pose[:3, :3] = turn_of(quaternion).T
                camera = skywave.Camera(numpy.diag([9, 9, 1]), pose, (8, 8))
                annotations.write_colmap("q", {"a": camera})
                line = pathlib.Path("q/images.txt").read_text().split()
                written = numpy.array(line[1:5], float)
                numpy.testing.assert_allclose(turn_of(written), turn_of(quaternion), atol=1e-12)

    def test_object_coordinates_are_places_in_the_box_of_a_model(self):
        scene, camera = self.scene()
        picture = skywave.render(scene, sky(), spp=1, filter="box",
                                 aovs=["object-id", "position"])
        # The plate is 2 wide; its model is 4 wide, lies on its side and is half as large here.
        pose = 0.5 * numpy.array([[0.0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 2]])
        found = annotations.object_coordinates(
            picture, {"plate": (pose, [-2, -2, -1], [2, 2, 1])})
        plate = picture.layers["object-id"] == 1
        self.assertGreater(plate.sum(), 100)
        self.assertTrue(numpy.isnan(found[~plate]).all())
        x, y = picture.layers["position"][plate][:, :2].T
        numpy.testing.assert_allclose(found[plate], numpy.stack(
            [(y + 1) / 2, (1 - x) / 2, numpy.full_like(x, 0.5)], axis=1), atol=1e-5)
        with self.assertRaisesRegex(skywave.Error, "no object 'cup', but plate, chip"):
            annotations.object_coordinates(picture, {"cup": (pose, [0] * 3, [1] * 3)})

    def test_a_scene_of_bop_has_poses_depths_and_masks(self):
        scene, camera = self.scene()
        picture = skywave.render(scene, sky(), spp=2, aovs=["object-id", "depth"])
        bop = annotations.Bop("train/000000", metres=0.01)
        model = numpy.eye(4)
        model[:3, 3] = [0.5, 0.25, 0]
        self.assertEqual(bop.add(picture, camera, {"plate": (7, model)}), 0)
        bop.save()
        folder = pathlib.Path("train/000000")
        truth, = json.loads((folder / "scene_gt.json").read_text())["0"]
        self.assertEqual(truth["obj_id"], 7)
        seen = json.loads((folder / "scene_camera.json").read_text())["0"]
        # The corner (1, 1, 0) of the plate is at (0.5, 0.75, 0) of the model.
        R, t = numpy.array(truth["cam_R_m2c"]).reshape(3, 3), numpy.array(truth["cam_t_m2c"])
        at = R @ numpy.array([0.5, 0.75, 0]) * 10 + t  # a unit is 10 mm
        pose = numpy.asarray(camera.world_from_camera)
        expected = 10 * pose[:3, :3].T @ ([1, 1, 0] - pose[:3, 3])
        numpy.testing.assert_allclose(at, expected, atol=1e-9)
        mask = picture.layers["object-id"] == 1
        row, column = [int(i) for i in numpy.argwhere(mask)[len(numpy.argwhere(mask)) // 2]]
        depth = read_png16(folder / "depth/000000.png")[row][column] * seen["depth_scale"]
        self.assertAlmostEqual(depth, 10 * picture.layers["depth"][row, column], delta=0.051)
        path = folder / "mask_visib/000000_000000.png"
        self.assertEqual(struct.unpack(">IIBB", path.read_bytes()[16:26]), (40, 30, 8, 0))
        numpy.testing.assert_array_equal(lines_of(path), numpy.where(mask, 255, 0))
        self.assertFalse((folder / "scene_gt_info.json").exists())
        self.assertTrue((folder / "rgb/000000.png").exists())
        with self.assertRaisesRegex(skywave.Error, "no object 'cup', but plate, chip"):
            bop.add(picture, camera, {"cup": (1, model)})
        with self.assertRaisesRegex(skywave.Error, "plate: .*no rotation"):
            bop.add(picture, camera, {"plate": (1, 2 * model)})

    def test_a_picture_that_bop_cannot_hold_leaves_nothing(self):
        scene, camera = self.scene()
        picture = skywave.render(scene, sky(), spp=1, aovs=["object-id", "depth"])
        bop = annotations.Bop("far", metres=1000)
        with self.assertRaisesRegex(skywave.Error, "more than 65535 steps"):
            bop.add(picture, camera, {})
        small = skywave.render(scene, sky(), spp=1, size=(20, 15), aovs=["object-id", "depth"])
        with self.assertRaisesRegex(skywave.Error, "40 x 30 pixels, and this one is of 20 x 15"):
            annotations.Bop("far").add(small, camera, {})
        self.assertEqual([path for path in pathlib.Path("far").rglob("*") if path.is_file()], [])
        pathlib.Path("file").write_text("")
        with self.assertRaisesRegex(skywave.FileError, "file"):
            annotations.Bop("file")


def lines_of(path):
    """Returns the grey PNG of 8 bits that write_mask writes."""
    data = pathlib.Path(path).read_bytes()
    width, height = struct.unpack(">II", data[16:24])
    raw = zlib.decompress(data[data.index(b"IDAT") + 4:])
    return numpy.frombuffer(raw, numpy.uint8).reshape(height, width + 1)[:, 1:]


class SilhouettesTest(Case):
    LAYERS = ["object-id", "hidden-id", "depth"]

    def setUp(self):
        super().setUp()
        # A wall of which a plate hides a part, and a chip behind both that is not seen.
        self.parts = {"wall": square(-2, -2, 0, 4), "plate": square(0, -1.92, 2, 1.44),
                      "chip": square(0.1, -1.8, -1, 1.2)}
        pose = numpy.diag([1.0, -1, -1, 1])
        pose[2, 3] = 10
        self.camera = skywave.Camera(numpy.array([[50.0, 0, 19.5], [0, 50, 14.5], [0, 0, 1]]), pose,
                                     (40, 30))

    def picture(self, *names):
        scene = skywave.Scene()
        for name in names:
            scene.add_mesh(*self.parts[name], name=name)
        return skywave.render(scene.set_camera(self.camera), sky(), spp=1, filter="box",
                              aovs=self.LAYERS)

    def test_a_silhouette_is_the_mask_of_the_object_alone(self):
        picture = self.picture(*self.parts)
        for name in self.parts:
            alone = self.picture(name).layers["object-id"] == 1
            self.assertGreater(alone.sum(), 10)
            numpy.testing.assert_array_equal(annotations.silhouette(picture, name), alone, name)
        with self.assertRaisesRegex(skywave.Error, "no object 'cup', but wall, plate, chip"):
            annotations.silhouette(picture, "cup")
        with self.assertRaisesRegex(skywave.Error, "no layer hidden-id"):
            annotations.silhouette(skywave.render("spheres", sky(), spp=1, size=(8, 6),
                                                  aovs=["object-id"]), "red")

    def test_visibility_is_the_share_of_a_silhouette_that_is_seen(self):
        picture = self.picture(*self.parts)
        ids = picture.layers["object-id"]
        wall = (self.picture("wall").layers["object-id"] == 1).sum()
        self.assertEqual(annotations.visibility(picture),
                         {"wall": (ids == 1).sum() / wall, "plate": 1.0, "chip": 0.0})
        self.assertLess((ids == 1).sum(), wall)
        coco = annotations.Coco({"thing": "*"})
        coco.add("a.png", picture)
        self.assertEqual({a["object"]: a["visibility"] for a in coco.annotations},
                         {"wall": (ids == 1).sum() / wall, "plate": 1.0})

    def test_meshes_of_one_name_have_one_silhouette(self):
        left, right = square(-1.5, -1, 0, 1), square(0.5, -1, 0, 1)
        scene = skywave.Scene().add_mesh(*left, name="pair").add_mesh(*right, name="pair")
        scene.add_mesh(*square(0.2, -1.6, 2, 1.5), name="plate").set_camera(self.camera)
        picture = skywave.render(scene, sky(), spp=1, filter="box", aovs=self.LAYERS)
        pair = skywave.Scene().add_mesh(*left).add_mesh(*right).set_camera(self.camera)
        alone = skywave.render(pair, sky(), spp=1, filter="box", aovs=self.LAYERS)
        whole = alone.layers["object-id"] > 0
        numpy.testing.assert_array_equal(annotations.silhouette(picture, "pair"), whole)
        ids = picture.layers["object-id"]
        self.assertEqual(annotations.visibility(picture),
                         {"pair": ((ids == 1) | (ids == 2)).sum() / whole.sum(), "plate": 1.0})
        self.assertLess(annotations.visibility(picture)["pair"], 0.9)

    def test_bop_has_silhouettes_and_counts(self):
        picture = self.picture(*self.parts)
        bop = annotations.Bop("scene", metres=0.1)
        bop.add(picture, self.camera,
                {name: (i, numpy.eye(4)) for i, name in enumerate(self.parts)})
        bop.save()
        infos = json.loads(pathlib.Path("scene/scene_gt_info.json").read_text())["0"]
        self.assertEqual(len(infos), 2)  # the chip is not seen
        for i, name in enumerate(("wall", "plate")):
            whole = self.picture(name).layers["object-id"] == 1
            seen = picture.layers["object-id"] == i + 1
            y, x = numpy.nonzero(whole)
            self.assertEqual(infos[i]["bbox_obj"], [x.min(), y.min(), x.max() - x.min() + 1,
                                                    y.max() - y.min() + 1])
            self.assertEqual((infos[i]["px_count_all"], infos[i]["px_count_visib"],
                              infos[i]["px_count_valid"]), (whole.sum(), seen.sum(), whole.sum()))
            self.assertAlmostEqual(infos[i]["visib_fract"], seen.sum() / whole.sum())
            numpy.testing.assert_array_equal(lines_of(f"scene/mask/000000_00000{i}.png"),
                                             numpy.where(whole, 255, 0))


class AnnotationsTest(Case):
    def picture(self, **options):
        """A wall at z = 0, half of it hidden by a plate at z = 2; the camera is at z = 10, and its
        picture of 40 x 30 pixels shows 8 x 6 in the plane of the wall."""
        scene = skywave.Scene()
        scene.add_mesh(*square(-2, -2, 0, 4), name="wall")
        scene.add_mesh(*square(0, -1.92, 2, 1.44), name="plate 7")
        K = numpy.array([[50.0, 0, 19.5], [0, 50, 14.5], [0, 0, 1]])
        pose = numpy.diag([1.0, -1, -1, 1])
        pose[2, 3] = 10
        scene.set_camera(skywave.Camera(K, pose, (40, 30)))
        return skywave.render(scene, sky(), spp=4, filter="box",
                              aovs=["object-id", "depth", "distance", "uv"], **options)

    def test_boxes_masks_and_areas_are_those_of_the_geometry(self):
        picture = self.picture()
        self.assertEqual(picture.object_names, ["wall", "plate 7"])
        ids = picture.layers["object-id"]
        # A pixel is 0.2 wide at the wall and 0.16 at the plate.
        self.assertEqual(annotations.boxes(ids), {1: (10, 5, 20, 20), 2: (20, 18, 9, 9)})
        coco = annotations.Coco({"sheet": "pl?te*", "wall": ["nothing", "wall"]})
        self.assertEqual(coco.add("a.png", picture), 2)
        self.assertEqual(coco.add("b.png", picture), 2)
        coco.save("coco.json")
        with open("coco.json", encoding="utf-8") as file:
            saved = json.load(file)
        self.assertEqual([c["name"] for c in saved["categories"]], ["sheet", "wall"])
        self.assertEqual([(a["image_id"], a["category_id"], a["object"])
                          for a in saved["annotations"]],
                         [(1, 2, "wall"), (1, 1, "plate 7"), (2, 2, "wall"), (2, 1, "plate 7")])
        for annotation, number in zip(saved["annotations"], (1, 2)):
            mask = decoded_runs(annotation["segmentation"])
            self.assertEqual(mask, (ids == number).astype(int).tolist())
            self.assertEqual(annotation["area"], sum(map(sum, mask)))
        self.assertEqual(len({a["id"] for a in saved["annotations"]}), 4)

    def test_a_film_of_another_shape_shows_more_of_the_scene(self):
        ids = self.picture(size=(80, 30)).layers["object-id"]
        self.assertEqual(annotations.boxes(ids), {1: (30, 5, 20, 20), 2: (40, 18, 9, 9)})

    def test_depths_are_exact(self):
        picture = self.picture()
        ids = picture.layers["object-id"]
        # Away from edges, all samples of a pixel see the same object.
        inner = numpy.zeros_like(ids, dtype=bool)
        inner[7:17, 12:28] = True
        depth, distance = picture.layers["depth"], picture.layers["distance"]
        numpy.testing.assert_allclose(depth[inner], 10, atol=1e-4)
        numpy.testing.assert_allclose(depth[19:26, 21:28], 8, atol=1e-4)
        y, x = numpy.nonzero(inner)
        exact = 10 * numpy.sqrt(1 + ((x - 19.5) / 50)**2 + ((y - 14.5) / 50)**2)
        numpy.testing.assert_allclose(distance[inner], exact, atol=0.01)
        annotations.write_depth("depth.png", depth)
        steps = numpy.array(read_png16("depth.png"))
        self.assertEqual(steps[10, 14], 10000)
        self.assertEqual(steps[22, 24], 8000)
        self.assertEqual(steps[0, 0], 0)

    def test_run_lengths_begin_with_zeros(self):
        for mask, counts in (([[0, 1], [0, 1]], [2, 2]), ([[1, 0], [1, 1]], [0, 2, 1, 1]),
                             ([[0, 0]], [2]), ([[1], [1]], [0, 2])):
            runs = annotations.run_lengths(numpy.array(mask))
            self.assertEqual(runs["counts"], counts)
            self.assertEqual(decoded_runs(runs), mask)

    def test_png_keep_all_bits(self):
        values = numpy.array([[0, 1, 255], [256, 65534, 65535]])
        annotations.write_png16("ids.png", values)
        self.assertEqual(read_png16("ids.png"), values.tolist())

    def test_the_example_makes_the_same_pictures_in_two_runs(self):
        example = pathlib.Path(__file__).resolve().parents[2] / "examples/dataset.py"

        def run(*arguments):
            subprocess.run([sys.executable, "-B", example, "--size", "32", "--spp", "8",
                            *map(str, arguments)], check=True, stdout=subprocess.DEVNULL)

        run("--pictures", 2, "-o", "whole")
        run("--pictures", 1, "-o", "parts")
        run("--pictures", 1, "--first", 1, "-o", "parts")
        pictures = sorted(path.name for path in pathlib.Path("whole").glob("*.png"))
        self.assertEqual(len(pictures), 6)
        for name in pictures:
            self.assertEqual(pathlib.Path("whole", name).read_bytes(),
                             pathlib.Path("parts", name).read_bytes(), name)
        coco = json.loads(pathlib.Path("whole/annotations_0000.json").read_text())
        ids = numpy.array(read_png16("whole/0001_objects.png"))
        of_second = [a for a in coco["annotations"] if a["image_id"] == 2]
        self.assertEqual(sum(a["area"] for a in of_second), (ids > 1).sum())  # 1 is the table

    def test_what_does_not_fit_is_refused(self):
        def refuse(word, function, *arguments):
            with self.assertRaisesRegex(skywave.Error, word):
                function(*arguments)

        refuse("65535", annotations.write_png16, "x.png", [[65536]])
        refuse("65535", annotations.write_png16, "x.png", [[0.5]])
        refuse("shape", annotations.write_png16, "x.png", [1, 2])
        refuse("at least 0.00153", annotations.write_depth, "x.png", [[100.0, 1e10]])
        refuse("nosuch", annotations.write_png16, "nosuch/x.png", [[1]])
        picture = self.picture()
        coco = annotations.Coco({"cup": ["cup*"], "wall": "wall"})
        coco.add("a.png", picture)
        with self.assertWarnsRegex(UserWarning, r"'cup' \(cup\*\) takes none .* plate 7, wall"):
            coco.save("coco.json")
        bare = skywave.render("spheres", sky(), size=(8, 6), spp=1)
        refuse("object-id", annotations.Coco({"all": "*"}).add, "a.png", bare)


if __name__ == "__main__":
    unittest.main()
