#include "kernels/accumulate.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/accumulate.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/camera.h"
#include "kernels/simd/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Adds the first `rows` lanes to the rows path[0..] of the radiance columns. A path has at most one
// row in a table, so no two additions go to the same row.
HWY_INLINE void AddToPaths(const V3& gain, const std::uint32_t* path, std::uint32_t rows,
                           const PathColumns& paths) {
  alignas(kColumnAlignment) float r[kPadRows], g[kPadRows], b[kPadRows];
  Store3(gain, r, g, b);
  for (std::uint32_t lane = 0; lane < rows; ++lane) {
    const std::uint32_t row = path[lane];
    paths.r[row] += r[lane];
    paths.g[row] += g[lane];
    paths.b[row] += b[lane];
  }
}

void AddEscapedRadiance(const EscapeColumns& rows, std::uint32_t n, const MisPolicy& mis,
                        const PathColumns& paths) {
  const VF zero = hn::Zero(F()), one = Set(1.0f);
  const std::uint32_t lanes = static_cast<std::uint32_t>(hn::Lanes(F()));
  for (std::uint32_t i = 0; i < n; i += lanes) {
    const VF pdf = Load(rows.pdf + i);
    VF weight = zero;
    if (mis.enabled) {
      const VF light = Load(rows.light_pdf + i);
      const VF p = pdf * mis.bsdf_samples, p2 = p * p;
      weight = p2 / (p2 + light * light);
    }
    weight = IfThen(hn::Le(pdf, zero), one, weight);  // there is no density
    const V3 light = Load3(rows.throughput_r + i, rows.throughput_g + i, rows.throughput_b + i) *
                     Load3(rows.radiance_r + i, rows.radiance_g + i, rows.radiance_b + i);
    AddToPaths(light * weight, rows.path + i, std::min(lanes, n - i), paths);
  }
}

void AddUnoccludedRadiance(const LightColumns& lights, const std::uint32_t* path, std::uint32_t n,
                           const PathColumns& paths) {
  const VF zero = hn::Zero(F());
  const std::uint32_t lanes = static_cast<std::uint32_t>(hn::Lanes(F()));
  for (std::uint32_t i = 0; i < n; i += lanes) {
    // Occlusion is as unpredictable as random numbers, so adding a zero is cheaper than a branch.
    const MF seen = hn::Ge(Load(lights.t_far + i), zero);
    if (hn::AllFalse(F(), seen)) continue;
    const V3 gain =
        IfThen(seen, Load3(lights.r + i, lights.g + i, lights.b + i), V3{zero, zero, zero});
    AddToPaths(gain, path + i, std::min(lanes, n - i), paths);
  }
}

void SubtractControl(const ControlColumns& control, const std::uint32_t* path, std::uint32_t n,
                     const PathColumns& paths) {
  const VF zero = hn::Zero(F());
  const std::uint32_t lanes = static_cast<std::uint32_t>(hn::Lanes(F()));
  for (std::uint32_t i = 0; i < n; i += lanes) {
    const V3 known = Load3(control.r + i, control.g + i, control.b + i);
    AddToPaths(V3{zero, zero, zero} - known, path + i, std::min(lanes, n - i), paths);
  }
}

// Converts radiance to integer units: adding 2^52 leaves the rounded value in the mantissa of a
// double.
template <bool kHasSigns>
HWY_INLINE void ToUnits(VF value, double units, std::uint64_t* out) {
  const hn::CappedTag<double, kPadRows / 2> d;
  const hn::RebindToUnsigned<decltype(d)> bits;
  const hn::Rebind<float, decltype(d)> half;
  alignas(kColumnAlignment) float lanes[kPadRows];
  Store(value, lanes);
  // Half of it more leaves room below for negative values.
  const auto magic = hn::Set(d, kHasSigns ? 0x1.8p52 : 0x1p52);
  for (std::size_t i = 0; i < hn::Lanes(F()); i += hn::Lanes(d)) {
    const auto scaled = hn::PromoteTo(d, hn::LoadU(half, lanes + i)) * hn::Set(d, units);
    const auto kept = kHasSigns ? scaled : hn::Min(scaled, magic);
    const auto rounded = hn::BitCast(bits, kept + magic);
    hn::StoreU(rounded - hn::BitCast(bits, magic), bits, out + i);
  }
}

// The units that the film adds for some rows are stored by [channel][row].
constexpr std::uint32_t kUnitRows = 4 * kPadRows;
struct RowUnits {
  alignas(kColumnAlignment) std::uint64_t rgb[3][kUnitRows];
};
// Writes the units of one vector to rows `at` and on.
template <bool kHasSigns = false>
HWY_INLINE void ToUnits(const V3& rgb, const FilmScale& scale, RowUnits& units,
                        std::uint32_t at = 0) {
  const VF zero = hn::Zero(F()), limit = Set(scale.limit);
  const auto keep = [&](VF value) HWY_ATTR {
    if constexpr (kHasSigns) {
      const VF number = hn::IfThenElseZero(hn::Eq(value, value), value);
      return hn::Max(hn::Min(number, limit), -limit);
    }
    // A comparison with NaN fails, so NaN becomes 0 like negative values.
    return hn::Min(hn::IfThenElseZero(hn::Gt(value, zero), value), limit);
  };
  ToUnits<kHasSigns>(keep(rgb.x), scale.units, units.rgb[0] + at);
  ToUnits<kHasSigns>(keep(rgb.y), scale.units, units.rgb[1] + at);
  ToUnits<kHasSigns>(keep(rgb.z), scale.units, units.rgb[2] + at);
}

