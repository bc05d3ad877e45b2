// Tests clamps against what single samples have brought: each part of a path is at most its limit,
// in its own colour.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/film_layers.h"
#include "tests/support/refused.h"
#include "tests/support/render_scenes.h"
#include "wavefront/stages/clamps.h"

namespace skywave {
namespace {

constexpr float kDirect = 0.15f, kIndirect = 0.08f;

// A copper ball in a matt room, which a sun shines into.
JobRequest Request(const std::string& integrator, std::uint32_t seed, std::uint32_t samples = 1) {
  JobRequest request = SmallRequest(40, 30, samples);
  request.integrator = integrator == "direct" ? Integrator::kDirect : Integrator::kPath;
  request.options.bsdf_samples = integrator == "split" ? 3 : 0;
  if (integrator == "one surface") request.options.max_depth = 1;
  request.options.seed = seed;
  return request;
}

JobRequest Clamped(JobRequest request, float direct, float indirect) {
  request.options.of<ClampOptions>() = {.direct = direct, .indirect = indirect};
  return request;
}

std::vector<float> Picture(const Scene& scene, const JobRequest& request) {
  return Render(RenderJob(scene, request)).Resolve(request.samples_per_pixel.value()).rgb;
}

// The channels of a layer, pixel by pixel.
std::vector<float> Interleaved(const Layers& layers, const std::string& name) {
  const std::size_t pixels = layers.at(name + ".R").size();
  std::vector<float> rgb(3 * pixels);
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<float>& channel = layers.at(name + "." + "RGB"[c]);
    for (std::size_t i = 0; i < pixels; ++i) rgb[3 * i + c] = channel[i];
  }
  return rgb;
}

// Limits pixels, whose largest channel decides; returns how many were above the limit.
std::size_t Limit(std::vector<float>& rgb, float limit) {
  std::size_t above = 0;
  for (std::size_t i = 0; i < rgb.size(); i += 3) {
    const float most = std::max({rgb[i], rgb[i + 1], rgb[i + 2]});
    if (most <= limit) continue;
    ++above;
    for (std::size_t c = 0; c < 3; ++c) rgb[i + c] *= limit / most;
  }
  return above;
}

class Clamps : public testing::TestWithParam<std::string> {};

// With one sample a pixel is a path, and its layers are the parts that are clamped.
TEST_P(Clamps, LimitEachPartOfEachPath) {
  const Scene scene = RoomUnderSkylight();
  std::size_t of_direct = 0, of_indirect = 0;
  for (std::uint32_t seed = 1; seed <= 8; ++seed) {
    const JobRequest request = Request(GetParam(), seed);
    const Layers layers = Resolve(MakeJob(scene, request, "direct,indirect"));
    const std::vector<float> direct = Interleaved(layers, "direct"),
                             indirect = Interleaved(layers, "indirect");
    std::vector<float> less_direct = direct, less_indirect = indirect;
    of_direct += Limit(less_direct, kDirect), of_indirect += Limit(less_indirect, kIndirect);
    const std::vector<float> a = Picture(scene, Clamped(request, kDirect, 0)),
                             b = Picture(scene, Clamped(request, 0, kIndirect)),
                             c = Picture(scene, Clamped(request, kDirect, kIndirect));
    for (std::size_t i = 0; i < direct.size(); ++i) {
      const float tolerance = 1e-5f * (0.1f + direct[i] + indirect[i]);
      ASSERT_NEAR(a[i], less_direct[i] + indirect[i], tolerance) << seed << " " << i;
      ASSERT_NEAR(b[i], direct[i] + less_indirect[i], tolerance) << seed << " " << i;
      ASSERT_NEAR(c[i], less_direct[i] + less_indirect[i], tolerance) << seed << " " << i;
    }
    // The layers of a clamped picture are those of its parts.
    const Layers clamped =
        Resolve(MakeJob(scene, Clamped(request, kDirect, kIndirect), "direct,indirect"));
    const std::vector<float> clamped_direct = Interleaved(clamped, "direct");
    for (std::size_t i = 0; i < direct.size(); ++i) {
      ASSERT_NEAR(clamped_direct[i], less_direct[i], 1e-5f * (0.1f + direct[i]));
    }
  }
  EXPECT_GT(of_direct, 20u);
  // There is hardly a mirror, and indirect light needs two surfaces.
  if (GetParam() == "direct" || GetParam() == "one surface") return;
  EXPECT_GT(of_indirect, 50u);
}

// The largest channel of a sample decides, or its luminance.
TEST_P(Clamps, LimitTheSampleByItsLargestChannelOrItsLuminance) {
  constexpr float kSample = 0.18f, kLuminance = 0.12f;
  const Scene scene = RoomUnderSkylight();
  std::size_t of_samples = 0, of_luminance = 0;
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    const JobRequest request = Request(GetParam(), seed);
    const std::vector<float> plain = Picture(scene, request);
    std::vector<float> less = plain, darker = plain;
    of_samples += Limit(less, kSample);
    for (std::size_t i = 0; i < plain.size(); i += 3) {
      const double y = 0.2125 * plain[i] + 0.7154 * plain[i + 1] + 0.0721 * plain[i + 2];
      if (y <= kLuminance) continue;
      ++of_luminance;
      for (std::size_t c = 0; c < 3; ++c) darker[i + c] *= float(kLuminance / y);
    }
    JobRequest by_channel = request, by_luminance = request;
    by_channel.options.of<ClampOptions>().sample = kSample;
    by_luminance.options.of<ClampOptions>().luminance = kLuminance;
    const std::vector<float> a = Picture(scene, by_channel), b = Picture(scene, by_luminance);
    for (std::size_t i = 0; i < plain.size(); ++i) {
      ASSERT_NEAR(a[i], less[i], 1e-5f * (0.1f + plain[i])) << seed << " " << i;
      ASSERT_NEAR(b[i], darker[i], 1e-5f * (0.1f + plain[i])) << seed << " " << i;
    }
  }
  EXPECT_GT(of_samples, 20u);
  EXPECT_GT(of_luminance, 20u);
}

