// What BSDFs of a diffuse body and of a gloss share whose colours are given apart: the colours, the
// GGX facets of the gloss, and how a direction is drawn from either.
#if defined(SKYWAVE_KERNELS_BODY_AND_GLOSS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_BODY_AND_GLOSS_INL_H_
#undef SKYWAVE_KERNELS_BODY_AND_GLOSS_INL_H_
#else
#define SKYWAVE_KERNELS_BODY_AND_GLOSS_INL_H_
#endif

#include "kernels/bsdf/ggx-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct BodyAndGloss {
  HWY_INLINE BodyAndGloss(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                          std::uint32_t n)
      : fields(MaterialFields(s, i, n)),
        ggx(Field(m, fields, kAlpha)),
        body(ColorOf(s, i)),
        gloss(Field3(m, fields, kGloss)) {
    if (m.varied) gloss = gloss * VariedColor(s, i);
  }

  // Returns the probability of the gloss, of two albedos. Each lobe gets at least a tenth, because
  // the albedos are rough and of luminance only.
  static HWY_INLINE VF ShareOf(VF gloss, VF body) {
    return Clamp(gloss / hn::Max(gloss + body, Set(1e-6f)), 0.1f, 0.9f);
  }
  HWY_INLINE V3 Direction(const V3& wo, VF u, VF v, MF glossy) const {
    return IfThen(glossy, ggx.Reflect(wo, u, v), CosineHemisphere(u, v));
  }

  VU fields;
  Ggx ggx;
  V3 body, gloss;
};

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