// Counts those of the rows `inside` that a film cannot hold unchanged.
template <bool kHasSigns = false>
HWY_INLINE void CountMisfits(V3 rgb, MF inside, const FilmScale& scale, FilmCounts& counts) {
  const VF zero = hn::Zero(F()), limit = Set(scale.limit);
  if constexpr (kHasSigns) rgb = {hn::Abs(rgb.x), hn::Abs(rgb.y), hn::Abs(rgb.z)};
  const MF valid = hn::And(hn::And(hn::Ge(rgb.x, zero), hn::Ge(rgb.y, zero)), hn::Ge(rgb.z, zero));
  counts.invalid += hn::CountTrue(F(), hn::AndNot(valid, inside));
  // Channels are compared one by one, because the maximum of a NaN and a number depends on the
  // target.
  const MF bright =
      hn::Or(hn::Or(hn::Gt(rgb.x, limit), hn::Gt(rgb.y, limit)), hn::Gt(rgb.z, limit));
  counts.clamped += hn::CountTrue(F(), hn::And(inside, bright));
}

template <bool kShared, bool kHasSigns = false>
FilmCounts AddToSums(const PathColumns& paths, std::uint32_t n, const FilmScale& scale,
                     std::uint64_t* sums) {
  const std::uint32_t lanes = static_cast<std::uint32_t>(hn::Lanes(F()));
  FilmCounts counts = {0, 0};
  RowUnits units;
  for (std::uint32_t begin = 0; begin < n; begin += kUnitRows) {
    const std::uint32_t rows = std::min(kUnitRows, n - begin);
    for (std::uint32_t at = 0; at < rows; at += lanes) {
      const std::uint32_t i = begin + at;
      const V3 rgb = Load3(paths.r + i, paths.g + i, paths.b + i);
      CountMisfits<kHasSigns>(rgb, hn::RebindMask(F(), RowsBelow(i, n)), scale, counts);
      ToUnits<kHasSigns>(rgb, scale, units, at);
    }
    // The beams of a block follow each other, so the samples of a pixel are summed before the
    // memory is touched.
    const std::uint32_t* const pixels = paths.pixel + begin;
    for (std::uint32_t ray = 0; ray < kBeamRays; ++ray) {
      for (std::uint32_t row = ray; row < rows;) {
        const std::uint32_t pixel = pixels[row];
        std::uint64_t r = 0, g = 0, b = 0;  // at most kUnitRows * 2^52
        for (; row < rows && pixels[row] == pixel; row += kBeamRays) {
          r += units.rgb[0][row], g += units.rgb[1][row], b += units.rgb[2][row];
        }
        std::uint64_t* sum = sums + std::size_t(pixel) * 3;
        if constexpr (kShared) {
          AddSaturating(sum[0], r), AddSaturating(sum[1], g), AddSaturating(sum[2], b);
        } else if constexpr (kHasSigns) {
          sum[0] += r, sum[1] += g, sum[2] += b;
        } else {
          sum[0] = SaturatingSum(sum[0], r);
          sum[1] = SaturatingSum(sum[1], g);
          sum[2] = SaturatingSum(sum[2], b);
        }
      }
    }
  }
  return counts;
}
FilmCounts AddToFilm(const PathColumns& paths, std::uint32_t n, const FilmScale& scale,
                     std::uint64_t* sums, bool shared) {
  if (scale.has_signs) return AddToSums<false, true>(paths, n, scale, sums);
  return shared ? AddToSums<true>(paths, n, scale, sums) : AddToSums<false>(paths, n, scale, sums);
}

FilmCounts AddSplatsToFilm(const LightColumns& splats, const std::uint32_t* pixel, std::uint32_t n,
                           float factor, const FilmScale& scale, std::uint64_t* sums) {
  const std::uint32_t lanes = static_cast<std::uint32_t>(hn::Lanes(F()));
  FilmCounts counts = {0, 0};
  RowUnits units;
  for (std::uint32_t i = 0; i < n; i += lanes) {
    const MF arrived = hn::And(hn::Ge(Load(splats.t_far + i), hn::Zero(F())),
                               hn::RebindMask(F(), RowsBelow(i, n)));
    if (hn::AllFalse(F(), arrived)) continue;
    const V3 rgb = Load3(splats.r + i, splats.g + i, splats.b + i) * factor;
    CountMisfits(rgb, arrived, scale, counts);
    ToUnits(rgb, scale, units);
    for (std::uint32_t lane = 0; lane < std::min(lanes, n - i); ++lane) {
      if (!(splats.t_far[i + lane] >= 0)) continue;
      std::uint64_t* sum = sums + std::size_t(pixel[i + lane]) * 3;
      for (std::size_t c = 0; c < 3; ++c) AddSaturating(sum[c], units.rgb[c][lane]);
    }
  }
  return counts;
}

