#include "kernels/lights/places.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/lights/places.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/simd/rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Returns the root for normals: that of the axis which they are closest to, x before y before z.
HWY_INLINE VU RootOf(const V3& normal) {
  const VF zero = hn::Zero(F());
  const VF x = hn::Abs(normal.x), y = hn::Abs(normal.y), z = hn::Abs(normal.z);
  const MF along_x = hn::And(hn::Ge(x, y), hn::Ge(x, z)), along_y = hn::Ge(y, z);
  const VF part = IfThen(along_x, normal.x, IfThen(along_y, normal.y, normal.z));
  const VU axis = IfThen(hn::RebindMask(U(), along_x), SetU(0),
                         IfThen(hn::RebindMask(U(), along_y), SetU(2), SetU(4)));
  const VU negative = hn::IfThenElseZero(hn::RebindMask(U(), hn::Lt(part, zero)), SetU(1));
  return axis + negative;
}

void FindPlaces(const PlaceTreeView& tree, std::uint32_t n, const SurfaceColumns& s, float* place) {
  const VU leaf = SetU(kPlaceLeaf), one = SetU(1);
  const VF zero = hn::Zero(F()), last = Set(float((1u << kPlaceLevels) - 1));
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const MF used = hn::RebindMask(F(), RowsBelow(i, n));
    const auto step = [&](const float* org, float low) HWY_ATTR {
      const VF steps = (Load(org + i) - low) * tree.steps;
      const VF inside = hn::Min(hn::Max(steps, zero), last);
      return ToUnsigned(hn::IfThenElseZero(used, inside));
    };
    const VU x = step(s.org_x, tree.low[0]), y = step(s.org_y, tree.low[1]),
             z = step(s.org_z, tree.low[2]);
    const V3 normal = IfThen(used, Load3(s.ns_x + i, s.ns_y + i, s.ns_z + i), V3{zero, zero, zero});
    VU node = Gather(tree.nodes, RootOf(normal));
    VU bit = SetU(1u << (kPlaceLevels - 1));
    for (std::uint32_t level = 0; level < kPlaceLevels; ++level) {
      const MU inner = hn::Lt(node, leaf);
      if (hn::AllFalse(U(), inner)) break;
      const auto child = [&](VU steps, std::uint32_t number) HWY_ATTR {
        return hn::IfThenElseZero(hn::Ne(hn::And(steps, bit), hn::Zero(U())), SetU(number));
      };
      const VU index = node + (child(x, 1) + (child(y, 2) + child(z, 4)));
      node = IfThen(inner, Gather(tree.nodes, hn::IfThenElseZero(inner, index)), node);
      bit = hn::ShiftRight<1>(bit);
    }
    Store(ToFloat(hn::And(node, leaf - one)), place + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(FindPlaces);

void FindPlaces(const PlaceTreeView& tree, std::uint32_t n, const SurfaceColumns& surfaces,
                float* place) {
  HWY_DYNAMIC_DISPATCH(FindPlaces)(tree, n, surfaces, place);
}

}  // namespace skywave
#endif  // HWY_ONCE
