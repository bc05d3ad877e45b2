// Words that lie together in memory, one record per lane, are loaded record by record and
// transposed, which costs a quarter of a gather for each word (Zen 4, AVX-512).
#if defined(SKYWAVE_KERNELS_RECORDS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_RECORDS_INL_H_
#undef SKYWAVE_KERNELS_RECORDS_INL_H_
#else
#define SKYWAVE_KERNELS_RECORDS_INL_H_
#endif

#include "kernels/simd/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Each vector holds one word of every lane's record.
struct Words4 {
  VU w0, w1, w2, w3;
};

#if HWY_TARGET != HWY_SCALAR

// Loads a vector of the four words at base + first[0], of those at base + first[4], and so on.
template <class D>
HWY_INLINE hn::Vec<D> LoadEveryFourth(D d, const std::uint32_t* base, const std::uint32_t* first) {
  constexpr std::size_t kLanes = hn::MaxLanes(d);
  if constexpr (kLanes == 4) {
    return hn::LoadU(d, base + *first);
  } else {
    const hn::Half<D> half;
    return hn::Combine(d, LoadEveryFourth(half, base, first + kLanes / 2),
                       LoadEveryFourth(half, base, first));
  }
}

// Loads a vector of the pairs at base + first[0] and first[1], then first[4] and first[5], and so
// on.
template <class D>
HWY_INLINE hn::Vec<D> LoadPairs(D d, const float* base, const std::uint32_t* first) {
  constexpr std::size_t kLanes = hn::MaxLanes(d);
  if constexpr (kLanes == 2) {
    return hn::LoadU(d, base + *first);
  } else {
    const hn::Half<D> half;
    constexpr std::size_t kNext = kLanes == 4 ? 1 : kLanes / 2;
    return hn::Combine(d, LoadPairs(half, base, first + kNext), LoadPairs(half, base, first));
  }
}

// Gathers words base[first] to base[first + 3] of each lane.
HWY_INLINE Words4 GatherWords4(const std::uint32_t* base, VU first) {
  alignas(kColumnAlignment) std::uint32_t at[kPadRows];
  Store(first, at);
  const U d;
  // Block k of vector j has the record of lane 4 k + j.
  const VU v0 = LoadEveryFourth(d, base, at), v1 = LoadEveryFourth(d, base, at + 1),
           v2 = LoadEveryFourth(d, base, at + 2), v3 = LoadEveryFourth(d, base, at + 3);
  const VU even_low = hn::InterleaveLower(d, v0, v2), odd_low = hn::InterleaveLower(d, v1, v3);
  const VU even_high = hn::InterleaveUpper(d, v0, v2), odd_high = hn::InterleaveUpper(d, v1, v3);
  return {hn::InterleaveLower(d, even_low, odd_low), hn::InterleaveUpper(d, even_low, odd_low),
          hn::InterleaveLower(d, even_high, odd_high), hn::InterleaveUpper(d, even_high, odd_high)};
}

// Gathers words base[first] and base[first + 1] of each lane.
HWY_INLINE void GatherPairs(const float* base, VU first, VF& low, VF& high) {
  alignas(kColumnAlignment) std::uint32_t at[kPadRows];
  Store(first, at);
  const F d;
  // Block k of the first vector has the pairs of lanes 4 k and 4 k + 1, the second one the others.
  const VF v0 = LoadPairs(d, base, at), v1 = LoadPairs(d, base, at + 2);
  const VF even = hn::InterleaveLower(d, v0, v1), odd = hn::InterleaveUpper(d, v0, v1);
  low = hn::InterleaveLower(d, even, odd);
  high = hn::InterleaveUpper(d, even, odd);
}

#else

HWY_INLINE void GatherPairs(const float* base, VU first, VF& low, VF& high) {
  low = Gather(base, first);
  high = Gather(base, first + SetU(1));
}

HWY_INLINE Words4 GatherWords4(const std::uint32_t* base, VU first) {
  return {Gather(base, first), Gather(base, first + SetU(1)), Gather(base, first + SetU(2)),
          Gather(base, first + SetU(3))};
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
