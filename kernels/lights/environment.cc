#include "kernels/lights/environment.h"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/lights/environment.cc"
#include "hwy/cache_control.h"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/lights/environment-inl.h"
#include "kernels/lights/search_tree-inl.h"
#include "kernels/simd/sphere-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Returns the weights of packed texels without their solid angle. With kAbove only the luminance
// above `base` counts.
template <bool kAbove>
HWY_INLINE VF WeighTexels(VU packed, float base) {
  // Mantissas stay in their place in the words, and the weights of the channels make up for it:
  // powers of two do not change the rounding.
  const VU mantissa = SetU((1u << kMantissaBits) - 1);
  const float unit = 1.0f / (1 << kMantissaBits);
  const auto channel = [&](VU mask) HWY_ATTR { return ToFloat(hn::And(packed, mask)); };
  const V3 rgb = {channel(mantissa), channel(hn::ShiftLeft<kMantissaBits>(mantissa)),
                  channel(hn::ShiftLeft<2 * kMantissaBits>(mantissa))};
  const V3 weights = {Set(kLuminance[0]), Set(kLuminance[1] * unit),
                      Set(kLuminance[2] * unit * unit)};
  const VF luminance = Dot(rgb, weights) * PowerOf(packed);
  return kAbove ? hn::Max(luminance - base, hn::Zero(F())) : luminance;
}
HWY_INLINE VF WeighTexels(VU packed, float base) {
  return base != 0 ? WeighTexels<true>(packed, base) : WeighTexels<false>(packed, base);
}

// These are the parts of the lines that the rows of a chunk read.
constexpr std::uint32_t kHalfTexels = kLineTexels / 2;
struct LineRows {
  alignas(64) float header[kChunk][4];     // TexelLine::density, left; RowArea::start, step
  alignas(64) std::uint32_t half[kChunk];  // half of the texels, 0 or 1
  // One unused word and the texels of that half, in two parts of four words.
  alignas(64) PackedRadiance words[2][kChunk][4];
};
static_assert(kHalfTexels == 7);

struct TexelPick {
  VU packed, texel;  // the texel, and its number in its half of the line
  VF weight;
  VF x;  // position inside, in [0, 1)
};

// Picks the texels at positions x of the weights in half lines of rows i and on; the first `used`
// texels of a half are in the map. The sum loses a texel that weighs 2^-24 of those before it: it
// is drawn too rarely, and no more light than that is lost.
template <bool kAbove>
HWY_INLINE TexelPick PickTexels(const LineRows& lines, std::uint32_t i, VU used, float base, VF x) {
  const VF below_one = Set(0x1.fffffep-1f);
  VU texel[kHalfTexels + 1];  // counted from 1
  hn::LoadInterleaved4(U(), lines.words[0][i], texel[0], texel[1], texel[2], texel[3]);
  hn::LoadInterleaved4(U(), lines.words[1][i], texel[4], texel[5], texel[6], texel[7]);
  VF weight[kHalfTexels + 1], end[kHalfTexels + 1];
  for (std::uint32_t k = 1; k <= kHalfTexels; ++k) {
    weight[k] = WeighTexels<kAbove>(texel[k], base);
    if (kAbove) {
      const MF inside = hn::RebindMask(F(), hn::Lt(SetU(k - 1), used));
      weight[k] = hn::IfThenElseZero(inside, weight[k]);
    }
    end[k] = k == 1 ? weight[1] : end[k - 1] + weight[k];
  }
  const VF total = end[kHalfTexels];
  // The target stays below the end even after rounding, so that the texel found has a weight.
  const VF target = hn::Min(x * total, total * below_one);
  TexelPick pick = {texel[1], hn::Zero(U()), weight[1], hn::Zero(F())};
  VF begin = hn::Zero(F());
  for (std::uint32_t k = 2; k <= kHalfTexels; ++k) {
    const MF behind = hn::Ge(target, end[k - 1]);
    const MU behind_u = hn::RebindMask(U(), behind);
    pick.packed = IfThen(behind_u, texel[k], pick.packed);
    pick.texel = IfThen(behind_u, SetU(k - 1), pick.texel);
    pick.weight = IfThen(behind, weight[k], pick.weight);
    begin = IfThen(behind, end[k - 1], begin);
  }
  pick.x = hn::Min((target - begin) / pick.weight, below_one);
  return pick;
}

