#include "kernels/cross_filter.h"

#include <algorithm>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/cross_filter.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/simd/exp-inl.h"
#include "kernels/simd/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// A weight falls with the distance z beyond that of equal pixels and is 0 from kLimit on: e^-z,
// approximated by a power that reaches 0.
constexpr float kTolerated = 0.5f;
constexpr float kLimit = 8;
// A pixel may be this many times noisier before it weighs less.
constexpr float kNoisier = 2;
// A pixel with this many samples gets half of the noise around it at least.
constexpr float kFewSamples = 8;
// The noise of neighbours that are more than this many times as bright as a pixel is scaled down,
// by the square of what they are brighter by.
constexpr float kBrighter = 32;
// Differences of neighbours are correlated once they are filtered, so their mean is one of few
// independent numbers and intervals have to be wider. The factor is fitted so that intervals cover
// what they claim (docs/denoising.md).
constexpr float kFewNumbers = 2.0f;

// A tile with two more pixels on each side, and room for whole vectors.
constexpr int kPitch = FilterTile::kWidth + 3 * static_cast<int>(kPadRows);
constexpr int kRows = FilterTile::kHeight + 4;
struct TilePlane {
  alignas(kColumnAlignment) float values[kRows][kPitch];
  // Returns pixel (x, y) of the tile; x and y may be -2.
  float* at(int x, int y) { return &values[y + 2][x + static_cast<int>(kPadRows)]; }
};

void SmoothNoise(const PlaneShape& shape, const HalfPlanes& half, const HalfPlanes& other,
                 const float* samples, int y, float* noise) {
  const int lanes = static_cast<int>(hn::Lanes(F()));
  for (int x = 0; x < shape.width; x += lanes) {
    const std::size_t at = shape.at(x, y);
    const VF zero = hn::Zero(F());
    const auto brightness = [&](std::size_t i) HWY_ATTR {
      const V3 sum =
          Load3(half.r + i, half.g + i, half.b + i) + Load3(other.r + i, other.g + i, other.b + i);
      return hn::Abs(sum.x + sum.y + sum.z);
    };
    const VF bright = brightness(at) * kBrighter;
    VF sum = zero, sum_of_alike = zero, sum_of_logs = zero;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const std::size_t j = shape.at(x + dx, y + dy);
        const VF v = Load(half.noise + j);
        const VF ratio = hn::Min(bright / (brightness(j) + kNoNoise), Set(1.0f));
        sum = sum + v;
        sum_of_alike = sum_of_alike + v * ratio * ratio;
        sum_of_logs = sum_of_logs + Log2(hn::Max(v, Set(1e-30f)));
      }
    }
    const VF own = Load(half.noise + at), geometric = Exp2(sum_of_logs * (1.0f / 9));
    const VF share = kFewSamples / (Load(samples + at) + kFewSamples);
    const VF least = hn::Max(geometric, share * sum_of_alike * (1.0f / 9));
    Store(IfThen(hn::Eq(own, zero), sum * (1.0f / 9), hn::Max(own, least)), noise + at);
  }
}

void TakeLogarithms(const PlaneShape& shape, int y, float scale, float* plane) {
  const int lanes = static_cast<int>(hn::Lanes(F()));
  for (int x = 0; x < shape.width; x += lanes) {
    float* const at = plane + shape.at(x, y);
    Store(Log(hn::Max(Load(at), Set(1e-30f))) * scale, at);
  }
}

// What the pixels of a tile are compared with: pixels of the same planes some pixels away, or what
// another frame has of them.
struct Neighbours {
  FeaturePlanes features;
  HalfPlanes halves[2];
  std::size_t first, pitch;  // place of that of the tile's first pixel; places from row to row
  float dx, dy;              // from a pixel to its neighbour

  std::size_t at(int x, int y) const {
    return std::size_t(std::ptrdiff_t(first) + std::ptrdiff_t(pitch) * y + x);
  }
};

// Writes the squared distances z between the pixels of a tile, one more on each side, and their
// neighbours, by one half; sums of three in a row go to `sums`.
HWY_INLINE void Distances(const PlaneShape& shape, const HalfPlanes& here, const FilterTile& tile,
                          const Neighbours& neighbours, int half, TilePlane& z, TilePlane& sums) {
  const HalfPlanes& there = neighbours.halves[half];
  const int lanes = static_cast<int>(hn::Lanes(F()));
  for (int y = -1; y <= tile.height; ++y) {
    const std::size_t row = shape.at(tile.x, tile.y + y), their_row = neighbours.at(0, y);
    for (int x = -1; x <= tile.width; x += lanes) {
      const std::size_t i = row + std::size_t(x), j = their_row + std::size_t(x);
      const V3 d =
          Load3(here.r + i, here.g + i, here.b + i) - Load3(there.r + j, there.g + j, there.b + j);
      const VF noise = Load(here.noise + i) + Load(there.noise + j) + kNoNoise;
      Store(hn::Min(Dot(d, d) / noise, Set(1e6f)), z.at(x, y));
    }
    for (int x = 0; x < tile.width; x += lanes) {
      const VF sides = Load(z.at(x - 1, y)) + Load(z.at(x + 1, y));
      Store(sides + Load(z.at(x, y)), sums.at(x, y));
    }
  }
}

