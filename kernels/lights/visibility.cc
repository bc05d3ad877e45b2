#include "kernels/lights/visibility.h"

#include <algorithm>
#include <iterator>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/lights/visibility.cc"
#include "hwy/cache_control.h"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/lights/environment-inl.h"
#include "kernels/lights/search_tree-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

void SampleFromPlaces(const EnvironmentView& map, const SlotTexelsView& texels,
                      const PlacePicksView& picks, const float* light_norm,
                      const UniformColumns& uniforms, std::uint32_t n, float samples, bool mixed,
                      const LightColumns& out) {
  static_assert(kPlaceRows == kChunk);
  SearchColumns search;
  alignas(64) std::uint32_t place[kChunk], slot[kChunk], texel[kChunk], packed[kChunk];
  alignas(64) float position[kChunk], keep[kChunk], density[kChunk];
  const VU last = SetU(picks.learnt - 1);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const MF used = hn::RebindMask(F(), RowsBelow(i, n));
    const VU found = ToUnsigned(hn::IfThenElseZero(used, Load(light_norm + i)));
    Store(hn::Min(found, last), place + i);
  }
  // Places of neighbours differ, so the roots of all rows are fetched at the same time, and so are
  // the levels after them.
  for (std::uint32_t i = 0; i < n; ++i) hwy::Prefetch(picks.trees.level[0] + place[i]);
  Search(picks.trees, place, uniforms.u, n, search, [](std::uint32_t, std::uint32_t) {});
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t cell = search.item[i], begin = texels.begin[cell];
    const std::uint32_t count = texels.begin[cell + 1] - begin;
    const float along = search.x[i] * float(count);
    const std::uint32_t index = std::min(std::uint32_t(along), count - 1);
    slot[i] = begin + index;
    position[i] = along - float(index);
    density[i] = picks.probability[place[i] * picks.cells + cell];
    hwy::Prefetch(texels.slots + slot[i]);
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const AliasSlot& here = texels.slots[slot[i]];
    const std::uint32_t slots[2] = {here.other, slot[i]};
    keep[i] = here.keep;
    slot[i] = slots[uniforms.v[i] < here.keep];
    hwy::Prefetch(texels.texels + slot[i]);
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const SlotTexel& here = texels.texels[slot[i]];
    texel[i] = here.texel, packed[i] = here.radiance, density[i] *= here.density;
  }
  const VU width = SetU(map.width);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const MU inside = RowsBelow(i, n);
    const MF used = hn::RebindMask(F(), inside);
    const VU at = hn::IfThenElseZero(inside, Load(texel + i));
    // The float quotient may be one off.
    VU row = ToUnsigned(ToFloat(at) * (1.0f / float(map.width)));
    row = IfThen(hn::Gt(row * width, at), row - SetU(1), row);
    VU column = at - row * width;
    const MU next = hn::Gt(column, SetU(map.width - 1));
    row = IfThen(next, row + SetU(1), row);
    column = IfThen(next, column - width, column);
    const VF below_one = Set(0x1.fffffep-1f);
    const VF fx = Clamp(hn::IfThenElseZero(used, Load(position + i)), 0.0f, 0x1.fffffep-1f);
    const VF y = hn::IfThenElseZero(used, Load(uniforms.v + i)), share = Load(keep + i);
    const MF keeps = hn::Lt(y, share);
    const VF below = IfThen(keeps, y, y - share);
    const VF length = IfThen(keeps, share, 1.0f - share);
    const VF fy = hn::Min(below / hn::Max(length, Set(1e-20f)), below_one);
    const V3 radiance =
        UnpackRadiance(hn::IfThenElseZero(inside, Load(packed + i)), map.radiance_unit);
    const VF pdf = Load(density + i) * samples;
    if (!mixed) {
      EmitTexels(map, column, row, FetchAreas(map, row), fx, fy, radiance, pdf, out, i);
      continue;
    }
    alignas(64) float block[7][kPadRows];
    LightColumns drawn = {block[0], block[1], block[2], block[3], block[4], block[5], block[6]};
    EmitTexels(map, column, row, FetchAreas(map, row), fx, fy, radiance, pdf, drawn, 0);
    const MF learnt = hn::And(used, hn::Lt(Load(light_norm + i), Set(float(picks.learnt))));
    float* const columns[] = {out.dir_x, out.dir_y, out.dir_z, out.r, out.g, out.b, out.pdf};
    for (std::size_t c = 0; c < std::size(columns); ++c) {
      Store(IfThen(learnt, Load(block[c]), Load(columns[c] + i)), columns[c] + i);
    }
  }
}

void ScaleByPlace(const PlacePicksView& picks, const float* light_norm, const std::uint32_t* cell,
                  const float* other, std::uint32_t n, const EscapeColumns& rows) {
  const VF zero = hn::Zero(F());
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const MU used = hn::And(RowsBelow(i, n), hn::RebindMask(U(), hn::Gt(Load(rows.pdf + i), zero)));
    const VU from = hn::IfThenElseZero(used, Load(rows.from + i));
    const VF norm = hn::IfThenElseZero(hn::RebindMask(F(), used), Gather(light_norm, from));
    const MF learnt = hn::Lt(norm, Set(float(picks.learnt)));
    const VU at = hn::IfThenElseZero(hn::And(used, hn::RebindMask(U(), learnt)),
                                     ToUnsigned(norm) * SetU(picks.cells) + Load(cell + i));
    VF pdf = Load(rows.light_pdf + i) * Gather(picks.probability, at);
    if (other != nullptr) pdf = IfThen(learnt, pdf, Load(other + i));
    StoreBelow(pdf, rows.light_pdf, i, n);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(SampleFromPlaces);
HWY_EXPORT(ScaleByPlace);

void SampleFromPlaces(const EnvironmentView& map, const SlotTexelsView& texels,
                      const PlacePicksView& picks, const float* light_norm,
                      const UniformColumns& uniforms, std::uint32_t n, float samples, bool mixed,
                      const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(SampleFromPlaces)
  (map, texels, picks, light_norm, uniforms, n, samples, mixed, out);
}
void ScaleByPlace(const PlacePicksView& picks, const float* light_norm, const std::uint32_t* cell,
                  const float* other, std::uint32_t n, const EscapeColumns& rows) {
  HWY_DYNAMIC_DISPATCH(ScaleByPlace)(picks, light_norm, cell, other, n, rows);
}

}  // namespace skywave
#endif  // HWY_ONCE
