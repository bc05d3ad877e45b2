#include "kernels/environment.h"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/environment.cc"
#include "hwy/cache_control.h"
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
  alignas(64) std::uint32_t target[kChunk];  // position on the line of the node
  alignas(64) std::uint32_t span[kChunk];    // start of the child, and of the next one << 16
};

// The last child that does not start behind `target`. A node is one cache line.
HWY_INLINE std::uint32_t FindChild(const SearchNode& node, std::uint32_t target) {
  const hn::CappedTag<std::int16_t, kNodeFan> d;
  const auto limit = hn::Set(d, static_cast<std::int16_t>(target));
  std::size_t behind = 0;
  for (std::size_t i = 0; i < kNodeFan; i += hn::Lanes(d)) {
    behind += hn::CountTrue(d, hn::Gt(hn::Load(d, node.start + i), limit));
  }
  return kNodeFan - 1 - static_cast<std::uint32_t>(behind);
}

// Start and end of a child from its span. Behind the last child stands the start of another node,
// 0.
HWY_INLINE VU SpanStart(VU span) { return hn::And(span, SetU(0xFFFFu)); }
HWY_INLINE VU SpanEnd(VU span) {
  const VU next = hn::ShiftRight<16>(span);
  return IfThen(hn::Eq(next, SetU(0)), SetU(kNodeMass), next);
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
    const std::uint32_t child = FindChild(node, s.target[i]);
    std::memcpy(&s.span[i], &node.start[child], sizeof s.span[i]);
    s.item[i] = s.item[i] * kNodeFan + child;
  }
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU span = Load(s.span + i);
    const VF start = ToFloat(SpanStart(span)), end = ToFloat(SpanEnd(span));
    Store(hn::Div(hn::Sub(Load(s.x + i), start), hn::Sub(end, start)), s.x + i);
  }
}

// Searches the tree whose number stands in `item`. Afterwards the span is that of the item in its
// leaf. A level's nodes are numbered through all trees, so that the child numbers of one level,
// less what the padding of the level above skips, are node numbers of the next.
HWY_INLINE void Search(const SearchTreeView& trees, std::uint32_t n, SearchColumns& s) {
  alignas(64) std::uint32_t tree[kChunk];
  std::copy_n(s.item, n, tree);
  for (std::uint32_t level = 0; level < trees.levels; ++level) {
    if (level > 0) {
      // Child c of node (tree, k) is node tree * nodes + (k * fan + c) of the next level.
      const std::uint32_t above = trees.nodes[level - 1] * kNodeFan, here = trees.nodes[level];
      for (std::uint32_t i = 0; i < n; ++i) {
        s.item[i] -= tree[i] * (above - here);
        hwy::Prefetch(trees.level[level] + s.item[i]);
      }
    }
    DescendLevel(trees.level[level], n, s);
  }
  const std::uint32_t slots = trees.nodes[trees.levels - 1] * kNodeFan;
  for (std::uint32_t i = 0; i < n; ++i) s.item[i] -= tree[i] * slots;
}

HWY_INLINE V3 UnpackRadiance(VU packed, float unit) {
  const VU mantissa = SetU((1u << kMantissaBits) - 1);
  // 2^(exponent - 31) assembled in the exponent field of a float.
  const VU exponent = hn::ShiftRight<3 * kMantissaBits>(packed);
  const VF power = AsFloat(hn::ShiftLeft<23>(hn::Add(exponent, SetU(127 - kMaxExponent))));
  const VF scale = hn::Mul(power, Set(unit));
  return Scale({ToFloat(hn::And(packed, mantissa)),
                ToFloat(hn::And(hn::ShiftRight<kMantissaBits>(packed), mantissa)),
                ToFloat(hn::And(hn::ShiftRight<2 * kMantissaBits>(packed), mantissa))},
               scale);
}