// Returns the squared distance of the features of pixels i and of their neighbours j.
HWY_INLINE VF FeatureDistance(const FeaturePlanes& f, std::size_t i, const Neighbours& neighbours,
                              std::size_t j) {
  const FeaturePlanes& g = neighbours.features;
  const V3 normal = Load3(f.normal_x + i, f.normal_y + i, f.normal_z + i) -
                    Load3(g.normal_x + j, g.normal_y + j, g.normal_z + j);
  const V3 albedo = Load3(f.albedo_r + i, f.albedo_g + i, f.albedo_b + i) -
                    Load3(g.albedo_r + j, g.albedo_g + j, g.albedo_b + j);
  // The depth of a plane changes from pixel to pixel, so the distance of j from the plane of i
  // counts.
  const VF slope =
      Load(f.depth_dx + i) * Set(neighbours.dx) + Load(f.depth_dy + i) * Set(neighbours.dy);
  const VF depth = Load(g.depth + j) - Load(f.depth + i) - slope;
  const VF of_surface = Dot(normal, normal) + Dot(albedo, albedo) + depth * depth;
  // Where nothing was hit there are no features.
  const VF here = Load(f.coverage + i), there = Load(g.coverage + j);
  const VF both = hn::Min(here, there), coverage = here - there;
  const VF share = both * kCoverageUnit;
  return share * share * of_surface + coverage * coverage;
}

// Sums of a tile for one half: of what its pixels are averaged with, of the weights, and of the
// noise by their squares.
struct Averages {
  TilePlane r, g, b, weight, noise;

  HWY_INLINE void Clear(int x, int y) {
    for (TilePlane* plane : {&r, &g, &b, &weight, &noise}) Store(hn::Zero(F()), plane->at(x, y));
  }
  // Adds pixels `j` of a half to those at (x, y).
  HWY_INLINE void Add(int x, int y, const HalfPlanes& from, std::size_t j, VF share) {
    const auto sum = [&](TilePlane& plane, VF value) HWY_ATTR {
      float* const at = plane.at(x, y);
      Store(Load(at) + value, at);
    };
    sum(r, share * Load(from.r + j));
    sum(g, share * Load(from.g + j));
    sum(b, share * Load(from.b + j));
    sum(weight, share);
    sum(noise, share * share * Load(from.noise + j));
  }
};

// Calls f(x, y, i) for the vectors of a tile; pixel (x, y) of it is number i of the planes.
template <class Function>
HWY_INLINE void ForEachVector(const PlaneShape& shape, const FilterTile& tile, const Function& f) {
  const int lanes = static_cast<int>(hn::Lanes(F()));
  for (int y = 0; y < tile.height; ++y) {
    for (int x = 0; x < tile.width; x += lanes) f(x, y, shape.at(tile.x + x, tile.y + y));
  }
}

// Returns how much pixels j count for pixels i by one half: (trust - excess)^8, where `trust` is
// what their features leave, and the excess of their distance, `around` summed over 3 x 3 pixels,
// is beyond what noise explains. Pixels that are noisier count less, and single ones that are far
// apart
// (`z`) not at all.
HWY_INLINE VF NeighbourWeight(VF trust, VF around, VF z, VF noise_i, VF noise_j) {
  const VF zero = hn::Zero(F());
  const VF excess = hn::Max(around * (1.0f / 9) - kTolerated, zero);
  VF weight = hn::Max(trust - excess * (1 / kLimit), zero);
  weight = weight * weight, weight = weight * weight;
  weight = weight * weight;
  weight = weight * hn::Min(noise_i * kNoisier / noise_j, Set(1.0f));
  return IfThen(hn::Gt(z, Set(kFarApart)), zero, weight);
}

// The sums of both halves of a tile, and squared distances for one neighbour at a time.
struct CrossSums {
  TilePlane z[2], three[2];
  Averages averages[2];
};

