// Tests that the library refuses bad arguments by name.
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "kernels/bsdf/bsdf.h"
#include "skywave/skywave.h"
#include "tests/support/gltf_document.h"
#include "tests/support/library_scenes.h"
#include "tests/support/program.h"

namespace skywave {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Each call is refused with an Error whose place is `place` and whose message contains `word`.
struct Refusal {
  const char *place, *word;
  std::function<void()> call;
};

void ExpectRefusals(const std::vector<Refusal>& refusals) {
  for (const Refusal& refusal : refusals) {
    SCOPED_TRACE(std::string(refusal.place) + ", " + refusal.word);
    try {
      refusal.call();
      ADD_FAILURE() << "was accepted";
    } catch (const api::Error& error) {
      EXPECT_EQ(error.place(), refusal.place);
      EXPECT_NE(std::string(error.what()).find(refusal.word), std::string::npos) << error.what();
    }
  }
}

TEST(LibraryErrors, NameTheBadArray) {
  api::Scene scene;
  Square square;
  scene.AddMesh(square.mesh());
  const auto mesh = [&](auto change) {
    return [&scene, change] {
      Square bad;
      api::MeshArrays arrays = bad.mesh();
      change(bad, arrays);
      scene.AddMesh(arrays);
    };
  };
  const auto texture = [&](std::vector<float> rgb, int width, int height) {
    return [&scene, rgb, width, height] { scene.AddTexture({rgb, width, height}); };
  };
  const auto map = [&](std::vector<float> rgb, int width, int height) {
    return [&scene, rgb, width, height] { scene.SetEnvironment({rgb, width, height}); };
  };
  const auto material = [&](const char* bsdf, std::vector<api::MaterialParameter> parameters) {
    return [&scene, bsdf, parameters] { scene.AddMaterial(bsdf, parameters); };
  };
  ExpectRefusals(
      {{"positions", "0 values", [&] { scene.AddMesh({}); }},
       {"positions", "11 values", mesh([](Square& s, api::MeshArrays& m) {
          m.positions = std::span(s.positions).first(11);
        })},
       {"positions", "nan", mesh([](Square& s, api::MeshArrays&) { s.positions[4] = kNan; })},
       {"positions", "value 4",
        mesh([](Square& s, api::MeshArrays&) { s.positions[4] = -kInfinity; })},
       {"triangles", "5 indices",
        mesh([](Square& s, api::MeshArrays& m) { m.triangles = std::span(s.triangles).first(5); })},
       {"triangles", "0 indices", mesh([](Square&, api::MeshArrays& m) { m.triangles = {}; })},
       {"triangles", "vertex 4", mesh([](Square& s, api::MeshArrays&) { s.triangles[5] = 4; })},
       {"triangles", "vertex 4294967295",
        mesh([](Square& s, api::MeshArrays&) { s.triangles[0] = ~0u; })},
       {"normals", "9 values",
        mesh([](Square& s, api::MeshArrays& m) { m.normals = std::span(s.normals).first(9); })},
       {"normals", "length 0", mesh([](Square& s, api::MeshArrays&) { s.normals[1] = 0; })},
       {"uvs", "7 values",
        mesh([](Square& s, api::MeshArrays& m) { m.uvs = std::span(s.uvs).first(7); })},
       {"uvs", "nan", mesh([](Square& s, api::MeshArrays&) { s.uvs[0] = kNan; })},
       {"alphas", "8 values",
        mesh([](Square& s, api::MeshArrays& m) { m.alphas = std::span(s.normals).first(8); })},
       {"alphas", "not in [0, 1]", mesh([](Square& s, api::MeshArrays& m) {
          s.normals.assign(12, 1.5f);
          m.alphas = std::span(s.normals).first(4);
        })},
       {"colors", "8 values",
        mesh([](Square& s, api::MeshArrays& m) { m.colors = std::span(s.normals).first(8); })},
       {"material", "number 7", mesh([](Square&, api::MeshArrays& m) { m.material = 7; })},
       {"material", "number -1", mesh([](Square&, api::MeshArrays& m) { m.material = -1; })},
       {"image", "2 x 2", texture({1, 2, 3}, 2, 2)},
       {"image", "-1 x -1", texture({1, 2, 3}, -1, -1)},
       {"image", "65536", texture({1, 2, 3}, 65536, 65536)},
       {"image", "inf", texture({1, kInfinity, 3}, 1, 1)},
       {"map", "black", map({0, 0, 0, 0, 0, 0}, 2, 1)},
       {"map", "black", map({kNan, -1, -kInfinity}, 1, 1)},
       {"map", "0 x 0", map({}, 0, 0)},
       {"map", "has 3 values", map({1, 2, 3}, 2, 1)},
       {"bsdf", "lambert", material("lambertian", {})},
       {"rough", "alpha", material("conductor", {{"rough", {1}}})},
       {"ior", "no such parameter", material("lambert", {{"ior", {1.5f}}})},
       {"absorption", "no such parameter", material("lambert", {{"absorption", {1}}})},
       {"alpha", "from 0 to 1", material("conductor", {{"alpha", {2}}})},
       {"alpha", "nan", material("conductor", {{"alpha", {kNan}}})},
       {"alpha", "takes 1", material("conductor", {{"alpha", {0.1f, 0.2f}}})},
       {"eta", "takes 3", material("conductor", {{"eta", {0.1f, 0.2f}}})},
       {"reflectance", "no value", material("lambert", {{"reflectance", {}}})},
       {"emission", "-1", material("lambert", {{"emission", {-1}}})},
       {"material", "texture", material("lambert", {{"color_texture", {3}}})},
       {"material", "texture", material("lambert", {{"color_texture", {1e20f}}})},
       {"material", "mixed", material("lambert", {{"mixture", {0, 9, 0.5f}}})},
       {"mixture", "share", material("lambert", {{"mixture", {0, 0, 2}}})},
       {"position", "nan",
        [&] {
          scene.AddPointLight({kNan, 0, 0}, {1, 1, 1});
        }},
       {"intensity", "negative",
        [&] {
          scene.AddPointLight({0, 0, 0}, {1, -1, 1});
        }},
       {"full_degrees", "<=",
        [&] {
          scene.AddSpotLight({}, {0, 1, 0}, {1, 1, 1}, 40, 30);
        }},
       {"dark_degrees", "180",
        [&] {
          scene.AddSpotLight({}, {0, 1, 0}, {1, 1, 1}, 10, 200);
        }},
       {"axis", "no direction",
        [&] {
          scene.AddSpotLight({}, {}, {1, 1, 1}, 10, 30);
        }},
       {"direction", "inf",
        [&] {
          scene.AddDistantLight({0, kInfinity, 0}, {1, 1, 1});
        }},
       {"target", "eye",
        [&] {
          scene.SetCamera({1, 1, 1}, {1, 1, 1}, {0, 1, 0}, 40);
        }},
       {"up", "view",
        [&] {
          scene.SetCamera({0, 1, 0}, {0, 0, 0}, {0, 1, 0}, 40);
        }},
       {"fov_degrees", "180",
        [&] {
          scene.SetCamera({0, 1, 1}, {0, 0, 0}, {0, 1, 0}, kNan);
        }},
       {"axis", "x, y or z", [&] { scene.SetUp('w'); }}});
  EXPECT_EQ(scene.triangles(), 2u) << "a refused mesh has left something";
  scene.AddDistantLight({0, 1, 0}, {1, 1, 1});
  EXPECT_GT(Render(scene, kLookDown)[0], 0);
}

TEST(LibraryErrors, RefuseFractionsWhereANumberIsMeant) {
  const float white[3] = {1, 1, 1};
  api::Scene scene;
  scene.AddTexture({white, 1, 1});
  EXPECT_EQ(scene.AddMaterial("lambert", {{"color_texture", {0}}}), 1);
  ExpectRefusals({{"material", "texture", [&] {
                     scene.AddMaterial("lambert", {{"color_texture", {0.5f}}});
                   }}});
}

TEST(LibraryErrors, NameTheBadOption) {
  const api::Scene scene("spheres");
  api::Renderer renderer(scene, kSmall);
  std::vector<float> wrong(5);
  const auto with = [&](Options options) {
    return [&scene, options] { api::Renderer(scene, options); };
  };
  ExpectRefusals({{"max-dept", "max-depth", with({{"max-dept", "3"}})},
                  {"scene", "no such option", with({{"scene", "gallery"}})},
                  {"spp", "'0' is not", with({{"spp", "0"}})},
                  {"spp", "'' is not", with({{"spp", ""}})},
                  {"size", "12x", with({{"size", "12x"}})},
                  {"shutter", "f-number", with({{"shutter", "1/60"}})},
                  {"split 2", "splits paths", with({{"split", "2"}, {"integrator", "bdpt"}})},
                  {"no.exr", "no.exr", with({{"env", "no.exr"}})},
                  {"nothing.obj", "nothing.obj", [] { api::Scene("nothing.obj"); }},
                  {"strict", "maybe",
                   [] {
                     api::Scene("spheres", {{"strict", "maybe"}});
                   }},
                  {"spp", "no such option",
                   [] {
                     api::Scene("spheres", {{"spp", "4"}});
                   }},
                  {"Renderer", "Render first", [&] { Pixels(renderer); }},
                  {"Renderer", "Render first", [&] { renderer.WriteExr("x.exr"); }},
                  {"rgb", "5 floats",
                   [&] {
                     renderer.Render();
                     renderer.CopyPicture(wrong);
                   }},
                  {"layer", "aovs", [&] { renderer.CopyLayer("albedo", wrong); }},
                  {"tone", "clip|filmic",
                   [] {
                     api::EncodePng({std::vector<float>{1, 1, 1}, 1, 1}, 0, "x");
                   }},
                  {"scene", "no light",
                   [] {
                     api::Scene dark;
                     dark.AddMesh(Square().mesh());
                     api::Renderer(dark, {});
                   }},
                  {"scene", "no triangle",
                   [] {
                     api::Scene empty;
                     empty.SetEnvironment(Map().image());
                     api::Renderer(empty, {});
                   }},
                  {"save-reference reference.png", "end in .exr",
                   [&] {
                     api::Converge(scene, {{"save-reference", "reference.png"}});
                   }},
                  {"save-reference a.exr", "no other",
                   [&] {
                     api::Converge(scene, {{"save-reference", "a.exr"}, {"reference", "b.exr"}});
                   }},
                  {"strategies", "needs a value",
                   [&] {
                     api::Converge(scene, {{"strategies", " "}});
                   }},
                  {"projection", "latlong", [] {
                     api::DescribeMap({std::vector<float>(6, 1.0f), 2, 1}, "flat");
                   }}});
}

}  // namespace
}  // namespace skywave
