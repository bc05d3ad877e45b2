// Tests that pictures with catchers are cleaned part by part, and that their layers go together.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "base/error.h"
#include "job/denoise/catchers.h"
#include "job/denoise/denoise.h"
#include "job/denoise/input.h"
#include "tests/support/film_layers.h"
#include "tests/support/render_scenes.h"

namespace skywave {
namespace {

constexpr int kSide = 64;

// A floor under a sky with a sun, and objects on it.
Scene FloorScene(bool visible_objects) {
  Scene scene;
  Place(scene, Quad(20), AddLambert(scene, "floor", {0.5f, 0.4f, 0.3f}), glm::vec3(0));
  scene.materials[0].catcher = true;
  const float up = visible_objects ? 0.5f : -2;
  Place(scene, Sphere(0.5f), AddLambert(scene, "red", {0.7f, 0.1f, 0.1f}), {-0.6f, up, 0});
  Place(scene, Sphere(0.5f), AddLambert(scene, "blue", {0.1f, 0.2f, 0.7f}), {0.6f, up, 0.3f});
  SetLight(scene, SkyWithSun(64, 32, 40, 0.2));
  scene.camera = LookAtCamera({0, 2.5f, 4}, {0, 0.3f, 0}, {0, 1, 0}, 40, false);
  return scene;
}

// A picture with alpha, and the layers that a denoiser reads.
struct Rendered {
  Image image;
  std::vector<float> alpha;
  std::vector<NamedChannel> layers;

