// The rough conductor is defined in conductor-inl.h, because a coat may lie over it.
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/conductor.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf_kernels-inl.h"
#include "kernels/bsdf/conductor-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

SKYWAVE_BSDF_KERNELS(Conductor)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr BsdfTraits ConductorTraits = {
    .name = "conductor",
    .lobed = true,
    .varying = Varying::kAlpha,
    .tables = {.ggx = true},
    .parameters = {{"alpha"}, {"eta"}, {"k"}},
    .pack = [](const Material& m, MeasuredBrdfs, MaterialRecord& r) { PackConductor(m, r); }};
SKYWAVE_BSDF_TABLE(Conductor)

}  // namespace skywave
#endif  // HWY_ONCE
