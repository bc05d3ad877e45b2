#include "kernels/light_paths/photons.h"

#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/light_paths/photons.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/simd/math-inl.h"
#include "kernels/simd/runs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Returns the kernel per area of the disk, without the factor that is the same for all photons.
HWY_INLINE VF KernelShape(PhotonKernel kernel, VF distance2, VF inverse_radius2) {
  const VF one = Set(1.0f), inside2 = distance2 * inverse_radius2;
  switch (kernel) {
    case PhotonKernel::kConstant:
      return one;
    case PhotonKernel::kCone:
      return one - hn::Sqrt(inside2);
    case PhotonKernel::kEpanechnikov:
      return one - inside2;
  }
  return one;
}

// Copies the photons of neighbors [0, n) as they are: flux, and the bits of dir, normal and depth
// in the columns of the direction.
HWY_INLINE void CopyPhotons(const PhotonColumns& photons, const NeighborColumns& found,
                            std::uint32_t n, const LightColumns& out) {
  for (std::uint32_t i = 0; i < n;) {
    const RowRun run(found.point, i, n);
    Store3({run.Take(photons.r), run.Take(photons.g), run.Take(photons.b)}, out.r + i, out.g + i,
           out.b + i);
    Store3({AsFloat(run.Take(photons.dir)), AsFloat(run.Take(photons.normal)),
            AsFloat(run.Take(photons.depth))},
           out.dir_x + i, out.dir_y + i, out.dir_z + i);
    i += run.count();
  }
}

void LoadPhotons(const PhotonColumns& photons, const NeighborColumns& found, std::uint32_t n,
                 const PhotonQuery& query, const LightColumns& out) {
  CopyPhotons(photons, found, n, out);
  const VF zero = hn::Zero(F());
  const float scale = query.kernel == PhotonKernel::kConstant ? 1.0f
                      : query.kernel == PhotonKernel::kCone   ? 3.0f
                                                              : 2.0f;
  const VF factor = Set(scale * kInvPi / query.radius2);
  const VF inverse_radius2 = Set(1.0f / query.radius2);
  const V3 normal = Set3(query.normal);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    // Rows beyond the last may hold anything, and BSDFs look into tables by directions.
    const MU row = RowsBelow(i, n);
    const VU photon_dir = hn::IfThenElseZero(row, AsBits(Load(out.dir_x + i)));
    const VU photon_normal = AsBits(Load(out.dir_y + i)), depth = AsBits(Load(out.dir_z + i));
    const VF distance2 = Load(found.distance2 + i);
    const V3 dir = DecodeNormal(photon_dir);
    const VF same = hn::Abs(Dot(normal, DecodeNormal(photon_normal)));
    const VF cosine = hn::Abs(Dot(normal, dir));
    const MF deep = hn::RebindMask(F(), hn::Gt(depth, SetU(query.max_depth)));
    const MF counts = hn::And(
        hn::And(hn::Gt(same, Set(kLeastNormalCosine)), hn::Lt(distance2, Set(query.radius2))),
        hn::AndNot(deep, hn::Gt(cosine, Set(1e-6f))));
    const VF shape = KernelShape(query.kernel, distance2, inverse_radius2);
    const VF weight = IfThen(counts, factor * shape / hn::Max(cosine, Set(1e-6f)), zero);
    const V3 flux = Load3(out.r + i, out.g + i, out.b + i);
    Store3(dir, out.dir_x + i, out.dir_y + i, out.dir_z + i);
    Store3(flux * weight, out.r + i, out.g + i, out.b + i);
  }
  // Copied vectors may reach further beyond the last row than those of the loop.
  Store3({zero, zero, Set(1.0f)}, out.dir_x + n, out.dir_y + n, out.dir_z + n);
}

void SumReflected(const BsdfValueColumns& values, const LightColumns& light, std::uint32_t n,
                  float* rgb) {
  const float* const value[3] = {values.r, values.g, values.b};
  const float* const flux[3] = {light.r, light.g, light.b};
  for (int channel = 0; channel < 3; ++channel) {
    alignas(kColumnAlignment) float sums[kPadRows] = {};
    for (std::uint32_t i = 0; i < n; i += kPadRows) {
      for (std::uint32_t j = 0; j < kPadRows && i + j < n; j += hn::Lanes(F())) {
        const VF product = Load(value[channel] + i + j) * Load(flux[channel] + i + j);
        const MF inside = hn::RebindMask(F(), RowsBelow(i + j, n));
        Store(Load(sums + j) + hn::IfThenElseZero(inside, product), sums + j);
      }
    }
    for (const float sum : sums) rgb[channel] += sum;
  }
}

void RepeatSurface(const SurfaceColumns& from, std::uint32_t row, std::uint32_t n,
                   const SurfaceColumns& to) {
  const auto repeat = [row, n](const auto* column, auto* copies) HWY_ATTR {
    const auto value =
        hn::Set(hn::CappedTag<std::decay_t<decltype(*column)>, kPadRows>(), column[row]);
    for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) Store(value, copies + i);
  };
  repeat(from.wo_x, to.wo_x), repeat(from.wo_y, to.wo_y), repeat(from.wo_z, to.wo_z);
  repeat(from.ng_x, to.ng_x), repeat(from.ng_y, to.ng_y), repeat(from.ng_z, to.ng_z);
  repeat(from.ns_x, to.ns_x), repeat(from.ns_y, to.ns_y), repeat(from.ns_z, to.ns_z);
  repeat(from.color_r, to.color_r), repeat(from.color_g, to.color_g);
  repeat(from.color_b, to.color_b);
  repeat(from.material, to.material);
  repeat(from.varying_0, to.varying_0), repeat(from.varying_1, to.varying_1);
  repeat(from.varying_2, to.varying_2), repeat(from.varying_3, to.varying_3);
  repeat(from.base_normal, to.base_normal);
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(LoadPhotons);
HWY_EXPORT(SumReflected);
HWY_EXPORT(RepeatSurface);

void LoadPhotons(const PhotonColumns& photons, const NeighborColumns& found, std::uint32_t n,
                 const PhotonQuery& query, const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(LoadPhotons)(photons, found, n, query, out);
}

void SumReflected(const BsdfValueColumns& values, const LightColumns& light, std::uint32_t n,
                  float* rgb) {
  HWY_DYNAMIC_DISPATCH(SumReflected)(values, light, n, rgb);
}

void RepeatSurface(const SurfaceColumns& from, std::uint32_t row, std::uint32_t n,
                   const SurfaceColumns& to) {
  HWY_DYNAMIC_DISPATCH(RepeatSurface)(from, row, n, to);
}

}  // namespace skywave
#endif  // HWY_ONCE
