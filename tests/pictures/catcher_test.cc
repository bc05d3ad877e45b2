// Tests catchers: what is seen of them is the difference of the picture with objects and that
// without, path by path.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <string>
#include <vector>

#include "base/error.h"
#include "job/marks.h"
#include "scene/geometry.h"
#include "scene/instances.h"
#include "tests/support/film_layers.h"
#include "tests/support/refused.h"
#include "tests/support/render_scenes.h"
#include "wavefront/policies/control_pilot.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

constexpr int kSide = 24;
constexpr std::uint32_t kSamples = 64;

// A floor and a wall under a sky with a sun; objects come after these two meshes.
Scene PlaceScene() {
  Scene scene;
  const std::uint32_t floor = AddLambert(scene, "floor", {0.5f, 0.4f, 0.3f});
  const std::uint32_t wall = AddLambert(scene, "wall", {0.2f, 0.6f, 0.3f});
  Place(scene, Quad(3), floor, glm::vec3(0));
  Place(scene, Facetted(RoundedBox({3, 1, 0.1f}, 0.01f, 1)), wall, {0, 1, -2});
  scene.meshes[0].name = "floor of the place";
  SetLight(scene, SkyWithSun(64, 32, 40, 0.2));
  scene.camera = LookAtCamera({0.5f, 2.5f, 5}, {0, 0.4f, 0}, {0, 1, 0}, 40, false);
  return scene;
}
constexpr std::size_t kPlaceMeshes = 2;

void CatchPlace(Scene& scene) {
  for (std::size_t i = 0; i < kPlaceMeshes; ++i) {
    scene.materials[scene.meshes[i].material].catcher = true;
  }
}

Scene WithObjects(Scene scene) {
  const std::uint32_t red = AddLambert(scene, "red", {0.7f, 0.1f, 0.1f});
  Place(scene, Sphere(0.5f), red, {-0.8f, 0.5f, 0.3f});
  Place(scene, Sphere(0.4f), AddMetal(scene, "Cu", 0.2f), {0.4f, 0.4f, 0.6f});
  return scene;
}

struct Rendered {
  Image beauty;
  Layers layers;
  double Layer(const std::string& name, std::size_t i) const { return layers.at(name)[i]; }
};

Rendered Render(const Scene& scene, const JobRequest& request) {
  JobRequest transparent = request;
  transparent.background = Background::kTransparent;
  const RenderJob job(scene, transparent);
  const Film film = Render(job);
  const std::uint32_t samples = job.options().samples_per_pixel;
  return {.beauty = film.Resolve(samples), .layers = ByName(film.ResolveAovs(samples))};
}

// Returns, by pixel, whether it shows nothing of the objects, which nothing of the place hides.
std::vector<bool> WithoutObjects(Scene scene, const JobRequest& request) {
  scene.meshes.erase(scene.meshes.begin(), scene.meshes.begin() + kPlaceMeshes);
  for (Material& material : scene.materials) material.catcher = false;
  std::vector<bool> without;
  for (const float alpha : Render(scene, request).layers.at("alpha.A"))
    without.push_back(alpha == 0);
  return without;
}

Scene OfPlaceAlone(Scene scene) {
  scene.meshes.resize(kPlaceMeshes);
  scene.instances.clear();
  for (Material& material : scene.materials) material.catcher = false;
  return scene;
}

struct Case {
  std::string name;
  std::function<void(Scene&)> change = [](Scene&) {};
  std::function<void(JobRequest&)> ask = [](JobRequest&) {};
  // False: the place alone draws other random numbers, so that only means agree.
  bool same_numbers = true;
};