HWY_INLINE VU BlockOf(const InversionView& inversion, VU column, VU row) {
  return hn::Add(hn::Mul(row, SetU(inversion.blocks)), hn::ShiftRight<5>(column));
}

// Mass of a texel in its leaf. Starts stand in pairs in 32-bit words: of an even child both ends
// are in one word, of an odd one in two.
HWY_INLINE VU LeafMass(const InversionView& inversion, VU block, VU column) {
  const SearchTreeView& trees = inversion.columns;
  const auto* words = reinterpret_cast<const std::uint32_t*>(trees.level[trees.levels - 1]);
  const VU child = hn::And(column, SetU(kNodeFan - 1));
  const VU at = hn::Add(hn::ShiftLeft<4>(block), hn::ShiftRight<1>(child));
  const VU word = Gather(words, at);
  const VU next = Gather(words, hn::Add(at, SetU(1)));
  const VU odd_span = hn::Or(hn::ShiftRight<16>(word), hn::ShiftLeft<16>(next));
  const VU span = IfThen(hn::TestBit(child, SetU(1)), odd_span, word);
  // Not SpanEnd: in front of the first child with mass the next one starts at 0 too.
  const VU end =
      IfThen(hn::Eq(child, SetU(kNodeFan - 1)), SetU(kNodeMass), hn::ShiftRight<16>(span));
  return hn::Sub(end, SpanStart(span));
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
    for (std::uint32_t i = 0; i < rows; ++i) {
      hwy::Prefetch(map.packed + std::size_t(down.item[i]) * map.width + across.item[i]);
    }

    for (std::uint32_t i = 0; i < rows; i += hn::Lanes(F())) {
      // Rows behind the last are unspecified: keep the gathers inside the tables.
      const MU inside = RowsBelow(i, rows);
      const VU row = hn::IfThenElseZero(inside, Load(down.item + i));
      const VU column = hn::IfThenElseZero(inside, Load(across.item + i));
      const VU span = Load(across.span + i);
      const VU mass = hn::Sub(SpanEnd(span), SpanStart(span));

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

      const VU texel = hn::Add(hn::Mul(row, SetU(map.width)), column);
      const V3 radiance = UnpackRadiance(Gather(map.packed, texel), map.radiance_unit);
      const VF density = Gather(inversion.block_density, BlockOf(inversion, column, row));
      const std::uint32_t to = begin + i;
      Store3(WorldFromMap(map, direction), out.dir_x + to, out.dir_y + to, out.dir_z + to);
      Store3(radiance, out.r + to, out.g + to, out.b + to);
      Store(hn::Mul(density, ToFloat(mass)), out.pdf + to);
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

// The map between texel centres, in full precision.
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
  const auto texel = [&](VU column, VU row) HWY_ATTR {
    const VU at = hn::Mul(hn::Add(hn::Mul(row, width), column), SetU(3));
    return V3{Gather(map.rgb, at), Gather(map.rgb, hn::Add(at, SetU(1))),
              Gather(map.rgb, hn::Add(at, SetU(2)))};
  };
  const VF one = Set(1.0f);
  const auto across = [&](VU row) HWY_ATTR {
    return Add(Scale(texel(left, row), hn::Sub(one, fx)), Scale(texel(right, row), fx));
  };
  return Add(Scale(across(top), hn::Sub(one, fy)), Scale(across(bottom), fy));
}

// Positions of a chunk of directions on the map.
struct LookupColumns {
  alignas(64) float u[kChunk], v[kChunk];
  alignas(64) std::uint32_t column[kChunk], row[kChunk];
};

// Finds the texels of directions [begin, begin + rows) and asks the memory for them: by the time
// all are found the first have arrived.
HWY_INLINE void FindTexels(const EnvironmentView& map, const InversionView* inversion,
                           const float* x, const float* y, const float* z, std::uint32_t rows,
                           LookupColumns& lookup) {
  for (std::uint32_t i = 0; i < rows; i += hn::Lanes(F())) {
    const MF inside = hn::RebindMask(F(), RowsBelow(i, rows));
    // Rows behind the last look along +z.
    const V3 dir =
        IfThen(inside, Load3(x + i, y + i, z + i), V3{hn::Zero(F()), hn::Zero(F()), Set(1.0f)});
    VF u, v;
    MapPosition(map, dir, u, v);
    Store(u, lookup.u + i), Store(v, lookup.v + i);
    Store(CellOf(u, map.width), lookup.column + i);
    Store(CellOf(v, map.height), lookup.row + i);
  }
  for (std::uint32_t i = 0; i < rows; ++i) {
    hwy::Prefetch(map.packed + std::size_t(lookup.row[i]) * map.width + lookup.column[i]);
  }
  if (inversion == nullptr) return;
  const SearchTreeView& trees = inversion->columns;
  const SearchNode* leaves = trees.level[trees.levels - 1];
  for (std::uint32_t i = 0; i < rows; ++i) {
    hwy::Prefetch(leaves + std::size_t(lookup.row[i]) * inversion->blocks +
                  lookup.column[i] / kNodeFan);
  }
}

HWY_INLINE V3 FetchTexels(const EnvironmentView& map, VU column, VU row) {
  const VU texel = hn::Add(hn::Mul(row, SetU(map.width)), column);
  return UnpackRadiance(Gather(map.packed, texel), map.radiance_unit);
}

void EvaluateEscaped(const EnvironmentView& map, const InversionView* inversion, std::uint32_t n,
                     const EscapeColumns& escaped) {
  const VF zero = hn::Zero(F());
  LookupColumns lookup;
  for (std::uint32_t begin = 0; begin < n; begin += kChunk) {
    const std::uint32_t rows = std::min(kChunk, n - begin);
    FindTexels(map, inversion, escaped.dir_x + begin, escaped.dir_y + begin, escaped.dir_z + begin,
               rows, lookup);
    for (std::uint32_t i = 0; i < rows; i += hn::Lanes(F())) {
      const std::uint32_t to = begin + i;
      const MF seen = hn::Eq(Load(escaped.pdf + to), zero);
      V3 radiance = {zero, zero, zero};
      VF density = zero;
      if (!hn::AllTrue(F(), seen)) {
        const VU column = Load(lookup.column + i), row = Load(lookup.row + i);
        radiance = FetchTexels(map, column, row);
        if (inversion != nullptr) {
          const VU block = BlockOf(*inversion, column, row);
          density = hn::Mul(Gather(inversion->block_density, block),
                            ToFloat(LeafMass(*inversion, block, column)));
        }
      }
      if (!hn::AllFalse(F(), seen)) {
        radiance =
            IfThen(seen, InterpolateTexels(map, Load(lookup.u + i), Load(lookup.v + i)), radiance);
      }
      Store3(radiance, escaped.radiance_r + to, escaped.radiance_g + to, escaped.radiance_b + to);
      Store(density, escaped.light_pdf + to);
    }
  }
}

void LookUpTexels(const EnvironmentView& map, std::uint32_t n, const LightColumns& out) {
  LookupColumns lookup;
  for (std::uint32_t begin = 0; begin < n; begin += kChunk) {
    const std::uint32_t rows = std::min(kChunk, n - begin);
    FindTexels(map, nullptr, out.dir_x + begin, out.dir_y + begin, out.dir_z + begin, rows, lookup);
    for (std::uint32_t i = 0; i < rows; i += hn::Lanes(F())) {
      const std::uint32_t to = begin + i;
      Store3(FetchTexels(map, Load(lookup.column + i), Load(lookup.row + i)), out.r + to,
             out.g + to, out.b + to);
    }
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
void EvaluateEscaped(const EnvironmentView& map, const InversionView* inversion, std::uint32_t n,
                     const EscapeColumns& rows) {
  HWY_DYNAMIC_DISPATCH(EvaluateEscaped)(map, inversion, n, rows);
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
