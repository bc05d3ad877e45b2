#include "kernels/surface/instances.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/surface/instances.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/simd/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

void MoveInstances(const HitColumns& hits, const std::uint32_t* queue, std::uint32_t kind,
                   std::uint32_t n, const SurfaceColumns& surfaces) {
  std::uint32_t to = 0;
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(U())) {
    const RowCompressor rows(hn::Eq(Load(queue + i), SetU(kind)));
    rows.Move(hits.geom + i, surfaces.instance + to);
    to += rows.count();
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(MoveInstances);

void MoveInstances(const HitColumns& hits, const std::uint32_t* queue, std::uint32_t kind,
                   std::uint32_t n, const SurfaceColumns& surfaces) {
  HWY_DYNAMIC_DISPATCH(MoveInstances)(hits, queue, kind, n, surfaces);
}

}  // namespace skywave
#endif  // HWY_ONCE
