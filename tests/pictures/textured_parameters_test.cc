// Parameters of pbrt's materials that have an image: an image of one value is that value, and an
// image of two halves is each of them on its side.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <string>

#include "image/image.h"
#include "scene/pbrt/reader.h"
#include "tests/support/made_image.h"
#include "tests/support/render_scenes.h"
#include "tests/support/temporary_folder.h"
#include "wavefront/option_names.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

constexpr int kSide = 32;

// A material with @ for its parameter, as a number, a colour or a texture of the type; the values
// are a float's if `type` is.
struct TexturedCase {
  std::string name, material, type, parameter;
  glm::vec3 left, right;
  std::string more = "";
  bool compensated = true;  // false: what facets scatter more than once is left out
  // The tables of coats over metal are those of a few widths: albedos are within 2 %.
  double bound = 0.006;
};
void PrintTo(const TexturedCase& test, std::ostream* out) { *out << test.name; }

class TexturedParameters : public testing::TestWithParam<TexturedCase> {
 protected:
  // Renders a sheet that faces the camera, under a faint sky, a sun on each side and a lamp.
  Image Render(const std::string& parameter, const std::string& textures = "",
               Integrator integrator = Integrator::kPath) const {
    const TexturedCase& test = GetParam();
    const std::string text =
        "LookAt 0 0 -4  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" 40\n"
        "PixelFilter \"box\" WorldBegin\n"
        "LightSource \"infinite\" \"rgb L\" [.2 .3 .4]\n"
        "LightSource \"distant\" \"rgb L\" [2 2 2] \"point3 from\" [1 1 -3]\n"
        "LightSource \"distant\" \"rgb L\" [1 2 1] \"point3 from\" [-1 1 3]\n"
        "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [3 3 3] \"bool twosided\" true\n"
        "Translate 0 0 -5 Shape \"disk\" \"float radius\" 2 \"float innerradius\" 1 "
        "AttributeEnd\n" +
        textures + "Material \"" + test.material + "\" " + parameter + " " + test.more +
        " Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" "
        "[-1.4 -1.4 0 1.4 -1.4 0 1.4 1.4 0 -1.4 1.4 0] \"point2 uv\" [0 0 1 0 1 1 0 1]\n";
    Scene scene = ParsePbrt(text, folder_.Path("t.pbrt"), {.strict = true});
    for (Material& material : scene.materials) {
      material.energy_compensation = material.energy_compensation && test.compensated;
    }
    JobRequest request = SmallRequest(kSide, kSide, 256);
    request.max_depth = 3;
    request.integrator = integrator;
    const RenderJob job(scene, request);
    Film film = job.MakeFilm();
    RenderFrame(job.frame(), film);
    return film.Resolve(job.options().samples_per_pixel);
  }
  Image RenderConstant(const glm::vec3& value) const {
    const TexturedCase& test = GetParam();
    const std::string numbers = test.type == "float"
                                    ? fmt::format("{}", value.x)
                                    : fmt::format("{} {} {}", value.x, value.y, value.z);
    const std::string type = test.type == "float" ? "float" : "rgb";
    return Render(fmt::format("\"{} {}\" [{}]", type, test.parameter, numbers));
  }
  Image RenderTextured(const glm::vec3& left, const glm::vec3& right,
                       Integrator integrator = Integrator::kPath) const {
    const TexturedCase& test = GetParam();
    WriteImage(folder_.Path("image.pfm"),
               MadeImage(32, 1, [&](int x, int) { return x < 16 ? left : right; }));
    return Render(fmt::format("\"texture {}\" \"t\"", test.parameter),
                  fmt::format("Texture \"t\" \"{}\" \"imagemap\" \"string filename\" "
                              "\"image.pfm\" \"string wrap\" \"clamp\"\n",
                              test.type),
                  integrator);
  }

  TemporaryFolder folder_;
};

// Columns of the picture: the halves of the sheet, without what is near their rims, and both.
struct Columns {
  int begin, end;
};
constexpr Columns kLeft = {3, 14}, kRight = {18, 29}, kBoth = {3, 29};

glm::dvec3 Mean(const Image& image, Columns columns) {
  glm::dvec3 sum(0);
  for (int y = 3; y < kSide - 3; ++y) {
    for (int x = columns.begin; x < columns.end; ++x) {
      const float* const rgb = image.Pixel(x, y);
      sum += glm::dvec3(rgb[0], rgb[1], rgb[2]);
    }
  }
  return sum / double((columns.end - columns.begin) * (kSide - 6));
}