  const std::vector<float>& at(const std::string& name) const {
    return std::find_if(layers.begin(), layers.end(),
                        [&](const NamedChannel& layer) { return layer.name == name; })
        ->values;
  }
};

JobRequest Request(std::uint32_t samples, Background background = Background::kTransparent) {
  JobRequest request = SmallRequest(kSide, kSide, samples);
  request.background = background;
  return request;
}

// Renders a picture; one without its background shows the foreground.
Rendered Render(const Scene& scene, const JobRequest& request) {
  const RenderJob job = MakeJob(scene, request, "denoiser");
  const Film film = skywave::Render(job);
  const std::uint32_t samples = job.options().samples_per_pixel;
  Rendered rendered = {film.Resolve(samples), {}, film.ResolveAovs(samples)};
  if (request.background == Background::kMap) return rendered;
  rendered.alpha = rendered.at("alpha.A");
  for (std::size_t i = 0; i < rendered.image.rgb.size(); ++i) {
    const std::string channel(1, "RGB"[i % 3]);
    rendered.image.rgb[i] = rendered.at("foreground." + channel)[i / 3];
  }
  return rendered;
}

Cleaning Clean(Rendered& rendered) {
  return CleanPicture(Denoiser::kStatistics, "noisy.exr", rendered.image, rendered.alpha,
                      rendered.layers);
}

double SquaredDistance(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::pow(double(a[i]) - b[i], 2);
  return sum;
}

// Returns the values of pixels that show nothing but catchers.
std::vector<float> OfWholePixels(const Rendered& rendered, const std::vector<float>& values) {
  std::vector<float> whole;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (rendered.at("clean.A")[i] == 1) whole.push_back(values[i]);
  }
  return whole;
}

double SumOf(const std::vector<float>& values) {
  double sum = 0;
  for (const float value : values) sum += value;
  return sum;
}

TEST(CatchersDenoised, AllLayersComeNearerToTheTruthAndKeepTheirMean) {
  const Scene scene = FloorScene(true);
  JobRequest request = Request(2048);
  request.options.seed = 7;
  const Rendered truth = Render(scene, request), noisy = Render(scene, Request(16));
  Rendered clean = noisy;
  const Cleaning cleaning = Clean(clean);
  EXPECT_LT(SquaredDistance(clean.image.rgb, truth.image.rgb),
            0.5 * SquaredDistance(noisy.image.rgb, truth.image.rgb));
  EXPECT_LT(SquaredDistance(clean.alpha, truth.alpha),
            0.5 * SquaredDistance(noisy.alpha, truth.alpha));
  for (const std::string channel : {"R", "B"}) {
    const std::string change = "difference." + channel, shadow = "shadow." + channel;
    EXPECT_LT(SquaredDistance(clean.at(change), truth.at(change)),
              0.5 * SquaredDistance(noisy.at(change), truth.at(change)));
    // A ratio says little where objects hide most of a pixel.
    EXPECT_LT(SquaredDistance(OfWholePixels(truth, clean.at(shadow)),
                              OfWholePixels(truth, truth.at(shadow))),
              0.5 * SquaredDistance(OfWholePixels(truth, noisy.at(shadow)),
                                    OfWholePixels(truth, truth.at(shadow))));
  }
  EXPECT_NEAR(SumOf(clean.at("difference.G")) / SumOf(truth.at("difference.G")), 1, 0.03);
  EXPECT_NEAR(SumOf(clean.image.rgb) / SumOf(truth.image.rgb), 1, 0.03);
  int outside = 0;
  for (std::size_t i = 0; i < truth.image.rgb.size(); ++i) {
    const double error = cleaning.error[i % 3].values[i / 3];
    outside += std::abs(clean.image.rgb[i] - truth.image.rgb[i]) > 1.96 * error + 1e-6;
  }
  EXPECT_LT(outside, 0.1 * double(truth.image.rgb.size()));
  EXPECT_EQ(cleaning.oidn, "");
}

TEST(CatchersDenoised, LayersGoTogether) {
  Rendered clean = Render(FloorScene(true), Request(16));
  Clean(clean);
  int of_objects = 0, of_catchers = 0;
  for (std::size_t i = 0; i < clean.alpha.size(); ++i) {
    const float shadows[] = {clean.at("shadow.R")[i], clean.at("shadow.G")[i],
                             clean.at("shadow.B")[i]};
    const float change = clean.at("difference.G")[i];
    const double kept = std::min({double(shadows[0]), double(shadows[1]), double(shadows[2]), 1.0});
    if (clean.at("clean.A")[i] == 0) {
      EXPECT_EQ(clean.alpha[i], clean.at("objects.A")[i]);
      EXPECT_EQ(shadows[1], 1);
      EXPECT_EQ(change, 0);
      ++of_objects;
    } else if (clean.at("objects.A")[i] == 0) {
      EXPECT_NEAR(clean.alpha[i], (1 - kept) * clean.at("clean.A")[i], 1e-6);
      EXPECT_EQ(change == 0, shadows[1] == 1);
      EXPECT_GE(shadows[1], 0);
      // The darkest channel is all shadow, and has no light of its own.
      const std::size_t darkest = std::size_t(std::min_element(shadows, shadows + 3) - shadows);
      if (shadows[darkest] < 1) {
        EXPECT_NEAR(clean.image.rgb[3 * i + darkest], 0, 1e-6);
      }
      ++of_catchers;
    }
    for (std::size_t c = 0; c < 3; ++c) EXPECT_GE(clean.image.rgb[3 * i + c], 0);
  }
  EXPECT_GT(of_objects, 100);
  EXPECT_GT(of_catchers, kSide * kSide / 2);
}

TEST(CatchersDenoised, ObjectsTakeNoMoreLightThanThereIs) {
  Rendered clean = Render(FloorScene(true), Request(8));
  for (NamedChannel& layer : clean.layers) {
    if (!layer.name.starts_with("difference.")) continue;
    for (float& value : layer.values) value *= 3;
  }
  Clean(clean);
  int black = 0;
  for (const float shadow : clean.at("shadow.G")) {
    EXPECT_GE(shadow, 0);
    black += shadow == 0;
  }
  EXPECT_GT(black, 50);
}

TEST(CatchersDenoised, ObjectsThatChangeNothingLeaveNoTrace) {
  Rendered clean = Render(FloorScene(false), Request(8));
  const Image noisy = clean.image;
  Clean(clean);
  EXPECT_EQ(clean.image.rgb, noisy.rgb);
  for (std::size_t i = 0; i < clean.alpha.size(); ++i) {
    EXPECT_EQ(clean.alpha[i], 0);
    EXPECT_EQ(clean.at("difference.R")[i], 0);
    EXPECT_EQ(clean.at("shadow.B")[i], 1);
  }
}

TEST(CatchersDenoised, ABackgroundChangesNoLayer) {
  const Scene scene = FloorScene(true);
  Rendered transparent = Render(scene, Request(16));
  Clean(transparent);
  Rendered whole = Render(scene, Request(16, Background::kMap));
  const std::vector<NamedChannel> layers = whole.layers;
  Image beauty = whole.image;
  Clean(whole);
  EXPECT_TRUE(whole.alpha.empty());
  EXPECT_EQ(whole.image.rgb, Denoise(Denoiser::kStatistics, "noisy.exr", beauty, layers).image.rgb);
  EXPECT_EQ(whole.at("alpha.A"), transparent.alpha);
  EXPECT_EQ(whole.at("shadow.R"), transparent.at("shadow.R"));
  EXPECT_EQ(whole.at("difference.B"), transparent.at("difference.B"));
  for (std::size_t i = 0; i < transparent.alpha.size(); ++i) {
    EXPECT_EQ(whole.at("foreground.G")[i], transparent.image.rgb[3 * i + 1]);
  }
}

// Sums of the difference have signs in films whose other sums have none.
TEST(CatchersDenoised, PartsOfAPictureAddUp) {
  const Scene scene = FloorScene(true);
  const RenderJob job = MakeJob(scene, Request(16), "denoiser");
  const Film whole = skywave::Render(job);
  FrameView frame = job.frame();
  Film first = job.MakeFilm(), second = job.MakeFilm();
  frame.options.first_sample = 0, frame.options.samples_per_pixel = 5;
  RenderFrame(frame, first);
  frame.options.first_sample = 5, frame.options.samples_per_pixel = 11;
  RenderFrame(frame, second);
  first.Merge(second);
  EXPECT_EQ(ByName(first.ResolveAovs(16)), ByName(whole.ResolveAovs(16)));
}

// A part ends where others hide it: that is an edge, and outliers are not spread beyond it.
TEST(CatchersDenoised, PartsAreSeenInTheirShareOfAPixel) {
  const Rendered noisy = Render(FloorScene(true), Request(8));
  const DenoiserInput input =
      FindInput("noisy.exr", noisy.image, noisy.layers, {"objects-", "objects.A"});
  EXPECT_EQ(input.coverage.data(), noisy.at("objects.A").data());
  EXPECT_EQ(input.variance[1].data(), noisy.at("objects-variance.G").data());
  const DenoiserInput whole = FindInput("noisy.exr", noisy.image, noisy.layers);
  EXPECT_EQ(whole.coverage.data(), noisy.at("coverage.V").data());
  EXPECT_EQ(whole.half[2].data(), noisy.at("half.B").data());
}

TEST(CatchersDenoised, PicturesWithoutThePartsAreRefused) {
  Rendered noisy = Render(FloorScene(true), Request(8));
  std::erase_if(noisy.layers,
                [](const NamedChannel& layer) { return layer.name == "clean-half.G"; });
  try {
    Clean(noisy);
    FAIL() << "not refused";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("no channel clean-half.G"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace skywave