// Begins with the pixels of a tile themselves.
HWY_INLINE void BeginSums(const PlaneShape& shape, const HalfPlanes (&in)[2],
                          const FilterTile& tile, CrossSums& sums) {
  // A pixel equals itself.
  ForEachVector(shape, tile, [&](int x, int y, std::size_t i) HWY_ATTR {
    for (int half = 0; half < 2; ++half) {
      sums.averages[half].Clear(x, y);
      sums.averages[half].Add(x, y, in[half], i, Set(1.0f));
    }
  });
}

// Adds neighbours: each half is weighted by the other one.
HWY_INLINE void AddNeighbours(const PlaneShape& shape, const FeaturePlanes& features,
                              const HalfPlanes (&in)[2], const FilterTile& tile,
                              const Neighbours& neighbours, CrossSums& sums) {
  for (int half = 0; half < 2; ++half) {
    Distances(shape, in[half], tile, neighbours, half, sums.z[half], sums.three[half]);
  }
  ForEachVector(shape, tile, [&](int x, int y, std::size_t i) HWY_ATTR {
    const std::size_t j = neighbours.at(x, y);
    const VF trust = Set(1.0f) - FeatureDistance(features, i, neighbours, j) * (0.5f / kLimit);
    if (hn::AllTrue(F(), hn::Le(trust, hn::Zero(F())))) return;
    for (int half = 0; half < 2; ++half) {
      TilePlane& rows = sums.three[half];
      const VF around = Load(rows.at(x, y - 1)) + Load(rows.at(x, y + 1)) + Load(rows.at(x, y));
      const VF weight = NeighbourWeight(trust, around, Load(sums.z[half].at(x, y)),
                                        Load(in[half].noise + i) + kNoNoise,
                                        Load(neighbours.halves[half].noise + j) + kNoNoise);
      sums.averages[1 - half].Add(x, y, neighbours.halves[1 - half], j, weight);
    }
  });
}

// Writes the averages that sums say.
HWY_INLINE void WriteAverages(const PlaneShape& shape, const FilterTile& tile, CrossSums& sums,
                              const HalfPlanes (&out)[2]) {
  ForEachVector(shape, tile, [&](int x, int y, std::size_t i) HWY_ATTR {
    for (int half = 0; half < 2; ++half) {
      Averages& a = sums.averages[half];
      const HalfPlanes& to = out[half];
      const VF scale = 1.0f / Load(a.weight.at(x, y));
      Store(Load(a.r.at(x, y)) * scale, to.r + i);
      Store(Load(a.g.at(x, y)) * scale, to.g + i);
      Store(Load(a.b.at(x, y)) * scale, to.b + i);
      Store(Load(a.noise.at(x, y)) * scale * scale, to.noise + i);
    }
  });
}

void CrossFilter(const PlaneShape& shape, const FeaturePlanes& features, const HalfPlanes (&in)[2],
                 const FilterLevel& level, const FilterTile& tile, const HalfPlanes (&out)[2]) {
  CrossSums sums;
  BeginSums(shape, in, tile, sums);
  for (int y = -level.radius; y <= level.radius; ++y) {
    for (int x = -level.radius; x <= level.radius; ++x) {
      if (x == 0 && y == 0) continue;
      const int dx = x * level.stride, dy = y * level.stride;
      const Neighbours neighbours = {
          features,      {in[0], in[1]}, shape.at(tile.x + dx, tile.y + dy),
          shape.pitch(), float(dx),      float(dy)};
      AddNeighbours(shape, features, in, tile, neighbours, sums);
    }
  }
  WriteAverages(shape, tile, sums, out);
}

void AverageFrames(const PlaneShape& shape, const FeaturePlanes& features,
                   const HalfPlanes (&in)[2], std::span<const BroughtTile> others,
                   const FilterTile& tile, const HalfPlanes (&out)[2]) {
  CrossSums sums;
  BeginSums(shape, in, tile, sums);
  for (const BroughtTile& other : others) {
    const Neighbours neighbours = {other.features,
                                   {other.halves[0], other.halves[1]},
                                   other.shape.at(0, 0),
                                   other.shape.pitch(),
                                   0,
                                   0};
    AddNeighbours(shape, features, in, tile, neighbours, sums);
  }
  WriteAverages(shape, tile, sums, out);
}

