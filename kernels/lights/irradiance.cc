#include "kernels/lights/irradiance.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/lights/irradiance.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/simd/rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

void LookUpWeights(const float* weight_of_place, std::uint32_t n, float* column) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU place = hn::IfThenElseZero(RowsBelow(i, n), ToUnsigned(Load(column + i)));
    Store(Gather(weight_of_place, place), column + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(LookUpWeights);

void FindControlWeights(const ControlWeightView& weights, std::uint32_t n,
                        const SurfaceColumns& surfaces, const ControlWeightColumns& out) {
  FindPlaces(weights.places, n, surfaces, out.weight);
  HWY_DYNAMIC_DISPATCH(LookUpWeights)(weights.weight, n, out.weight);
}

}  // namespace skywave
#endif  // HWY_ONCE
