#include "kernels/flux.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/flux.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

void MakeFlux(bool refracts, const SurfaceColumns& s, const MaterialView& materials,
              const LightColumns& lights, std::uint32_t n, const BsdfValueColumns& values) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const V3 ng = GeometricNormal(s, i), ns = ShadingNormal(s, i);
    const V3 wo = Outgoing(s, i), wi = DirectionOf(lights, i);
    VF factor = ShadingNormalFactor(ns, ng, wo, wi);
    if (refracts) {
      const VF ratio = IndexRatio(s, materials, MaterialFields(s, i, n), i);
      const MF through = hn::Lt(Dot(ns, wi), hn::Zero(F()));
      factor = IfThen(through, hn::Div(factor, hn::Mul(ratio, ratio)), factor);
    }
    const V3 value = Load3(values.r + i, values.g + i, values.b + i);
    // Rows of the next BSDF follow, and a product of theirs would be read.
    StoreBelow(hn::Mul(value.x, factor), values.r, i, n);
    StoreBelow(hn::Mul(value.y, factor), values.g, i, n);
    StoreBelow(hn::Mul(value.z, factor), values.b, i, n);
  }
}

void MoveToSide(const LightColumns& lights, std::uint32_t n, const SurfaceColumns& s) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    MoveOrigins(s, ShadingLanes(s, i), DirectionOf(lights, i), i, n);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(MakeFlux);
HWY_EXPORT(MoveToSide);

void MakeFlux(const BsdfKernels& bsdf, const SurfaceColumns& surfaces,
              const MaterialView& materials, const LightColumns& lights, std::uint32_t n,
              const BsdfValueColumns& values) {
  HWY_DYNAMIC_DISPATCH(MakeFlux)(bsdf.refracts, surfaces, materials, lights, n, values);
}
void MoveToSide(const LightColumns& lights, std::uint32_t n, const SurfaceColumns& surfaces) {
  HWY_DYNAMIC_DISPATCH(MoveToSide)(lights, n, surfaces);
}

}  // namespace skywave
#endif  // HWY_ONCE
