// Renders exported lights in POV-Ray and Blender and compares them with irradiance computed from
// the list.
//
// The scene is a diffuse sphere, which casts no shadow on itself because it is convex: its radiance
// at normal n is rho / pi * sum of E max(0, n . d). POV-Ray agrees to 1 % (its Radiance files have
// 8 bits), Cycles to 2 % (faceted sphere, noise). Tests are skipped if the program is not
// installed.
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <numbers>
#include <string>

#include "base/files.h"
#include "lights/light_sets/probe_lights.h"
#include "lights/probe/calibration.h"
#include "lights/probe/export_lights.h"
#include "tests/support/light_test_maps.h"

namespace skywave {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kAlbedo = 0.5;
constexpr int kPixels = 64;      // side of a picture
constexpr double kExtent = 2.2;  // width that a picture shows; the sphere has radius 1

bool IsInstalled(const char* program) {
  return std::system(("command -v " + std::string(program) + " > /dev/null 2>&1").c_str()) == 0;
}

class RenderedExport : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("skywave_export_" + std::to_string(getpid()) + "_" +
               testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string File(const std::string& name) const { return (folder_ / name).string(); }
  // Runs a command in the temporary folder.
  void Execute(const std::string& command) const {
    const std::string whole =
        "cd '" + folder_.string() + "' && " + command + " > log.txt 2>&1 < /dev/null";
    ASSERT_EQ(std::system(whole.c_str()), 0) << ReadFile(File("log.txt"));
  }

  std::filesystem::path folder_;
};

std::vector<DirectionalLight> Lights() {
  const Image image = test::SunMap(128, 64, 2000);
  return MakeProbeLights(MakeSphereMap(image),
                         {.lights = {.source = LightSource::kVarianceCut, .lights = 8}})
      .set.lights;
}

// Returns the mean difference over the mean radiance. The view space of normals is x right, y up, z
// towards the eye.
double Error(const Image& image, const std::vector<DirectionalLight>& lights, LightFormat format,
             const std::function<Vector3(const Vector3&)>& world_from_view) {
  const WorldAxes axes = AxesOf(format);
  double difference = 0, level = 0;
  for (int py = 0; py < kPixels; ++py) {
    for (int px = 0; px < kPixels; ++px) {
      const double x = ((px + 0.5) / kPixels - 0.5) * kExtent;
      const double y = (0.5 - (py + 0.5) / kPixels) * kExtent;
      if (x * x + y * y > 0.9 * 0.9) continue;
      const Vector3 normal = world_from_view({x, y, std::sqrt(1 - x * x - y * y)});
      std::array<double, 3> expected = {};
      for (const DirectionalLight& light : lights) {
        const double cosine = std::max(0.0, Dot(normal, axes.ToWorld(light.direction)));
        for (int c = 0; c < 3; ++c) expected[c] += kAlbedo / kPi * light.irradiance[c] * cosine;
      }
      for (int c = 0; c < 3; ++c) {
        difference += std::abs(image.Pixel(px, py)[c] - expected[c]);
        level += expected[c];
      }
    }
  }
  return difference / level;
}

TEST_F(RenderedExport, PovrayShowsTheSameIrradiance) {
  if (!IsInstalled("povray")) GTEST_SKIP() << "povray is not installed";
  const std::vector<DirectionalLight> lights = Lights();
  WriteFileAtomically(File("lights.inc"), ExportLights(lights, {.format = LightFormat::kPovray}));
  for (const double side : {-1.0, 1.0}) {  // position of the camera along z
    WriteFileAtomically(
        File("scene.pov"),
        "#version 3.7;\nglobal_settings { assumed_gamma 1 }\n#include \"lights.inc\"\n"
        "camera { orthographic location <0,0," +
            std::to_string(5 * side) + "> look_at <0,0,0> right x*" + std::to_string(kExtent) +
            " up y*" + std::to_string(kExtent) + " }\nsphere { 0, 1 pigment { rgb " +
            std::to_string(kAlbedo) + " } finish { ambient 0 diffuse 1 } }\n");
    const std::string size = std::to_string(kPixels);
    Execute("povray +Iscene.pov +Oout.hdr +FH +W" + size + " +H" + size + " -D -GA +L.");
    if (HasFatalFailure()) return;
    const Image image = ReadImage(File("out.hdr"));
    // In a left-handed world an eye at -z has +x on its right.
    const double error = Error(image, lights, LightFormat::kPovray, [&](const Vector3& v) {
      return Vector3{-side * v.x, v.y, side * v.z};
    });
    EXPECT_LT(error, 0.01);
    RecordProperty(side < 0 ? "error_front" : "error_back", std::to_string(error));
  }
}

constexpr const char* kBlenderScene = R"(import bpy, sys, math
from mathutils import Vector
for thing in list(bpy.data.objects):
    bpy.data.objects.remove(thing)
scene = bpy.context.scene
scene.render.engine = 'CYCLES'
scene.cycles.device = 'CPU'
scene.cycles.use_denoising = False
scene.cycles.use_adaptive_sampling = False
scene.cycles.max_bounces = 0
scene.cycles.sample_clamp_direct = 0
scene.world.use_nodes = True
scene.world.node_tree.nodes['Background'].inputs['Color'].default_value = (0, 0, 0, 1)
scene.render.resolution_percentage = 100
scene.render.image_settings.file_format = 'OPEN_EXR'
scene.render.image_settings.color_depth = '32'
eye = bpy.data.objects.new('eye', bpy.data.cameras.new('eye'))
scene.collection.objects.link(eye)
scene.camera = eye
exec(open('lights.py').read())
def render(name, size, samples):
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.cycles.samples = samples
    scene.render.filepath = name
    bpy.ops.render.render(write_still=True)
)";