std::vector<Case> Cases() {
  const auto strategy = [](const char* name) {
    return [name](JobRequest& request) { request.strategy = name; };
  };
  return {
      {"plain"},
      {"product", [](Scene&) {}, strategy("product")},
      {"cosine", [](Scene&) {}, strategy("cosine")},
      {"median-cut", [](Scene&) {}, strategy("median-cut")},
      {"without mis", [](Scene&) {}, [](JobRequest& request) { request.options.mis = false; }},
      {"direct", [](Scene&) {},
       [](JobRequest& request) {
         request.integrator = Integrator::kDirect;
         request.options.light_samples = 2;
       }},
      {"control", [](Scene&) {},
       [](JobRequest& request) {
         request.options.of<ControlOptions>().control = ControlVariate::kIrradiance;
       },
       false},  // its weights are learned from what is there
      {"signed filter", [](Scene&) {},
       [](JobRequest& request) { request.filter = PixelFilter::kMitchell; }},
      {"mirror for a floor",
       [](Scene& scene) {
         scene.materials[0].bsdf = BsdfKind::kMirror, scene.materials[0].eta = glm::vec3(0);
       }},
      {"spot and sun",
       [](Scene& scene) {
         scene.lights = {SlantingSpot(), SlantingSun()};
       }},
      {"wall that shines",
       [](Scene& scene) {
         scene.materials[1].emission = {2, 1, 0.5f};
       }},
      // Which rays pass depends on the numbers of triangles.
      {"wall with holes", [](Scene& scene) { scene.materials[1].opacity = 0.6f; },
       [](JobRequest&) {}, false},
      {"mixture for a floor",
       [](Scene& scene) {
         const auto parts = std::uint32_t(scene.materials.size());
         AddLambert(scene, "dark", glm::vec3(0.1f));
         AddMirror(scene, 0.8f);
         scene.meshes[0].material = std::uint32_t(scene.materials.size());
         scene.materials.push_back({.name = "mixed"});
         scene.materials.back().mixture = Mixture{parts, parts + 1, 0.4f};
         scene.materials.back().catcher = true;
       }},
      {"instances",
       [](Scene& scene) {
         Object object;
         object.meshes = {Sphere(0.3f)};
         object.meshes[0].material = scene.meshes.back().material;
         scene.objects.push_back(object);
         for (const double x : {-0.2, 1.2}) {
           scene.instances.push_back(
               {0, glm::dmat4x3(glm::translate(glm::dmat4(1), glm::dvec3(x, 0.3, 1.2)))});
         }
       }},
  };
}

// Paths that objects do not meet are the same without them, and the others are followed by the same
// numbers; so pixels are those of a render of the place alone, but for rays within rounding of an
// edge, and not only on average.
TEST(Catchers, LightWithoutObjectsIsThatOfThePlace) {
  for (const Case& item : Cases()) {
    SCOPED_TRACE(item.name);
    Scene scene = WithObjects(PlaceScene());
    CatchPlace(scene);
    item.change(scene);
    JobRequest request = SmallRequest(kSide, kSide, kSamples);
    item.ask(request);
    const Rendered with = Render(scene, request);
    const Rendered place = Render(OfPlaceAlone(scene), request);
    const std::vector<bool> compared = WithoutObjects(scene, request);
    int pixels = 0, others = 0, changed = 0;
    double sum = 0, of_place = 0;
    for (std::size_t i = 0; i < compared.size(); ++i) {
      if (!compared[i]) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        const std::string channel(1, "RGB"[c]);
        const double difference = with.Layer("difference." + channel, i);
        const double clean = with.beauty.rgb[3 * i + c] - difference;
        const double expected = place.beauty.rgb[3 * i + c];
        others += std::abs(clean - expected) > 1e-5 * (1 + std::abs(expected));
        sum += clean, of_place += expected;
        changed += difference != 0;
        ++pixels;
      }
    }
    EXPECT_GT(pixels, kSide * kSide);
    EXPECT_GT(changed, pixels / 20);
    if (item.same_numbers) {
      EXPECT_LE(others, pixels / 100);
    }
    EXPECT_NEAR(sum, of_place, 1e-3 * of_place);
  }
}

