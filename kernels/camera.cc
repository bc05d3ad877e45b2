#include "kernels/camera.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/camera.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

HWY_INLINE VF FilterOffset(const float* table, VF uniform) {
  const VF position = hn::Mul(uniform, Set(float(kFilterCells)));
  const VU cell = ToUnsigned(position);
  const VF low = Gather(table, cell);
  const VF high = Gather(table, hn::Add(cell, SetU(1)));
  return hn::Add(low, hn::Mul(hn::Sub(position, ToFloat(cell)), hn::Sub(high, low)));
}

void GenerateCameraRays(const CameraView& camera, const PathColumns& paths,
                        const UniformColumns& film, std::uint32_t n, const RayColumns& rays) {
  const V3 origin = Set3(camera.origin), corner = Set3(camera.corner);
  const V3 right = Set3(camera.right), down = Set3(camera.down);
  const VF one = Set(1.0f), zero = hn::Zero(F());
  const VF infinity = Set(std::numeric_limits<float>::infinity());
  // x = pixel - y * width, with y from a float division that may be one too large or too small.
  const VF inverse_width = Set(1.0f / float(camera.width));
  const VU width = SetU(camera.width);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU pixel = Load(paths.pixel + i);
    VU row = ToUnsigned(hn::Mul(ToFloat(pixel), inverse_width));
    row = IfThen(hn::Gt(hn::Mul(row, width), pixel), hn::Sub(row, SetU(1)), row);
    VU column = hn::Sub(pixel, hn::Mul(row, width));
    const MU next = hn::Gt(column, SetU(camera.width - 1));
    row = IfThen(next, hn::Add(row, SetU(1)), row);
    column = IfThen(next, hn::Sub(column, width), column);
    const VF x = hn::Add(hn::Add(ToFloat(column), Set(0.5f)),
                         FilterOffset(camera.filter_offset, Load(film.u + i)));
    const VF y = hn::Add(hn::Add(ToFloat(row), Set(0.5f)),
                         FilterOffset(camera.filter_offset, Load(film.v + i)));
    const V3 dir = Normalize(Add(corner, Add(Scale(right, x), Scale(down, y))));
    Store3(origin, rays.org_x + i, rays.org_y + i, rays.org_z + i);
    Store3(dir, rays.dir_x + i, rays.dir_y + i, rays.dir_z + i);
    Store(infinity, rays.t_far + i);
    Store3({one, one, one}, rays.throughput_r + i, rays.throughput_g + i, rays.throughput_b + i);
    Store(zero, rays.pdf + i);
    const VU path = hn::Iota(U(), i);
    Store(path, rays.path + i);
    Store(path, rays.from + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(GenerateCameraRays);

void GenerateCameraRays(const CameraView& camera, const PathColumns& paths,
                        const UniformColumns& film, std::uint32_t n, const RayColumns& rays) {
  HWY_DYNAMIC_DISPATCH(GenerateCameraRays)(camera, paths, film, n, rays);
}

}  // namespace skywave
#endif  // HWY_ONCE
