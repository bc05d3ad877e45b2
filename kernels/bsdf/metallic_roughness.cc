// Metallic-roughness is defined in metallic_roughness-inl.h, because layers may lie over it.
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/metallic_roughness.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf_kernels-inl.h"
#include "kernels/bsdf/metallic_roughness-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

SKYWAVE_BSDF_KERNELS(MetallicRoughness)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr BsdfTraits MetallicRoughnessTraits = {
    .name = "metallic-roughness",
    .lobed = true,
    .varying = Varying::kRoughness,
    .tables = {.ggx = true},
    .parameters = {{"alpha"}, {"metallic"}, {"ior"}},
    .pack = [](const Material& m, MeasuredBrdfs, MaterialRecord& r) {
      PackMetallicRoughness(m, r);
    }};
SKYWAVE_BSDF_TABLE(MetallicRoughness)

}  // namespace skywave
#endif  // HWY_ONCE
