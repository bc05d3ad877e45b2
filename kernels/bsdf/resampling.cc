#include "kernels/bsdf/resampling.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/resampling.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

void StartReservoirs(const float* u, std::uint32_t n, const ReservoirColumns& reservoirs) {
  const VF zero = hn::Zero(F());
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    Store(zero, reservoirs.target + i);
    Store(zero, reservoirs.sum + i);
    Store(Load(u + i), reservoirs.x + i);
  }
}

void OfferCandidates(const LightColumns& lights, const BsdfValueColumns& values,
                     CandidateCounts counts, std::uint32_t n, const ReservoirColumns& reservoirs) {
  const VF zero = hn::Zero(F()), below_one = Set(0x1.fffffep-1f);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const V3 radiance = Load3(lights.r + i, lights.g + i, lights.b + i);
    const V3 value = Load3(values.r + i, values.g + i, values.b + i);
    const VF target = Luminance(value * radiance);
    const VF density =
        float(counts.map) * Load(lights.pdf + i) + float(counts.bsdf) * Load(values.pdf + i);
    const MF offered = hn::And(hn::Gt(target, zero), hn::Gt(density, zero));
    const VF weight = hn::IfThenElseZero(offered, target / density);
    const VF sum = Load(reservoirs.sum + i) + weight;
    // The candidate is kept with probability weight / sum; either way the rest of x is uniform
    // again.
    const VF probability = weight / sum;
    const VF x = Load(reservoirs.x + i);
    const MF kept = hn::And(offered, hn::Lt(x, probability));
    const VF rest = IfThen(kept, x / probability, (x - probability) / (1.0f - probability));
    Store(IfThen(offered, hn::Min(rest, below_one), x), reservoirs.x + i);
    Store(sum, reservoirs.sum + i);
    Store(IfThen(kept, target, Load(reservoirs.target + i)), reservoirs.target + i);
    const auto keep = [&](const float* candidate, float* held) HWY_ATTR {
      Store(IfThen(kept, Load(candidate + i), Load(held + i)), held + i);
    };
    keep(lights.dir_x, reservoirs.dir_x);
    keep(lights.dir_y, reservoirs.dir_y);
    keep(lights.dir_z, reservoirs.dir_z);
    keep(lights.r, reservoirs.r);
    keep(lights.g, reservoirs.g);
    keep(lights.b, reservoirs.b);
  }
}

void TakeFromReservoirs(const ReservoirColumns& reservoirs, std::uint32_t n, float samples,
                        const LightColumns& out) {
  const VF zero = hn::Zero(F());
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VF target = Load(reservoirs.target + i);
    const MF some = hn::Gt(target, zero);
    const VF worth = Load(reservoirs.sum + i) / (target * samples);
    const auto light = [&](const float* radiance, float* to) HWY_ATTR {
      Store(hn::IfThenElseZero(some, Load(radiance + i) * worth), to + i);
    };
    light(reservoirs.r, out.r);
    light(reservoirs.g, out.g);
    light(reservoirs.b, out.b);
    const auto direction = [&](const float* from, float fallback, float* to) HWY_ATTR {
      Store(IfThen(some, Load(from + i), Set(fallback)), to + i);
    };
    direction(reservoirs.dir_x, 0, out.dir_x);
    direction(reservoirs.dir_y, 0, out.dir_y);
    direction(reservoirs.dir_z, 1, out.dir_z);
    Store(hn::IfThenElseZero(some, Set(std::numeric_limits<float>::infinity())), out.pdf + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(StartReservoirs);
HWY_EXPORT(OfferCandidates);
HWY_EXPORT(TakeFromReservoirs);

void StartReservoirs(const float* u, std::uint32_t n, const ReservoirColumns& reservoirs) {
  HWY_DYNAMIC_DISPATCH(StartReservoirs)(u, n, reservoirs);
}
void OfferCandidates(const LightColumns& lights, const BsdfValueColumns& values,
                     CandidateCounts counts, std::uint32_t n, const ReservoirColumns& reservoirs) {
  HWY_DYNAMIC_DISPATCH(OfferCandidates)(lights, values, counts, n, reservoirs);
}
void TakeFromReservoirs(const ReservoirColumns& reservoirs, std::uint32_t n, float samples,
                        const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(TakeFromReservoirs)(reservoirs, n, samples, out);
}

}  // namespace skywave
#endif  // HWY_ONCE
