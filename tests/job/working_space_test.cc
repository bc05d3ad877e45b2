// Tests scenes that are rendered in other spaces of red, green and blue.
#include "scene/working_space.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "image/primaries.h"
#include "job/picture.h"
#include "tests/support/render_scenes.h"
#include "tests/support/rendered_image.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

constexpr RgbSpace kWide[] = {RgbSpace::kRec2020, RgbSpace::kAcescg};

glm::vec3 In(RgbSpace space, const glm::vec3& color) {
  return glm::vec3(FromRec709(space) * glm::dvec3(color));
}

void ExpectColor(const glm::vec3& found, const glm::vec3& expected, float tolerance) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], tolerance * expected[c]) << c;
}

glm::vec3 Middle(const Image& image) {
  const float* const pixel = image.Pixel(image.width / 2, image.height / 2);
  return {pixel[0], pixel[1], pixel[2]};
}

JobRequest Request(RgbSpace space) {
  JobRequest request = SmallRequest(9, 9, 256);
  request.integrator = Integrator::kDirect;
  request.working_space = space;
  return request;
}

// A square seen from the front.
Scene Screen(const Material& material) {
  Scene scene;
  scene.materials.push_back(material);
  Place(scene, Quad(1), std::uint32_t(scene.materials.size() - 1), glm::vec3(0));
  scene.camera = LookAtCamera({0, 3, 0.001f}, {0, 0, 0}, {0, 0, -1}, 20, false);
  return scene;
}

constexpr glm::vec3 kRed(0.9f, 0.1f, 0.05f), kBlue(0.1f, 0.3f, 0.8f);

TEST(WorkingSpace, LampsAndMapsAreConverted) {
  for (const RgbSpace space : kWide) {
    Scene lamp =
        Screen({.reflectance = glm::vec3(0), .emission = kRed, .emits_on_both_sides = true});
    ExpectColor(Middle(Render(lamp, Request(space))), In(space, kRed), 1e-5f);
    Scene sky = Screen({.opacity = 0});
    sky.environments = {{.scale = kBlue, .world_from_map = EnvironmentFrame('y', false, 0)}};
    ExpectColor(Middle(Render(sky, Request(space))), In(space, kBlue), 4e-3f);  // packed texels
  }
}

// In a space, light is multiplied by a reflectance channel by channel.
TEST(WorkingSpace, LightIsComputedInIt) {
  for (const RgbSpace space : kWide) {
    Scene scene = Screen({.reflectance = kRed});
    scene.lights.push_back({.kind = LocalLightKind::kDistant,
                            .emission = float(M_PI) * kBlue,
                            .direction = {0, 1, 0}});
    ExpectColor(Middle(Render(scene, Request(space))), In(space, kRed) * In(space, kBlue), 1e-4f);
    ExpectColor(Middle(Render(scene, Request(RgbSpace::kRec709))), kRed * kBlue, 1e-4f);
  }
}

TEST(WorkingSpace, GreysAreTheSameInAll) {
  Scene scene = Screen({.reflectance = glm::vec3(0.5f)});
  scene.lights.push_back({.kind = LocalLightKind::kDistant,
                          .emission = glm::vec3(2),
                          .direction = glm::normalize(glm::vec3(1, 2, 1))});
  const glm::vec3 expected = Middle(Render(scene, Request(RgbSpace::kRec709)));
  for (const RgbSpace space : kWide) {
    ExpectColor(Middle(Render(scene, Request(space))), expected, 1e-5f);
  }
}

