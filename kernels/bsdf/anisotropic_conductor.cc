// Brushed metal has GGX facets of two widths (microfacet-inl.h).
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/conductor_tables.h"
#include "kernels/bsdf/material.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/anisotropic_conductor.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf_kernels-inl.h"
#include "kernels/bsdf/microfacet-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

using AnisotropicConductor = MicrofacetConductor<AnisotropicGgx>;

SKYWAVE_BSDF_KERNELS(AnisotropicConductor)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr BsdfTraits AnisotropicConductorTraits = {
    .name = "anisotropic-conductor",
    .lobed = true,
    .varying = Varying::kTangent,
    .across = MaterialField::kAlphaAcross,
    .tables = {.anisotropic = true},
    .parameters = {{"alpha"}, {"alpha_across"}, {"eta"}, {"k"}},
    .pack = [](const Material& m, MeasuredBrdfs, MaterialRecord& r) {
      PackAlpha(m, r);
      PackWidths(m, r);
      PackConductorIndex(m, r);
      const float along = MicrofacetWidth(m.alpha);
      const float across = MicrofacetWidth(m.alpha_across.value_or(m.alpha));
      PackMultiscatter(m, r, [&](float eta, float k) {
        return ConductorMultiscatter(GetAnisotropicTables(), along, across, eta, k);
      });
    }};
SKYWAVE_BSDF_TABLE(AnisotropicConductor)

}  // namespace skywave
#endif  // HWY_ONCE
