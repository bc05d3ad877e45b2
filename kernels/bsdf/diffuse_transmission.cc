// Diffuse transmission is a thin sheet that reflects and transmits as Lambert does: f is color / pi
// on wo's side and the material's second colour / pi on the other. A side is drawn with the
// probability of its largest channel, a direction by the cosine.
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/diffuse_transmission.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf_kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct DiffuseTransmission {
  static constexpr bool kTransmits = true, kOnlyDiffuse = true;
  static constexpr MaterialField kTransmitted = kEta;

  HWY_INLINE DiffuseTransmission(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                                 std::uint32_t n)
      : reflected(ColorOf(s, i)), transmitted(Field3(m, MaterialFields(s, i, n), kTransmitted)) {
    if (m.varied) transmitted = transmitted * VariedColor(s, i);
    const VF back = MaxComponent(reflected), through = MaxComponent(transmitted);
    reflects = back / hn::Max(back + through, Set(1e-30f));
  }

  HWY_INLINE BsdfValue Evaluate(const V3&, const V3& wi) const {
    const MF above = hn::Gt(wi.z, hn::Zero(F()));
    const VF cosine = hn::Abs(wi.z) * kInvPi;
    const VF share = IfThen(above, reflects, 1.0f - reflects);
    return {IfThen(above, reflected, transmitted) * cosine, share * cosine};
  }
  HWY_INLINE BsdfSample Draw(const V3&, VF u, VF v, VF lobe) const {
    const MF above = hn::Lt(lobe, reflects);
    const V3 up = CosineHemisphere(u, v);
    const VF share = IfThen(above, reflects, 1.0f - reflects);
    return {{up.x, up.y, IfThen(above, up.z, -up.z)},
            IfThen(above, reflected, transmitted) * (1.0f / share),
            share * (up.z * kInvPi)};
  }
  HWY_INLINE V3 Diffuse(const V3&) const { return reflected * kInvPi; }
  HWY_INLINE V3 DiffuseThrough(const V3&) const { return transmitted * kInvPi; }

  V3 reflected, transmitted;
  VF reflects;  // probability of wo's side
};

SKYWAVE_BSDF_KERNELS(DiffuseTransmission)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr BsdfTraits DiffuseTransmissionTraits = {
    .name = "diffuse-transmission",
    .lobed = true,
    .varying = Varying::kSecondColor,
    .transmits = true,
    .parameters = {{"second_color", "transmittance"}},
    .pack = [](const Material& m, MeasuredBrdfs, MaterialRecord& r) {
      PackSecondColor(m, HWY_NAMESPACE::DiffuseTransmission::kTransmitted, r);
    }};
SKYWAVE_BSDF_TABLE(DiffuseTransmission)

}  // namespace skywave
#endif  // HWY_ONCE
