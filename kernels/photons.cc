#include "kernels/photons.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/photons.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Per area of the disk, without the factor that is the same for all photons.
HWY_INLINE VF KernelShape(PhotonKernel kernel, VF distance2, VF inverse_radius2) {
  const VF one = Set(1.0f), inside2 = hn::Mul(distance2, inverse_radius2);
  switch (kernel) {
    case PhotonKernel::kConstant:
      return one;
    case PhotonKernel::kCone:
      return hn::Sub(one, hn::Sqrt(inside2));
    case PhotonKernel::kEpanechnikov:
      return hn::Sub(one, inside2);
  }
  return one;
}

void LoadPhotons(const PhotonColumns& photons, const NeighborColumns& found, std::uint32_t n,
                 const PhotonQuery& query, const LightColumns& out) {
  const VF zero = hn::Zero(F());
  const float scale = query.kernel == PhotonKernel::kConstant ? 1.0f
                      : query.kernel == PhotonKernel::kCone   ? 3.0f
                                                              : 2.0f;
  const VF factor = Set(scale * kInvPi / query.radius2);
  const VF inverse_radius2 = Set(1.0f / query.radius2);
  const V3 normal = Set3(query.normal);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU point = hn::IfThenElseZero(RowsBelow(i, n), Load(found.point + i));
    const VF distance2 = Load(found.distance2 + i);
    const V3 dir = DecodeNormal(Gather(photons.dir, point));
    const VF same = hn::Abs(Dot(normal, DecodeNormal(Gather(photons.normal, point))));
    const VF cosine = hn::Abs(Dot(normal, dir));
    const MF deep =
        hn::RebindMask(F(), hn::Gt(Gather(photons.depth, point), SetU(query.max_depth)));
    const MF counts = hn::And(
        hn::And(hn::Gt(same, Set(kLeastNormalCosine)), hn::Lt(distance2, Set(query.radius2))),
        hn::AndNot(deep, hn::Gt(cosine, Set(1e-6f))));
    const VF shape = KernelShape(query.kernel, distance2, inverse_radius2);
    const VF weight =
        IfThen(counts, hn::Div(hn::Mul(factor, shape), hn::Max(cosine, Set(1e-6f))), zero);
    const V3 flux = {Gather(photons.r, point), Gather(photons.g, point), Gather(photons.b, point)};
    Store3(dir, out.dir_x + i, out.dir_y + i, out.dir_z + i);
    Store3(Scale(flux, weight), out.r + i, out.g + i, out.b + i);
  }
}

void SumReflected(const BsdfValueColumns& values, const LightColumns& light, std::uint32_t n,
                  float* rgb) {
  const float* const value[3] = {values.r, values.g, values.b};
  const float* const flux[3] = {light.r, light.g, light.b};
  for (int channel = 0; channel < 3; ++channel) {
    alignas(kColumnAlignment) float sums[kPadRows] = {};
    for (std::uint32_t i = 0; i < n; i += kPadRows) {
      for (std::uint32_t j = 0; j < kPadRows && i + j < n; j += hn::Lanes(F())) {
        const VF product = hn::Mul(Load(value[channel] + i + j), Load(flux[channel] + i + j));
        const MF inside = hn::RebindMask(F(), RowsBelow(i + j, n));
        Store(hn::Add(Load(sums + j), hn::IfThenElseZero(inside, product)), sums + j);
      }
    }
    for (const float sum : sums) rgb[channel] += sum;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(LoadPhotons);
HWY_EXPORT(SumReflected);

void LoadPhotons(const PhotonColumns& photons, const NeighborColumns& found, std::uint32_t n,
                 const PhotonQuery& query, const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(LoadPhotons)(photons, found, n, query, out);
}

void SumReflected(const BsdfValueColumns& values, const LightColumns& light, std::uint32_t n,
                  float* rgb) {
  HWY_DYNAMIC_DISPATCH(SumReflected)(values, light, n, rgb);
}

}  // namespace skywave
#endif  // HWY_ONCE
