#include "kernels/environment.h"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/environment.cc"
#include "hwy/cache_control.h"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/search-inl.h"
#include "kernels/sphere-inl.h"
#include "kernels/texels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

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

void SampleTexels(const EnvironmentView& map, const InversionView& inversion,
                  const UniformColumns& uniforms, std::uint32_t n, float samples,
                  const LightColumns& out) {
  SearchColumns down, across;
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
      const VF mass = ToFloat(hn::Sub(SpanEnd(span), SpanStart(span)));
      const VF block = Gather(inversion.block_density, BlockOf(inversion, column, row));
      EmitTexels(map, column, row, Load(across.x + i), Load(down.x + i),
                 hn::Mul(hn::Mul(block, mass), Set(samples)), out, begin + i);
    }
  }
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
HWY_INLINE void FindTexels(const EnvironmentView& map, const TexelDensity& density, const float* x,
                           const float* y, const float* z, std::uint32_t rows,
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
  if (density.inversion != nullptr) {
    const SearchTreeView& trees = density.inversion->columns;
    const SearchNode* leaves = trees.level[trees.levels - 1];
    for (std::uint32_t i = 0; i < rows; ++i) {
      hwy::Prefetch(leaves + std::size_t(lookup.row[i]) * density.inversion->blocks +
                    lookup.column[i] / kNodeFan);
    }
  } else if (density.table != nullptr) {
    for (std::uint32_t i = 0; i < rows; ++i) {
      hwy::Prefetch(density.table + std::size_t(lookup.row[i]) * map.width + lookup.column[i]);
    }
  }
}

HWY_INLINE VF DensityOf(const EnvironmentView& map, const TexelDensity& density, float samples,
                        VU column, VU row) {
  const VU texel = hn::Add(hn::Mul(row, SetU(map.width)), column);
  VF sum = hn::Zero(F());
  if (density.inversion != nullptr) {
    const VU block = BlockOf(*density.inversion, column, row);
    sum = hn::Mul(Gather(density.inversion->block_density, block),
                  ToFloat(LeafMass(*density.inversion, block, column)));
  } else if (density.table != nullptr) {
    sum = Gather(density.table, texel);
  }
  sum = hn::Mul(sum, Set(samples));
  return density.fixed == nullptr ? sum : hn::Add(sum, Gather(density.fixed, texel));
}

void EvaluateEscaped(const EnvironmentView& map, const TexelDensity& density, std::uint32_t n,
                     float samples, const EscapeColumns& escaped) {
  const VF zero = hn::Zero(F());
  LookupColumns lookup;
  for (std::uint32_t begin = 0; begin < n; begin += kChunk) {
    const std::uint32_t rows = std::min(kChunk, n - begin);
    FindTexels(map, density, escaped.dir_x + begin, escaped.dir_y + begin, escaped.dir_z + begin,
               rows, lookup);
    for (std::uint32_t i = 0; i < rows; i += hn::Lanes(F())) {
      const std::uint32_t to = begin + i;
      const MF seen = hn::Eq(Load(escaped.pdf + to), zero);
      V3 radiance = {zero, zero, zero};
      VF light_pdf = zero;
      if (!hn::AllTrue(F(), seen)) {
        const VU column = Load(lookup.column + i), row = Load(lookup.row + i);
        radiance = FetchTexels(map, column, row);
        light_pdf = DensityOf(map, density, samples, column, row);
      }
      if (!hn::AllFalse(F(), seen)) {
        radiance =
            IfThen(seen, InterpolateTexels(map, Load(lookup.u + i), Load(lookup.v + i)), radiance);
      }
      Store3(radiance, escaped.radiance_r + to, escaped.radiance_g + to, escaped.radiance_b + to);
      Store(light_pdf, escaped.light_pdf + to);
    }
  }
}

void LookUpTexels(const EnvironmentView& map, std::uint32_t n, const LightColumns& out) {
  LookupColumns lookup;
  for (std::uint32_t begin = 0; begin < n; begin += kChunk) {
    const std::uint32_t rows = std::min(kChunk, n - begin);
    FindTexels(map, TexelDensity{}, out.dir_x + begin, out.dir_y + begin, out.dir_z + begin, rows,
               lookup);
    for (std::uint32_t i = 0; i < rows; i += hn::Lanes(F())) {
      const std::uint32_t to = begin + i;
      Store3(FetchTexels(map, Load(lookup.column + i), Load(lookup.row + i)), out.r + to,
             out.g + to, out.b + to);
    }
  }
}

void SampleSphere(const UniformColumns& uniforms, std::uint32_t n, float samples,
                  const LightColumns& out) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    Store3(UniformSphere(Load(uniforms.u + i), Load(uniforms.v + i)), out.dir_x + i, out.dir_y + i,
           out.dir_z + i);
    Store(Set(0.25f * kInvPi * samples), out.pdf + i);
  }
}

void SampleCosine(const SurfaceColumns& surfaces, const UniformColumns& uniforms, std::uint32_t n,
                  float samples, const LightColumns& out) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const V3 local = CosineHemisphere(Load(uniforms.u + i), Load(uniforms.v + i));
    const Frame frame = MakeFrame(Load3(surfaces.ns_x + i, surfaces.ns_y + i, surfaces.ns_z + i));
    Store3(ToWorld(frame, local), out.dir_x + i, out.dir_y + i, out.dir_z + i);
    Store(hn::Mul(local.z, Set(kInvPi * samples)), out.pdf + i);
  }
}

void CosineDensity(const SurfaceColumns& surfaces, std::uint32_t n, float samples,
                   const EscapeColumns& rows) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU from = hn::IfThenElseZero(RowsBelow(i, n), Load(rows.from + i));
    const V3 ns = {Gather(surfaces.ns_x, from), Gather(surfaces.ns_y, from),
                   Gather(surfaces.ns_z, from)};
    const VF cosine = Dot(ns, Load3(rows.dir_x + i, rows.dir_y + i, rows.dir_z + i));
    Store(hn::Mul(hn::Max(cosine, hn::Zero(F())), Set(kInvPi * samples)), rows.light_pdf + i);
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
                  const UniformColumns& uniforms, std::uint32_t n, float samples,
                  const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(SampleTexels)(map, inversion, uniforms, n, samples, out);
}
void EvaluateEscaped(const EnvironmentView& map, const TexelDensity& density, std::uint32_t n,
                     float samples, const EscapeColumns& rows) {
  HWY_DYNAMIC_DISPATCH(EvaluateEscaped)(map, density, n, samples, rows);
}
void LookUpTexels(const EnvironmentView& map, std::uint32_t n, const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(LookUpTexels)(map, n, out);
}
void SampleSphere(const UniformColumns& uniforms, std::uint32_t n, float samples,
                  const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(SampleSphere)(uniforms, n, samples, out);
}
void SampleCosine(const SurfaceColumns& surfaces, const UniformColumns& uniforms, std::uint32_t n,
                  float samples, const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(SampleCosine)(surfaces, uniforms, n, samples, out);
}
void CosineDensity(const SurfaceColumns& surfaces, std::uint32_t n, float samples,
                   const EscapeColumns& rows) {
  HWY_DYNAMIC_DISPATCH(CosineDensity)(surfaces, n, samples, rows);
}

}  // namespace skywave
#endif  // HWY_ONCE
