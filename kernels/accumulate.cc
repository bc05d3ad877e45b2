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

// Calls f(pixel, for_each_row) for each run of rows [0, n) that are of one pixel; for_each_row(g)
// calls g(row) for these. The beams of a block follow each other, so what f adds up in registers is
// added to memory once.
template <class F>
HWY_INLINE void ForEachPixelRun(const std::uint32_t* pixels, std::uint32_t n, const F& f) {
  for (std::uint32_t ray = 0; ray < kBeamRays; ++ray) {
    std::uint32_t row = ray;
    while (row < n) {
      const std::uint32_t pixel = pixels[row];
      f(pixel, [&](const auto& g) {
        for (; row < n && pixels[row] == pixel; row += kBeamRays) g(row);
      });
    }
  }
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
    ForEachPixelRun(paths.pixel + begin, rows, [&](std::uint32_t pixel, const auto& for_each_row) {
      std::uint64_t r = 0, g = 0, b = 0;  // at most kUnitRows * 2^52
      for_each_row([&](std::uint32_t row) {
        r += units.rgb[0][row], g += units.rgb[1][row], b += units.rgb[2][row];
      });
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
    });
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

// What the rows of a run bring to the moments of their pixel.
struct RunMoments {
  std::uint32_t in_second_half = 0;
  Uint128 squares[3] = {}, half_squares[3] = {};  // at most kUnitRows * 2^104
  std::uint64_t half[3] = {};

  template <bool kHasSigns, bool kHalves>
  HWY_INLINE void Add(const RowUnits& units, std::uint32_t row, bool is_second) {
    in_second_half += is_second;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint64_t value = units.rgb[c][row];
      const std::uint64_t magnitude = kHasSigns && std::int64_t(value) < 0 ? -value : value;
      const Uint128 square = Uint128{magnitude} * magnitude;
      squares[c] += square;
      if constexpr (!kHalves) continue;
      half[c] += is_second ? value : 0;
      half_squares[c] += is_second ? square : 0;
    }
  }
};

template <bool kHasSigns, bool kHalves>
void AddMoments(const PathColumns& paths, std::uint32_t n, const FilmScale& scale,
                const MomentSums& sums) {
  const std::uint32_t lanes = static_cast<std::uint32_t>(hn::Lanes(F()));
  RowUnits units;
  for (std::uint32_t begin = 0; begin < n; begin += kUnitRows) {
    const std::uint32_t rows = std::min(kUnitRows, n - begin);
    for (std::uint32_t at = 0; at < rows; at += lanes) {
      const std::uint32_t i = begin + at;
      ToUnits<kHasSigns>(Load3(paths.r + i, paths.g + i, paths.b + i), scale, units, at);
    }
    ForEachPixelRun(paths.pixel + begin, rows, [&](std::uint32_t pixel, const auto& for_each_row) {
      RunMoments run;
      for_each_row([&](std::uint32_t row) {
        const bool is_second = kHalves && IsInSecondHalf(paths.sample[begin + row]);
        run.Add<kHasSigns, kHalves>(units, row, is_second);
      });
      const std::size_t at = std::size_t(pixel) * 3;
      if (sums.half_samples != nullptr) sums.half_samples[pixel] += run.in_second_half;
      for (std::size_t c = 0; c < 3; ++c) {
        if (sums.squares != nullptr) {
          sums.squares[at + c] = SaturatingSum(sums.squares[at + c], run.squares[c]);
        }
        if constexpr (!kHalves) continue;
        std::uint64_t& half = sums.half[at + c];
        half = kHasSigns ? half + run.half[c] : SaturatingSum(half, run.half[c]);
        sums.half_squares[at + c] = SaturatingSum(sums.half_squares[at + c], run.half_squares[c]);
      }
    });
  }
}
void AddMomentsToFilm(const PathColumns& paths, std::uint32_t n, const FilmScale& scale,
                      const MomentSums& sums) {
  if (sums.half == nullptr) {
    if (scale.has_signs) return AddMoments<true, false>(paths, n, scale, sums);
    return AddMoments<false, false>(paths, n, scale, sums);
  }
  if (scale.has_signs) return AddMoments<true, true>(paths, n, scale, sums);
  AddMoments<false, true>(paths, n, scale, sums);
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
HWY_EXPORT(AddMomentsToFilm);

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

void AddMomentsToFilm(const PathColumns& paths, std::uint32_t n, const FilmScale& scale,
                      const MomentSums& sums) {
  HWY_DYNAMIC_DISPATCH(AddMomentsToFilm)(paths, n, scale, sums);
}

}  // namespace skywave
#endif  // HWY_ONCE
