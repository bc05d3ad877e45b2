#include "kernels/feature_fit.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/feature_fit.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/simd/exp-inl.h"
#include "kernels/simd/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// A pixel that keeps more than this share of its noise has found few others like it.
constexpr float kNoisyShare = 0.07f;
// Pixels on each side that are fitted.
constexpr int kReach = 3;
constexpr int kNeighbours = (2 * kReach + 1) * (2 * kReach + 1) - 1;
// 1, normal, albedo, depth, coverage, x, y.
constexpr int kTerms = 11;
// Neighbours without noise are no better known than to this share of the noise of the pixel.
constexpr float kLeastNoise = 0.2f;
// Neighbours that are noisier by far count this much, so that sums of weights stay far from 0.
constexpr float kLeastWeight = 1e-6f;
constexpr float kRidge = 1e-3f;
// Added to the mean square of each feature, in its units: one that varies by less says little.
constexpr float kLeastSquare = 1e-3f;

// The terms of the linear function, and what is known of one neighbour of a vector of pixels.
struct Neighbour {
  VF terms[kTerms];  // of the features, relative to those of the pixel
  VF closeness;      // 0: it is outside of the picture
  V3 radiance[2];
  VF noise[2];
};

// What is read.
struct Planes {
  const FeaturePlanes& features;
  const TexturePlanes& texture;
  VF unit;  // of radiance, its inverse
  const HalfPlanes (&in)[2];
};

// Features of pixels, as they mix in proportion to what pixels show: multiplied by coverage.
HWY_INLINE void Features(const FeaturePlanes& f, VU at, VF depth_here, VF (&terms)[kTerms]) {
  const VF coverage = Gather(f.coverage, at), share = coverage * kCoverageUnit;
  const float* const plain[] = {f.normal_x, f.normal_y, f.normal_z,
                                f.albedo_r, f.albedo_g, f.albedo_b};
  terms[0] = Set(1.0f);
  for (int k = 0; k < 6; ++k) terms[1 + k] = share * Gather(plain[k], at);
  const VF steps = (Gather(f.depth, at) - depth_here) * kDepthUnit;
  terms[7] = share * Exp(Clamp(steps, -5, 5)) * (1 / kDepthUnit);
  terms[8] = coverage;
}

HWY_INLINE V3 Texture(const Planes& planes, VU at) {
  const TexturePlanes& t = planes.texture;
  return V3{Gather(t.r, at), Gather(t.g, at), Gather(t.b, at)} * planes.unit;
}

HWY_INLINE VF MeanSquare(const V3& color) { return Dot(color, color) * (1.0f / 3); }

// Finds neighbour (dx, dy) of pixels `at`.
HWY_INLINE Neighbour Find(const PlaneShape& shape, const Planes& planes, VU at,
                          const VF (&here)[kTerms], VF depth_here, int dx, int dy) {
  Neighbour found;
  const std::ptrdiff_t offset = std::ptrdiff_t(shape.pitch()) * dy + dx;
  const VU j = at + SetU(static_cast<std::uint32_t>(offset));
  // The rim has no features, and a coverage that is none.
  const MF inside = hn::Lt(Gather(planes.features.coverage, j), Set(0.5f * kNoCoverage));
  Features(planes.features, j, depth_here, found.terms);
  for (int k = 1; k < 9; ++k) {
    found.terms[k] = IfThen(inside, found.terms[k] - here[k], hn::Zero(F()));
  }
  found.terms[9] = Set(float(dx)), found.terms[10] = Set(float(dy));

  const float falls = 1 - float(dx * dx + dy * dy) * (1 / (2.25f * kReach * kReach));
  found.closeness = IfThen(inside, Set(falls * falls * falls * falls), hn::Zero(F()));

  const V3 texture = Texture(planes, j);
  for (int half = 0; half < 2; ++half) {
    const HalfPlanes& in = planes.in[half];
    found.radiance[half] = V3{Gather(in.r, j), Gather(in.g, j), Gather(in.b, j)} * texture;
    found.noise[half] = Gather(in.noise, j) * MeanSquare(texture);
  }
  return found;
}

// A symmetric matrix by its lower triangle, and its Cholesky factor.
struct Symmetric {
  VF values[kTerms * (kTerms + 1) / 2];
  HWY_INLINE VF& at(int row, int column) { return values[row * (row + 1) / 2 + column]; }
};

