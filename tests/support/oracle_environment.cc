#include "tests/support/oracle_environment.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

namespace skywave {
namespace {

constexpr double kTau = 2 * glm::pi<double>();

// Turns weights at begin[1..n] into their cumulative distribution at begin[0..n]; if all are 0,
// they count as equal. Returns their sum.
double Cumulate(double* begin, int n) {
  begin[0] = 0;
  for (int i = 0; i < n; ++i) begin[i + 1] += begin[i];
  const double sum = begin[n];
  for (int i = 0; i <= n; ++i) begin[i] = sum > 0 ? begin[i] / sum : double(i) / n;
  return sum;
}

// Returns the item of a cumulative distribution at begin[0..n] that `uniform` selects.
int Find(const double* begin, int n, double uniform) {
  return std::min(int(std::upper_bound(begin, begin + n + 1, uniform) - begin) - 1, n - 1);
}

}  // namespace

OracleEnvironment::OracleEnvironment(const EnvironmentLight& light, OracleLights lights)
    : width_(light.map ? light.map->width : 1),
      height_(light.map ? light.map->height : 1),
      rgb_(light.map ? light.map->rgb : std::vector<float>{1, 1, 1}),
      scale_(light.scale),
      world_from_map_(light.world_from_map),
      lights_(lights),
      solid_angle_(height_),
      cumulative_rows_(height_ + 1),
      cumulative_texels_(std::size_t(width_ + 1) * height_) {
  for (int row = 0; row < height_; ++row) {
    solid_angle_[row] = kTau / width_ *
                        (std::cos(glm::pi<double>() * row / height_) -
                         std::cos(glm::pi<double>() * (row + 1) / height_));
    double* texels = &cumulative_texels_[std::size_t(width_ + 1) * row];
    for (int column = 0; column < width_; ++column) {
      const glm::dvec3 radiance = Texel(column, row);
      texels[column + 1] = radiance.x + radiance.y + radiance.z;
    }
    cumulative_rows_[row + 1] = Cumulate(texels, width_) * solid_angle_[row];
  }
  // A black map has no row to choose, so the sphere is sampled uniformly.
  if (Cumulate(cumulative_rows_.data(), height_) <= 0) lights_ = OracleLights::kUniform;
}

glm::dvec3 OracleEnvironment::Texel(int column, int row) const {
  const float* rgb = &rgb_[(std::size_t(row) * width_ + column) * 3];
  return scale_ * glm::dvec3(rgb[0], rgb[1], rgb[2]);
}

void OracleEnvironment::Position(const glm::dvec3& direction, double& u, double& v) const {
  const double right = glm::dot(world_from_map_[0], direction);
  const double forward = glm::dot(world_from_map_[1], direction);
  const double up = glm::dot(world_from_map_[2], direction);
  u = 0.5 + std::atan2(right, forward) / kTau;
  v = std::acos(std::clamp(up, -1.0, 1.0)) / glm::pi<double>();
}

double OracleEnvironment::Density(int column, int row) const {
  if (lights_ == OracleLights::kUniform) return 1 / (2 * kTau);
  const double* texels = &cumulative_texels_[std::size_t(width_ + 1) * row];
  return (cumulative_rows_[row + 1] - cumulative_rows_[row]) *
         (texels[column + 1] - texels[column]) / solid_angle_[row];
}

glm::dvec3 OracleEnvironment::Seen(const glm::dvec3& direction) const {
  double u, v;
  Position(direction, u, v);
  const double x = u * width_ - 0.5, y = v * height_ - 0.5;
  const double fx = x - std::floor(x), fy = y - std::floor(y);
  // Columns wrap at the seam; the rows at the poles repeat.
  const int left = (int(std::floor(x)) + width_) % width_, right = (left + 1) % width_;
  const int top = std::clamp(int(std::floor(y)), 0, height_ - 1);
  const int bottom = std::clamp(int(std::floor(y)) + 1, 0, height_ - 1);
  return (1 - fy) * ((1 - fx) * Texel(left, top) + fx * Texel(right, top)) +
         fy * ((1 - fx) * Texel(left, bottom) + fx * Texel(right, bottom));
}

OracleEnvironment::Lit OracleEnvironment::AsLight(const glm::dvec3& direction) const {
  double u, v;
  Position(direction, u, v);
  const int column = std::clamp(int(u * width_), 0, width_ - 1);
  const int row = std::clamp(int(v * height_), 0, height_ - 1);
  return {Texel(column, row), Density(column, row)};
}

OracleEnvironment::LightSample OracleEnvironment::Sample(OracleRandom& random) const {
  double u, up;
  int column = 0, row = 0;
  if (lights_ == OracleLights::kUniform) {
    u = random(), up = 1 - 2 * random();
    column = std::clamp(int(u * width_), 0, width_ - 1);
    row = std::clamp(int(std::acos(up) / glm::pi<double>() * height_), 0, height_ - 1);
  } else {
    row = Find(cumulative_rows_.data(), height_, random());
    column = Find(&cumulative_texels_[std::size_t(width_ + 1) * row], width_, random());
    u = (column + random()) / width_;
    const double top = std::cos(glm::pi<double>() * row / height_);
    up = top - random() * solid_angle_[row] * width_ / kTau;
  }
  const double sine = std::sqrt(std::max(0.0, 1 - up * up)), turn = kTau * (u - 0.5);
  const glm::dvec3 on_map(sine * std::sin(turn), sine * std::cos(turn), up);
  return {world_from_map_ * on_map, Texel(column, row), Density(column, row)};
}

}  // namespace skywave