TEST_F(RenderedExport, BlenderShowsTheSameIrradiance) {
  if (!IsInstalled("blender")) GTEST_SKIP() << "blender is not installed";
  const std::vector<DirectionalLight> lights = Lights();
  WriteFileAtomically(File("lights.py"), ExportLights(lights, {.format = LightFormat::kBlender}));
  WriteFileAtomically(
      File("scene.py"),
      std::string(kBlenderScene) +
          "bpy.ops.mesh.primitive_uv_sphere_add(segments=256, ring_count=128, radius=1)\n"
          "ball = bpy.context.object\n"
          "stuff = bpy.data.materials.new('stuff')\nstuff.use_nodes = True\n"
          "nodes = stuff.node_tree.nodes\n"
          "nodes.clear()\n"
          "diffuse, out = nodes.new('ShaderNodeBsdfDiffuse'), "
          "nodes.new('ShaderNodeOutputMaterial')\n"
          "diffuse.inputs['Color'].default_value = (0.5, 0.5, 0.5, 1)\n"
          "stuff.node_tree.links.new(diffuse.outputs[0], out.inputs['Surface'])\n"
          "ball.data.materials.append(stuff)\n"
          "eye.data.type, eye.data.ortho_scale = 'ORTHO', " +
          std::to_string(kExtent) +
          "\n"
          "eye.location, eye.rotation_euler = (0, -5, 0), (math.pi / 2, 0, 0)\n"
          "render('out.exr', " +
          std::to_string(kPixels) + ", 1024)\n");
  Execute("blender -b --factory-startup -noaudio --python-exit-code 1 --python scene.py");
  if (HasFatalFailure()) return;
  const double error =
      Error(ReadImage(File("out.exr")), lights, LightFormat::kBlender, [](const Vector3& v) {
        return Vector3{v.x, -v.z, v.y};
      });
  EXPECT_LT(error, 0.02);
  RecordProperty("error", std::to_string(error));
}

// The residual map, as Blender's world, must be oriented like the lights.
TEST_F(RenderedExport, BlenderOrientsTheResidualMapLikeTheLights) {
  if (!IsInstalled("blender")) GTEST_SKIP() << "blender is not installed";
  WriteExr(File("rest.exr"), CalibrationMap(128));
  WriteFileAtomically(File("lights.py"), ExportLights({}, {.format = LightFormat::kBlender,
                                                           .residual = File("rest.exr")}));
  std::string script = kBlenderScene;
  script += "eye.data.angle = math.radians(1)\neye.rotation_mode = 'QUATERNION'\n";
  const WorldAxes axes = AxesOf(LightFormat::kBlender);
  for (int i = 0; i < 6; ++i) {
    // Blender interpolates the first row with the last, so the pole itself would show both.
    Vector3 look = kCalibrationAxes[i].direction;
    if (look.z != 0) look.y = 0.06;
    const Vector3 d = axes.ToWorld(look);
    script += "eye.rotation_quaternion = Vector((" + std::to_string(d.x) + ", " +
              std::to_string(d.y) + ", " + std::to_string(d.z) + ")).to_track_quat('-Z', 'Y')\n" +
              "render('axis" + std::to_string(i) + ".exr', 4, 1)\n";
  }
  WriteFileAtomically(File("scene.py"), script);
  Execute("blender -b --factory-startup -noaudio --python-exit-code 1 --python scene.py");
  if (HasFatalFailure()) return;
  for (int i = 0; i < 6; ++i) {
    const Image seen = ReadImage(File("axis" + std::to_string(i) + ".exr"));
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(seen.Pixel(2, 2)[c], kCalibrationAxes[i].radiance[c], 0.02)
          << kCalibrationAxes[i].name;
    }
  }
}

}  // namespace
}  // namespace skywave