// Metals reflect their colour at normal incidence, whatever its index.
TEST(WorkingSpace, MetalsReflectTheirColour) {
  const Material copper = {.bsdf = BsdfKind::kConductor,
                           .reflectance = glm::vec3(1),
                           .eta = {0.2f, 0.92f, 1.1f},
                           .k = {3.9f, 2.45f, 2.14f},
                           .alpha = 1e-3f};
  const auto reflected = [](const Material& metal) {
    glm::vec3 r;
    for (int c = 0; c < 3; ++c) {
      const float n = metal.eta[c], k2 = metal.k[c] * metal.k[c];
      r[c] = ((n - 1) * (n - 1) + k2) / ((n + 1) * (n + 1) + k2);
    }
    return r;
  };
  for (const RgbSpace space : kWide) {
    Scene scene = Screen(copper);
    ConvertScene(space, scene);
    ExpectColor(reflected(scene.materials.back()), In(space, reflected(copper)), 1e-4f);
    EXPECT_EQ(scene.materials.back().eta, copper.eta);
    // A channel that no k makes as dark as it becomes.
    Scene dark = Screen({.bsdf = BsdfKind::kConductor, .eta = {1, 1, 9}, .k = {0.1f, 0.1f, 0}});
    const glm::vec3 before = reflected(dark.materials.back());
    ConvertScene(space, dark);
    ExpectColor(reflected(dark.materials.back()), In(space, before), 1e-4f);
    Scene mirror = Screen({.bsdf = BsdfKind::kConductor, .eta = glm::vec3(0), .k = glm::vec3(0)});
    ConvertScene(space, mirror);
    EXPECT_EQ(mirror.materials.back().k, glm::vec3(0));
  }
}

// After the mean free path, what is left of white light is the converted colour.
TEST(WorkingSpace, GlassAbsorbsItsColour) {
  Scene scene = Screen({.bsdf = BsdfKind::kDielectric, .absorption = {0.1f, 0.5f, 2.4f}});
  ConvertScene(RgbSpace::kAcescg, scene);
  const glm::vec3 found = glm::exp(-scene.materials.back().absorption);  // the mean is 1
  ExpectColor(found, In(RgbSpace::kAcescg, glm::exp(-glm::vec3(0.1f, 0.5f, 2.4f))), 1e-4f);
}

// An image that one material takes for colours and another one for roughness stays what it is for
// the other one.
TEST(WorkingSpace, ImagesOfColoursAreConvertedAndNumbersStay) {
  Scene scene;
  Image image(1, 1);
  image.rgb = {kRed.x, kRed.y, kRed.z};
  scene.images = {image, image};
  scene.textures = {{.image = 0}, {.image = 1}, {.image = 0}};
  scene.materials = {{.color_texture = 0}, {.roughness_texture = 2}, {.emission_texture = 1}};
  scene.meshes.push_back(Quad(1));
  scene.meshes.back().colors.assign(scene.meshes.back().positions.size(), kBlue);
  ConvertScene(RgbSpace::kAcescg, scene);
  const auto color_of = [&](const std::optional<std::uint32_t>& texture) {
    const std::vector<float> rgb = scene.images[scene.textures[*texture].image].Floats().rgb;
    return glm::vec3(rgb[0], rgb[1], rgb[2]);
  };
  ExpectColor(color_of(scene.materials[0].color_texture), In(RgbSpace::kAcescg, kRed), 1e-5f);
  ExpectColor(color_of(scene.materials[2].emission_texture), In(RgbSpace::kAcescg, kRed), 1e-5f);
  EXPECT_EQ(color_of(scene.materials[1].roughness_texture), kRed);
  ExpectColor(scene.meshes[0].colors[0], In(RgbSpace::kAcescg, kBlue), 1e-5f);
}

// A lamp has its colour in every PNG, and the EXR says what its numbers are.
TEST(WorkingSpace, PicturesShowTheSameColours) {
  const TemporaryFolder folder;
  for (const RgbSpace space : {RgbSpace::kRec709, RgbSpace::kRec2020, RgbSpace::kAcescg}) {
    const RenderJob job(
        Screen({.reflectance = glm::vec3(0), .emission = kRed, .emits_on_both_sides = true}),
        Request(space));
    Film film = job.MakeFilm();
    RenderFrame(job.frame(), film);
    const SampleRange samples = {0, 256};
    const Picture picture =
        ResolvePicture(film, samples.count(), 0, IdentityOf(job, {}, true), PartOf(job, samples));
    EXPECT_EQ(picture.space, space);
    const std::string path = folder.Path("lamp.exr");
    WriteExrAndPng(path, picture);
    EXPECT_EQ(ReadOwnColors(path).space, space);
    ExpectColor(Middle(ReadImage(path)), kRed, 1e-4f);
    const Image seen = ReadTexture(folder.Path("lamp.png"), Encoding::kSrgb);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(Middle(seen)[c], kRed[c], 0.005f);
  }
}

}  // namespace
}  // namespace skywave
