// Tests pictures by other weights of their lights.
#include "job/relight.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "base/error.h"
#include "job/session.h"
#include "tests/support/render_scenes.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

// A floor under a white sky and a red sun; one of them may be dark.
Scene LitFloor(float sky, float sun) {
  Scene scene;
  Place(scene, Quad(5), AddLambert(scene, "floor", glm::vec3(0.5f)), glm::vec3(0));
  Place(scene, Sphere(0.5f), AddLambert(scene, "ball", glm::vec3(0.7f)), {0, 0.5f, 0});
  scene.camera = LookAtCamera({0, 3, 5}, {0, 0, 0}, {0, 1, 0}, 40, false);
  SetConstantLight(scene, sky);
  if (sun > 0) {
    scene.lights.push_back({.name = "sun",
                            .kind = LocalLightKind::kDistant,
                            .emission = sun * glm::vec3(4, 2, 1),
                            .direction = glm::normalize(glm::vec3(0.5f, 1, 0.3f))});
  }
  return scene;
}

constexpr std::uint32_t kSamples = 64;

class RelightFiles : public testing::Test {
 protected:
  // Renders both lights to files; returns the picture.
  Picture Render(const Scene& scene, JobRequest request = SmallRequest(20, 15, kSamples)) {
    request.options.aovs |= *ParseAovs("lights");
    const RenderJob job(scene, request);
    const PictureIdentity identity = IdentityOf(job, {}, true);
    const RenderedFilm rendered = RunSession(job, identity, {});
    WriteFilm(folder_.Path("lit.film"), identity, job.options().aovs, rendered);
    Picture picture = ResolvePicture(rendered.film, rendered.samples, job.options().aovs, identity,
                                     rendered.part);
    WriteExr(folder_.Path("lit.exr"), picture);
    return picture;
  }

  // Expects InputError whose text has `word`.
  template <class F>
  void ExpectRefused(const F& f, const std::string& word) {
    try {
      f();
      ADD_FAILURE() << "not refused: " << word;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  }

  TemporaryFolder folder_;
};

double MeanOf(const Image& image, std::size_t channel) {
  double sum = 0;
  for (std::size_t i = channel; i < image.rgb.size(); i += 3) sum += image.rgb[i];
  return sum * 3 / double(image.rgb.size());
}

TEST_F(RelightFiles, WeightsOfOneGiveThePicture) {
  const Picture picture = Render(LitFloor(1, 1));
  for (const char* const file : {"lit.exr", "lit.film"}) {
    const LitPicture lit = ReadLitPicture(folder_.Path(file), {});
    EXPECT_EQ(lit.groups, (std::vector<std::string>{"environment", "sun"})) << file;
    const Image same = Relit(lit, {});
    for (std::size_t i = 0; i < same.rgb.size(); ++i) {
      ASSERT_NEAR(same.rgb[i], picture.image.rgb[i], 2e-7f * picture.image.rgb[i]);
    }
  }
}

// Light is linear: the picture of other lights is that of other weights, but for noise.
TEST_F(RelightFiles, WeightsGiveThePictureOfThoseLights) {
  Render(LitFloor(1, 1));
  const LitPicture lit = ReadLitPicture(folder_.Path("lit.exr"), {});
  const Image mixed = Relit(lit, {{"environment", {0.25f, 0.25f, 0.25f}}, {"sun", {3, 3, 3}}});
  const Image rendered = Render(LitFloor(0.25f, 3)).image;
  const Image red = Relit(lit, {{"environment", {0, 0, 0}}, {"sun", {1, 0, 0}}});
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(MeanOf(mixed, c), MeanOf(rendered, c), 0.02 * MeanOf(rendered, c)) << c;
  }
  EXPECT_GT(MeanOf(red, 0), 0.1);
  EXPECT_EQ(MeanOf(red, 1), 0);
}

TEST_F(RelightFiles, PicturesThatAreNoSumOfTheirLightsAreRefused) {
  JobRequest catching = SmallRequest(20, 15, 4);
  catching.catchers = {"floor"};
  const Scene scene = LitFloor(1, 1);
  Render(scene, catching);
  ExpectRefused([&] { ReadLitPicture(folder_.Path("lit.exr"), {}); }, "do not add up");
  WriteExr(folder_.Path("plain.exr"), Image(4, 3));
  ExpectRefused([&] { ReadLitPicture(folder_.Path("plain.exr"), {}); }, "--aovs lights");
  Render(scene);
  const LitPicture lit = ReadLitPicture(folder_.Path("lit.exr"), {});
  ExpectRefused([&] { Relit(lit, {{"son", {1, 1, 1}}}); }, "sun");
}

TEST_F(RelightFiles, TablesHaveAPictureARow) {
  const auto rows = ReadWeightTable(
      folder_.Write("t.csv", "# comment\nsun, sky.r,sky.g,sky.b\r\n1,2,3,4\n\n 0.5,0,1e-1,7\n"));
  ASSERT_EQ(rows.size(), 2u);
  ASSERT_EQ(rows[1].size(), 2u);
  EXPECT_EQ(rows[1][0].group, "sun");
  EXPECT_EQ(rows[1][0].factor, (std::array<float, 3>{0.5f, 0.5f, 0.5f}));
  EXPECT_EQ(rows[1][1].group, "sky");
  EXPECT_EQ(rows[1][1].factor, (std::array<float, 3>{0, 0.1f, 7}));
  for (const auto& [text, word] : {std::pair("sun\n1,2\n", "t.csv:2"),
                                   {"sun\nx\n", "'x' is no weight"},
                                   {"sun,\n1,1\n", "t.csv:2"},
                                   {"", "no row"},
                                   {"sun\n", "no row"},
                                   {"sun\nnan\n", "no weight"}}) {
    folder_.Write("t.csv", text);
    ExpectRefused([&] { ReadWeightTable(folder_.Path("t.csv")); }, word);
  }
}

TEST(LightWeight, IsANameAndOneOrThreeNumbers) {
  const Codec<LightWeight> codec = LightWeights();
  const auto weight = codec.parse("a=b=0.5/0.6/1");
  ASSERT_TRUE(weight.has_value());
  EXPECT_EQ(weight->group, "a=b");
  EXPECT_EQ(weight->factor, (std::array<float, 3>{0.5f, 0.6f, 1}));
  EXPECT_EQ(codec.print(*codec.parse("key=2")), "key=2/2/2");
  for (const char* const bad : {"key", "=2", "key=", "key=1/2", "key=1/2/x", "key=1/2/3/4"}) {
    EXPECT_FALSE(codec.parse(bad).has_value()) << bad;
  }
}

}  // namespace
}  // namespace skywave
