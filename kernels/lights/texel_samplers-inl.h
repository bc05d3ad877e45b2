// Texels of a cell are drawn by the cell's alias table.
#if defined(SKYWAVE_KERNELS_TEXEL_SAMPLERS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_TEXEL_SAMPLERS_INL_H_
#undef SKYWAVE_KERNELS_TEXEL_SAMPLERS_INL_H_
#else
#define SKYWAVE_KERNELS_TEXEL_SAMPLERS_INL_H_
#endif

#include "kernels/lights/environment-inl.h"
#include "kernels/lights/texel_samplers.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Draws a texel in cell `cell` of each lane at (x, y) and emits it.
HWY_INLINE void EmitFromCells(const EnvironmentView& map, const CellsView& cells, VU cell, VF x,
                              VF y, VF scale, const LightColumns& out, std::uint32_t to) {
  const VU begin = Gather(cells.begin, cell);
  const VU count = Gather(cells.begin, cell + SetU(1)) - begin;
  const VF position = x * ToFloat(count);
  const VU index = hn::Min(ToUnsigned(position), count - SetU(1));
  VU slot = begin + index;
  const auto* words = reinterpret_cast<const std::uint32_t*>(cells.slots);
  const VU at = hn::ShiftLeft<1>(slot);
  const VF keep = AsFloat(Gather(words, at));
  const VU other = Gather(words, at + SetU(1));
  const MF kept = hn::Lt(y, keep);
  slot = IfThen(hn::RebindMask(U(), kept), slot, other);
  const VF below = IfThen(kept, y, y - keep);
  const VF length = IfThen(kept, keep, 1.0f - keep);
  const VF fy = hn::Min(below / hn::Max(length, Set(1e-20f)), Set(0x1.fffffep-1f));
  const VF fx = Clamp(position - ToFloat(index), 0.0f, 0x1.fffffep-1f);
  const VU texel = Gather(cells.texel, slot);
  // texel is row * width + column; the float quotient may be one off.
  const VU width = SetU(map.width);
  VU row = ToUnsigned(ToFloat(texel) * (1.0f / float(map.width)));
  row = IfThen(hn::Gt(row * width, texel), row - SetU(1), row);
  VU column = texel - row * width;
  const MU next = hn::Gt(column, SetU(map.width - 1));
  row = IfThen(next, row + SetU(1), row);
  column = IfThen(next, column - width, column);
  EmitTexels(map, column, row, fx, fy, Gather(cells.density, texel) * scale, out, to);
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
