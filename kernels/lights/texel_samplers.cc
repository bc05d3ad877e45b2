#include "kernels/lights/texel_samplers.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/lights/texel_samplers.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/lights/search_tree-inl.h"
#include "kernels/lights/texel_samplers-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

HWY_INLINE VU Halves(VU words, bool high) {
  return high ? hn::ShiftRight<16>(words) : hn::And(words, SetU(0xFFFFu));
}

// Splits at `share` of kWarpOne: adds 1 to `cell` where x falls beyond it, and stretches x to [0,
// 1).
HWY_INLINE void SplitAt(VU share, VF& x, VU& cell) {
  const VF scaled = x * float(kWarpOne);
  const VF edge = ToFloat(share);
  const MF behind = hn::Ge(scaled, edge);
  const VF position = IfThen(behind, scaled - edge, scaled);
  const VF length = IfThen(behind, float(kWarpOne) - edge, edge);
  x = hn::Min(position / length, Set(0x1.fffffep-1f));
  cell = cell + hn::IfThenElseZero(hn::RebindMask(U(), behind), SetU(1));
}

void SampleTexelsByWarp(const EnvironmentView& map, const WarpView& warp, const float* density,
                        const UniformColumns& uniforms, std::uint32_t n, float samples,
                        const LightColumns& out) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const MF inside = hn::RebindMask(F(), RowsBelow(i, n));
    VF x = hn::IfThenElseZero(inside, Load(uniforms.u + i));
    VF y = hn::IfThenElseZero(inside, Load(uniforms.v + i));
    VU column = hn::Zero(U()), row = hn::Zero(U());
    for (std::uint32_t l = 0; l < warp.levels; ++l) {
      const WarpLevel& level = warp.level[l];
      const auto* words = reinterpret_cast<const std::uint32_t*>(level.records);
      const VU at = hn::ShiftLeft<1>(row * SetU(level.width) + column);
      const VU first = Gather(words, at);
      VU left = Halves(first, true);
      if (level.split_y) {
        const VU below = Halves(Gather(words, at + SetU(1)), false);
        const VU row_before = row + row;
        row = row_before;
        SplitAt(Halves(first, false), y, row);
        left = IfThen(hn::Eq(row, row_before), left, below);
      }
      if (level.split_x) {
        column = column + column;
        SplitAt(left, x, column);
      }
    }
    const VU texel = row * SetU(map.width) + column;
    EmitTexels(map, column, row, x, y, Gather(density, texel) * samples, out, i);
  }
}

void SampleCells(const EnvironmentView& map, const CellsView& cells, const SearchTreeView* tree,
                 const UniformColumns& uniforms, std::uint32_t n, float samples,
                 const LightColumns& out) {
  SearchColumns search;
  for (std::uint32_t begin = 0; begin < n; begin += kChunk) {
    const std::uint32_t rows = std::min(kChunk, n - begin);
    if (tree != nullptr) {
      Search(*tree, uniforms.u + begin, rows, search);
    } else {
      std::copy_n(uniforms.u + begin, rows, search.x);
      std::fill_n(search.item, rows, 0u);
    }
    for (std::uint32_t i = 0; i < rows; i += hn::Lanes(F())) {
      const MU inside = RowsBelow(i, rows);
      const MF used = hn::RebindMask(F(), inside);
      EmitFromCells(map, cells, hn::IfThenElseZero(inside, Load(search.item + i)),
                    hn::IfThenElseZero(used, Load(search.x + i)),
                    hn::IfThenElseZero(used, Load(uniforms.v + begin + i)), Set(samples), out,
                    begin + i);
    }
  }
}

void SampleOneCell(const EnvironmentView& map, const CellsView& cells, std::uint32_t cell,
                   float scale, const UniformColumns& uniforms, std::uint32_t n,
                   const LightColumns& out) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const MF used = hn::RebindMask(F(), RowsBelow(i, n));
    EmitFromCells(map, cells, SetU(cell), hn::IfThenElseZero(used, Load(uniforms.u + i)),
                  hn::IfThenElseZero(used, Load(uniforms.v + i)), Set(scale), out, i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(SampleTexelsByWarp);
HWY_EXPORT(SampleCells);
HWY_EXPORT(SampleOneCell);

void SampleTexelsByWarp(const EnvironmentView& map, const WarpView& warp, const float* density,
                        const UniformColumns& uniforms, std::uint32_t n, float samples,
                        const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(SampleTexelsByWarp)(map, warp, density, uniforms, n, samples, out);
}
void SampleCells(const EnvironmentView& map, const CellsView& cells, const SearchTreeView* tree,
                 const UniformColumns& uniforms, std::uint32_t n, float samples,
                 const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(SampleCells)(map, cells, tree, uniforms, n, samples, out);
}
void SampleOneCell(const EnvironmentView& map, const CellsView& cells, std::uint32_t cell,
                   float scale, const UniformColumns& uniforms, std::uint32_t n,
                   const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(SampleOneCell)(map, cells, cell, scale, uniforms, n, out);
}

}  // namespace skywave
#endif  // HWY_ONCE
