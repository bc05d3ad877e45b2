// Tests mattes: ids, what a pixel keeps whatever comes first, and shares of a picture against
// pictures of single samples.
#include "wavefront/film/mattes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "scene/builtin/builtin.h"
#include "tests/support/film_layers.h"
#include "tests/support/render_scenes.h"

namespace skywave {
namespace {

// The values are those of Appleby's own program, but for the first one, whose exponent is changed
// as the specification of Cryptomatte wants it.
TEST(Mattes, IdsAreThoseOfMurmur3) {
  EXPECT_EQ(MatteId(""), 0x00800000u);
  EXPECT_EQ(MatteId("a"), 0x3c2569b2u);
  EXPECT_EQ(MatteId("hello"), 0x248bfa47u);
  EXPECT_EQ(MatteId("hello, world"), 0x149bbb7fu);
  EXPECT_EQ(MatteId("The quick brown fox jumps over the lazy dog"), 0x2e4ff723u);
  for (int i = 0; i < 100000; ++i) {
    ASSERT_TRUE(std::isnormal(std::bit_cast<float>(MatteId("object " + std::to_string(i))))) << i;
  }
}

MatteSums Sums(std::size_t slots, std::size_t pixels) {
  MatteSums sums;
  sums.slots = slots;
  sums.ids.resize(slots * pixels);
  sums.weights.resize(slots * pixels);
  return sums;
}

TEST(Mattes, APixelKeepsTheSmallestIdsWithAllOfTheirWeightInAnyOrder) {
  constexpr std::size_t kPixels = 3, kPixel = 1;
  std::mt19937 random(7);
  std::vector<std::pair<std::uint32_t, std::uint64_t>> samples;
  std::map<std::uint32_t, double> weight_of;
  for (int i = 0; i < 500; ++i) {
    const std::uint32_t id = 1 + random() % 40 * 977;
    samples.emplace_back(id, 1 + random() % 5);
    weight_of[id] += double(samples.back().second);
  }
  ASSERT_GT(weight_of.size(), kMatteSlots + 10);
  std::vector<std::pair<std::uint32_t, double>> smallest(
      weight_of.begin(), std::next(weight_of.begin(), std::ptrdiff_t(kMatteSlots)));
  std::sort(smallest.begin(), smallest.end(), [](const auto& a, const auto& b) {
    return a.second != b.second ? a.second > b.second : a.first < b.first;
  });
  for (int order = 0; order < 20; ++order) {
    std::shuffle(samples.begin(), samples.end(), random);
    MatteSums sums = Sums(kMatteSlots, kPixels);
    for (const auto& [id, weight] : samples) AddToMatte(kPixel, id, weight, sums);
    const auto ranks = RanksOf(sums, kPixel);
    for (std::size_t rank = 0; rank < kMatteRanks; ++rank) {
      ASSERT_EQ(ranks[rank].id, smallest[rank].first) << rank;
      ASSERT_EQ(ranks[rank].weight, smallest[rank].second) << rank;
    }
    for (const std::size_t other : {0, 2}) EXPECT_EQ(RanksOf(sums, other)[0].id, 0u);
  }
}

TEST(Mattes, TheHeaderNamesAllIds) {
  const Metadata attributes =
      MatteAttributes("crypto_object", MakeMatteNames({"a \"b\"", "hello", "hello"}));
  // The key is the hash of the layer's name, without its last digit.
  std::map<std::string, std::string> by_name(attributes.begin(), attributes.end());
  const std::string key = "cryptomatte/f834d0a/";
  EXPECT_EQ(by_name.at(key + "name"), "crypto_object");
  EXPECT_EQ(by_name.at(key + "hash"), "MurmurHash3_32");
  EXPECT_EQ(by_name.at(key + "conversion"), "uint32_to_float32");
  const auto manifest = nlohmann::json::parse(by_name.at(key + "manifest"));
  EXPECT_EQ(manifest.size(), 2u);
  EXPECT_EQ(manifest.at("hello"), "248bfa47");
  for (const auto& [name, text] : attributes) {
    EXPECT_TRUE(IsOfMatte(name));
    EXPECT_LE(name.size(), 31u) << "short names are those that all readers know";
  }
}

// Returns the share of an id in a pixel by the layers of a matte.
double ShareIn(const Layers& layers, const std::string& matte, std::uint32_t id,
               std::size_t pixel) {
  double share = 0;
  for (int layer = 0; layer < 3; ++layer) {
    for (const auto& [of_id, of_share] : {std::pair("R", "G"), std::pair("B", "A")}) {
      const std::string name = matte + "0" + std::to_string(layer) + ".";
      if (std::bit_cast<std::uint32_t>(layers.at(name + of_id)[pixel]) == id) {
        share += layers.at(name + of_share)[pixel];
      }
    }
  }
  return share;
}

JobRequest MatteRequest(std::uint32_t samples) {
  JobRequest request = SmallRequest(40, 30, samples);
  request.max_depth = 1;
  request.camera.lens_radius = 0.1f;  // edges are out of focus
  return request;
}

// A picture of one sample says by its layer object-id what that sample sees.
// Two instances of a square, one of which has a name, beside a square that a node stands there.
TEST(Mattes, NodesAreObjects) {
  Scene scene;
  const std::uint32_t chalk = AddLambert(scene, "chalk", glm::vec3(0.5f));
  scene.objects.push_back({.name = "square", .meshes = {Quad(0.5f)}});
  scene.objects[0].meshes[0].name = "square", scene.objects[0].meshes[0].material = chalk;
  scene.nodes = {"left"};
  const auto at = [](double x) {
    glm::dmat4x3 to(1.0);
    to[3] = {x, 0, 0};
    return to;
  };
  scene.instances = {{.object = 0, .world_from_object = at(-2), .node = 0},
                     {.object = 0, .world_from_object = at(0)}};
  Place(scene, Quad(0.5f), chalk, {2, 0, 0});
  scene.meshes[0].name = "mesh", scene.meshes[0].node = "right";
  SetConstantLight(scene, 1);
  scene.camera = LookAtCamera({0, 5, 0.001f}, {0, 0, 0}, {0, 0, -1}, 60, false);
  const RenderJob job = MakeJob(scene, SmallRequest(48, 24, 4), "crypto-object");
  const std::vector<float> ids = Resolve(job).at("crypto_object00.R");
  std::set<std::uint32_t> seen;
  for (const float id : ids) seen.insert(std::bit_cast<std::uint32_t>(id));
  EXPECT_EQ(seen,
            (std::set<std::uint32_t>{0, MatteId("left"), MatteId("square"), MatteId("right")}));
  const auto pixel = [&](int x) {
    return std::bit_cast<std::uint32_t>(ids[12 * 48 + std::size_t(x)]);
  };
  EXPECT_EQ(pixel(16), MatteId("left"));
  EXPECT_EQ(pixel(24), MatteId("square"));
  EXPECT_EQ(pixel(32), MatteId("right"));
  // Alpha has the same surfaces, and asks for no names.
  JobRequest request = SmallRequest(48, 24, 4);
  request.background = Background::kTransparent;
  EXPECT_EQ(Resolve(RenderJob(scene, request)).at("alpha.A")[12 * 48 + 24], 1);
}

TEST(Mattes, SharesAreThoseOfTheSamplesThroughALens) {
  constexpr std::uint32_t kSamples = 16;
  Scene scene = BuiltinScene("spheres");
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    scene.meshes[i].name = "ball " + std::to_string(i);
  }
  scene.meshes[1].name.clear();                         // it is called "mesh 2"
  scene.meshes[3].material = scene.meshes[2].material;  // two of one material
  const RenderJob job =
      MakeJob(scene, MatteRequest(kSamples), "crypto-object,crypto-material,alpha");
  const Layers layers = Resolve(job);
  const std::size_t pixels = layers.at("alpha.A").size();
  std::vector<std::map<std::uint32_t, double>> objects(pixels), materials(pixels);
  for (std::uint32_t sample = 0; sample < kSamples; ++sample) {
    const RenderJob one = MakeJob(scene, MatteRequest(1), "object-id");
    FrameView frame = one.frame();
    frame.options.picture_samples = {0, kSamples};
    frame.options.first_sample = sample;
    const Layers of_one = ByName(Render(one, frame).ResolveAovs(1));
    for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
      const auto number = std::size_t(of_one.at("object-id.V")[pixel]);
      if (number == 0) continue;
      const Mesh& mesh = scene.meshes[number - 1];
      objects[pixel][MatteId(number == 2 ? "mesh 2" : mesh.name)] += 1.0 / kSamples;
      materials[pixel][MatteId(scene.materials[mesh.material].name)] += 1.0 / kSamples;
    }
  }
  int edges = 0;
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    double all = 0;
    for (const auto& [id, share] : objects[pixel]) {
      ASSERT_EQ(ShareIn(layers, "crypto_object", id, pixel), share) << pixel;
      all += share;
    }
    for (const auto& [id, share] : materials[pixel]) {
      ASSERT_EQ(ShareIn(layers, "crypto_material", id, pixel), share) << pixel;
    }
    ASSERT_EQ(float(all), layers.at("alpha.A")[pixel]) << pixel;
    edges += objects[pixel].size() > 1;
  }
  EXPECT_GT(edges, 50);
}

// Filters with negative weights give shares by weight: they are those of alpha.
TEST(Mattes, SharesAddUpToAlphaUnderAFilterWithSigns) {
  JobRequest request = MatteRequest(16);
  request.filter = PixelFilter::kMitchell;
  const Layers layers = Resolve(MakeJob(BuiltinScene("spheres"), request, "crypto-object,alpha"));
  int between = 0;
  for (std::size_t pixel = 0; pixel < layers.at("alpha.A").size(); ++pixel) {
    double all = 0;
    bool clamped = false;
    for (int layer = 0; layer < 3; ++layer) {
      const std::string name = "crypto_object0" + std::to_string(layer) + ".";
      for (const std::string& id_and_share : {std::string("RG"), std::string("BA")}) {
        const float share = layers.at(name + id_and_share[1])[pixel];
        all += share;
        clamped |= share == 0 && layers.at(name + id_and_share[0])[pixel] != 0;
      }
    }
    if (clamped) continue;
    const float alpha = layers.at("alpha.A")[pixel];
    ASSERT_NEAR(all, alpha, 1e-5) << pixel;
    between += alpha > 0.01 && alpha < 0.99;
  }
  EXPECT_GT(between, 5);
}

}  // namespace
}  // namespace skywave
