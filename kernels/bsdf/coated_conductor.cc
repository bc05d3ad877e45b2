// A conductor under a clear coat (coat-inl.h) of its own index and width. The BSDF leaves out how
// refraction into the coat changes the metal, and light that is reflected to and fro between them.
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/coated_conductor.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/coat-inl.h"
#include "kernels/bsdf/conductor-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct ConductorCoat {
  static constexpr MaterialField kAlpha = kRoughnessTexture;

  HWY_INLINE ConductorCoat(const MaterialView& m, VU fields)
      : strength(Set(1.0f)), alpha(Clamp(Field(m, fields, kAlpha), 1e-3f, 1.0f)) {
    const VF ior = Field(m, fields, kIor), one = Set(1.0f);
    const VF amplitude = hn::Div(hn::Sub(ior, one), hn::Add(ior, one));
    f0 = hn::Mul(amplitude, amplitude);
  }
  VF strength, alpha, f0;
};

using CoatedConductor = Coated<Conductor, ConductorCoat>;

SKYWAVE_BSDF_KERNELS(CoatedConductor)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr BsdfTraits CoatedConductorTraits = {
    .name = "coated-conductor",
    .lobed = true,
    .tables = {.ggx = true},
    .parameters = {{"alpha"}, {"eta"}, {"k"}, {"coat_alpha"}, {"ior"}},
    .pack = [](const Material& m, MeasuredBrdfs, MaterialRecord& r) {
      PackConductor(m, r);
      PutField(r, HWY_NAMESPACE::ConductorCoat::kAlpha, MicrofacetWidth(m.coat_alpha));
      PutField(r, MaterialField::kIor, m.ior);
    }};
SKYWAVE_BSDF_TABLE(CoatedConductor)

}  // namespace skywave
#endif  // HWY_ONCE