// Expects the same means but for a share `bound` in each channel.
void ExpectSame(const glm::dvec3& found, const glm::dvec3& expected, double bound) {
  const glm::dvec3 change = glm::abs(found / expected - 1.0);
  EXPECT_LT(std::max({change.x, change.y, change.z}), bound)
      << found.x << " " << found.y << " " << found.z << " against " << expected.x << " "
      << expected.y << " " << expected.z;
}

TEST_P(TexturedParameters, TexturesEqualConstantsOfTheirValues) {
  const TexturedCase& test = GetParam();
  const Image left = RenderConstant(test.left), right = RenderConstant(test.right);
  const Image uniform = RenderTextured(test.left, test.left);
  const Image halves = RenderTextured(test.left, test.right);
  ExpectSame(Mean(uniform, kBoth), Mean(left, kBoth), test.bound);
  // uv (0, 0) is in the lower left corner, which a left-handed camera sees there.
  ExpectSame(Mean(halves, kLeft), Mean(left, kLeft), test.bound);
  ExpectSame(Mean(halves, kRight), Mean(right, kRight), test.bound);
  // The parameter matters.
  const glm::dvec3 change = glm::abs(Mean(left, kRight) / Mean(right, kRight) - 1.0);
  EXPECT_GT(std::max({change.x, change.y, change.z}), 0.04);
}

// Light paths scatter by the same textures.
TEST_P(TexturedParameters, LightPathsMatchPathTracing) {
  const TexturedCase& test = GetParam();
  const Image path = RenderTextured(test.left, test.right);
  const Image bdpt = RenderTextured(test.left, test.right, Integrator::kBdpt);
  ExpectSame(Mean(bdpt, kBoth), Mean(path, kBoth), 0.02);
}

const std::string kGold = "\"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\"";
INSTANTIATE_TEST_SUITE_P(
    Pbrt, TexturedParameters,
    testing::Values(
        TexturedCase{"ConductorRoughness", "conductor", "float", "roughness", glm::vec3(0.05f),
                     glm::vec3(0.4f), kGold},
        TexturedCase{"BodyUnderCoat", "coateddiffuse", "float", "roughness", glm::vec3(0.03f),
                     glm::vec3(0.4f), "\"rgb reflectance\" [.2 .3 .1]"},
        TexturedCase{"MetalUnderCoat", "coatedconductor", "float", "conductor.roughness",
                     glm::vec3(0.05f), glm::vec3(0.4f), "\"float interface.roughness\" .04", true,
                     0.02},
        TexturedCase{"CoatOverMetal", "coatedconductor", "float", "interface.roughness",
                     glm::vec3(0.03f), glm::vec3(0.4f), "\"float conductor.roughness\" .1", true,
                     0.02},
        TexturedCase{"MetalRoughness", "metal", "float", "roughness", glm::vec3(0.05f),
                     glm::vec3(0.4f), kGold},
        TexturedCase{"ConductorWidth", "conductor", "float", "roughness", glm::vec3(0.2f),
                     glm::vec3(0.6f), kGold + " \"bool remaproughness\" false"},
        TexturedCase{"ConductorReflectance",
                     "conductor",
                     "spectrum",
                     "reflectance",
                     {0.8f, 0.5f, 0.2f},
                     {0.1f, 0.4f, 0.9f},
                     "\"float roughness\" 0.1"},
        TexturedCase{"BrushedReflectance",
                     "conductor",
                     "spectrum",
                     "reflectance",
                     {0.8f, 0.5f, 0.2f},
                     {0.1f, 0.4f, 0.9f},
                     "\"float uroughness\" 0.1 \"float vroughness\" 0.3"},
        TexturedCase{"BrushedWidth", "conductor", "float", "uroughness", glm::vec3(0.05f),
                     glm::vec3(0.4f), kGold + " \"float vroughness\" 0.1"},
        TexturedCase{"BrushedWidthAcross", "conductor", "float", "vroughness", glm::vec3(0.05f),
                     glm::vec3(0.4f), kGold + " \"float uroughness\" 0.1"},
        TexturedCase{"GroundGlass", "dielectric", "float", "vroughness", glm::vec3(0.02f),
                     glm::vec3(0.7f), "\"float uroughness\" 0.3", false},
        TexturedCase{"DielectricRoughness", "dielectric", "float", "roughness", glm::vec3(0.04f),
                     glm::vec3(0.5f)},
        TexturedCase{"Transmittance",
                     "diffusetransmission",
                     "spectrum",
                     "transmittance",
                     {0.6f, 0.5f, 0.1f},
                     {0.1f, 0.4f, 0.6f}}),
    [](const testing::TestParamInfo<TexturedCase>& test) { return test.param.name; });

}  // namespace
}  // namespace skywave
