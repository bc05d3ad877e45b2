#include "scene/pbrt/solid_textures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/gtc/constants.hpp>
#include <memory>
#include <utility>

#include "base/error.h"
#include "scene/materials/noise.h"
#include "scene/shapes/curves.h"

namespace skywave {
namespace {

PbrtTexture SolidTexture(PbrtSolid color, int evaluations = 1) {
  PbrtTexture texture;
  texture.solid = std::make_shared<const PbrtSolid>(std::move(color));
  texture.evaluations = evaluations;
  return texture;
}

// Returns the transform into the space of a texture, which is the one in which it is defined.
glm::dmat4 TextureFromWorld(PbrtReader& reader, const PbrtParameters& parameters) {
  if (const auto& flaw = reader.state.flaw) {
    Warn(reader, parameters,
         fmt::format("its transform is {} since the {} of {}: that of the world is used",
                     flaw->what, flaw->directive, ToString(flaw->position)));
    return glm::dmat4(1);
  }
  return glm::inverse(reader.state.to_world);
}
// Returns that of functions of the place, to which pbrt-v3 applies the transform itself where
// pbrt-v4 has its inverse.
glm::dmat4 PatternFromWorld(PbrtReader& reader, const PbrtParameters& parameters) {
  return reader.v3 ? reader.state.to_world : TextureFromWorld(reader, parameters);
}

glm::dvec3 FindVector(PbrtParameters& parameters, std::string_view name,
                      const glm::dvec3& otherwise) {
  const PbrtParameter* found = Find(parameters, {"vector", "vector3"}, name);
  if (!found) return otherwise;
  if (found->floats.size() != 3) {
    throw InputError(found->position,
                     fmt::format("{}: \"{}\" takes one vector", parameters.directive, name));
  }
  return {found->floats[0], found->floats[1], found->floats[2]};
}

// Returns a coordinate that counts texels: nothing is seen of an image that repeats more often, and
// what is no number is one end.
double Bounded(double x) {
  constexpr double kFarthest = 1e4;
  return x > -kFarthest ? std::min(x, kFarthest) : -kFarthest;
}

// Returns a texture of any kind as a function; an image is one of (u, v).
PbrtSolid AsSolid(PbrtReader& reader, const PbrtTexture& texture) {
  if (texture.solid) return *texture.solid;
  const glm::vec3 factor = texture.value.value_or(glm::vec3(1));
  if (!texture.image) return [factor](const PbrtPoint&) { return factor; };
  const Texture source = reader.scene.textures[*texture.image];
  std::shared_ptr<const CompactImage>& image = reader.images_in_space[source.image];
  if (!image) image = std::make_shared<const CompactImage>(reader.scene.images[source.image]);
  return [factor, source, image](const PbrtPoint& point) {
    const glm::dvec2 at = glm::dmat3x2(source.transform) * glm::dvec3(point.uv, 1);
    return factor * LookUpImage(*image, source, glm::dvec2(Bounded(at.x), Bounded(at.y)));
  };
}

// Returns the (u, v) that a mapping gives to places of the texture's space. u of a sphere is its
// polar angle, v of a cylinder its height, in pbrt-v3 that of the unit sphere.
using UvOfPlace = std::function<glm::dvec2(const glm::dvec3&)>;
UvOfPlace MappingInSpace(PbrtParameters& parameters, std::string_view mapping, bool v3) {
  if (mapping == "planar") {
    const glm::dvec3 along = FindVector(parameters, "v1", {1, 0, 0});
    const glm::dvec3 across = FindVector(parameters, "v2", {0, 1, 0});
    return [=](const glm::dvec3& p) { return glm::dvec2(glm::dot(p, along), glm::dot(p, across)); };
  }
  return [v3, sphere = mapping == "spherical"](const glm::dvec3& p) {
    const double turn = std::atan2(p.y, p.x) / glm::two_pi<double>(), length = glm::length(p);
    const double height = length > 0 ? std::clamp(p.z / length, -1.0, 1.0) : 0;
    if (sphere) return glm::dvec2(std::acos(height) / glm::pi<double>(), turn - std::floor(turn));
    return glm::dvec2(0.5 + turn, v3 ? height : p.z);
  };
}

}  // namespace

PbrtTexture ReadSolidChecks(PbrtReader& reader, const PbrtParameters& parameters) {
  return SolidTexture([to_texture = PatternFromWorld(reader, parameters)](const PbrtPoint& point) {
    const glm::dvec3 cell = glm::floor(glm::dvec3(to_texture * glm::dvec4(point.place, 1)));
    return glm::vec3(glm::mod(cell.x + cell.y + cell.z, 2.0) == 0 ? 0 : 1);
  });
}

PbrtTexture ReadDirection(PbrtReader& reader, PbrtParameters& parameters) {
  glm::dvec3 direction = FindVector(parameters, "dir", {0, 1, 0});
  direction = glm::normalize(glm::dmat3(reader.state.to_world) * direction);
  if (!std::isfinite(direction.x)) {
    throw InputError(parameters.position, parameters.directive + ": \"dir\" is no direction");
  }
  return SolidTexture([direction](const PbrtPoint& point) {
    return glm::vec3(float(std::abs(glm::dot(point.normal, direction))));
  });
}

// Sheets of stone lie across y, bent by noise; the colours along a curve are pbrt's.
PbrtTexture ReadMarble(PbrtReader& reader, PbrtParameters& parameters) {
  const int octaves = std::clamp(FindInt(parameters, "octaves").value_or(8), 0, 32);
  const double roughness = FindFloat(parameters, "roughness").value_or(0.5f);
  const double scale = FindFloat(parameters, "scale").value_or(1);
  const double variation = FindFloat(parameters, "variation").value_or(0.2f);
  return SolidTexture(
      [=, to_texture = PatternFromWorld(reader, parameters)](const PbrtPoint& point) {
        constexpr int kCurves = 6;
        static const glm::dvec3 kStone(0.58, 0.58, 0.6);
        static const glm::dvec3 kColors[kCurves + 3] = {
            kStone, kStone, kStone,           {0.5, 0.5, 0.5}, {0.6, 0.59, 0.58},
            kStone, kStone, {0.2, 0.2, 0.33}, kStone};
        const glm::dvec3 at = scale * glm::dvec3(to_texture * glm::dvec4(point.place, 1));
        const double sheet = at.y + variation * FractalNoise(at, roughness, octaves);
        const double along = (0.5 + 0.5 * std::sin(sheet)) * kCurves;
        const int curve = std::clamp(int(along), 0, kCurves - 1);
        return glm::vec3(1.5 * BezierPoint(kColors + curve, along - curve));
      });
}

PbrtTexture ReadNoise(PbrtReader& reader, PbrtParameters& parameters, const std::string& kind) {
  const bool windy = kind == "windy", wrinkled = kind == "wrinkled";
  int octaves = 8;
  double roughness = 0.5;
  if (!windy) {
    octaves = std::clamp(FindInt(parameters, "octaves").value_or(octaves), 0, 32);
    roughness = FindFloat(parameters, "roughness").value_or(0.5f);
  }
  return SolidTexture([=,
                       to_texture = PatternFromWorld(reader, parameters)](const PbrtPoint& point) {
    const glm::dvec3 at(to_texture * glm::dvec4(point.place, 1));
    if (wrinkled) return glm::vec3(float(TurbulentNoise(at, roughness, octaves)));
    if (!windy) return glm::vec3(float(FractalNoise(at, roughness, octaves)));
    // The wind is three octaves of a tenth of the frequency, and raises six of waves.
    return glm::vec3(float(std::abs(FractalNoise(0.1 * at, 0.5, 3)) * FractalNoise(at, 0.5, 6)));
  });
}

PbrtTexture CombineInSpace(PbrtReader& reader, const PbrtParameters& parameters,
                           const std::vector<PbrtTexture>& textures, const CombineTexels& combine) {
  // Only a material makes something of a single texture, which ends the chain.
  int evaluations = textures.size() > 1 ? 1 : 0;
  for (const PbrtTexture& texture : textures) evaluations += texture.evaluations;
  if (evaluations > kMaxPbrtEvaluations) {
    Warn(reader, parameters,
         fmt::format("it takes more than {} evaluations of textures that vary in space: its users "
                     "take their default",
                     kMaxPbrtEvaluations));
    return {};
  }
  std::vector<PbrtSolid> operands;
  for (const PbrtTexture& texture : textures) operands.push_back(AsSolid(reader, texture));
  return SolidTexture(
      [operands = std::move(operands), combine](const PbrtPoint& point) {
        std::vector<glm::vec3> values;
        values.reserve(operands.size());
        for (const PbrtSolid& operand : operands) values.push_back(operand(point));
        return combine(values);
      },
      evaluations);
}

bool IsPbrtMappingInSpace(std::string_view mapping) {
  return mapping == "planar" || mapping == "spherical" || mapping == "cylindrical";
}

PbrtTexture LayInSpace(PbrtReader& reader, PbrtParameters& parameters, std::string_view mapping,
                       const PbrtTexture& texture) {
  const UvOfPlace uv_of = MappingInSpace(parameters, mapping, reader.v3);
  if (!texture.image) return texture;
  // A plane of pbrt-v3 is one of the world.
  const bool of_world = reader.v3 && mapping == "planar";
  const glm::dmat4 to_texture = of_world ? glm::dmat4(1) : TextureFromWorld(reader, parameters);
  return SolidTexture([=, color_at = AsSolid(reader, texture)](const PbrtPoint& point) {
    const glm::dvec2 uv = uv_of(glm::dvec3(to_texture * glm::dvec4(point.place, 1)));
    return color_at({point.place, point.normal, uv});
  });
}

}  // namespace skywave
