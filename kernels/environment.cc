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

// Block of a texel of the packed tables.
HWY_INLINE VU BlockOf(VU at) {
  static_assert(kBlockTexels == 1u << 3);
  return hn::ShiftRight<3>(at);
}

// What packed texels weigh, without their solid angle.
HWY_INLINE VF WeighTexels(VU packed, float base) {
  const VF luminance = Dot(UnpackRadiance(packed, 1.0f), Set3(kLuminance));
  return hn::Max(hn::Sub(luminance, Set(base)), hn::Zero(F()));
}

// The blocks of the rows of a chunk in halves, which is how vectors take them apart.
constexpr std::uint32_t kHalfBlock = 4;
static_assert(kBlockTexels == 2 * kHalfBlock);
struct BlockRows {
  alignas(64) PackedRadiance half[2][kChunk][kHalfBlock];
};

struct TexelPick {
  VU packed, texel;  // the texel, and its number in the block
  VF probability;    // in the block
  VF x;              // position inside, in [0, 1)
};

// The texels of the blocks of rows i and on, of which the first `used` are in the map, on which
// positions x of the blocks' weights fall. The sum over a block forgets a texel that weighs 2^-24
// of those in front of it: it is drawn too rarely, and the light that is lost is no more than that.
HWY_INLINE TexelPick PickTexels(const BlockRows& blocks, std::uint32_t i, VU used, float base,
                                VF x) {
  const VF below_one = Set(0x1.fffffep-1f);
  VU texel[kBlockTexels];
  for (std::uint32_t h = 0; h < 2; ++h) {
    VU* const of_half = texel + h * kHalfBlock;
    hn::LoadInterleaved4(U(), blocks.half[h][i], of_half[0], of_half[1], of_half[2], of_half[3]);
  }
  VF weight[kBlockTexels], end[kBlockTexels];
  for (std::uint32_t k = 0; k < kBlockTexels; ++k) {
    const MF inside = hn::RebindMask(F(), hn::Lt(SetU(k), used));
    weight[k] = hn::IfThenElseZero(inside, WeighTexels(texel[k], base));
    end[k] = k == 0 ? weight[0] : hn::Add(end[k - 1], weight[k]);
  }
  const VF total = end[kBlockTexels - 1];
  // Below the end even after rounding, so that what is found weighs something.
  const VF target = hn::Min(hn::Mul(x, total), hn::Mul(total, below_one));
  TexelPick pick = {texel[0], hn::Zero(U()), weight[0], hn::Zero(F())};
  VF begin = hn::Zero(F());
  for (std::uint32_t k = 1; k < kBlockTexels; ++k) {
    const MF behind = hn::Ge(target, end[k - 1]);
    const MU behind_u = hn::RebindMask(U(), behind);
    pick.packed = IfThen(behind_u, texel[k], pick.packed);
    pick.texel = IfThen(behind_u, SetU(k), pick.texel);
    pick.probability = IfThen(behind, weight[k], pick.probability);
    begin = IfThen(behind, end[k - 1], begin);
  }
  pick.x = hn::Min(hn::Div(hn::Sub(target, begin), pick.probability), below_one);
  pick.probability = hn::Div(pick.probability, total);
  return pick;
}

void SampleTexels(const EnvironmentView& map, const InversionView& inversion,
                  const UniformColumns& uniforms, std::uint32_t n, float samples,
                  const LightColumns& out) {
  SearchColumns down, across;
  BlockRows blocks;
  for (std::uint32_t begin = 0; begin < n; begin += kChunk) {
    const std::uint32_t rows = std::min(kChunk, n - begin);
    std::copy_n(uniforms.v + begin, rows, down.x);
    std::fill_n(down.item, rows, 0u);
    Search(inversion.rows, rows, down);
    std::copy_n(uniforms.u + begin, rows, across.x);
    std::copy_n(down.item, rows, across.item);
    Search(inversion.blocks, rows, across);
    const auto block = [&](std::uint32_t i) HWY_ATTR {
      return inversion.packed + std::size_t(down.item[i]) * map.stride +
             across.item[i] * kBlockTexels;
    };
    for (std::uint32_t i = 0; i < rows; ++i) hwy::Prefetch(block(i));
    for (std::uint32_t i = 0; i < rows; ++i) {
      const PackedRadiance* const texels = block(i);
      for (std::uint32_t h = 0; h < 2; ++h) {
        std::memcpy(blocks.half[h][i], texels + h * kHalfBlock, sizeof blocks.half[h][i]);
      }
    }
    for (std::uint32_t i = 0; i < rows; i += hn::Lanes(F())) {
      // Rows behind the last are unspecified: keep the gathers inside the tables.
      const VU row = hn::IfThenElseZero(RowsBelow(i, rows), Load(down.item + i));
      const VU first = hn::Mul(Load(across.item + i), SetU(kBlockTexels));
      const TexelPick pick = PickTexels(blocks, i, hn::Sub(SetU(map.width), first), inversion.base,
                                        Load(across.x + i));
      const VF of_block = hn::Mul(hn::Mul(Load(down.mass + i), Load(across.mass + i)),
                                  Gather(inversion.row_density, row));
      const VU column = hn::IfThenElseZero(RowsBelow(i, rows), hn::Add(first, pick.texel));
      const V3 radiance = inversion.packed == map.packed
                              ? UnpackRadiance(pick.packed, map.radiance_unit)
                              : FetchTexels(map, column, row);
      EmitTexels(map, column, row, pick.x, Load(down.x + i), radiance,
                 hn::Mul(hn::Mul(of_block, pick.probability), Set(samples)), out, begin + i);
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
    hwy::Prefetch(map.packed + std::size_t(lookup.row[i]) * map.stride + lookup.column[i]);
  }
  if (density.inversion != nullptr) {
    for (std::uint32_t i = 0; i < rows; ++i) {
      const std::size_t at = std::size_t(lookup.row[i]) * map.stride + lookup.column[i];
      hwy::Prefetch(density.inversion->block_density + at / kBlockTexels);
    }
  } else if (density.table != nullptr) {
    for (std::uint32_t i = 0; i < rows; ++i) {
      hwy::Prefetch(density.table + std::size_t(lookup.row[i]) * map.width + lookup.column[i]);
    }
  }
}

// Density of the texels whose packed form is given, too.
HWY_INLINE VF DensityOf(const EnvironmentView& map, const TexelDensity& density, float samples,
                        VU column, VU row, VU packed) {
  const VU texel = hn::Add(hn::Mul(row, SetU(map.width)), column);
  VF sum = hn::Zero(F());
  if (density.inversion != nullptr) {
    const InversionView& inversion = *density.inversion;
    const VU at = PackedIndex(map, column, row);
    if (inversion.packed != map.packed) packed = Gather(inversion.packed, at);
    sum =
        hn::Mul(Gather(inversion.block_density, BlockOf(at)), WeighTexels(packed, inversion.base));
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
        const VU packed = Gather(map.packed, PackedIndex(map, column, row));
        radiance = UnpackRadiance(packed, map.radiance_unit);
        light_pdf = DensityOf(map, density, samples, column, row, packed);
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
