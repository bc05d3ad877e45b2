#include "lights/maps/resample.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "lights/maps/projections.h"
#include "lights/maps/sphere_picture.h"

namespace skywave {
namespace {

using Rgb = std::array<double, 3>;

// True if the rim of a disk does not cut the pixel.
bool IsWhole(const Image& image, int x, int y) {
  for (int corner = 0; corner < 4; ++corner) {
    const double px = 2.0 * (x + (corner & 1)) / image.width - 1;
    const double py = 2.0 * (y + (corner >> 1)) / image.height - 1;
    if (px * px + py * py > 1) return false;
  }
  return true;
}

// Returns the number of samples along each side of a target pixel: three for each source pixel
// along it if both were uniform over the sphere, and at least four, or three where source pixels
// are larger by a quarter and two where they are twice as large.
int SamplesAlongSide(const Image& image, int width, int height) {
  constexpr int kMost = 64;
  const double ratio = std::sqrt(double(image.width) * image.height / (double(width) * height));
  const int least = ratio > 0.8 ? 4 : ratio > 0.5 ? 3 : 2;
  return std::clamp(int(std::ceil(3 * ratio)), least, kMost);
}

// The directions of samples on a grid of `side` x `side` in each pixel of a picture, and the solid
// angles that they stand for.
class SampleGrid {
 public:
  SampleGrid(Projection projection, int width, int height, int side)
      : projection_(projection), columns_(width * side), rows_(height * side) {
    if (projection != Projection::kLatLong) return;
    // Sines and cosines are those of columns and rows.
    for (int x = 0; x < columns_; ++x) {
      meridians_.push_back(*DirectionOfPoint(projection, {(x + 0.5) / columns_, 0.5}));
    }
    for (int y = 0; y < rows_; ++y) {
      const ImagePoint point = {0.5, (y + 0.5) / rows_};
      parallels_.push_back({std::sin(std::numbers::pi * point.v),
                            DirectionOfPoint(projection, point)->z,
                            SolidAngleDensity(projection, point)});
    }
  }

  // Returns the weight of a sample and writes its direction; 0: there is none.
  double Sample(int x, int y, Vector3& direction) const {
    if (!parallels_.empty()) {
      const Parallel& at = parallels_[std::size_t(y)];
      const Vector3& meridian = meridians_[std::size_t(x)];
      direction = {at.radius * meridian.x, at.radius * meridian.y, at.z};
      return at.weight;
    }
    const ImagePoint point = PointOf(x, y);
    const double weight = SolidAngleDensity(projection_, point);
    if (!(weight > 0)) return 0;
    const std::optional<Vector3> there = DirectionOfPoint(projection_, point);
    if (!there) return 0;
    direction = *there;
    return weight;
  }

  // Returns the point of a source that has a sample's direction.
  ImagePoint PointIn(Projection source, int x, int y, const Vector3& direction) const {
    // Two lat-long maps differ in their resolution alone.
    if (source == Projection::kLatLong && projection_ == source) return PointOf(x, y);
    return PointOfDirection(source, direction);
  }

 private:
  struct Parallel {
    double radius, z, weight;
  };
  ImagePoint PointOf(int x, int y) const { return {(x + 0.5) / columns_, (y + 0.5) / rows_}; }

  Projection projection_;
  int columns_, rows_;
  std::vector<Vector3> meridians_;   // of a lat-long map, one a column of samples
  std::vector<Parallel> parallels_;  // likewise, one a row
};

void FillPixel(const SpherePicture& source, Projection from, const SampleGrid& grid, int side,
               int x, int y, Image& target) {
  Rgb sum = {};
  double weights = 0;
  for (int s = 0; s < side * side; ++s) {
    Vector3 direction;
    const int column = x * side + s % side, row = y * side + s / side;
    const double weight = grid.Sample(column, row, direction);
    if (!(weight > 0)) continue;
    source.Add(grid.PointIn(from, column, row, direction), weight, sum);
    weights += weight;
  }
  if (!(weights > 0)) return;
  for (int c = 0; c < 3; ++c) target.Pixel(x, y)[c] = float(sum[c] / weights);
}

// Adds channel c of every source pixel to the target pixel that has its direction.
void Splat(const Image& image, Projection from, Projection to, int c, Image& target) {
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double value = image.Pixel(x, y)[c];
      if (value == 0) continue;
      const auto direction =
          DirectionOfPoint(from, {(x + 0.5) / image.width, (y + 0.5) / image.height});
      if (!direction) continue;
      const ImagePoint point = PointOfDirection(to, *direction);
      const int tx = std::min(int(point.u * target.width), target.width - 1);
      const int ty = std::min(int(point.v * target.height), target.height - 1);
      const double area = PixelSolidAngle(to, target.width, target.height, tx, ty);
      if (!(area > 0)) continue;
      target.Pixel(tx, ty)[c] +=
          float(value * PixelSolidAngle(from, image.width, image.height, x, y) / area);
    }
  }
}

}  // namespace

std::array<double, 3> SphereIntegral(const Image& image, Projection projection) {
  const SpherePicture source(image, projection);
  std::vector<Rgb> rows(image.height);
  tbb::parallel_for(0, image.height, [&](int y) {
    double area = 0;
    for (int x = 0; x < image.width; ++x) {
      // The pixels of a row of a lat-long map are equal.
      if (x == 0 || projection != Projection::kLatLong) {
        area = PixelSolidAngle(projection, image.width, image.height, x, y);
      }
      if (area == 0) continue;
      if (IsDisk(projection) && !IsWhole(image, x, y)) {
        source.Add({(x + 0.5) / image.width, (y + 0.5) / image.height}, area, rows[y]);
        continue;
      }
      for (int c = 0; c < 3; ++c) rows[y][c] += area * image.Pixel(x, y)[c];
    }
  });
  Rgb integral = {};
  for (const Rgb& row : rows) {
    for (int c = 0; c < 3; ++c) integral[c] += row[c];
  }
  return integral;
}

Image Resample(const Image& image, Projection from, Projection to, int width, int height) {
  CheckProjectionSize(from, image.width, image.height);
  CheckProjectionSize(to, width, height);
  if (from == to && image.width == width && image.height == height) return image;
  Image target(width, height);
  const SpherePicture source(image, from);
  const int side = SamplesAlongSide(image, width, height);
  const SampleGrid grid(to, width, height, side);
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) FillPixel(source, from, grid, side, x, y, target);
  });

  const Rgb wanted = SphereIntegral(image, from);
  Rgb found = SphereIntegral(target, to);
  for (int c = 0; c < 3; ++c) {
    if (found[c] == 0 && wanted[c] > 0) {
      Splat(image, from, to, c, target);
      found[c] = SphereIntegral(target, to)[c];
    }
    if (found[c] == 0) continue;
    const double scale = wanted[c] / found[c];
    for (std::size_t i = std::size_t(c); i < target.rgb.size(); i += 3) {
      target.rgb[i] = float(target.rgb[i] * scale);
    }
  }
  return target;
}

Image ToLatLong(Image image, Projection projection) {
  if (projection == Projection::kLatLong) return image;
  CheckProjectionSize(projection, image.width, image.height);
  const int height = LatLongHeight(projection, image.width, image.height);
  return Resample(image, projection, Projection::kLatLong, 2 * height, height);
}

}  // namespace skywave
