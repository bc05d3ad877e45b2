#include "kernels/environment.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/environment.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/sphere-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Columns of a search in flight. A chunk stays in the first-level cache.
constexpr std::uint32_t kChunk = 256;
struct SearchColumns {
  alignas(64) float x[kChunk];               // in: uniform; out: position inside the item found
  alignas(64) std::uint32_t item[kChunk];    // in: tree; out: item, counted through all trees
  alignas(64) std::uint32_t target[kChunk];  // scaled uniform, then first child
  alignas(64) std::uint32_t low[kChunk], high[kChunk];  // cumulative masses around the child
};

// Number of the node's entries <= target. One node is one cache line.
HWY_INLINE std::uint32_t CountNotAbove(const SearchNode& node, std::uint32_t target) {
  const hn::CappedTag<std::int16_t, kNodeFan> d;
  const auto limit = hn::Set(d, static_cast<std::int16_t>(target));
  std::size_t above = 0;
  for (std::size_t i = 0; i < kNodeFan; i += hn::Lanes(d)) {
    above += hn::CountTrue(d, hn::Gt(hn::Load(d, node.cumulative + i), limit));
  }
  return kNodeFan - static_cast<std::uint32_t>(above);
}

// Walks `n` searches down a level: `item` is the node on the way in and the child on the way out.
HWY_INLINE void DescendLevel(const SearchNode* nodes, std::uint32_t n, SearchColumns& s) {
  const VF node_mass = Set(float(kNodeMass));
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VF scaled = hn::Mul(Load(s.x + i), node_mass);
    Store(scaled, s.x + i);
    Store(ToUnsigned(scaled), s.target + i);
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const SearchNode& node = nodes[s.item[i]];
    const std::uint32_t child = CountNotAbove(node, s.target[i]);
    s.high[i] = static_cast<std::uint32_t>(node.cumulative[child]);
    s.low[i] = child == 0 ? 0 : static_cast<std::uint32_t>(node.cumulative[child - 1]);
    s.item[i] = s.item[i] * kNodeFan + child;
  }
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VF low = ToFloat(Load(s.low + i)), high = ToFloat(Load(s.high + i));
    Store(hn::Div(hn::Sub(Load(s.x + i), low), hn::Sub(high, low)), s.x + i);
  }
}

// Searches the tree whose number stands in `item`. Afterwards high - low is the mass of the item in
// its leaf. A level's nodes are numbered through all trees, so that the child numbers of one level,
// less what the padding of the level above skips, are node numbers of the next.
HWY_INLINE void Search(const SearchTreeView& trees, std::uint32_t n, SearchColumns& s) {
  alignas(64) std::uint32_t tree[kChunk];
  std::copy_n(s.item, n, tree);
  for (std::uint32_t level = 0; level < trees.levels; ++level) {
    if (level > 0) {
      // Child c of node (tree, k) is node tree * nodes + (k * fan + c) of the next level.
      const std::uint32_t above = trees.nodes[level - 1] * kNodeFan, here = trees.nodes[level];
      for (std::uint32_t i = 0; i < n; ++i) s.item[i] -= tree[i] * (above - here);
    }
    DescendLevel(trees.level[level], n, s);
  }
  const std::uint32_t slots = trees.nodes[trees.levels - 1] * kNodeFan;
  for (std::uint32_t i = 0; i < n; ++i) s.item[i] -= tree[i] * slots;
}

// A half without sign to a float, denormals included whatever the mode of the processor.
HWY_INLINE VF HalfToFloat(VU half) {
  const VU normal = hn::Add(hn::ShiftLeft<13>(half), SetU((127 - 15) << 23));
  const VF denormal = hn::Mul(ToFloat(half), Set(0x1p-24f));
  return IfThen(hn::RebindMask(F(), hn::Lt(half, SetU(1u << 10))), denormal, AsFloat(normal));
}

