// Tests photographs behind pictures: how they are fitted, and what the files show of them.
#include "job/backplate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "job/merge_films.h"
#include "job/session.h"
#include "scene/builtin/builtin.h"
#include "tests/support/made_image.h"
#include "tests/support/render_scenes.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

constexpr int kWidth = 24, kHeight = 18;

std::uint8_t ByteAt(int x, int y, int c) { return std::uint8_t((11 * x + 7 * y + 90 * c) % 256); }

class Photographs : public testing::Test {
 protected:
  void SetUp() override {
    std::vector<std::uint8_t> bytes;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        for (int c = 0; c < 3; ++c) bytes.push_back(ByteAt(x, y, c));
      }
    }
    WritePng(folder_.Path("plate.png"), kWidth, kHeight, bytes);
  }

  Picture Render(const std::string& plate, const ExposureRequest& exposure,
                 std::optional<CropWindow> crop = std::nullopt) {
    JobRequest request = SmallRequest(kWidth, kHeight, 4);
    request.scene = "spheres";
    request.backplate = folder_.Path(plate);
    request.catchers = {"floor"};
    request.crop = crop;
    const RenderJob job(BuiltinScene("spheres"), request);
    notes_ = job.notes();
    const PictureIdentity identity = IdentityOf(job, exposure, true);
    const RenderedFilm rendered = RunSession(job, identity, {});
    WriteFilm(folder_.Path("picture.film"), identity, job.options().aovs, rendered);
    return ResolvePicture(rendered.film, rendered.samples, job.options().aovs, identity,
                          rendered.part);
  }

  TemporaryFolder folder_;
  std::vector<std::string> notes_;
};

const std::vector<float>& Layer(const Picture& picture, const std::string& name) {
  for (const NamedChannel& channel : picture.layers) {
    if (channel.name == name) return channel.values;
  }
  throw std::runtime_error("no layer " + name);
}

// Where nothing is in front, the PNG has the bytes of the photograph, whatever the exposure of the
// picture is; elsewhere the composite is the picture over it.
TEST_F(Photographs, AreSeenAsTheyAre) {
  for (const float stops : {0.0f, 1.5f}) {
    const Picture picture = Render("plate.png", {.exposure = ExposureChoice{.stops = stops}});
    folder_.Write("seen.png", EncodePng(picture));
    EXPECT_FALSE(IsRgba(folder_.Path("seen.png")));
    const Image png = ReadTexture(folder_.Path("seen.png"), Encoding::kLinear);
    const Image plate = ReadTexture(folder_.Path("plate.png"), Encoding::kSrgb);
    int empty = 0, between = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const auto pixel = std::size_t(y * kWidth + x);
        const float alpha = picture.alpha[pixel];
        empty += alpha == 0, between += alpha > 0.05f && alpha < 0.95f;
        for (int c = 0; c < 3; ++c) {
          const float front = picture.image.Pixel(x, y)[c];
          if (alpha == 0 && front == 0) {
            ASSERT_EQ(std::lround(png.Pixel(x, y)[c] * 255), ByteAt(x, y, c)) << x << " " << y;
          }
          const float behind = plate.Pixel(x, y)[c] * std::exp2(-stops);
          const float expected = front + (1 - alpha) * behind;
          ASSERT_NEAR(Layer(picture, std::string("composite.") + "RGB"[c])[pixel], expected,
                      1e-6f + 1e-6f * expected);
        }
      }
    }
    EXPECT_GT(empty, 20);
    EXPECT_GT(between, 20);
  }
}

// A photograph of radiance is in the units of the picture.
TEST_F(Photographs, OfRadianceHaveItsUnits) {
  const Image radiance = MadeImage(
      kWidth, kHeight, [](int x, int y) { return glm::vec3(0.1f * float(x), 3, float(y)); });
  WriteExr(folder_.Path("plate.exr"), radiance);
  const Picture picture = Render("plate.exr", {.exposure = ExposureChoice{.stops = 2}});
  ASSERT_EQ(picture.alpha[5], 0);
  EXPECT_EQ(Layer(picture, "composite.G")[5], 3);
}

// What the PNG shows is exposed: with the objects alone, the photograph would not count.
TEST_F(Photographs, OfRadianceAreExposedWithThePicture) {
  const Image radiance =
      MadeImage(kWidth, kHeight, [](int x, int) { return glm::vec3(20 + 0.1f * float(x)); });
  WriteExr(folder_.Path("plate.exr"), radiance);
  const Picture picture = Render("plate.exr", {.exposure = ExposureChoice{.automatic = true}});
  EXPECT_EQ(picture.tone.exposure_stops, AutomaticExposureStops(picture.composite, {}));
  EXPECT_LT(picture.tone.exposure_stops, AutomaticExposureStops(picture.image, {}) - 1);
}

