#include "scene/pbrt/light_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <utility>

#include "base/error.h"
#include "scene/light_shapes.h"
#include "scene/materials/texture_baking.h"
#include "scene/materials/texture_files.h"

namespace skywave {
namespace {

// Returns the equal-area square (LightMapping::kSphere) of a lat-long image whose first row is
// about +z, and whose columns turn from +x to +y.
Image SquareOfLatLong(const CompactImage& latlong) {
  constexpr int kPoints = 2;  // along each side of a texel
  Texture around;
  around.wrap_v = TextureWrap::kClamp;
  // A narrow image has few texels, however long it is.
  constexpr double kMostTexels = 4096;  // along a side
  const double even = std::ceil(std::sqrt(double(latlong.width) * latlong.height));
  const int side =
      int(std::min({double(std::max((latlong.width + 1) / 2, latlong.height)), even, kMostTexels}));
  Image square(side, side);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      glm::vec3 sum(0);
      for (int i = 0; i < kPoints * kPoints; ++i) {
        const glm::dvec3 to = DirectionOfSquare((x + (i % kPoints + 0.5) / kPoints) / side,
                                                (y + (i / kPoints + 0.5) / kPoints) / side);
        const double turn = std::atan2(to.y, to.x) / glm::two_pi<double>();
        const double down = std::acos(std::clamp(to.z, -1.0, 1.0)) / glm::pi<double>();
        sum += LookUpImage(latlong, around, {turn - std::floor(turn), down});
      }
      for (int c = 0; c < 3; ++c) square.Pixel(x, y)[c] = sum[c] / (kPoints * kPoints);
    }
  }
  return square;
}

}  // namespace

void WarnOfPbrtLightImage(PbrtReader& reader, const PbrtParameters& parameters,
                          const InputError& error) {
  AddMissing(reader.warnings, parameters.position, parameters.directive, error,
             "it shines without an image");
}

std::optional<PbrtLightFile> FindPbrtLightFile(PbrtReader& reader, PbrtParameters& parameters) {
  for (const bool v4 : {true, false}) {
    const auto file = FindString(parameters, v4 ? "filename" : "mapname");
    if (!file || file->empty()) continue;
    try {
      return PbrtLightFile{ResolvePbrtPath(reader, *file, parameters.position), v4};
    } catch (const InputError& error) {
      WarnOfPbrtLightImage(reader, parameters, error);
      return PbrtLightFile{"", v4};
    }
  }
  return std::nullopt;
}

PbrtLightImage FindPbrtLightImage(PbrtReader& reader, PbrtParameters& parameters) {
  const PbrtLightFile file =
      FindPbrtLightFile(reader, parameters).value_or(PbrtLightFile{"", false});
  if (!file.path.empty()) {
    const Encoding encoding = file.v4 ? Encoding::kSrgb : Encoding::kLinear;
    try {
      return {AddTextureImage(reader.texture_files, file.path, encoding), file.v4};
    } catch (const InputError& error) {
      WarnOfPbrtLightImage(reader, parameters, error);
    }
  }
  Image white(1, 1);
  std::fill(white.rgb.begin(), white.rgb.end(), 1.0f);
  return {AddTextureImage(reader.scene, std::move(white)), file.v4};
}

PbrtSphereImage SphereImageOf(PbrtReader& reader, const PbrtParameters& parameters,
                              const PbrtLightImage& given) {
  const auto key = std::pair(given.index, given.v4);
  const auto known = reader.sphere_images.find(key);
  if (known != reader.sphere_images.end()) return known->second;
  const CompactImage& source = reader.scene.images[given.index];
  Image image = given.v4 ? source.Floats() : SquareOfLatLong(source);
  if (image.width != image.height) {
    throw InputError(parameters.position,
                     fmt::format("{}: its image of {} x {} is not an equal-area square",
                                 parameters.directive, image.width, image.height));
  }
  double sum = 0;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    const float mean = (image.rgb[i] + image.rgb[i + 1] + image.rgb[i + 2]) / 3;
    // To pbrt-v4, the colours do not count, their means do.
    for (std::size_t c = 0; given.v4 && c < 3; ++c) image.rgb[i + c] = mean;
    sum += double(mean);
  }
  const double mean = sum / (double(image.rgb.size()) / 3);
  const PbrtSphereImage made = {AddTextureImage(reader.scene, std::move(image)), mean};
  reader.sphere_images.emplace(key, made);
  return made;
}

}  // namespace skywave