TEST_P(Clamps, ThatNothingReachesChangeNoBit) {
  const Scene scene = RoomUnderSkylight();
  const JobRequest request = Request(GetParam(), 3, 4);
  EXPECT_EQ(Picture(scene, Clamped(request, 1e11f, 1e11f)), Picture(scene, request));
}

// A file may ask for limits, which a user can change or lift.
TEST(Clamps, OfTheSceneHoldUnlessTheUserGivesOthers) {
  Scene scene = RoomUnderSkylight();
  JobRequest request = Request("path", 1);
  JobRequest limited = request, lifted = request;
  limited.options.of<ClampOptions>().sample = 0.18f;
  lifted.options.of<ClampOptions>().sample = ClampOptions::kLifted;
  const std::vector<float> plain = Picture(scene, request), less = Picture(scene, limited);
  EXPECT_NE(plain, less);
  scene.settings.largest_of_sample = 0.18f;
  EXPECT_EQ(Picture(scene, request), less);
  EXPECT_EQ(Picture(scene, lifted), plain);
  request.integrator = Integrator::kBdpt;
  const std::vector<std::string> notes = RenderJob(scene, request).notes();
  EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
    return note.find("samples are not limited to a largest component of 0.18") != note.npos;
  }));
}

INSTANTIATE_TEST_SUITE_P(All, Clamps, testing::Values("path", "direct", "split", "one surface"),
                         [](const auto& of) { return of.param.substr(0, of.param.find(' ')); });

// What catchers look like without the objects is clamped as what they look like with them.
TEST(ClampsOfCatchers, LimitThePlaceAsWell) {
  Scene scene;
  const std::uint32_t floor = AddLambert(scene, "floor", {0.5f, 0.4f, 0.3f});
  Place(scene, Quad(3), floor, glm::vec3(0));
  Place(scene, Sphere(0.5f), AddLambert(scene, "red", {0.7f, 0.1f, 0.1f}), {0, 0.5f, 0});
  scene.materials[floor].catcher = true;
  SetLight(scene, SkyWithSun(64, 32, 40, 0.2));
  scene.camera = LookAtCamera({0.5f, 2.5f, 5}, {0, 0.4f, 0}, {0, 1, 0}, 40, false);
  std::size_t above = 0;
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    JobRequest request = Request("one surface", seed);
    request.background = Background::kTransparent;
    request.options.aovs = ParseAovs("albedo").value();
    const auto layers = [&](const JobRequest& some) {
      return ByName(Render(RenderJob(scene, some)).ResolveAovs(1));
    };
    const Layers plain = layers(request), clamped = layers(Clamped(request, kDirect, 0));
    const std::vector<float> difference = Interleaved(plain, "difference"),
                             less = Interleaved(clamped, "difference"),
                             albedo = Interleaved(plain, "albedo");
    std::vector<float> with = Picture(scene, request), without = with;
    for (std::size_t i = 0; i < with.size(); ++i) without[i] -= difference[i];
    above += Limit(with, kDirect) + Limit(without, kDirect);
    for (std::size_t i = 0; i < with.size(); ++i) {
      const bool of_floor = albedo[3 * (i / 3) + 1] > 0.3f;  // the ball is less green
      if (!of_floor) continue;
      ASSERT_NEAR(less[i], with[i] - without[i], 1e-4f) << seed << " " << i;
    }
  }
  EXPECT_GT(above, 20u);
}

TEST(Clamps, AreRefusedWhereTheyAreNotKnown) {
  const Scene scene = RoomUnderSkylight();
  JobRequest request = Clamped(Request("path", 1), 0, 1);
  request.integrator = Integrator::kBdpt;
  ExpectRefused(scene, request, "direct or path");
  request.integrator = Integrator::kPath;
  request.options.aovs = ParseAovs("lights").value();
  ExpectRefused(scene, request, "light groups");
}

}  // namespace
}  // namespace skywave