// Replaces a positive definite matrix by the triangle L with L L^T = M. No pivot is below `least`.
HWY_INLINE void Factor(Symmetric& m, VF least) {
  for (int row = 0; row < kTerms; ++row) {
    for (int column = 0; column <= row; ++column) {
      VF value = m.at(row, column);
      for (int k = 0; k < column; ++k) value = value - m.at(row, k) * m.at(column, k);
      m.at(row, column) =
          row == column ? hn::Sqrt(hn::Max(value, least)) : value / m.at(column, column);
    }
  }
}

// Replaces x by the solution of L L^T x = x.
HWY_INLINE void Solve(Symmetric& triangle, VF (&x)[kTerms]) {
  for (int row = 0; row < kTerms; ++row) {
    for (int k = 0; k < row; ++k) x[row] = x[row] - triangle.at(row, k) * x[k];
    x[row] = x[row] / triangle.at(row, row);
  }
  for (int row = kTerms - 1; row >= 0; --row) {
    for (int k = row + 1; k < kTerms; ++k) x[row] = x[row] - triangle.at(k, row) * x[k];
    x[row] = x[row] / triangle.at(row, row);
  }
}

// What the neighbours of a half say of pixels.
struct Prediction {
  V3 radiance;
  VF variance;  // of it, all channels
  VF error;     // squared, of the linear function
};

// Fits the linear function to the neighbours, by the noise of the other half; `noise_here` is the
// unit of the weights.
HWY_INLINE Prediction Fit(const Neighbour (&neighbours)[kNeighbours], int half, VF noise_here) {
  const VF zero = hn::Zero(F());
  Symmetric matrix;
  VF red[kTerms], green[kTerms], blue[kTerms], first[kTerms], squares[kTerms];
  for (VF& value : matrix.values) value = zero;
  for (int k = 0; k < kTerms; ++k) {
    red[k] = green[k] = blue[k] = first[k] = squares[k] = zero;
  }
  VF weights[kNeighbours];
  VF all_weights = zero, all_close = zero;
  for (int j = 0; j < kNeighbours; ++j) {
    const Neighbour& n = neighbours[j];
    const VF noise = n.noise[1 - half] + noise_here * kLeastNoise;
    const VF weight = n.closeness * hn::Max(noise_here / noise, Set(kLeastWeight));
    weights[j] = weight;
    all_weights = all_weights + weight, all_close = all_close + n.closeness;
    for (int row = 0; row < kTerms; ++row) {
      const VF weighted = weight * n.terms[row];
      for (int column = 0; column <= row; ++column) {
        matrix.at(row, column) = matrix.at(row, column) + weighted * n.terms[column];
      }
      red[row] = red[row] + weighted * n.radiance[half].x;
      green[row] = green[row] + weighted * n.radiance[half].y;
      blue[row] = blue[row] + weighted * n.radiance[half].z;
      squares[row] = squares[row] + n.closeness * n.terms[row] * n.terms[row];
    }
  }
  // Where there is no neighbour at all nothing is divided by 0, and nothing is said.
  const MF is_known = hn::Gt(all_close, zero);
  all_weights = IfThen(is_known, all_weights, Set(1.0f));
  const VF per_close = 1.0f / IfThen(is_known, all_close, Set(1.0f));
  for (int k = 1; k < kTerms; ++k) {
    const VF ridge = (squares[k] * per_close + kLeastSquare) * all_weights * kRidge;
    matrix.at(k, k) = matrix.at(k, k) + ridge;
  }
  Factor(matrix, all_weights * (1e-3f * kRidge * kLeastSquare));
  // The first row of the inverse makes the intercept.
  first[0] = Set(1.0f);
  Solve(matrix, first), Solve(matrix, red), Solve(matrix, green), Solve(matrix, blue);

  VF variance = zero, weighted = zero, plain = zero;
  for (int j = 0; j < kNeighbours; ++j) {
    const Neighbour& n = neighbours[j];
    VF share = zero;
    V3 left = n.radiance[half];
    for (int k = 0; k < kTerms; ++k) {
      share = share + first[k] * n.terms[k];
      left = left - V3{red[k], green[k], blue[k]} * n.terms[k];
    }
    share = share * weights[j];
    variance = variance + share * share * n.noise[half];
    const VF square = Dot(left, left);
    weighted = weighted + weights[j] * square;
    plain = plain + n.closeness * (square - n.noise[half] * 0.5f);
  }
  return {.radiance = {red[0], green[0], blue[0]},
          .variance = variance,
          .error = IfThen(is_known, hn::Max(weighted / all_weights, plain * per_close),
                          Set(std::numeric_limits<float>::infinity()))};
}

