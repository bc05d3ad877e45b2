// This metal has Beckmann's Gaussian slopes, of two widths (microfacet-inl.h): the distribution of
// Cook and Torrance 1982.
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/beckmann_conductor.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf_kernels-inl.h"
#include "kernels/bsdf/microfacet-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

using BeckmannConductor = MicrofacetConductor<Beckmann>;

SKYWAVE_BSDF_KERNELS(BeckmannConductor)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr BsdfTraits BeckmannConductorTraits = {
    .name = "beckmann-conductor",
    .varying = Varying::kTangent,
    .parameters = {{"alpha"}, {"alpha_across"}, {"eta"}, {"k"}},
    .pack = [](const Material& m, MeasuredBrdfs, MaterialRecord& r) {
      PackWidths(m, r);
      PackConductorIndex(m, r);
    }};
SKYWAVE_BSDF_TABLE(BeckmannConductor)

}  // namespace skywave
#endif  // HWY_ONCE