struct Texel {
  V3 radiance;
  VU mass;
};
HWY_INLINE Texel FetchTexel(const EnvironmentView& map, VU index) {
  const auto* words = reinterpret_cast<const std::uint32_t*>(map.texels);
  const VU at = hn::ShiftLeft<1>(index);
  const VU rg = Gather(words, at), b_mass = Gather(words, hn::Add(at, SetU(1)));
  const VU low = SetU(0xFFFFu);
  const V3 rgb = {HalfToFloat(hn::And(rg, low)), HalfToFloat(hn::ShiftRight<16>(rg)),
                  HalfToFloat(hn::And(b_mass, low))};
  return {Scale(rgb, Set(map.radiance_scale)), hn::ShiftRight<16>(b_mass)};
}

HWY_INLINE VF TexelDensity(const EnvironmentView& map, VU column, VU row, VU mass) {
  const VU block = hn::Add(hn::Mul(row, SetU(map.blocks)), hn::ShiftRight<5>(column));
  return hn::Mul(Gather(map.block_density, block), ToFloat(mass));
}

HWY_INLINE V3 WorldFromMap(const EnvironmentView& map, const V3& m) {
  const float* r = map.map_from_world;  // orthonormal: its transpose is its inverse
  return Add(Add(Scale(Set3(r), m.x), Scale(Set3(r + 3), m.y)), Scale(Set3(r + 6), m.z));
}
HWY_INLINE V3 MapFromWorld(const EnvironmentView& map, const V3& w) {
  const float* r = map.map_from_world;
  return {Dot(Set3(r), w), Dot(Set3(r + 3), w), Dot(Set3(r + 6), w)};
}

void SampleTexels(const EnvironmentView& map, const InversionView& inversion,
                  const UniformColumns& uniforms, std::uint32_t n, const LightColumns& out) {
  SearchColumns down, across;
  const VF width = Set(float(map.width));
  const VU equator = SetU((map.height + 1) / 2);
  const auto* areas = reinterpret_cast<const float*>(inversion.row_area);
  for (std::uint32_t begin = 0; begin < n; begin += kChunk) {
    const std::uint32_t rows = std::min(kChunk, n - begin);
    std::copy_n(uniforms.v + begin, rows, down.x);
    std::fill_n(down.item, rows, 0u);
    Search(inversion.rows, rows, down);
    std::copy_n(uniforms.u + begin, rows, across.x);
    std::copy_n(down.item, rows, across.item);
    Search(inversion.columns, rows, across);

    for (std::uint32_t i = 0; i < rows; i += hn::Lanes(F())) {
      // Rows behind the last are unspecified: keep the gathers inside the tables.
      const MU inside = RowsBelow(i, rows);
      const VU row = hn::IfThenElseZero(inside, Load(down.item + i));
      const VU column = hn::IfThenElseZero(inside, Load(across.item + i));
      const VU mass = hn::Sub(Load(across.high + i), Load(across.low + i));

      const VU area = hn::ShiftLeft<1>(row);
      const VF w = hn::Add(Gather(areas, area),
                           hn::Mul(Gather(areas, hn::Add(area, SetU(1))), Load(down.x + i)));
      const VF sine = hn::Mul(Set(2.0f), SafeSqrt(hn::Mul(w, hn::Sub(Set(1.0f), w))));
      const VF up_north = hn::Sub(Set(1.0f), hn::Mul(Set(2.0f), w));
      const VF up = IfThen(hn::RebindMask(F(), hn::Lt(row, equator)), up_north, hn::Neg(up_north));
      // u = 1/2 looks forward: the turn from forward to right is u - 1/2.
      const VF u = hn::Div(hn::Add(ToFloat(column), Load(across.x + i)), width);
      VF sin_turn, cos_turn;
      SinCosTurn(u, sin_turn, cos_turn);
      const V3 direction = {hn::Neg(hn::Mul(sine, sin_turn)), hn::Neg(hn::Mul(sine, cos_turn)), up};

      const Texel texel = FetchTexel(map, hn::Add(hn::Mul(row, SetU(map.width)), column));
      const std::uint32_t to = begin + i;
      Store3(WorldFromMap(map, direction), out.dir_x + to, out.dir_y + to, out.dir_z + to);
      Store3(texel.radiance, out.r + to, out.g + to, out.b + to);
      Store(TexelDensity(map, column, row, mass), out.pdf + to);
    }
  }
}

