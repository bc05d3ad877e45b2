#include "kernels/lights/visibility.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/lights/visibility.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/lights/search_tree-inl.h"
#include "kernels/lights/texel_samplers-inl.h"

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
  return hn::Add(axis, negative);
}

void FindPlaces(const PlaceTreeView& tree, std::uint32_t n, const SurfaceColumns& s) {
  const VU leaf = SetU(kPlaceLeaf), one = SetU(1);
  const VF zero = hn::Zero(F()), last = Set(float((1u << kPlaceLevels) - 1));
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const MF used = hn::RebindMask(F(), RowsBelow(i, n));
    const auto step = [&](const float* org, float low) HWY_ATTR {
      const VF steps = hn::Mul(hn::Sub(Load(org + i), Set(low)), Set(tree.steps));
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
      const VU index = hn::Add(node, hn::Add(child(x, 1), hn::Add(child(y, 2), child(z, 4))));
      node = IfThen(inner, Gather(tree.nodes, hn::IfThenElseZero(inner, index)), node);
      bit = hn::ShiftRight<1>(bit);
    }
    Store(ToFloat(hn::And(node, hn::Sub(leaf, one))), s.light_norm + i);
  }
}

void SampleFromPlaces(const EnvironmentView& map, const CellsView& cells,
                      const PlacePicksView& picks, const float* light_norm,
                      const UniformColumns& uniforms, std::uint32_t n, float samples,
                      const LightColumns& out) {
  SearchColumns search;
  alignas(64) std::uint32_t place[kChunk];
  for (std::uint32_t begin = 0; begin < n; begin += kChunk) {
    const std::uint32_t rows = std::min(kChunk, n - begin);
    for (std::uint32_t i = 0; i < rows; i += hn::Lanes(F())) {
      const MF used = hn::RebindMask(F(), RowsBelow(i, rows));
      Store(ToUnsigned(hn::IfThenElseZero(used, Load(light_norm + begin + i))), place + i);
    }
    Search(picks.trees, place, uniforms.u + begin, rows, search,
           [](std::uint32_t, std::uint32_t) {});
    for (std::uint32_t i = 0; i < rows; i += hn::Lanes(F())) {
      const MU inside = RowsBelow(i, rows);
      const MF used = hn::RebindMask(F(), inside);
      const VU cell = hn::IfThenElseZero(inside, Load(search.item + i));
      const VU at = hn::Add(hn::Mul(Load(place + i), SetU(picks.cells)), cell);
      const VF probability = Gather(picks.probability, at);
      EmitFromCells(map, cells, cell, hn::IfThenElseZero(used, Load(search.x + i)),
                    hn::IfThenElseZero(used, Load(uniforms.v + begin + i)),
                    hn::Mul(probability, Set(samples)), out, begin + i);
    }
  }
}

void ScaleByPlace(const PlacePicksView& picks, const float* light_norm, const std::uint32_t* cell,
                  std::uint32_t n, const EscapeColumns& rows) {
  const VF zero = hn::Zero(F());
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const MU used = hn::And(RowsBelow(i, n),
                            hn::RebindMask(U(), hn::Gt(Load(rows.pdf + i), zero)));
    const VU from = hn::IfThenElseZero(used, Load(rows.from + i));
    const VF norm = hn::IfThenElseZero(hn::RebindMask(F(), used), Gather(light_norm, from));
    const VU at = hn::Add(hn::Mul(ToUnsigned(norm), SetU(picks.cells)),
                          hn::IfThenElseZero(used, Load(cell + i)));
    const VF pdf = hn::Mul(Load(rows.light_pdf + i), Gather(picks.probability, at));
    StoreBelow(pdf, rows.light_pdf + i, i, n);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(FindPlaces);
HWY_EXPORT(SampleFromPlaces);
HWY_EXPORT(ScaleByPlace);

void FindPlaces(const PlaceTreeView& tree, std::uint32_t n, const SurfaceColumns& surfaces) {
  HWY_DYNAMIC_DISPATCH(FindPlaces)(tree, n, surfaces);
}
void SampleFromPlaces(const EnvironmentView& map, const CellsView& cells,
                      const PlacePicksView& picks, const float* light_norm,
                      const UniformColumns& uniforms, std::uint32_t n, float samples,
                      const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(SampleFromPlaces)
  (map, cells, picks, light_norm, uniforms, n, samples, out);
}
void ScaleByPlace(const PlacePicksView& picks, const float* light_norm, const std::uint32_t* cell,
                  std::uint32_t n, const EscapeColumns& rows) {
  HWY_DYNAMIC_DISPATCH(ScaleByPlace)(picks, light_norm, cell, n, rows);
}

}  // namespace skywave
#endif  // HWY_ONCE