struct LineHeaders {
  VF density, left;
  RowAreas area;
};
HWY_INLINE LineHeaders LoadHeaders(const LineRows& lines, std::uint32_t i) {
  LineHeaders h;
  hn::LoadInterleaved4(F(), lines.header[i], h.density, h.left, h.area.start, h.area.step);
  return h;
}

// Reads lines line[0, rows) of an inversion in rows row[] of the map, and the halves of their
// texels on which positions x fall; x become positions in the halves.
HWY_INLINE void ReadLines(const TexelLine* texels, const RowArea* areas, const std::uint32_t* row,
                          const std::uint32_t* line, std::uint32_t rows, float* x, LineRows& read) {
  for (std::uint32_t i = 0; i < rows; ++i) {
    std::memcpy(read.header[i], &texels[line[i]], 2 * sizeof(float));
    std::memcpy(read.header[i] + 2, &areas[row[i]], 2 * sizeof(float));
  }
  for (std::uint32_t i = 0; i < rows; i += hn::Lanes(F())) {
    const VF left = LoadHeaders(read, i).left;
    const VF at = Load(x + i);
    const MF behind = hn::Ge(at, left);
    const VF start = hn::IfThenElseZero(behind, left);
    const VF length = IfThen(behind, 1.0f - left, left);
    Store((at - start) / length, x + i);
    Store(hn::IfThenElseZero(hn::RebindMask(U(), behind), SetU(1)), read.half + i);
  }
  for (std::uint32_t i = 0; i < rows; ++i) {
    // The words begin one before the half.
    const std::uint32_t* const words =
        Words(texels + line[i]) + kLineWords - kLineTexels - 1 + read.half[i] * kHalfTexels;
    std::memcpy(read.words[0][i], words, sizeof read.words[0][i]);
    std::memcpy(read.words[1][i], words + 4, sizeof read.words[1][i]);
  }
}

template <bool kAbove>
void SampleLines(const EnvironmentView& map, const InversionView& inversion,
                 const UniformColumns& uniforms, std::uint32_t n, float samples,
                 const LightColumns& out) {
  SearchColumns down, across;
  alignas(64) std::uint32_t line[kChunk];
  LineRows lines;
  for (std::uint32_t begin = 0; begin < n; begin += kChunk) {
    const std::uint32_t rows = std::min(kChunk, n - begin);
    Search(inversion.rows, uniforms.v + begin, rows, down);
    Search(inversion.lines, down.item, uniforms.u + begin, rows, across,
           [&](std::uint32_t i, std::uint32_t item) {
             line[i] = down.item[i] * map.lines + item;
             hwy::Prefetch(inversion.texels + line[i]);
           });
    ReadLines(inversion.texels, map.row_area, down.item, line, rows, across.x, lines);
    for (std::uint32_t i = 0; i < rows; i += hn::Lanes(F())) {
      const VU first =
          Load(across.item + i) * SetU(kLineTexels) + Load(lines.half + i) * SetU(kHalfTexels);
      const TexelPick pick =
          PickTexels<kAbove>(lines, i, SetU(map.width) - first, inversion.base, Load(across.x + i));
      // Rows beyond the last are unspecified; the mask keeps the gathers inside the tables.
      const MU inside = RowsBelow(i, rows);
      const VU row = hn::IfThenElseZero(inside, Load(down.item + i));
      const VU column = hn::IfThenElseZero(inside, first + pick.texel);
      const V3 radiance = inversion.texels == map.texels
                              ? UnpackRadiance(pick.packed, map.radiance_unit)
                              : FetchTexels(map, column, row);
      const LineHeaders header = LoadHeaders(lines, i);
      EmitTexels(map, column, row, header.area, pick.x, Load(down.x + i), radiance,
                 header.density * pick.weight * samples, out, begin + i);
    }
  }
}

