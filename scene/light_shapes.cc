#include "scene/light_shapes.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <limits>

#include "base/error.h"
#include "kernels/lights/local_lights.h"

namespace skywave {
namespace {

constexpr double kFullTurn = 2 * glm::pi<double>();  // [rad]
constexpr std::uint32_t kLeastSide = 256;            // points along a side of the square

// A point of a shape's square: its direction in the light's space, unit, and the factor that is its
// own whatever the image; `density` is that of directions if points are uniform in the square.
struct SquarePoint {
  glm::dvec3 direction;
  double density;  // [1/sr]
  double factor;
};

double SpotShare(SpotCurve curve, double t) {
  if (curve == SpotCurve::kSmoothStep) return t * t * (3 - 2 * t);
  return curve == SpotCurve::kSquare ? t * t : t * t * t * t;
}

SquarePoint ConePoint(const PunctualLight& light, double s, double t) {
  const double edge = double(light.cos_dark), full = double(light.cos_full);
  const double cosine = 1 - t * (1 - edge), sine = std::sqrt(std::max(1 - cosine * cosine, 0.0));
  const double x = std::clamp((cosine - edge) / std::max(full - edge, 1e-6), 0.0, 1.0);
  return {{sine * std::cos(kFullTurn * s), sine * std::sin(kFullTurn * s), cosine},
          1 / (kFullTurn * std::max(1 - edge, 1e-7)),
          SpotShare(light.curve, x)};
}

SquarePoint PlanePoint(const glm::vec2& half_size, double s, double t) {
  const glm::dvec2 half(half_size);
  const glm::dvec3 at((2 * s - 1) * half.x, (1 - 2 * t) * half.y, 1);
  const double length = glm::length(at);
  return {at / length, length * length * length / (4 * half.x * half.y), 1};
}

SquarePoint PointOfSquare(const PunctualLight& light, double s, double t) {
  switch (light.form->mapping) {
    case LightMapping::kCone:
      return ConePoint(light, s, t);
    case LightMapping::kSphere:
      return {DirectionOfSquare(s, t), 1 / (2 * kFullTurn), 1};
    case LightMapping::kPlane:
      break;
  }
  return PlanePoint(light.form->half_size, s, t);
}

void CopyRows(const glm::dmat3& matrix, float* to) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) to[3 * row + column] = float(matrix[column][row]);
  }
}

}  // namespace

glm::dvec3 DirectionOfSquare(double s, double t) {
  const double a = 2 * s - 1, b = 2 * t - 1;
  const double inside = 1 - (std::abs(a) + std::abs(b)), r = 1 - std::abs(inside);
  const double phi = (r > 0 ? (std::abs(b) - std::abs(a)) / r + 1 : 0) * kFullTurn / 8;
  const double side = r * std::sqrt(2 - r * r);
  return {side * std::copysign(std::cos(phi), a), side * std::copysign(std::sin(phi), b),
          std::copysign(1 - r * r, inside)};
}

LightShapeView LightShapeTables::view() const {
  if (shapes.empty()) return {};
  return {.shapes = shapes.data(), .texels = texels.data(), .choices = choices.data()};
}

std::size_t LightShapeTables::bytes() const {
  return shapes.size() * sizeof shapes[0] + texels.size() * sizeof texels[0] +
         choices.size() * sizeof choices[0];
}

std::vector<std::uint32_t> MakeChoice(const std::vector<double>& weights, std::uint32_t units) {
  double total = 0;
  std::size_t last = 0, some = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (!(weights[i] > 0)) continue;
    total += weights[i];
    last = i, ++some;
  }
  std::vector<std::uint32_t> first(weights.size() + 1);
  if (some == 0) return first;
  const double free = double(units) - double(some);
  double sum = 0;
  std::uint32_t before = 0;  // units that were given to have one each
  for (std::size_t i = 0; i < weights.size(); ++i) {
    sum += weights[i];
    before += weights[i] > 0;
    const double share = i >= last ? free : std::min(std::floor(free * (sum / total) + 0.5), free);
    first[i + 1] = std::uint32_t(share) + before;
  }
  return first;
}

