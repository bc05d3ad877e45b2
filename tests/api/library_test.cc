// Tests the library: its pictures are those of the command line, arrays are what files are, bad
// arguments are refused by name, and callbacks see and stop a render.
#include "skywave/skywave.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "kernels/bsdf/bsdf.h"
#include "tests/support/gltf_document.h"
#include "tests/support/library_scenes.h"
#include "tests/support/program.h"

namespace skywave {
namespace {

class Library : public Program {};

TEST_F(Library, WritesTheFilesOfTheCommandLine) {
  const Options options = With(
      kSmall,
      {{"aovs", "albedo,normal,depth"}, {"exposure", "0.5"}, {"tone", "filmic"}, {"seed", "7"}});
  ASSERT_EQ(Run("render gallery --size 24x16 --spp 4 --max-depth 3 --aovs albedo,normal,depth "
                "--exposure 0.5 --tone filmic --seed 7 -o cli.exr --stats cli.json")
                .exit_code,
            0);
  api::Renderer renderer(api::Scene("gallery"), options);
  renderer.Render();
  renderer.WriteExr(Path("api.exr"));
  renderer.WritePng(Path("api.png"));
  EXPECT_EQ(Bytes("api.exr"), Bytes("cli.exr"));
  EXPECT_EQ(Bytes("api.png"), Bytes("cli.png"));
  const api::Image file = api::ReadImage(Path("cli.exr"));
  EXPECT_EQ(file.width, renderer.width());
  EXPECT_TRUE(SameBits(file.rgb, Pixels(renderer)));
  const auto statistics = nlohmann::json::parse(renderer.Statistics());
  const auto written = nlohmann::json::parse(Bytes("cli.json"));
  EXPECT_EQ(statistics["samples"], written["samples"]);
  EXPECT_EQ(statistics["rays"]["camera"]["count"], written["rays"]["camera"]["count"]);
  EXPECT_EQ(statistics["scene"], written["scene"]);
  EXPECT_NE(renderer.Summary().find("Msamples/s"), std::string::npos);
}

TEST_F(Library, InstancesEqualTransformedCopies) {
  Square square;
  api::Scene copies, instances;
  std::vector<float> moved = square.positions;
  for (std::size_t i = 0; i < moved.size(); i += 3) moved[i] += 2, moved[i + 1] -= 0.5f;
  api::MeshArrays second = square.mesh();
  second.positions = moved;
  copies.AddMesh(square.mesh());
  copies.AddMesh(second);
  const int object = instances.AddObject("square");
  api::MeshArrays part = square.mesh();
  part.object = object;
  instances.AddMesh(part);
  const float matrices[] = {1, 0, 0, 0, 0, 1, 0, 0,     0, 0, 1, 0,
                            1, 0, 0, 2, 0, 1, 0, -0.5f, 0, 0, 1, 0};
  instances.AddInstances(object, matrices);
  EXPECT_EQ(instances.triangles(), square.triangles.size() / 3);
  const auto picture = [&](api::Scene& scene) {
    scene.AddDistantLight({0, 1, 0}, {1, 1, 1});
    api::Renderer renderer(scene, kLookDown);
    renderer.Render();
    return Pixels(renderer);
  };
  EXPECT_TRUE(SameBits(picture(instances), picture(copies)));
  EXPECT_THROW(instances.AddInstances(object + 1, matrices), api::Error);
  EXPECT_THROW(instances.AddInstances(object, std::span(matrices).first(13)), api::Error);
}

TEST_F(Library, GivesTheLayersOfTheOptionAovs) {
  Square square;
  api::Scene scene;
  const int red = scene.AddMaterial("lambert", {{"reflectance", {0.75f, 0.25f, 0.125f}}});
  scene.AddMesh(square.mesh(red));
  scene.AddDistantLight({0, 1, 0}, {1, 1, 1});
  api::Renderer renderer(scene, With(kLookDown, {{"aovs", "depth,albedo"}}));
  renderer.Render();
  std::map<std::string, std::string> channels;
  for (const api::Layer& layer : renderer.layers()) channels[layer.name] = layer.channels;
  EXPECT_EQ(channels, (std::map<std::string, std::string>{{"albedo", "RGB"}, {"depth", "Z"}}));
  std::vector<float> albedo(16 * 3), depth(16);
  renderer.CopyLayer("albedo", albedo);
  renderer.CopyLayer("depth", depth);
  for (std::size_t i = 0; i < 16; ++i) {
    EXPECT_FLOAT_EQ(albedo[3 * i], 0.75f);
    EXPECT_FLOAT_EQ(albedo[3 * i + 1], 0.25f);
    EXPECT_FLOAT_EQ(albedo[3 * i + 2], 0.125f);
    EXPECT_NEAR(depth[i], 2, 1e-3);
  }
}

TEST_F(Library, SceneFromArraysEqualsSceneFromFile) {
  Put("square.ply",
      "ply\nformat ascii 1.0\nelement vertex 4\n"
      "property float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty float ny\nproperty float nz\n"
      "property float u\nproperty float v\n"
      "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
      "-1 0 1 0 1 0 0 1\n1 0 1 0 1 0 1 1\n1 0 -1 0 1 0 1 0\n-1 0 -1 0 1 0 0 0\n"
      "3 0 1 2\n3 0 2 3\n");
  Square square;
  api::Scene arrays;
  arrays.AddMesh(square.mesh());
  api::Scene file(Path("square.ply"));
  const Map map;
  arrays.SetEnvironment(map.image());
  file.SetEnvironment(map.image());
  EXPECT_EQ(arrays.triangles(), file.triangles());
  EXPECT_TRUE(SameBits(Render(arrays, kSmall), Render(file, kSmall)));

  // Normals may have any length: those of two corners are tilted and one of them is four times as
  // long.
  api::Scene unit, longer;
  square.normals[0] = 0.5f, square.normals[3] = -0.5f;
  unit.AddMesh(square.mesh());
  for (std::size_t i = 0; i < 3; ++i) square.normals[i] *= 4;
  longer.AddMesh(square.mesh());
  unit.SetEnvironment(map.image()), longer.SetEnvironment(map.image());
  EXPECT_TRUE(SameBits(Render(longer, kSmall), Render(unit, kSmall)));
}

TEST_F(Library, MapInMemoryEqualsMapFromFile) {
  const Map map;
  std::string pfm = "PF\n16 8\n-1.0\n";  // rows from the bottom
  for (int row = 7; row >= 0; --row) {
    pfm.append(reinterpret_cast<const char*>(&map.rgb[std::size_t(row) * 48]), 48 * sizeof(float));
  }
  Put("map.pfm", pfm);
  api::Scene memory("spheres"), file("spheres");
  memory.SetEnvironment(map.image());
  for (const Options& more : {Options{},
                              {{"env-rotate", "40"}, {"env-intensity", "0.5"}},
                              {{"env-projection", "angular"}, {"env-up", "z"}},
                              {{"strategy", "product"}}}) {
    const Options options = With(kSmall, more);
    EXPECT_TRUE(
        SameBits(Render(memory, options), Render(file, With(options, {{"env", Path("map.pfm")}}))))
        << (more.empty() ? "" : more[0].first);
  }
  // A map that an option names comes before the scene's.
  Put("black_but_one.pfm", "PF\n1 1\n-1.0\n" + std::string("\0\0\x80\x3f\0\0\0\0\0\0\0\0", 12));
  EXPECT_FALSE(SameBits(Render(memory, kSmall),
                        Render(memory, With(kSmall, {{"env", Path("black_but_one.pfm")}}))));
}

// Renderers of a scene share what they make of it, and none sees what another one or a change of
// the scene has made: each picture is that of a scene which nobody has rendered before.
TEST_F(Library, RenderersOfOneSceneMakeThePicturesOfScenesOfTheirOwn) {
  const Square square;
  const Map map;
  std::vector<float> dim = map.rgb;
  for (float& value : dim) value *= 0.25f;
  const std::function<void(api::Scene&)> changes[] = {
      [&](api::Scene& s) { s.AddMesh(square.mesh()); },
      [&](api::Scene& s) { s.SetEnvironment(map.image()); },
      [](api::Scene& s) {
        s.SetCamera({2, 3, 4}, {0, 0, 0}, {0, 1, 0}, 40);
      },
      [](api::Scene& s) {
        s.AddMaterial("conductor", {{"alpha", {0.2f}}});
      },
      [&](api::Scene& s) {
        api::MeshArrays raised = square.mesh();
        std::vector<float> positions = square.positions;
        for (std::size_t i = 1; i < positions.size(); i += 3) positions[i] = 0.5f;
        raised.positions = positions;
        raised.material = 1;
        s.AddMesh(raised);
      },
      [&](api::Scene& s) {
        s.SetEnvironment({dim, 16, 8});
      },
      [](api::Scene& s) {
        s.AddPointLight({0, 2, 0}, {3, 1, 1});
      },
      [](api::Scene& s) {
        s.SetCamera({-2, 3, 4}, {0, 0, 0}, {0, 1, 0}, 40);
      },
      [](api::Scene& s) { s.SetUp('z'); }};
  api::Scene changed;
  std::optional<api::Renderer> earlier;
  std::vector<float> of_earlier;
  for (std::size_t i = 0; i < std::size(changes); ++i) {
    changes[i](changed);
    if (i == 0) continue;  // no light yet
    api::Scene fresh;
    for (std::size_t k = 0; k <= i; ++k) changes[k](fresh);
    const std::vector<float> expected = Render(fresh, kSmall);
    EXPECT_TRUE(SameBits(Render(changed, kSmall), expected)) << "change " << i;
    const api::Scene copy = changed;
    EXPECT_TRUE(SameBits(Render(copy, kSmall), expected)) << "copy of change " << i;
    if (earlier) {
      earlier->Render();
      EXPECT_TRUE(SameBits(Pixels(*earlier), of_earlier)) << "before change " << i;
    }
    earlier.emplace(changed, kSmall);
    of_earlier = expected;
  }
}

TEST_F(Library, OptionsTakeNumbersAndTruthValues) {
  const api::Scene scene("spheres");
  const Options texts = {{"size", "20x12"},  {"spp", "3"},     {"fov", "33.25"},
                         {"ground", "true"}, {"mis", "false"}, {"env-intensity", "0.1"}};
  const Options values = {{"size", "20x12"}, {"spp", 3u},    {"fov", 33.25},
                          {"ground", true},  {"mis", false}, {"env-intensity", 0.1f}};
  EXPECT_TRUE(SameBits(Render(scene, texts), Render(scene, values)));
  EXPECT_FALSE(SameBits(Render(scene, texts), Render(scene, With(values, {{"spp", 4}}))));
  api::Renderer renderer(scene, values);
  renderer.Render({});
  EXPECT_TRUE(SameBits(Pixels(renderer), Render(scene, texts)));
}

// The camera of a scene is the one that the options place, also where space is left-handed.
TEST_F(Library, CameraOfTheSceneEqualsCameraOptions) {
  Put("left.pbrt",
      "WorldBegin\nLightSource \"infinite\" \"rgb L\" [1 2 3]\n"
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2]\n"
      "  \"point P\" [-1 -1 3 1 -1 3 0 1 3]\nWorldEnd\n");
  api::Scene placed(Path("left.pbrt"));
  placed.SetCamera({1, 0.5f, 0}, {0.5f, 0, 3}, {0, 1, 0}, 50);
  const std::vector<float> picture = Render(placed, kSmall);
  EXPECT_TRUE(SameBits(
      picture, Render(api::Scene(Path("left.pbrt")),
                      With(kSmall, {{"eye", "1,0.5,0"}, {"target", "0.5,0,3"}, {"fov", "50"}}))));
}

// A white square under lights of closed form: radiance is rho / pi times irradiance.
TEST(LibraryLights, IlluminateByTheirIntensity) {
  static constexpr double kPi = std::numbers::pi;
  struct Case {
    const char* name;
    void (*add)(api::Scene&);
    double irradiance;
  };
  const Case cases[] = {
      {"point",
       [](api::Scene& s) {
         s.AddPointLight({3, 4, 0}, {25, 50, 100});
       },
       25.0 / 25 * 0.8},  // the cosine of a triangle of sides 3, 4, 5
      {"distant",
       [](api::Scene& s) {
         s.AddDistantLight({3, 4, 0}, {2, 4, 8});
       },
       2 * 0.8},
      {"inside of a spot",
       [](api::Scene& s) {
         s.AddSpotLight({0, 4, 0}, {0, -1, 0}, {16, 32, 64}, 20, 30);
       },
       1},
      {"half of a spot",  // 25 degrees off the axis, where 3 t^2 - 2 t^3 is nearly a half
       [](api::Scene& s) {
         const float angle = 25 * float(kPi) / 180;
         s.AddSpotLight({0, 4, 0}, {std::sin(angle), -std::cos(angle), 0}, {16, 32, 64}, 20, 30);
       },
       [] {
         const auto cosine = [](double degrees) { return std::cos(degrees * kPi / 180); };
         const double t = (cosine(25) - cosine(30)) / (cosine(20) - cosine(30));
         return t * t * (3 - 2 * t);
       }()},
      {"outside of a spot",
       [](api::Scene& s) {
         s.AddSpotLight({0, 4, 0}, {1, -1, 0}, {16, 32, 64}, 20, 30);
       },
       0},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    Square square;
    api::Scene scene;
    const int white = scene.AddMaterial("lambert", {{"reflectance", {0.5f}}});
    scene.AddMesh(square.mesh(white));
    c.add(scene);
    const std::vector<float> rgb = Render(scene, kLookDown);
    for (std::size_t i = 0; i < rgb.size(); ++i) {
      const double expected = 0.5 / kPi * c.irradiance * double(1 << (i % 3));
      EXPECT_NEAR(rgb[i], expected, 2e-3 * expected);
    }
  }
}

TEST(LibraryMaterials, TakeTheParametersOfEveryBsdf) {
  for (const BsdfKernels& bsdf : Bsdfs()) {
    SCOPED_TRACE(bsdf.name);
    api::Scene scene;
    std::vector<api::MaterialParameter> parameters = {{"reflectance", {0.5f, 0.4f, 0.3f}}};
    for (const MaterialParameter& parameter : ParametersOf(bsdf)) {
      if (parameter.name != "measured") parameters.push_back({std::string(parameter.name), {0.5f}});
    }
    if (bsdf.tables.measured) {
      EXPECT_THROW(scene.AddMaterial(std::string(bsdf.name), parameters), api::Error);
    } else {
      EXPECT_EQ(scene.AddMaterial(std::string(bsdf.name), parameters), 1);
    }
  }
}

TEST(LibraryMaterials, ParametersAndTexturesChangeThePicture) {
  Square square;
  const auto look = [&](const std::vector<api::MaterialParameter>& parameters,
                        const std::optional<api::ImageArray>& texture = {}) {
    api::Scene scene;
    if (texture) scene.AddTexture(*texture);
    scene.AddMesh(square.mesh(scene.AddMaterial("lambert", parameters)));
    scene.AddDistantLight(
        {0, 1, 0}, {float(std::numbers::pi), float(std::numbers::pi), float(std::numbers::pi)});
    return Render(scene, kLookDown);
  };
  const float green[3] = {0.25f, 0.5f, 1};
  const std::vector<float> plain = look({{"reflectance", {0.5f}}});
  const std::vector<float> textured =
      look({{"reflectance", {0.5f}}, {"color_texture", {0}}}, api::ImageArray{green, 1, 1});
  const std::vector<float> shining = look({{"reflectance", {0}}, {"emission", {3, 2, 1}}});
  for (std::size_t i = 0; i < plain.size(); ++i) {
    EXPECT_NEAR(plain[i], 0.5, 1e-3);
    EXPECT_NEAR(textured[i], 0.5 * green[i % 3], 1e-3);
    EXPECT_NEAR(shining[i], 3 - int(i % 3), 1e-3);
  }
}

TEST(LibraryProgress, IsReportedOnTheCallingThreadAndKeepsThePicture) {
  // Long enough to be seen, whatever the machine.
  const Options options = {{"size", "320x240"}, {"spp", "64"}, {"max-depth", "5"}};
  api::Renderer renderer(api::Scene("gallery"), options);
  double last = 0;
  int calls = 0;
  const std::thread::id here = std::this_thread::get_id();
  renderer.Render([&](double done) {
    EXPECT_EQ(std::this_thread::get_id(), here);
    EXPECT_GE(done, last);
    EXPECT_LE(done, 1);
    last = done;
    ++calls;
    return true;
  });
  EXPECT_GT(calls, 0);
  EXPECT_GT(last, 0);
  const std::vector<float> watched = Pixels(renderer);

  // A tile of that many samples would take minutes.
  api::Renderer deep(api::Scene("gallery"), {{"size", "8x8"}, {"spp", "16777216"}});
  EXPECT_THROW(deep.Render([](double) { return false; }), api::Canceled);

  for (const char* integrator : {"path", "photon", "vcm"}) {
    SCOPED_TRACE(integrator);
    api::Renderer canceled(api::Scene("gallery"), With(options, {{"integrator", integrator}}));
    EXPECT_THROW(canceled.Render([](double) { return false; }), api::Canceled);
    EXPECT_THROW(Pixels(canceled), api::Error) << "there is no whole picture";
    EXPECT_THROW(canceled.Render([](double) -> bool { throw std::out_of_range("mine"); }),
                 std::out_of_range);
    if (std::string(integrator) == "path") {
      canceled.Render();
      EXPECT_TRUE(SameBits(Pixels(canceled), watched));
    }
  }
}

TEST_F(Library, RecordsTheCommandOfScenesThatWereNotChanged) {
  api::Scene scene("spheres");
  const Options options = With(kSmall, {{"guide", "true"}});
  api::Renderer whole(scene, options);
  whole.Render();
  whole.WriteExr(Path("whole.exr"));
  EXPECT_NE(Bytes("whole.exr").find("skywave render spheres --size 24x16"), std::string::npos);
  Square square;
  scene.AddMesh(square.mesh());
  api::Renderer changed(scene, options);
  changed.Render();
  changed.WriteExr(Path("changed.exr"));
  EXPECT_EQ(Bytes("changed.exr").find("skywave render"), std::string::npos);
}

TEST_F(Library, MeasuresWhatTheSubcommandsMeasure) {
  const Map map;
  std::vector<float> other = map.rgb;
  other[5] += 0.5f;
  const auto same = nlohmann::json::parse(api::Compare(map.image(), map.image()));
  EXPECT_EQ(same["mse"], 0);
  EXPECT_EQ(same["different_pixels"], 0);
  const auto changed = nlohmann::json::parse(api::Compare({other, 16, 8}, map.image()));
  EXPECT_NEAR(changed["mse"].get<double>(), 0.25 / 3 / 128, 1e-9);
  EXPECT_EQ(changed["max_at"], nlohmann::json({1, 0}));

  const auto info = nlohmann::json::parse(api::DescribeMap(map.image()));
  EXPECT_EQ(info["width"], 16);
  EXPECT_EQ(info["projection"], "latlong");
  EXPECT_EQ(nlohmann::json::parse(api::DescribeMap(map.image(), "angular"))["projection"],
            "angular");

  int calls = 0;
  const auto measured = nlohmann::json::parse(api::Converge(api::Scene("gallery"),
                                                            {{"size", "16x12"},
                                                             {"strategies", "importance uniform"},
                                                             {"budgets", "1,4"},
                                                             {"repeats", "2"},
                                                             {"reference-spp", "64"}},
                                                            [&](double) { return ++calls > 0; }));
  ASSERT_EQ(measured["strategies"].size(), 2u);
  EXPECT_EQ(measured["strategies"][1]["strategy"], "uniform");
  EXPECT_EQ(measured["strategies"][1]["budgets"][1]["samples_per_pixel"], 4);
  EXPECT_GT(measured["strategies"][1]["budgets"][0]["error"].get<double>(),
            measured["strategies"][1]["budgets"][1]["error"].get<double>());
  EXPECT_TRUE(measured.contains("command"));

  // No command makes a scene that was changed.
  Square square;
  api::Scene scene("gallery");
  scene.AddMesh(square.mesh());
  const auto changed_scene = nlohmann::json::parse(api::Converge(
      scene, {{"size", "16x12"}, {"budgets", "1"}, {"repeats", "2"}, {"reference-spp", "2"}}));
  EXPECT_FALSE(changed_scene.contains("command"));
}

// A frame of an animation is the picture of a file whose nodes are there anyway.
TEST_F(Library, FramesRenderTheirPoses) {
  Put("moving.gltf", MovingTriangle().text());
  GltfDocument posed = TriangleDocument();
  posed.json["nodes"][0]["translation"] = {2.5, 0, 0};
  Put("still.gltf", posed.text());
  const Map map;
  const auto render = [&](const std::string& path, const Options& reading, const Options& options) {
    api::Scene scene(Path(path), reading);
    scene.SetEnvironment(map.image());
    return Render(scene, With(kSmall, options));
  };
  const Options half = {{"frame", "15"}, {"fps", "30"}, {"animation", "slide"}};
  // Frames have noise of their own unless it is coherent.
  const Options coherent = {{"coherent-noise", "true"}};
  const std::vector<float> picture = render("moving.gltf", half, coherent);
  EXPECT_TRUE(SameBits(picture, render("still.gltf", {}, {})));
  EXPECT_FALSE(SameBits(picture, render("moving.gltf", {}, {})));
  // Another camera and other materials, in the same way.
  posed.json["scenes"][0]["nodes"] = {0, 3};
  posed.json["materials"][0] = {{"name", "paint"}};
  Put("other.gltf", posed.text());
  EXPECT_TRUE(SameBits(render("moving.gltf", half,
                              {{"scene-camera", "side"},
                               {"material", "paint=:reflectance=1"},
                               {"coherent-noise", "true"}}),
                       render("other.gltf", {}, {})));
}

TEST_F(Library, ListsTheOptionsOfReading) {
  const std::vector<std::string> names = api::OptionsOfReading();
  for (const char* const name :
       {"strict", "max-triangles", "instances", "frame", "fps", "animation"}) {
    EXPECT_EQ(std::count(names.begin(), names.end(), name), 1) << name;
  }
  EXPECT_EQ(std::count(names.begin(), names.end(), "spp"), 0);
}

// A stop is a factor of two.
TEST(LibraryPictures, PngsAreExposed) {
  const std::vector<float> once = {0.02f, 0.1f, 0.25f}, twice = {0.04f, 0.2f, 0.5f};
  for (const char* const tone : {"clip", "filmic"}) {
    EXPECT_EQ(api::EncodePng({once, 1, 1}, 1, tone), api::EncodePng({twice, 1, 1}, 0, tone));
    EXPECT_NE(api::EncodePng({once, 1, 1}, 1, tone), api::EncodePng({once, 1, 1}, 0, tone));
  }
}

}  // namespace
}  // namespace skywave