// Lamps of objects take a share of the light samples in both frames, and so the place has other
// samples than alone: the means agree.
TEST(Catchers, LampsOfObjectsDoNotShineOnThePlaceAlone) {
  Scene scene = WithObjects(PlaceScene());
  CatchPlace(scene);
  Mesh lamp = Sphere(0.3f);
  lamp.material = std::uint32_t(scene.materials.size());
  scene.materials.push_back({.name = "lamp", .emission = glm::vec3(20)});
  for (glm::vec3& p : lamp.positions) p += glm::vec3(0.3f, 1.6f, 0.5f);
  scene.meshes.push_back(lamp);
  double clean = 0, clean2 = 0, place = 0, place2 = 0, caught = 0;
  constexpr int kRuns = 12;
  for (int run = 0; run < kRuns; ++run) {
    JobRequest request = SmallRequest(kSide, kSide, kSamples);
    request.options.seed = std::uint32_t(run);
    const Rendered with = Render(scene, request);
    request.options.seed = std::uint32_t(run + 100);
    const Rendered alone = Render(OfPlaceAlone(scene), request);
    const std::vector<bool> compared = WithoutObjects(scene, request);
    double with_sum = 0, alone_sum = 0;
    for (std::size_t i = 0; i < compared.size(); ++i) {
      if (!compared[i]) continue;
      with_sum += with.beauty.rgb[3 * i] - with.Layer("difference.R", i);
      alone_sum += alone.beauty.rgb[3 * i];
      caught += with.beauty.rgb[3 * i];
    }
    clean += with_sum, clean2 += with_sum * with_sum;
    place += alone_sum, place2 += alone_sum * alone_sum;
  }
  const auto error2 = [](double sum, double squares) {
    return (squares - sum * sum / kRuns) / (kRuns - 1) * kRuns;  // variance of the sum
  };
  EXPECT_NEAR(clean, place, 4.5 * std::sqrt(error2(clean, clean2) + error2(place, place2)));
  EXPECT_LT(std::sqrt(error2(clean, clean2)), 0.01 * clean);  // the test can tell
  EXPECT_GT(caught, 1.05 * clean);
}

TEST(Catchers, ObjectsThatChangeNothingLeaveNoTrace) {
  Scene scene = PlaceScene();
  CatchPlace(scene);
  Place(scene, Sphere(0.5f), AddLambert(scene, "hidden", glm::vec3(0.8f)), {0, -1, 0});
  // No ray of the wall goes below the floor.
  scene.meshes[0].positions = Quad(40).positions;
  const Rendered with = Render(scene, SmallRequest(kSide, kSide, kSamples));
  for (const std::string name : {"difference.R", "difference.G", "difference.B", "alpha.A",
                                 "foreground.R", "foreground.G", "foreground.B"}) {
    for (const float value : with.layers.at(name)) EXPECT_EQ(value, 0) << name;
  }
  for (const float value : with.layers.at("shadow.G")) EXPECT_EQ(value, 1);
}

TEST(Catchers, OverThePlaceTheForegroundIsTheWholePicture) {
  Scene scene = WithObjects(PlaceScene());
  CatchPlace(scene);
  JobRequest request = SmallRequest(kSide, kSide, kSamples);
  request.filter = PixelFilter::kBox;
  const Rendered with = Render(scene, request);
  const std::vector<bool> free = WithoutObjects(scene, request);
  // Where a pixel sees past the place, alpha is a share of what is behind both.
  const std::vector<float> of_place = Render(OfPlaceAlone(scene), request).layers.at("alpha.A");
  int covered = 0, shadowed = 0;
  for (std::size_t i = 0; i < free.size(); ++i) {
    const double alpha = with.Layer("alpha.A", i);
    if (of_place[i] < 1) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::string channel(1, "RGB"[c]);
      const double beauty = with.beauty.rgb[3 * i + c];
      const double clean = beauty - with.Layer("difference." + channel, i);
      const double over = with.Layer("foreground." + channel, i) + (1 - alpha) * clean;
      const double shadow = with.Layer("shadow." + channel, i);
      if (free[i]) {
        EXPECT_NEAR(over, beauty, 1e-5 * (1 + beauty));
        EXPECT_NEAR(shadow * clean, beauty, 1e-5 * (1 + beauty));
        EXPECT_LE(1 - alpha, std::min(shadow, 1.0) + 1e-6);
        shadowed += alpha > 0.2;
      } else if (alpha == 1) {
        EXPECT_NEAR(with.Layer("foreground." + channel, i), beauty, 1e-5 * (1 + beauty));
        ++covered;
      }
      EXPECT_GE(with.Layer("foreground." + channel, i), 0);
    }
  }
  EXPECT_GT(covered, 20);
  EXPECT_GT(shadowed, 20);
}

