// Reads the corners of triangles.
#if defined(SKYWAVE_KERNELS_CORNERS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_CORNERS_INL_H_
#undef SKYWAVE_KERNELS_CORNERS_INL_H_
#else
#define SKYWAVE_KERNELS_CORNERS_INL_H_
#endif

#include "kernels/simd/records-inl.h"
#include "kernels/simd/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// The corners of a triangle of each lane, in the space of its mesh.
struct Corners {
  V3 p0, p1, p2;
};
HWY_INLINE V3 GatherPosition(const float* positions, VU row) {
  const Words4 words =
      GatherWords4(reinterpret_cast<const std::uint32_t*>(positions), row + row + row);
  return {AsFloat(words.w0), AsFloat(words.w1), AsFloat(words.w2)};
}
// `corners` and `positions` are those of TriangleTables.
HWY_INLINE Corners GatherCorners(const std::uint32_t* corners, const float* positions, VU record) {
  const Words4 rows = GatherWords4(corners, record + record + record);
  return {GatherPosition(positions, rows.w0), GatherPosition(positions, rows.w1),
          GatherPosition(positions, rows.w2)};
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