// Writes the larger of the means over 3 x 3 and 5 x 5 pixels.
class NeighborhoodMean {
 public:
  // Reads pixels -2 to tile.height + 2 of `values`.
  HWY_INLINE NeighborhoodMean(const FilterTile& tile, TilePlane& values) {
    const int lanes = static_cast<int>(hn::Lanes(F()));
    for (int y = -2; y < tile.height + 2; ++y) {
      for (int x = 0; x < tile.width; x += lanes) {
        const VF inner =
            Load(values.at(x - 1, y)) + Load(values.at(x + 1, y)) + Load(values.at(x, y));
        const VF outer = Load(values.at(x - 2, y)) + Load(values.at(x + 2, y));
        Store(inner, three_.at(x, y));
        Store(inner + outer, five_.at(x, y));
      }
    }
  }
  HWY_INLINE VF At(int x, int y) {
    VF three = hn::Zero(F()), five = hn::Zero(F());
    for (int dy = -1; dy <= 1; ++dy) three = three + Load(three_.at(x, y + dy));
    for (int dy = -2; dy <= 2; ++dy) five = five + Load(five_.at(x, y + dy));
    return hn::Max(three * (1.0f / 9), five * (1.0f / 25));
  }

 private:
  TilePlane three_, five_;
};

HWY_INLINE void ErrorOfChannel(const PlaneShape& shape, const float* const (&noisy)[2],
                               const float* const (&filtered)[2], const FilterTile& tile,
                               float* squared_error) {
  const int lanes = static_cast<int>(hn::Lanes(F()));
  TilePlane differences, products;
  for (int y = -2; y < tile.height + 2; ++y) {
    for (int x = -2; x < tile.width + 2; x += lanes) {
      const std::size_t i = shape.at(tile.x + x, tile.y + y);
      const VF f0 = Load(filtered[0] + i), f1 = Load(filtered[1] + i);
      const VF x0 = Load(noisy[0] + i), x1 = Load(noisy[1] + i);
      const VF apart = f0 - f1;
      Store(apart * apart * (0.25f * kFewNumbers), differences.at(x, y));
      Store((f0 - x1) * (f1 - x0), products.at(x, y));
    }
  }
  NeighborhoodMean variance(tile, differences), squared_bias(tile, products);
  for (int y = 0; y < tile.height; ++y) {
    for (int x = 0; x < tile.width; x += lanes) {
      const VF bias = hn::Max(squared_bias.At(x, y), hn::Zero(F()));
      Store(variance.At(x, y) + bias, squared_error + shape.at(tile.x + x, tile.y + y));
    }
  }
}

void EstimateError(const PlaneShape& shape, const HalfPlanes (&noisy)[2],
                   const HalfPlanes (&filtered)[2], const FilterTile& tile,
                   const ErrorPlanes& squared_error) {
  ErrorOfChannel(shape, {noisy[0].r, noisy[1].r}, {filtered[0].r, filtered[1].r}, tile,
                 squared_error.r);
  ErrorOfChannel(shape, {noisy[0].g, noisy[1].g}, {filtered[0].g, filtered[1].g}, tile,
                 squared_error.g);
  ErrorOfChannel(shape, {noisy[0].b, noisy[1].b}, {filtered[0].b, filtered[1].b}, tile,
                 squared_error.b);
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(SmoothNoise);
HWY_EXPORT(TakeLogarithms);
HWY_EXPORT(CrossFilter);
HWY_EXPORT(AverageFrames);
HWY_EXPORT(EstimateError);

void SmoothNoise(const PlaneShape& shape, const HalfPlanes& half, const HalfPlanes& other,
                 const float* samples, int y, float* noise) {
  HWY_DYNAMIC_DISPATCH(SmoothNoise)(shape, half, other, samples, y, noise);
}
void TakeLogarithms(const PlaneShape& shape, int y, float scale, float* plane) {
  HWY_DYNAMIC_DISPATCH(TakeLogarithms)(shape, y, scale, plane);
}
void CrossFilter(const PlaneShape& shape, const FeaturePlanes& features, const HalfPlanes (&in)[2],
                 const FilterLevel& level, const FilterTile& tile, const HalfPlanes (&out)[2]) {
  HWY_DYNAMIC_DISPATCH(CrossFilter)(shape, features, in, level, tile, out);
}
void AverageFrames(const PlaneShape& shape, const FeaturePlanes& features,
                   const HalfPlanes (&in)[2], std::span<const BroughtTile> others,
                   const FilterTile& tile, const HalfPlanes (&out)[2]) {
  HWY_DYNAMIC_DISPATCH(AverageFrames)(shape, features, in, others, tile, out);
}
void EstimateError(const PlaneShape& shape, const HalfPlanes (&noisy)[2],
                   const HalfPlanes (&filtered)[2], const FilterTile& tile,
                   const ErrorPlanes& squared_error) {
  HWY_DYNAMIC_DISPATCH(EstimateError)(shape, noisy, filtered, tile, squared_error);
}

}  // namespace skywave
#endif  // HWY_ONCE
