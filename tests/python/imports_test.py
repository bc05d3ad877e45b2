"""Other packages that bring Embree, oneTBB or OpenEXR live in one process with Skywave;
scripts/test_python_packages.sh installs them."""
import importlib.util
import subprocess
import sys
import tempfile
import unittest

# What each package does once; all of them bring Embree, oneTBB or OpenEXR of their own.
USES = {
    "bpy": """
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.engine, scene.cycles.samples = "CYCLES", 1
scene.render.resolution_x = scene.render.resolution_y = 8
scene.camera = bpy.data.objects.new("c", bpy.data.cameras.new("c"))
scene.collection.objects.link(scene.camera)
bpy.ops.render.render()
""",
    "open3d": """
scene = open3d.t.geometry.RaycastingScene()
scene.add_triangles(open3d.t.geometry.TriangleMesh.from_legacy(
    open3d.geometry.TriangleMesh.create_box()))
ray = open3d.core.Tensor([[.5, .4, -1, 0, 0, 1]], dtype=open3d.core.Dtype.Float32)
assert abs(scene.cast_rays(ray)["t_hit"].item() - 1) < 1e-5
""",
    "embreex": """
import embreex.mesh_construction, embreex.rtcore_scene
scene = embreex.rtcore_scene.EmbreeScene()
triangle = numpy.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]], numpy.float32)
embreex.mesh_construction.TriangleMesh(scene, triangle)
hit = scene.run(numpy.array([[.2, .2, -1]], numpy.float32), numpy.array([[0, 0, 1]], numpy.float32))
assert hit[0] == 0
""",
    "OpenEXR": """
header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
OpenEXR.File(header, {"RGB": numpy.ones((8, 8, 3), numpy.float32)}).write("a.exr")
assert OpenEXR.File("a.exr").channels()["RGB"].pixels.sum() == 192
""",
    "skywave": """
picture = skywave.render("spheres", numpy.ones((4, 8, 3)), size=(16, 16), spp=4)
picture.save("b.exr")
assert (skywave.read_image("b.exr") == picture.rgb).all()
""",
}


class ImportOrders(unittest.TestCase):
    def test_packages_live_in_one_process_whoever_comes_first(self):
        names = [name for name in USES if importlib.util.find_spec(name)]
        self.assertIn("skywave", names)
        for order in [names[i:] + names[:i] for i in range(len(names))] + [names[::-1]]:
            code = ("import numpy, os\nimport " + ", ".join(order)
                    + "".join(USES[name] for name in order)
                    + "print('all done', flush=True)\nos._exit(0)")  # bpy may crash after it
            with self.subTest(order=order), tempfile.TemporaryDirectory() as folder:
                done = subprocess.run([sys.executable, "-B", "-c", code], cwd=folder,
                                      capture_output=True, text=True, check=False)
                self.assertTrue(done.stdout.endswith("all done\n"), done.stderr[-2000:])


if __name__ == "__main__":
    unittest.main()
