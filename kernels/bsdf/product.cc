#include "kernels/bsdf/product.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/product.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/lights/texel_samplers-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

void PickCells(const float* sums, std::uint32_t count, const float* u, std::uint32_t n,
               CellPicks& picks, float* norm) {
  const VF zero = hn::Zero(F()), below_one = Set(0x1.fffffep-1f);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const float* row = sums + i;
    const VF total = Load(row + std::size_t(count - 1) * kProductStride);
    // The target lies below the total, so that some sum is greater and a cell with weight is found.
    const VF target = hn::Min(Load(u + i), below_one) * total;
    // The cell begins at the last of the sums that do not exceed the target.
    VU cell = hn::Zero(U());
    VF begin = zero, end = total;
    for (std::uint32_t k = count - 1; k > 0; --k) {
      const VF sum = Load(row + std::size_t(k - 1) * kProductStride);
      const MF behind = hn::Gt(sum, target);
      end = IfThen(behind, sum, end);
      begin = hn::Max(begin, hn::IfThenZeroElse(behind, sum));
      cell = cell + hn::IfThenZeroElse(hn::RebindMask(U(), behind), SetU(1));
    }
    const VF weight = end - begin;
    const MF some = hn::Gt(weight, zero);
    Store(cell, picks.cell + i);
    Store(hn::IfThenElseZero(some, hn::Min((target - begin) / weight, below_one)), picks.x + i);
    Store(hn::IfThenElseZero(some, weight / total), picks.probability + i);
    Store(total, norm + i);
  }
}

void SamplePickedCells(const EnvironmentView& map, const CellsView& cells, const CellPicks& picks,
                       const float* v, std::uint32_t n, float samples, const LightColumns& out) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const MU inside = RowsBelow(i, n);
    const MF used = hn::RebindMask(F(), inside);
    EmitFromCells(map, cells, hn::IfThenElseZero(inside, Load(picks.cell + i)),
                  hn::IfThenElseZero(used, Load(picks.x + i)),
                  hn::IfThenElseZero(used, Load(v + i)), Load(picks.probability + i) * samples, out,
                  i);
  }
}

void FindCells(const EnvironmentView& map, const std::uint32_t* cell_of_texel, std::uint32_t n,
               const EscapeColumns& rows, std::uint32_t* cell) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const MF used = hn::RebindMask(F(), RowsBelow(i, n));
    const V3 dir = IfThen(used, Load3(rows.dir_x + i, rows.dir_y + i, rows.dir_z + i),
                          V3{hn::Zero(F()), hn::Zero(F()), Set(1.0f)});
    VF u, v;
    MapPosition(map, dir, u, v);
    const VU texel = CellOf(v, map.height) * SetU(map.width) + CellOf(u, map.width);
    Store(Gather(cell_of_texel, texel), cell + i);
  }
}

void GatherWeighedSurfaces(const SurfaceColumns& s, const MaterialView& m, const BsdfTraits& bsdf,
                           const std::uint32_t* from, std::uint32_t n, const SurfaceColumns& out) {
  const bool layers = bsdf.varying == Varying::kLayers || (m.glass_layers && bsdf.glass_layers);
  const float* const columns[] = {s.wo_x,      s.wo_y,     s.wo_z,      s.ng_x,      s.ng_y,
                                  s.ng_z,      s.ns_x,     s.ns_y,      s.ns_z,      s.color_r,
                                  s.color_g,   s.color_b,  s.varying_0, s.varying_1, s.light_norm,
                                  s.varying_2, s.varying_3};
  float* const copies[] = {
      out.wo_x,      out.wo_y,      out.wo_z,       out.ng_x,      out.ng_y,     out.ng_z,
      out.ns_x,      out.ns_y,      out.ns_z,       out.color_r,   out.color_g,  out.color_b,
      out.varying_0, out.varying_1, out.light_norm, out.varying_2, out.varying_3};
  const std::size_t count = std::size(columns) - (layers ? 0 : 2);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU row = hn::IfThenElseZero(RowsBelow(i, n), Load(from + i));
    for (std::size_t c = 0; c < count; ++c) {
      Store(Gather(columns[c], row), copies[c] + i);
    }
    Store(Gather(s.material, row), out.material + i);
    if (m.base_normals) Store(Gather(s.base_normal, row), out.base_normal + i);
  }
}

void ScaleByPick(const float* weight, const float* norm, std::uint32_t n, float* light_pdf) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VF total = Load(norm + i);
    const VF probability = Load(weight + i) / total;
    const VF pdf = Load(light_pdf + i) * probability;
    StoreBelow(hn::IfThenElseZero(hn::Gt(total, hn::Zero(F())), pdf), light_pdf, i, n);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(PickCells);
HWY_EXPORT(SamplePickedCells);
HWY_EXPORT(FindCells);
HWY_EXPORT(GatherWeighedSurfaces);
HWY_EXPORT(ScaleByPick);

void PickCells(const float* sums, std::uint32_t count, const float* u, std::uint32_t n,
               CellPicks& picks, float* norm) {
  HWY_DYNAMIC_DISPATCH(PickCells)(sums, count, u, n, picks, norm);
}
void SamplePickedCells(const EnvironmentView& map, const CellsView& cells, const CellPicks& picks,
                       const float* v, std::uint32_t n, float samples, const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(SamplePickedCells)(map, cells, picks, v, n, samples, out);
}
void FindCells(const EnvironmentView& map, const std::uint32_t* cell_of_texel, std::uint32_t n,
               const EscapeColumns& rows, std::uint32_t* cell) {
  HWY_DYNAMIC_DISPATCH(FindCells)(map, cell_of_texel, n, rows, cell);
}
void GatherWeighedSurfaces(const SurfaceColumns& surfaces, const MaterialView& materials,
                           const BsdfTraits& bsdf, const std::uint32_t* from, std::uint32_t n,
                           const SurfaceColumns& out) {
  HWY_DYNAMIC_DISPATCH(GatherWeighedSurfaces)(surfaces, materials, bsdf, from, n, out);
}
void ScaleByPick(const float* weight, const float* norm, std::uint32_t n, float* light_pdf) {
  HWY_DYNAMIC_DISPATCH(ScaleByPick)(weight, norm, n, light_pdf);
}

}  // namespace skywave
#endif  // HWY_ONCE