void SampleTexels(const EnvironmentView& map, const InversionView& inversion,
                  const UniformColumns& uniforms, std::uint32_t n, float samples,
                  const LightColumns& out) {
  if (inversion.base != 0) {
    SampleLines<true>(map, inversion, uniforms, n, samples, out);
  } else {
    SampleLines<false>(map, inversion, uniforms, n, samples, out);
  }
}

// These are the positions of a chunk of directions on the map.
struct LookupColumns {
  alignas(64) float u[kChunk], v[kChunk];
  alignas(64) std::uint32_t texel[kChunk];  // row-major
  alignas(64) std::uint32_t word[kChunk];   // index into the map's lines
};

// Finds the texels of directions [0, rows) and prefetches them: by the time all are found the first
// have arrived.
HWY_INLINE void FindTexels(const EnvironmentView& map, const TexelDensity& density, const float* x,
                           const float* y, const float* z, std::uint32_t rows,
                           LookupColumns& lookup) {
  for (std::uint32_t i = 0; i < rows; i += hn::Lanes(F())) {
    const MF inside = hn::RebindMask(F(), RowsBelow(i, rows));
    // Rows beyond the last look along +z.
    const V3 dir =
        IfThen(inside, Load3(x + i, y + i, z + i), V3{hn::Zero(F()), hn::Zero(F()), Set(1.0f)});
    VF u, v;
    MapPosition(map, dir, u, v);
    const VU column = CellOf(u, map.width), row = CellOf(v, map.height);
    Store(u, lookup.u + i), Store(v, lookup.v + i);
    Store(row * SetU(map.width) + column, lookup.texel + i);
    Store(WordOf(map, column, row), lookup.word + i);
  }
  for (std::uint32_t i = 0; i < rows; ++i) hwy::Prefetch(Words(map.texels) + lookup.word[i]);
  if (density.table != nullptr) {
    for (std::uint32_t i = 0; i < rows; ++i) hwy::Prefetch(density.table + lookup.texel[i]);
  }
}

// Returns the density of texels; `packed` is their packed form in the map.
HWY_INLINE VF DensityOf(const EnvironmentView& map, const TexelDensity& density, float samples,
                        VU texel, VU word, VU packed) {
  VF sum = hn::Zero(F());
  if (density.inversion != nullptr) {
    const InversionView& inversion = *density.inversion;
    const std::uint32_t* const words = Words(inversion.texels);
    if (inversion.texels != map.texels) packed = Gather(words, word);
    const VU line = hn::And(word, SetU(~(kLineWords - 1)));
    sum = AsFloat(Gather(words, line)) * WeighTexels(packed, inversion.base);
  } else if (density.table != nullptr) {
    sum = Gather(density.table, texel);
  }
  sum = sum * samples;
  return density.fixed == nullptr ? sum : sum + Gather(density.fixed, texel);
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
        const VU word = Load(lookup.word + i);
        const VU packed = Gather(Words(map.texels), word);
        radiance = UnpackRadiance(packed, map.radiance_unit);
        light_pdf = DensityOf(map, density, samples, Load(lookup.texel + i), word, packed);
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
      const VU packed = Gather(Words(map.texels), Load(lookup.word + i));
      Store3(UnpackRadiance(packed, map.radiance_unit), out.r + to, out.g + to, out.b + to);
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
    Store(local.z * (kInvPi * samples), out.pdf + i);
  }
}

void CosineDensity(const SurfaceColumns& surfaces, std::uint32_t n, float samples,
                   const EscapeColumns& rows) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU from = hn::IfThenElseZero(RowsBelow(i, n), Load(rows.from + i));
    const V3 ns = {Gather(surfaces.ns_x, from), Gather(surfaces.ns_y, from),
                   Gather(surfaces.ns_z, from)};
    const VF cosine = Dot(ns, Load3(rows.dir_x + i, rows.dir_y + i, rows.dir_z + i));
    Store(hn::Max(cosine, hn::Zero(F())) * (kInvPi * samples), rows.light_pdf + i);
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