// Values and noise of both halves.
struct Repaired {
  V3 light[2];
  VF noise[2];
};
// Returns pixels `at`: each half goes towards what its neighbours say as far as the other one
// allows.
HWY_INLINE Repaired Repair(const PlaneShape& shape, const Planes& planes, VU at) {
  const VF depth = Gather(planes.features.depth, at), zero = hn::Zero(F());
  VF here[kTerms];
  Features(planes.features, at, depth, here);
  Neighbour neighbours[kNeighbours];
  int count = 0;
  for (int dy = -kReach; dy <= kReach; ++dy) {
    for (int dx = -kReach; dx <= kReach; ++dx) {
      if (dx == 0 && dy == 0) continue;
      neighbours[count++] = Find(shape, planes, at, here, depth, dx, dy);
    }
  }
  const Neighbour own = Find(shape, planes, at, here, depth, 0, 0);
  const VF noise_here = (own.noise[0] + own.noise[1]) * 0.5f;
  const Prediction fits[2] = {Fit(neighbours, 0, noise_here), Fit(neighbours, 1, noise_here)};

  const V3 texture = Texture(planes, at);
  const V3 per_texture = {1.0f / texture.x, 1.0f / texture.y, 1.0f / texture.z};
  Repaired result;
  for (int half = 0; half < 2; ++half) {
    const Prediction& judge = fits[1 - half];
    const V3 apart = judge.radiance - own.radiance[1 - half];
    const VF variance = own.noise[1 - half] + judge.variance + judge.error;
    const MF is_alike =
        hn::And(hn::Le(Dot(apart, apart), variance * kFarApart), hn::Gt(own.noise[1 - half], zero));
    const VF share = IfThen(is_alike, own.noise[1 - half] / variance, zero);
    result.light[half] = Mix(own.radiance[half], fits[half].radiance, share) * per_texture;
    const VF rest = 1.0f - share;
    const VF noise = rest * rest * own.noise[half] + share * share * fits[half].variance;
    result.noise[half] = noise / MeanSquare(texture);
  }
  return result;
}

void FitToFeatures(const PlaneShape& shape, const FeaturePlanes& features,
                   const TexturePlanes& texture, float brightness, const HalfPlanes (&noisy)[2],
                   const HalfPlanes (&in)[2], int y, const HalfPlanes (&out)[2]) {
  const Planes planes = {features, texture, Set(1 / brightness), in};
  const std::uint32_t lanes = static_cast<std::uint32_t>(hn::Lanes(F()));
  // Pixels that are to be repaired, until there is a vector of them.
  alignas(kColumnAlignment) std::uint32_t list[kPadRows];
  std::uint32_t count = 0;
  const auto repair = [&]() HWY_ATTR {
    for (std::uint32_t i = count; i < lanes; ++i) list[i] = list[0];
    const Repaired repaired = Repair(shape, planes, Load(list));
    for (int half = 0; half < 2; ++half) {
      const HalfPlanes& to = out[half];
      alignas(kColumnAlignment) float values[4][kPadRows] = {};
      Store3(repaired.light[half], values[0], values[1], values[2]);
      Store(repaired.noise[half], values[3]);
      for (std::uint32_t i = 0; i < count; ++i) {
        to.r[list[i]] = values[0][i], to.g[list[i]] = values[1][i], to.b[list[i]] = values[2][i];
        to.noise[list[i]] = values[3][i];
      }
    }
    count = 0;
  };
  for (int half = 0; half < 2; ++half) {
    const std::size_t row = shape.at(0, y), width = std::size_t(shape.width);
    std::copy_n(in[half].r + row, width, out[half].r + row);
    std::copy_n(in[half].g + row, width, out[half].g + row);
    std::copy_n(in[half].b + row, width, out[half].b + row);
    std::copy_n(in[half].noise + row, width, out[half].noise + row);
  }
  for (int x = 0; x < shape.width; ++x) {
    const std::size_t at = shape.at(x, y);
    const float left = in[0].noise[at] + in[1].noise[at];
    if (left <= kNoisyShare * (noisy[0].noise[at] + noisy[1].noise[at]) + kNoNoise) continue;
    list[count++] = static_cast<std::uint32_t>(at);
    if (count == lanes) repair();
  }
  if (count > 0) repair();
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(FitToFeatures);

void FitToFeatures(const PlaneShape& shape, const FeaturePlanes& features,
                   const TexturePlanes& texture, float brightness, const HalfPlanes (&noisy)[2],
                   const HalfPlanes (&in)[2], int y, const HalfPlanes (&out)[2]) {
  HWY_DYNAMIC_DISPATCH(FitToFeatures)(shape, features, texture, brightness, noisy, in, y, out);
}

}  // namespace skywave
#endif  // HWY_ONCE