template <bool kHasSigns>
HWY_INLINE void AddSquare(std::uint64_t units, Uint128& sum) {
  if (kHasSigns && std::int64_t(units) < 0) units = -units;
  sum = SaturatingSum(sum, Uint128{units} * units);
}

template <bool kHasSigns>
void AddSquares(const PathColumns& paths, std::uint32_t n, const FilmScale& scale, Uint128* sums) {
  const std::uint32_t lanes = static_cast<std::uint32_t>(hn::Lanes(F()));
  RowUnits units;
  for (std::uint32_t i = 0; i < n; i += lanes) {
    ToUnits<kHasSigns>(Load3(paths.r + i, paths.g + i, paths.b + i), scale, units);
    for (std::uint32_t lane = 0; lane < std::min(lanes, n - i); ++lane) {
      for (std::size_t c = 0; c < 3; ++c) {
        AddSquare<kHasSigns>(units.rgb[c][lane], sums[std::size_t(paths.pixel[i + lane]) * 3 + c]);
      }
    }
  }
}
void AddSquaresToFilm(const PathColumns& paths, std::uint32_t n, const FilmScale& scale,
                      Uint128* sums) {
  if (scale.has_signs) return AddSquares<true>(paths, n, scale, sums);
  AddSquares<false>(paths, n, scale, sums);
}

template <bool kHasSigns>
void AddHalf(const PathColumns& paths, std::uint32_t n, const FilmScale& scale,
             const HalfSums& half) {
  const std::uint32_t lanes = static_cast<std::uint32_t>(hn::Lanes(F()));
  RowUnits units;
  for (std::uint32_t i = 0; i < n; i += lanes) {
    ToUnits<kHasSigns>(Load3(paths.r + i, paths.g + i, paths.b + i), scale, units);
    for (std::uint32_t row = i; row < std::min(i + lanes, n); ++row) {
      if (!IsInSecondHalf(paths.sample[row])) continue;
      const std::size_t pixel = paths.pixel[row];
      if (half.samples != nullptr) ++half.samples[pixel];
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint64_t value = units.rgb[c][row - i];
        std::uint64_t& sum = half.sums[3 * pixel + c];
        sum = kHasSigns ? sum + value : SaturatingSum(sum, value);
        AddSquare<kHasSigns>(value, half.squares[3 * pixel + c]);
      }
    }
  }
}
void AddHalfToFilm(const PathColumns& paths, std::uint32_t n, const FilmScale& scale,
                   const HalfSums& half) {
  if (scale.has_signs) return AddHalf<true>(paths, n, scale, half);
  AddHalf<false>(paths, n, scale, half);
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(AddEscapedRadiance);
HWY_EXPORT(AddUnoccludedRadiance);
HWY_EXPORT(SubtractControl);
HWY_EXPORT(AddToFilm);
HWY_EXPORT(AddSplatsToFilm);
HWY_EXPORT(AddSquaresToFilm);
HWY_EXPORT(AddHalfToFilm);

void AddEscapedRadiance(const EscapeColumns& rows, std::uint32_t n, const MisPolicy& mis,
                        const PathColumns& paths) {
  HWY_DYNAMIC_DISPATCH(AddEscapedRadiance)(rows, n, mis, paths);
}
void AddUnoccludedRadiance(const LightColumns& lights, const std::uint32_t* path, std::uint32_t n,
                           const PathColumns& paths) {
  HWY_DYNAMIC_DISPATCH(AddUnoccludedRadiance)(lights, path, n, paths);
}
void SubtractControl(const ControlColumns& control, const std::uint32_t* path, std::uint32_t n,
                     const PathColumns& paths) {
  HWY_DYNAMIC_DISPATCH(SubtractControl)(control, path, n, paths);
}

FilmCounts AddToFilm(const PathColumns& paths, std::uint32_t n, const FilmScale& scale,
                     std::uint64_t* sums, bool shared) {
  return HWY_DYNAMIC_DISPATCH(AddToFilm)(paths, n, scale, sums, shared);
}
FilmCounts AddSplatsToFilm(const LightColumns& splats, const std::uint32_t* pixel, std::uint32_t n,
                           float factor, const FilmScale& scale, std::uint64_t* sums) {
  return HWY_DYNAMIC_DISPATCH(AddSplatsToFilm)(splats, pixel, n, factor, scale, sums);
}

void AddSquaresToFilm(const PathColumns& paths, std::uint32_t n, const FilmScale& scale,
                      Uint128* sums) {
  HWY_DYNAMIC_DISPATCH(AddSquaresToFilm)(paths, n, scale, sums);
}
void AddHalfToFilm(const PathColumns& paths, std::uint32_t n, const FilmScale& scale,
                   const HalfSums& half) {
  HWY_DYNAMIC_DISPATCH(AddHalfToFilm)(paths, n, scale, half);
}

}  // namespace skywave
#endif  // HWY_ONCE
