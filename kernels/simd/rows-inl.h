// Functions that load the named columns of one vector of rows.
#if defined(SKYWAVE_KERNELS_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_ROWS_INL_H_
#undef SKYWAVE_KERNELS_ROWS_INL_H_
#else
#define SKYWAVE_KERNELS_ROWS_INL_H_
#endif

#include "kernels/simd/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

HWY_INLINE V3 GeometricNormal(const SurfaceColumns& s, std::uint32_t i) {
  return Load3(s.ng_x + i, s.ng_y + i, s.ng_z + i);
}
HWY_INLINE V3 ShadingNormal(const SurfaceColumns& s, std::uint32_t i) {
  return Load3(s.ns_x + i, s.ns_y + i, s.ns_z + i);
}
HWY_INLINE V3 Outgoing(const SurfaceColumns& s, std::uint32_t i) {
  return Load3(s.wo_x + i, s.wo_y + i, s.wo_z + i);
}
HWY_INLINE V3 DirectionOf(const LightColumns& lights, std::uint32_t i) {
  return Load3(lights.dir_x + i, lights.dir_y + i, lights.dir_z + i);
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
