#include "image/primaries.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace skywave {
namespace {

glm::dvec3 XyzOfWhite(const glm::dvec2& c) { return {c.x / c.y, 1, (1 - c.x - c.y) / c.y}; }

// The columns have any length.
glm::dmat3 PrimariesAsXyz(const RgbPrimaries& p) {
  const auto xyz = [](const glm::dvec2& c) { return glm::dvec3(c.x, c.y, 1 - c.x - c.y); };
  return {xyz(p.red), xyz(p.green), xyz(p.blue)};
}

bool AreEqual(const RgbPrimaries& a, const RgbPrimaries& b) {
  constexpr double kSame = 1e-3;
  return glm::distance(a.red, b.red) < kSame && glm::distance(a.green, b.green) < kSame &&
         glm::distance(a.blue, b.blue) < kSame && glm::distance(a.white, b.white) < kSame;
}

// Colours that are X, Y and Z themselves.
constexpr RgbPrimaries kXyz = {{1, 0}, {0, 1}, {0, 0}, {1.0 / 3, 1.0 / 3}};

struct SpaceDefinition {
  RgbSpace space;
  RgbPrimaries primaries;
  std::string_view interop_id;
};
constexpr SpaceDefinition kDefinitions[] = {
    {RgbSpace::kRec709, kRec709, "lin_rec709_scene"},
    {RgbSpace::kRec2020,
     {{0.708, 0.292}, {0.17, 0.797}, {0.131, 0.046}, kWhiteD65},
     "lin_rec2020_scene"},
    {RgbSpace::kAcescg,
     {{0.713, 0.293}, {0.165, 0.83}, {0.128, 0.044}, {0.32168, 0.33767}},
     "lin_ap1_scene"}};

const SpaceDefinition& DefinitionOf(RgbSpace space) {
  return *std::find_if(
      std::begin(kDefinitions), std::end(kDefinitions),
      [&](const SpaceDefinition& definition) { return definition.space == space; });
}

}  // namespace

bool IsRgbSpace(const RgbPrimaries& p) {
  for (const glm::dvec2& c : {p.red, p.green, p.blue, p.white}) {
    if (!std::isfinite(c.x) || !std::isfinite(c.y)) return false;
  }
  if (!(p.white.y > 0)) return false;
  const glm::dmat3 primaries = PrimariesAsXyz(p);
  if (!(std::abs(glm::determinant(primaries)) > 1e-9)) return false;
  const glm::dvec3 gains = glm::inverse(primaries) * XyzOfWhite(p.white);
  return std::isfinite(gains.x + gains.y + gains.z);
}

glm::dmat3 XyzFromRgb(const RgbPrimaries& p) {
  const glm::dmat3 primaries = PrimariesAsXyz(p);
  const glm::dvec3 gains = glm::inverse(primaries) * XyzOfWhite(p.white);
  return {primaries[0] * gains[0], primaries[1] * gains[1], primaries[2] * gains[2]};
}

glm::dmat3 AdaptToD65(const glm::dvec2& white) {
  const glm::dmat3 cones(0.8951, -0.7502, 0.0389, 0.2664, 1.7135, -0.0685, -0.1614, 0.0367, 1.0296);
  const glm::dvec3 gains = cones * XyzOfWhite(kWhiteD65) / (cones * XyzOfWhite(white));
  const glm::dmat3 scale(gains[0], 0, 0, 0, gains[1], 0, 0, 0, gains[2]);
  return glm::inverse(cones) * scale * cones;
}

const RgbPrimaries& PrimariesOf(RgbSpace space) { return DefinitionOf(space).primaries; }

std::optional<RgbSpace> SpaceOf(const RgbPrimaries& primaries) {
  for (const SpaceDefinition& definition : kDefinitions) {
    if (AreEqual(primaries, definition.primaries)) return definition.space;
  }
  return std::nullopt;
}

std::string_view InteropId(RgbSpace space) { return DefinitionOf(space).interop_id; }

glm::dmat3 FromRec709(RgbSpace space) {
  if (space == RgbSpace::kRec709) return glm::dmat3(1);
  const RgbPrimaries& p = PrimariesOf(space);
  return glm::inverse(AdaptToD65(p.white) * XyzFromRgb(p)) * XyzFromRgb(kRec709);
}

void ConvertToRec709(const RgbPrimaries& p, Image& image) {
  if (AreEqual(p, kRec709)) return;
  const glm::dmat3 adapt = AreEqual(p, kXyz) ? glm::dmat3(1) : AdaptToD65(p.white);
  ConvertColors(glm::inverse(XyzFromRgb(kRec709)) * adapt * XyzFromRgb(p), image);
}

void ConvertColors(const glm::dmat3& matrix, Image& image) {
  if (matrix == glm::dmat3(1)) return;
  tbb::parallel_for(0, image.height, [&](int y) {
    for (int x = 0; x < image.width; ++x) {
      float* const pixel = image.Pixel(x, y);
      const glm::vec3 color(matrix * glm::dvec3(pixel[0], pixel[1], pixel[2]));
      pixel[0] = color.x, pixel[1] = color.y, pixel[2] = color.z;
    }
  });
}

}  // namespace skywave
