#include "lights/maps/projections.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "base/error.h"
#include "lights/maps/sphere_map.h"

namespace skywave {
namespace {

// On a face of the cube direction = middle + a * across + b * rising, with a and b in [-1, 1].
struct Face {
  Vector3 middle, across, rising;
};
enum FaceIndex { kRight, kLeft, kUp, kDown, kFront, kBack };
constexpr Face kFaces[6] = {
    {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}}, {{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
    {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}}, {{0, 0, -1}, {1, 0, 0}, {0, 1, 0}},
    {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},  {{0, -1, 0}, {-1, 0, 0}, {0, 0, 1}},
};

// A layout gives the column and row of each face, and whether it is upside down.
struct CubeLayout {
  int columns, rows;
  struct Place {
    int column, row;
    bool turned;
  } place[6];  // by FaceIndex
};
constexpr CubeLayout kHorizontal = {
    4,
    3,
    {{2, 1, false}, {0, 1, false}, {1, 0, false}, {1, 2, false}, {1, 1, false}, {3, 1, false}}};
constexpr CubeLayout kVertical = {
    3,
    4,
    {{2, 1, false}, {0, 1, false}, {1, 0, false}, {1, 2, false}, {1, 1, false}, {1, 3, true}}};
constexpr CubeLayout kStrip = {
    6,
    1,
    {{0, 0, false}, {1, 0, false}, {2, 0, false}, {3, 0, false}, {4, 0, false}, {5, 0, false}}};

constexpr CubeLayout kColumn = {
    1, 6, {{0, 1, false}, {0, 0, false}, {0, 2, true}, {0, 3, true}, {0, 4, false}, {0, 5, false}}};

const CubeLayout* LayoutOf(Projection projection) {
  switch (projection) {
    case Projection::kHorizontalCross:
      return &kHorizontal;
    case Projection::kVerticalCross:
      return &kVertical;
    case Projection::kCubeStrip:
      return &kStrip;
    case Projection::kCubeColumn:
      return &kColumn;
    default:
      return nullptr;
  }
}

struct FacePoint {
  int face;
  double a, b;  // across and rising, in [-1, 1]
};

std::optional<FacePoint> FaceOfPoint(const CubeLayout& layout, ImagePoint point) {
  const double x = point.u * layout.columns, y = point.v * layout.rows;
  const int column = std::clamp(int(std::floor(x)), 0, layout.columns - 1);
  const int row = std::clamp(int(std::floor(y)), 0, layout.rows - 1);
  for (int face = 0; face < 6; ++face) {
    const CubeLayout::Place& place = layout.place[face];
    if (place.column != column || place.row != row) continue;
    const double sign = place.turned ? -1 : 1;
    return FacePoint{face, sign * (2 * (x - column) - 1), sign * (1 - 2 * (y - row))};
  }
  return std::nullopt;
}

ImagePoint PointOfCube(const CubeLayout& layout, const Vector3& d) {
  int face = 0;
  double largest = -1;
  for (int f = 0; f < 6; ++f) {
    const double along = Dot(d, kFaces[f].middle);
    if (along > largest) largest = along, face = f;
  }
  const CubeLayout::Place& place = layout.place[face];
  const double sign = place.turned ? -1 : 1;
  // Rounding must not put a point on an edge into the next face of the picture, or outside a cross.
  constexpr double kEdge = 1 - 1e-12;
  const double a = sign * std::clamp(Dot(d, kFaces[face].across) / largest, -kEdge, kEdge);
  const double b = sign * std::clamp(Dot(d, kFaces[face].rising) / largest, -kEdge, kEdge);
  return {(place.column + (a + 1) / 2) / layout.columns, (place.row + (1 - b) / 2) / layout.rows};
}

// pbrt's light space, in which the square is defined, has x = back, y = left, z = up.
ImagePoint PointOfOctahedral(const Vector3& d) {
  const double lx = -d.y, ly = -d.x;
  // This is sqrt(1 - |z|) without cancellation near the poles.
  const double r = std::sqrt((lx * lx + ly * ly) / (1 + std::abs(d.z)));
  const double phi = std::abs(lx) + std::abs(ly) > 0
                         ? std::atan2(std::abs(ly), std::abs(lx)) * 2 / std::numbers::pi
                         : 0;
  double y = phi * r, x = r - y;
  if (d.z < 0) {
    const double folded = 1 - y;
    y = 1 - x;
    x = folded;
  }
  return {(std::copysign(x, lx) + 1) / 2, (std::copysign(y, ly) + 1) / 2};
}

Vector3 DirectionOfOctahedral(ImagePoint point) {
  const double u = 2 * point.u - 1, v = 2 * point.v - 1;
  const double signed_distance = 1 - (std::abs(u) + std::abs(v));
  const double r = 1 - std::abs(signed_distance);
  const double phi = r > 0 ? ((std::abs(v) - std::abs(u)) / r + 1) * std::numbers::pi / 4 : 0;
  const double horizontal = r * std::sqrt(std::max(0.0, 2 - r * r));
  const double lx = std::copysign(horizontal * std::cos(phi), u);
  const double ly = std::copysign(horizontal * std::sin(phi), v);
  return {-ly, -lx, std::copysign(1 - r * r, signed_distance)};
}

// The middle of a mirror ball shows back. The ball is Lambert's equal-area azimuthal projection.
ImagePoint PointOfMirrorBall(const Vector3& d) {
  const double horizontal = std::hypot(d.x, d.z);
  if (horizontal == 0) return d.y <= 0 ? ImagePoint{0.5, 0.5} : ImagePoint{1, 0.5};
  const double r = std::sin(std::atan2(horizontal, -d.y) / 2) / horizontal;
  return {(1 + d.x * r) / 2, (1 - d.z * r) / 2};
}

// Returns the integral of the solid angle of a face over [-1, a] x [-1, b], up to a constant.
double CubeCorner(double a, double b) { return std::atan2(a * b, std::sqrt(a * a + b * b + 1)); }

// Disks take Gauss-Legendre quadrature inside and a fine grid where the rim cuts the pixel.
double DiskPixelSolidAngle(Projection projection, int width, int height, int x, int y) {
  const double nearest_x = std::max({0.0, 2.0 * x / width - 1, 1 - 2.0 * (x + 1) / width});
  const double nearest_y = std::max({0.0, 2.0 * y / height - 1, 1 - 2.0 * (y + 1) / height});
  if (nearest_x * nearest_x + nearest_y * nearest_y >= 1) return 0;
  int inside = 0;
  for (int corner = 0; corner < 4; ++corner) {
    const double px = 2.0 * (x + (corner & 1)) / width - 1;
    const double py = 2.0 * (y + (corner >> 1)) / height - 1;
    inside += px * px + py * py <= 1;
  }
  double sum = 0;
  if (inside == 4) {
    const double offset = 0.5 / std::sqrt(3.0);
    for (int s = 0; s < 4; ++s) {
      const double px = x + 0.5 + (s & 1 ? offset : -offset);
      const double py = y + 0.5 + (s & 2 ? offset : -offset);
      sum += SolidAngleDensity(projection, {px / width, py / height}) / 4;
    }
  } else {
    constexpr int kSide = 32;
    for (int s = 0; s < kSide * kSide; ++s) {
      const double px = x + (s % kSide + 0.5) / kSide, py = y + (s / kSide + 0.5) / kSide;
      sum += SolidAngleDensity(projection, {px / width, py / height}) / (kSide * kSide);
    }
  }
  return sum / (double(width) * height);
}

}  // namespace

Projection DetectProjection(const Image& image, const std::string& path) {
  const std::int64_t width = image.width, height = image.height;
  if (width == 2 * height) return Projection::kLatLong;
  if (width == 1 && height == 1) return Projection::kLatLong;
  if (width == height) return Projection::kAngular;
  if (3 * width == 4 * height) return Projection::kHorizontalCross;
  if (4 * width == 3 * height) return Projection::kVerticalCross;
  if (6 * width == height) return Projection::kCubeColumn;
  throw InputError(
      InputPosition::File(path),
      fmt::format(
          "{} x {} pixels are neither a lat-long map (2:1) nor an angular map (square) nor "
          "a cube cross (4:3, 3:4) nor a column of faces (1:6); say which with --env-projection {}",
          width, height, Choices<Projection>()));
}

ImagePoint PointOfDirection(Projection projection, const Vector3& d) {
  ImagePoint point = {};
  switch (projection) {
    case Projection::kLatLong:
      UvOfDirection(d, point.u, point.v);
      return point;
    case Projection::kAngular: {
      const double direction[3] = {d.x, d.y, d.z};
      double x, y;
      AngularPosition(direction, x, y);
      return {(1 + x) / 2, (1 - y) / 2};
    }
    case Projection::kMirrorBall:
      return PointOfMirrorBall(d);
    case Projection::kOctahedral:
      return PointOfOctahedral(d);
    default:
      return PointOfCube(*LayoutOf(projection), d);
  }
}

std::optional<Vector3> DirectionOfPoint(Projection projection, ImagePoint point) {
  const double x = 2 * point.u - 1, y = 1 - 2 * point.v, r = std::sqrt(x * x + y * y);
  switch (projection) {
    case Projection::kLatLong:
      return DirectionOfUv(point.u, point.v);
    case Projection::kAngular: {
      if (r > 1) return std::nullopt;
      const double scale = r > 0 ? std::sin(std::numbers::pi * r) / r : std::numbers::pi;
      return Vector3{x * scale, std::cos(std::numbers::pi * r), y * scale};
    }
    case Projection::kMirrorBall: {
      if (r > 1) return std::nullopt;
      const double scale = 2 * std::sqrt(1 - r * r);
      return Vector3{x * scale, 2 * r * r - 1, y * scale};
    }
    case Projection::kOctahedral:
      return DirectionOfOctahedral(point);
    default: {
      const std::optional<FacePoint> on = FaceOfPoint(*LayoutOf(projection), point);
      if (!on) return std::nullopt;
      const Face& face = kFaces[on->face];
      const Vector3 d = face.middle + on->a * face.across + on->b * face.rising;
      return (1 / Length(d)) * d;
    }
  }
}

double SolidAngleDensity(Projection projection, ImagePoint point) {
  const double x = 2 * point.u - 1, y = 1 - 2 * point.v, r = std::sqrt(x * x + y * y);
  switch (projection) {
    case Projection::kLatLong:
      return 2 * std::numbers::pi * std::numbers::pi * std::sin(std::numbers::pi * point.v);
    case Projection::kAngular:
      if (r > 1) return 0;
      return 4 * std::numbers::pi * (r > 0 ? std::sin(std::numbers::pi * r) / r : std::numbers::pi);
    case Projection::kMirrorBall:
      return r > 1 ? 0 : 16;
    case Projection::kOctahedral:
      return 4 * std::numbers::pi;
    default: {
      const CubeLayout& layout = *LayoutOf(projection);
      const std::optional<FacePoint> on = FaceOfPoint(layout, point);
      if (!on) return 0;
      return 4 * layout.columns * layout.rows * std::pow(1 + on->a * on->a + on->b * on->b, -1.5);
    }
  }
}

double PixelSolidAngle(Projection projection, int width, int height, int x, int y) {
  switch (projection) {
    case Projection::kLatLong:
      return RowSolidAngle(width, height, y);
    case Projection::kOctahedral:
      return 4 * std::numbers::pi / (double(width) * height);
    case Projection::kAngular:
    case Projection::kMirrorBall:
      return DiskPixelSolidAngle(projection, width, height, x, y);
    default: {
      const CubeLayout& layout = *LayoutOf(projection);
      const ImagePoint middle = {(x + 0.5) / width, (y + 0.5) / height};
      const std::optional<FacePoint> on = FaceOfPoint(layout, middle);
      if (!on) return 0;
      const double half_a = double(layout.columns) / width, half_b = double(layout.rows) / height;
      const double a0 = on->a - half_a, a1 = on->a + half_a;
      const double b0 = on->b - half_b, b1 = on->b + half_b;
      return CubeCorner(a1, b1) - CubeCorner(a0, b1) - CubeCorner(a1, b0) + CubeCorner(a0, b0);
    }
  }
}

void CheckProjectionSize(Projection projection, int width, int height) {
  if (width < 1 || height < 1) throw InputError({}, "a map needs at least one pixel", kExitUsage);
  const CubeLayout* layout = LayoutOf(projection);
  if (layout &&
      (width % layout->columns != 0 || height != width / layout->columns * layout->rows)) {
    throw InputError({}, fmt::format("a {} has square faces, {} across and {} down: {} x {} pixels "
                                     "do not fit; for example {} x {} do",
                                     ToString(projection), layout->columns, layout->rows, width,
                                     height, 64 * layout->columns, 64 * layout->rows));
  }
}

int LatLongHeight(Projection projection, int width, int height) {
  if (projection == Projection::kLatLong) return height;
  if (const CubeLayout* layout = LayoutOf(projection)) return 2 * (width / layout->columns);
  // From pole to pole, along the diagonals and the middles of its sides, a square has as many
  // texels as on a side, and twice as many around the equator. The largest squares would give more
  // texels than a map may have, 2^28.
  constexpr int kMostRows = 11585;
  if (projection == Projection::kOctahedral) return std::min(width, kMostRows);
  // An angular map has as many texels around as its width, and a ball four for three.
  const int rows =
      projection == Projection::kAngular ? width / 2 : int(std::int64_t(width) * 2 / 3);
  return std::max(rows, 1);
}

void DefaultSize(Projection projection, int latlong_height, int& width, int& height) {
  const int side = std::max(latlong_height, 1);
  if (const CubeLayout* layout = LayoutOf(projection)) {
    const int face = std::max(side / 2, 1);
    width = face * layout->columns;
    height = face * layout->rows;
  } else if (projection == Projection::kLatLong) {
    width = 2 * side;
    height = side;
  } else {
    width = height = projection == Projection::kAngular ? 2 * side : side + side / 2;
  }
}

}  // namespace skywave