// Position of a direction on the map: u, v in [0, 1].
HWY_INLINE void MapPosition(const EnvironmentView& map, const V3& dir, VF& u, VF& v) {
  const V3 m = MapFromWorld(map, dir);
  u = hn::Add(Set(0.5f), Atan2Turn(m.x, m.y));
  const VF sine = hn::Sqrt(hn::Add(hn::Mul(m.x, m.x), hn::Mul(m.y, m.y)));
  v = hn::Mul(Set(2.0f), Atan2Turn(sine, m.z));
}

// Cell of a position in [0, 1] on a line of `count` cells.
HWY_INLINE VU CellOf(VF position, std::uint32_t count) {
  const VF scaled = hn::Max(hn::Mul(position, Set(float(count))), hn::Zero(F()));
  return hn::Min(ToUnsigned(hn::Min(scaled, Set(float(count)))), SetU(count - 1));
}

HWY_INLINE V3 InterpolateTexels(const EnvironmentView& map, VF u, VF v) {
  const VF x = hn::Sub(hn::Mul(u, Set(float(map.width))), Set(0.5f));
  const VF y = hn::Sub(hn::Mul(v, Set(float(map.height))), Set(0.5f));
  const VF x_floor = hn::Floor(x), y_floor = hn::Floor(y);
  const VF fx = hn::Sub(x, x_floor), fy = hn::Sub(y, y_floor);
  const float last_x = float(map.width - 1), last_y = float(map.height - 1);
  // Columns wrap at the seam; the rows at the poles repeat.
  const VF x_next = hn::Add(x_floor, Set(1.0f));
  const VU left = ToUnsigned(IfThen(hn::Lt(x_floor, hn::Zero(F())), Set(last_x), x_floor));
  const VU right = ToUnsigned(IfThen(hn::Gt(x_next, Set(last_x)), hn::Zero(F()), x_next));
  const VU top = ToUnsigned(Clamp(y_floor, 0.0f, last_y));
  const VU bottom = ToUnsigned(Clamp(hn::Add(y_floor, Set(1.0f)), 0.0f, last_y));
  const VU width = SetU(map.width);
  const VU top_row = hn::Mul(top, width), bottom_row = hn::Mul(bottom, width);
  const VF one = Set(1.0f);
  const auto across = [&](VU row) HWY_ATTR {
    return Add(Scale(FetchTexel(map, hn::Add(row, left)).radiance, hn::Sub(one, fx)),
               Scale(FetchTexel(map, hn::Add(row, right)).radiance, fx));
  };
  return Add(Scale(across(top_row), hn::Sub(one, fy)), Scale(across(bottom_row), fy));
}

void EvaluateEscaped(const EnvironmentView& map, std::uint32_t n, const EscapeColumns& rows) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    // Padding rows look along +z.
    const MF inside = hn::RebindMask(F(), RowsBelow(i, n));
    const V3 dir = IfThen(inside, Load3(rows.dir_x + i, rows.dir_y + i, rows.dir_z + i),
                          V3{hn::Zero(F()), hn::Zero(F()), Set(1.0f)});
    VF u, v;
    MapPosition(map, dir, u, v);
    const MF seen = hn::And(inside, hn::Eq(Load(rows.pdf + i), hn::Zero(F())));
    V3 radiance = {hn::Zero(F()), hn::Zero(F()), hn::Zero(F())};
    VF density = hn::Zero(F());
    if (!hn::AllTrue(F(), seen)) {
      const VU column = CellOf(u, map.width), row = CellOf(v, map.height);
      const Texel texel = FetchTexel(map, hn::Add(hn::Mul(row, SetU(map.width)), column));
      radiance = texel.radiance;
      if (map.block_density != nullptr) density = TexelDensity(map, column, row, texel.mass);
    }
    if (!hn::AllFalse(F(), seen)) radiance = IfThen(seen, InterpolateTexels(map, u, v), radiance);
    Store3(radiance, rows.radiance_r + i, rows.radiance_g + i, rows.radiance_b + i);
    Store(density, rows.light_pdf + i);
  }
}

