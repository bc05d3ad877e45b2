#include "lights/probe/calibration.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <cstdint>
#include <numbers>

#include "base/error.h"
#include "lights/maps/sphere_map.h"

namespace skywave {

const CalibrationAxis kCalibrationAxes[6] = {
    {"+R", {1, 0, 0}, {1, 0.05f, 0.05f}}, {"-R", {-1, 0, 0}, {0.05f, 1, 1}},
    {"+F", {0, 1, 0}, {0.05f, 1, 0.05f}}, {"-F", {0, -1, 0}, {1, 0.05f, 1}},
    {"+U", {0, 0, 1}, {0.05f, 0.05f, 1}}, {"-U", {0, 0, -1}, {1, 1, 0.05f}},
};

namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr int kSide = 3;  // samples along each side of a pixel

// A glyph has 5 x 7 dots, one byte per row from the top; the leftmost dot is 16.
struct Glyph {
  char letter;
  std::uint8_t rows[7];
};
constexpr Glyph kGlyphs[] = {{'+', {0, 4, 4, 31, 4, 4, 0}},
                             {'-', {0, 0, 0, 31, 0, 0, 0}},
                             {'R', {30, 17, 17, 30, 20, 18, 17}},
                             {'F', {31, 16, 16, 30, 16, 16, 16}},
                             {'U', {17, 17, 17, 17, 17, 17, 14}}};

// Both letters of a name share a grid of 12 x 7 dots; the two columns in the middle stay free.
bool IsInk(const char* name, int column, int row) {
  if (column < 0 || column >= 12 || row < 0 || row >= 7 || column == 5 || column == 6) return false;
  const char letter = name[column > 6];
  const int dot = column > 6 ? column - 7 : column;
  for (const Glyph& glyph : kGlyphs) {
    if (glyph.letter == letter) return glyph.rows[row] >> (4 - dot) & 1;
  }
  return false;
}

bool IsOnLine(const Vector3& d) {
  constexpr double kStep = 15 * kRadians, kHalfWidth = 0.35 * kRadians;
  const auto distance = [](double angle) {
    return std::abs(angle - kStep * std::round(angle / kStep));
  };
  const double elevation = std::atan2(d.z, std::hypot(d.x, d.y));
  if (distance(elevation) < kHalfWidth) return true;
  return distance(std::atan2(d.x, d.y)) * std::hypot(d.x, d.y) < kHalfWidth;
}

std::array<float, 3> AxisColor(const Vector3& d) {
  for (const CalibrationAxis& axis : kCalibrationAxes) {
    if (Dot(d, axis.direction) < std::cos(kCalibrationDiskDegrees * kRadians)) continue;
    const Vector3 up = axis.direction.z == 0 ? Vector3{0, 0, 1} : Vector3{0, -axis.direction.z, 0};
    const Vector3 right = Cross(axis.direction, up);
    const double dot = 2.1 * kRadians * Dot(d, axis.direction);  // size of a glyph's dot
    const int column = int(std::floor(Dot(d, right) / dot + 6));
    const int row = int(std::floor(3.5 - Dot(d, up) / dot));
    if (IsInk(axis.name, column, row)) return {0, 0, 0};
    return axis.radiance;
  }
  if (IsOnLine(d)) return {0.5f, 0.5f, 0.5f};
  return d.z > 0 ? std::array<float, 3>{0.2f, 0.2f, 0.2f}
                 : std::array<float, 3>{0.08f, 0.08f, 0.08f};
}

}  // namespace

Image CalibrationMap(int height) {
  if (height < 1) throw InputError({}, "a map needs at least one row", kExitUsage);
  Image image(2 * height, height);
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < image.width; ++x) {
      float* rgb = image.Pixel(x, y);
      for (int s = 0; s < kSide * kSide; ++s) {
        const auto color = AxisColor(DirectionOfUv((x + (s % kSide + 0.5) / kSide) / image.width,
                                                   (y + (s / kSide + 0.5) / kSide) / image.height));
        for (int c = 0; c < 3; ++c) rgb[c] += color[c] / (kSide * kSide);
      }
    }
  });
  return image;
}

}  // namespace skywave