glm::dvec3 AddLightShape(const Scene& scene, const PunctualLight& light, const std::string& path,
                         LightShapeTables& tables) {
  const LightForm& form = light.form.value();
  LightShape shape = {.mapping = form.mapping};
  if (form.mapping == LightMapping::kCone) {
    shape.curve = light.curve;
    shape.extent[0] = light.cos_dark;
    shape.extent[1] = 1 / std::max(light.cos_full - light.cos_dark, 1e-6f);
  } else {
    shape.extent[0] = form.half_size.x, shape.extent[1] = form.half_size.y;
  }
  glm::dmat3 world_from_light(form.world_from_light);
  world_from_light /= std::cbrt(std::abs(glm::determinant(world_from_light)));
  CopyRows(world_from_light, shape.world_from_light);
  CopyRows(glm::inverse(world_from_light), shape.light_from_world);

  const CompactImage* const image = form.image ? &scene.images.at(*form.image) : nullptr;
  shape.width = image ? std::uint32_t(image->width) : 1;
  shape.height = image ? std::uint32_t(image->height) : 1;
  shape.first_texel = std::uint32_t(tables.texels.size());
  shape.first_choice = std::uint32_t(tables.choices.size());
  const std::size_t texels = std::size_t{shape.width} * shape.height;
  const std::size_t most = std::size_t(std::numeric_limits<std::int32_t>::max());
  if (tables.texels.size() + 3 * texels > most ||
      tables.choices.size() + texels + 2 * std::size_t{shape.height} + 1 > most) {
    throw InputError(InputPosition::File(path), "the images of its lights have too many texels");
  }
  if (image) {
    for (std::size_t i = 0; i < image->values(); ++i) tables.texels.push_back(image->Value(i));
  } else {
    tables.texels.insert(tables.texels.end(), 3, 1.0f);
  }

  // The weights are the light that each texel sends into the world.
  const std::uint32_t points =
      (kLeastSide + std::max(shape.width, shape.height) - 1) / std::max(shape.width, shape.height);
  const double step_s = 1.0 / (double(shape.width) * points);
  const double step_t = 1.0 / (double(shape.height) * points);
  tables.choices.resize(tables.choices.size() + shape.height + 1);
  std::vector<double> rows(shape.height), columns(shape.width);
  glm::dvec3 integral(0);
  for (std::uint32_t y = 0; y < shape.height; ++y) {
    for (std::uint32_t x = 0; x < shape.width; ++x) {
      double solid_angle = 0;
      for (std::uint32_t i = 0; i < points * points; ++i) {
        const double s = (double(x) * points + i % points + 0.5) * step_s;
        const double t = (double(y) * points + i / points + 0.5) * step_t;
        const SquarePoint point = PointOfSquare(light, s, t);
        const double length = glm::length(world_from_light * point.direction);
        solid_angle += point.factor / (point.density * length * length * length);
      }
      solid_angle *= step_s * step_t;
      const float* const rgb =
          &tables.texels[shape.first_texel + 3 * (std::size_t{y} * shape.width + x)];
      integral += glm::dvec3(rgb[0], rgb[1], rgb[2]) * solid_angle;
      columns[x] = (double(rgb[0]) + double(rgb[1]) + double(rgb[2])) * solid_angle;
    }
    rows[y] = 0;
    for (const double weight : columns) rows[y] += weight;
    const std::vector<std::uint32_t> bounds = MakeChoice(columns, kChoiceUnits);
    tables.choices.insert(tables.choices.end(), bounds.begin(), bounds.end());
  }
  const std::vector<std::uint32_t> bounds = MakeChoice(rows, kChoiceUnits);
  std::copy(bounds.begin(), bounds.end(), tables.choices.begin() + shape.first_choice);
  tables.shapes.push_back(shape);
  return integral;
}

}  // namespace skywave
