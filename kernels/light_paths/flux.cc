#include "kernels/light_paths/flux.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/light_paths/flux.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf-inl.h"
#include "kernels/surface/facing-inl.h"

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
      factor = IfThen(through, factor / (ratio * ratio), factor);
    }
    const V3 value = Load3(values.r + i, values.g + i, values.b + i);
    // Rows of the next BSDF follow, whose values must not be multiplied here.
    StoreBelow(value.x * factor, values.r, i, n);
    StoreBelow(value.y * factor, values.g, i, n);
    StoreBelow(value.z * factor, values.b, i, n);
  }
}

void FaceNormals(const SurfaceColumns& s, const LightColumns& lights, std::uint32_t n,
                 const NormalColumns& normals) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const V3 dir = DirectionOf(lights, i);
    const VF side = hn::CopySign(Set(1.0f), Dot(GeometricNormal(s, i), dir));
    const V3 ns = ShadingNormal(s, i) * side;
    const MF away = hn::Lt(Dot(ns, dir), Set(kGrazing));
    Store3(IfThen(away, FacingBentNormal(ns, dir), ns) * side, normals.x + i, normals.y + i,
           normals.z + i);
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
HWY_EXPORT(FaceNormals);
HWY_EXPORT(MoveToSide);

void MakeFlux(const BsdfKernels& bsdf, const SurfaceColumns& surfaces,
              const MaterialView& materials, const LightColumns& lights, std::uint32_t n,
              const BsdfValueColumns& values) {
  HWY_DYNAMIC_DISPATCH(MakeFlux)(bsdf.refracts, surfaces, materials, lights, n, values);
}
void FaceNormals(const SurfaceColumns& surfaces, const LightColumns& lights, std::uint32_t n,
                 const NormalColumns& normals) {
  HWY_DYNAMIC_DISPATCH(FaceNormals)(surfaces, lights, n, normals);
}
void MoveToSide(const LightColumns& lights, std::uint32_t n, const SurfaceColumns& surfaces) {
  HWY_DYNAMIC_DISPATCH(MoveToSide)(lights, n, surfaces);
}

}  // namespace skywave
#endif  // HWY_ONCE