TEST_F(Photographs, BehindACropAreThoseOfItsPixels) {
  const ExposureRequest exposure = {.exposure = ExposureChoice{.stops = 0}};
  const Picture whole = Render("plate.png", exposure);
  const Picture part = Render("plate.png", exposure, CropWindow{5, 2, 11, 9});
  const std::vector<float> all = Layer(whole, "composite.R"), some = Layer(part, "composite.R");
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 11; ++x) {
      ASSERT_EQ(some[std::size_t(11 * y + x)], all[std::size_t(kWidth * (y + 2) + x + 5)]);
    }
  }
  // A film remembers its photograph.
  const Picture merged = ResolveMerged(
      MergeFilms({.films = {folder_.Path("picture.film")}, .window = CropWindow{5, 2, 11, 9}}));
  EXPECT_EQ(Layer(merged, "composite.R"), some);
}

// A linear ramp stays one where it is scaled, and the middle stays in the middle: what is beyond
// the film is cut off on both sides alike.
TEST_F(Photographs, AreScaledToCoverTheFilm) {
  const auto ramp = [&](int width, int height) {
    WriteExr(folder_.Path("ramp.exr"), MadeImage(width, height, [&](int x, int y) {
               return glm::vec3(x + 0.5f - 0.5f * float(width), y + 0.5f - 0.5f * float(height), 1);
             }));
    return ReadBackplate(folder_.Path("ramp.exr"), kWidth, kHeight);
  };
  for (const auto& [width, height] : {std::pair(2 * kWidth, 2 * kHeight),
                                      {3 * kWidth, 2 * kHeight},
                                      {kWidth / 2, kHeight},
                                      {kWidth / 2, kHeight / 2},
                                      {7 * kWidth, 10 * kHeight}}) {
    const Backplate plate = ramp(width, height);
    const double scale = std::max(double(kWidth) / width, double(kHeight) / height);
    const bool same_shape = width * kHeight == height * kWidth;
    EXPECT_NE(plate.note, "");
    EXPECT_EQ(plate.note.find("cut off") == std::string::npos, same_shape) << plate.note;
    for (int y = 2; y < kHeight - 2; ++y) {
      for (int x = 2; x < kWidth - 2; ++x) {
        const float* const rgb = plate.image.Pixel(x, y);
        ASSERT_NEAR(rgb[0], (x + 0.5 - kWidth / 2) / scale, 1e-4) << width << "x" << height;
        ASSERT_NEAR(rgb[1], (y + 0.5 - kHeight / 2) / scale, 1e-4);
        ASSERT_NEAR(rgb[2], 1, 1e-6);
      }
    }
  }
  // Where many pixels become one, it has the mean of all of them.
  WriteExr(folder_.Path("stripes.exr"), MadeImage(8 * kWidth, 8 * kHeight, [](int x, int y) {
             return glm::vec3(x % 2, y % 2, x % 8 == 0);
           }));
  const Backplate grey = ReadBackplate(folder_.Path("stripes.exr"), kWidth, kHeight);
  EXPECT_NEAR(grey.image.Pixel(9, 7)[0], 0.5, 1e-3);
  EXPECT_NEAR(grey.image.Pixel(9, 7)[1], 0.5, 1e-3);
  EXPECT_NEAR(grey.image.Pixel(9, 7)[2], 0.125, 1e-3);
  const Backplate same = ramp(kWidth, kHeight);
  EXPECT_EQ(same.note, "");
  EXPECT_EQ(same.image.Pixel(0, 0)[0], 0.5f - kWidth / 2);
}

TEST_F(Photographs, ThatAreNotOpaqueAreWarnedOf) {
  const std::vector<std::uint8_t> colors(std::size_t(kWidth) * kHeight * 3, 128);
  std::vector<std::uint8_t> alpha(std::size_t(kWidth) * kHeight, 255);
  JobRequest request = SmallRequest(kWidth, kHeight, 1);
  request.backplate = folder_.Path("alpha.png");
  folder_.Write("alpha.png", EncodePng(kWidth, kHeight, colors, alpha));
  EXPECT_TRUE(RenderJob(BuiltinScene("spheres"), request).warnings().empty());
  alpha[7] = 254;
  folder_.Write("alpha.png", EncodePng(kWidth, kHeight, colors, alpha));
  const std::vector<std::string> warnings = RenderJob(BuiltinScene("spheres"), request).warnings();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("alpha.png: the alpha of the photograph is left out"),
            std::string::npos)
      << warnings[0];
  request.read.strict = true;
  EXPECT_THROW(RenderJob(BuiltinScene("spheres"), request), InputError);
}

TEST_F(Photographs, ThatCannotBeReadAreRefusedBeforeTheFirstRay) {
  JobRequest request = SmallRequest(8, 8, 1);
  request.backplate = folder_.Path("missing.png");
  EXPECT_THROW(RenderJob(BuiltinScene("spheres"), request), InputError);
  request.backplate = folder_.Path("plate.png");
  request.background = Background::kMap;
  EXPECT_THROW(RenderJob(BuiltinScene("spheres"), request), OptionError);
  request.background.reset();
  const RenderJob job(BuiltinScene("spheres"), request);
  EXPECT_TRUE(std::any_of(job.notes().begin(), job.notes().end(), [](const std::string& note) {
    return note.find("plate.png") != std::string::npos;
  })) << "another size is told";
}

}  // namespace
}  // namespace skywave
