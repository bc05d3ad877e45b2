#include "kernels/sampler.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/sampler.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/simd/math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Applies an Owen scramble to a bit-reversed word: every bit is flipped by a hash of the bits below
// it (Laine and Karras 2011 in the form of Burley 2020; constants of Vegdahl 2021, who searched for
// the least correlation between neighbouring bits).
HWY_INLINE VU ScrambleReversed(VU x, VU seed) {
  x = hn::Xor(x, x * SetU(0x3d20adeau));
  x = x + seed;
  x = x * hn::Or(hn::ShiftRight<16>(seed), SetU(1));
  x = hn::Xor(x, x * SetU(0x05526c56u));
  return hn::Xor(x, x * SetU(0x53a22864u));
}

// Returns the bit-reversed second Sobol' coordinate of index x. Its generator matrix is Pascal's
// triangle modulo 2: bit k is the parity of all bits j of x whose position contains k's, a superset
// sum that five butterfly steps compute.
HWY_INLINE VU SecondSobolReversed(VU x) {
  x = hn::Xor(x, hn::ShiftRight<1>(hn::And(x, SetU(0xAAAAAAAAu))));
  x = hn::Xor(x, hn::ShiftRight<2>(hn::And(x, SetU(0xCCCCCCCCu))));
  x = hn::Xor(x, hn::ShiftRight<4>(hn::And(x, SetU(0xF0F0F0F0u))));
  x = hn::Xor(x, hn::ShiftRight<8>(hn::And(x, SetU(0xFF00FF00u))));
  return hn::Xor(x, hn::ShiftRight<16>(x));
}

// Mixes all bits (Wellons 2018, "lowbias32").
HWY_INLINE VU Mix(VU x) {
  x = hn::Xor(x, hn::ShiftRight<16>(x));
  x = x * SetU(0x7feb352du);
  x = hn::Xor(x, hn::ShiftRight<15>(x));
  x = x * SetU(0x846ca68bu);
  return hn::Xor(x, hn::ShiftRight<16>(x));
}

void DrawUniforms(const PathColumns& paths, const std::uint32_t* rows, std::uint32_t n,
                  std::uint32_t pair, SampleIndexing indexing, const UniformColumns& out) {
  const U d;
  const VU key = SetU(pair * 0x9E3779B9u);
  const VU stride = SetU(indexing.stride), offset = SetU(indexing.offset);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(d)) {
    VU seed, sample;
    if (rows != nullptr) {
      // Rows beyond n are unspecified; the mask keeps the gather inside the table.
      const VU row = hn::IfThenElseZero(RowsBelow(i, n), Load(rows + i));
      if (hn::AllTrue(d, hn::Eq(row, hn::Iota(d, rows[i])))) {
        // Compaction is stable, so most rows that are neighbours here are neighbours in `paths`
        // too.
        seed = Load(paths.seed + rows[i]);
        sample = Load(paths.sample + rows[i]);
      } else {
        seed = Gather(paths.seed, row);
        sample = Gather(paths.sample, row);
      }
    } else {
      seed = Load(paths.seed + i);
      sample = Load(paths.sample + i);
    }
    const VU index = sample * stride + offset;
    const VU base = Mix(hn::Xor(seed, key));
    const VU shuffle_seed = base * SetU(0x85EBCA6Bu);
    const VU u_seed = Mix(base);
    const VU v_seed = hn::Xor(u_seed * SetU(0xC2B2AE35u), hn::ShiftRight<15>(u_seed));
    const VU shuffled = ReverseBits(ScrambleReversed(ReverseBits(index), shuffle_seed));
    const VU u = ReverseBits(ScrambleReversed(shuffled, u_seed));
    const VU v = ReverseBits(ScrambleReversed(SecondSobolReversed(shuffled), v_seed));
    Store(ToUnitFloat(u), out.u + i);
    Store(ToUnitFloat(v), out.v + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(DrawUniforms);

void DrawUniforms(const PathColumns& paths, const std::uint32_t* rows, std::uint32_t n,
                  std::uint32_t pair, SampleIndexing indexing, const UniformColumns& out) {
  HWY_DYNAMIC_DISPATCH(DrawUniforms)(paths, rows, n, pair, indexing, out);
}

std::uint32_t PixelSeed(std::uint32_t x, std::uint32_t y, std::uint32_t frame_seed) {
  const auto mix = [](std::uint32_t h) {
    h ^= h >> 16;
    h *= 0x7feb352du;
    h ^= h >> 15;
    h *= 0x846ca68bu;
    return h ^ h >> 16;
  };
  return mix(mix(mix(x + 0x9E3779B9u) ^ y) ^ frame_seed);
}

}  // namespace skywave
#endif  // HWY_ONCE