void LookUpTexels(const EnvironmentView& map, std::uint32_t n, const LightColumns& out) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    VF u, v;
    MapPosition(map, Load3(out.dir_x + i, out.dir_y + i, out.dir_z + i), u, v);
    const VU texel = hn::Add(hn::Mul(CellOf(v, map.height), SetU(map.width)), CellOf(u, map.width));
    Store3(FetchTexel(map, hn::IfThenElseZero(RowsBelow(i, n), texel)).radiance, out.r + i,
           out.g + i, out.b + i);
  }
}

void SampleSphere(const UniformColumns& uniforms, std::uint32_t n, const LightColumns& out) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    Store3(UniformSphere(Load(uniforms.u + i), Load(uniforms.v + i)), out.dir_x + i, out.dir_y + i,
           out.dir_z + i);
    Store(Set(0.25f * kInvPi), out.pdf + i);
  }
}

void SampleCosine(const SurfaceColumns& surfaces, const UniformColumns& uniforms, std::uint32_t n,
                  const LightColumns& out) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const V3 local = CosineHemisphere(Load(uniforms.u + i), Load(uniforms.v + i));
    const Frame frame = MakeFrame(Load3(surfaces.ns_x + i, surfaces.ns_y + i, surfaces.ns_z + i));
    Store3(ToWorld(frame, local), out.dir_x + i, out.dir_y + i, out.dir_z + i);
    Store(hn::Mul(local.z, Set(kInvPi)), out.pdf + i);
  }
}

void CosineDensity(const SurfaceColumns& surfaces, std::uint32_t n, const EscapeColumns& rows) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU from = hn::IfThenElseZero(RowsBelow(i, n), Load(rows.from + i));
    const V3 ns = {Gather(surfaces.ns_x, from), Gather(surfaces.ns_y, from),
                   Gather(surfaces.ns_z, from)};
    const VF cosine = Dot(ns, Load3(rows.dir_x + i, rows.dir_y + i, rows.dir_z + i));
    Store(hn::Mul(hn::Max(cosine, hn::Zero(F())), Set(kInvPi)), rows.light_pdf + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(SampleTexels);
HWY_EXPORT(EvaluateEscaped);
HWY_EXPORT(LookUpTexels);
HWY_EXPORT(SampleSphere);
HWY_EXPORT(SampleCosine);
HWY_EXPORT(CosineDensity);

void SampleTexels(const EnvironmentView& map, const InversionView& inversion,
                  const UniformColumns& uniforms, std::uint32_t n, const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(SampleTexels)(map, inversion, uniforms, n, out);
}
void EvaluateEscaped(const EnvironmentView& map, std::uint32_t n, const EscapeColumns& rows) {
  HWY_DYNAMIC_DISPATCH(EvaluateEscaped)(map, n, rows);
}
void LookUpTexels(const EnvironmentView& map, std::uint32_t n, const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(LookUpTexels)(map, n, out);
}
void SampleSphere(const UniformColumns& uniforms, std::uint32_t n, const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(SampleSphere)(uniforms, n, out);
}
void SampleCosine(const SurfaceColumns& surfaces, const UniformColumns& uniforms, std::uint32_t n,
                  const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(SampleCosine)(surfaces, uniforms, n, out);
}
void CosineDensity(const SurfaceColumns& surfaces, std::uint32_t n, const EscapeColumns& rows) {
  HWY_DYNAMIC_DISPATCH(CosineDensity)(surfaces, n, rows);
}

}  // namespace skywave
#endif  // HWY_ONCE
