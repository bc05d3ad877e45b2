#include "kernels/accumulate.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/accumulate.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Adds the first `rows` lanes to the rows path[0..] of the radiance columns. A path has at most one
// row in a table, so the additions cannot meet.
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
  const VF share = Set(mis.light_samples);
  const std::uint32_t lanes = static_cast<std::uint32_t>(hn::Lanes(F()));
  for (std::uint32_t i = 0; i < n; i += lanes) {
    const VF pdf = Load(rows.pdf + i);
    VF weight = zero;
    if (mis.enabled) {
      const VF light = hn::Mul(Load(rows.light_pdf + i), share);
      const VF p2 = hn::Mul(pdf, pdf);
      weight = hn::Div(p2, hn::Add(p2, hn::Mul(light, light)));
    }
    weight = IfThen(hn::Eq(pdf, zero), one, weight);
    const V3 light = Mul(Load3(rows.throughput_r + i, rows.throughput_g + i, rows.throughput_b + i),
                         Load3(rows.radiance_r + i, rows.radiance_g + i, rows.radiance_b + i));
    AddToPaths(Scale(light, weight), rows.path + i, std::min(lanes, n - i), paths);
  }
}

void AddUnoccludedRadiance(const LightColumns& lights, const std::uint32_t* path, std::uint32_t n,
                           const PathColumns& paths) {
  const VF zero = hn::Zero(F());
  const std::uint32_t lanes = static_cast<std::uint32_t>(hn::Lanes(F()));
  for (std::uint32_t i = 0; i < n; i += lanes) {
    // Occlusion is as good as random: adding a zero is cheaper than a branch on it.
    const MF seen = hn::Ge(Load(lights.t_far + i), zero);
    if (hn::AllFalse(F(), seen)) continue;
    const V3 gain =
        IfThen(seen, Load3(lights.r + i, lights.g + i, lights.b + i), V3{zero, zero, zero});
    AddToPaths(gain, path + i, std::min(lanes, n - i), paths);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(AddEscapedRadiance);
HWY_EXPORT(AddUnoccludedRadiance);

void AddEscapedRadiance(const EscapeColumns& rows, std::uint32_t n, const MisPolicy& mis,
                        const PathColumns& paths) {
  HWY_DYNAMIC_DISPATCH(AddEscapedRadiance)(rows, n, mis, paths);
}
void AddUnoccludedRadiance(const LightColumns& lights, const std::uint32_t* path, std::uint32_t n,
                           const PathColumns& paths) {
  HWY_DYNAMIC_DISPATCH(AddUnoccludedRadiance)(lights, path, n, paths);
}

}  // namespace skywave
#endif  // HWY_ONCE