TEST(Catchers, LayersDoNotDependOnThreadsAndWaves) {
  Scene scene = WithObjects(PlaceScene());
  CatchPlace(scene);
  JobRequest request = SmallRequest(kSide, kSide, 16);
  const Rendered first = Render(scene, request);
  request.options.threads = 1, request.options.wave = 64;
  EXPECT_EQ(Render(scene, request).layers, first.layers);
  request.options.backend = Backend::kSingle;
  EXPECT_EQ(Render(scene, request).layers, first.layers);
}

TEST(Catchers, MeshesAndMaterialsAreNamed) {
  Scene scene = WithObjects(PlaceScene());
  scene.meshes[2].material = scene.meshes[0].material;  // an object like the floor
  Mark("catcher", {"floor of the place", "wall"}, FlagOf(&Material::catcher), scene);
  EXPECT_TRUE(scene.materials[scene.meshes[0].material].catcher);
  EXPECT_TRUE(scene.materials[scene.meshes[1].material].catcher);
  EXPECT_FALSE(scene.materials[scene.meshes[2].material].catcher);
  EXPECT_EQ(scene.materials[scene.meshes[0].material].name, "floor");
  JobRequest request = SmallRequest(4, 4, 16);
  request.catchers = {"walls"};
  ExpectRefused(scene, request, "no material and no mesh has this name; there are wall,");
}

TEST(Catchers, RequestsThatCannotCatchAreRefusedByName) {
  Scene scene = WithObjects(PlaceScene());
  const JobRequest plain = SmallRequest(4, 4, 16);
  const auto refused = [&](const std::string& word, const auto& ask) {
    JobRequest request = plain;
    ask(request);
    ExpectRefused(scene, request, word);
  };
  refused("the scene has no catchers",
          [](JobRequest& request) { request.options.aovs = AovsOf(AovSum::kShadow); });
  CatchPlace(scene);
  EXPECT_NO_THROW(RenderJob(scene, plain));
  refused("direct or path", [](JobRequest& request) { request.integrator = Integrator::kBdpt; });
  refused("split", [](JobRequest& request) { request.options.bsdf_samples = 2; });
  refused("max-depth 0", [](JobRequest& request) { request.max_depth = 0; });
}

// The share that a pixel hides is by the weights of its filter, signed ones included.
TEST(Catchers, AlphaIsTheCoverageOfThePixelsFilter) {
  for (const PixelFilter filter : {PixelFilter::kBox, PixelFilter::kMitchell}) {
    Scene scene = PlaceScene();
    scene.meshes.resize(1);  // half of the film sees the left half of a floor from above
    scene.camera = LookAtCamera({3, 5, 0}, {3, 0, 0}, {0, 0, -1}, 40, false);
    JobRequest request = SmallRequest(16, 16, 256);
    request.filter = filter;
    const Rendered with = Render(scene, request);
    for (int y = 0; y < 16; ++y) {
      for (int x = 0; x < 16; ++x) {
        const double alpha = with.Layer("alpha.A", std::size_t(y * 16 + x));
        if (x < 5) {
          EXPECT_EQ(alpha, 1) << x;
        }
        if (x > 10) {
          EXPECT_EQ(alpha, 0) << x;
          EXPECT_EQ(with.beauty.rgb[std::size_t(3 * (y * 16 + x))], 0);
        }
      }
    }
  }
}

}  // namespace
}  // namespace skywave
