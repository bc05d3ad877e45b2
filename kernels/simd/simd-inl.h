// Every kernel file shares this: vector types, three-vectors, row compression, bit tricks. It is
// included once per instruction set, from inside foreach_target.
//
// Every lane of every target computes the same bits: no fused multiply-add, no approximate
// reciprocal, no library function whose rounding could differ. So images do not depend on the
// instruction set that the kernels run on.
#if defined(SKYWAVE_KERNELS_SIMD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_SIMD_INL_H_
#undef SKYWAVE_KERNELS_SIMD_INL_H_
#else
#define SKYWAVE_KERNELS_SIMD_INL_H_
#endif

#include <cstdint>

#include "hwy/highway.h"
#include "kernels/columns.h"
#include "kernels/simd/compress_table.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, kPadRows>;
using U = hn::CappedTag<std::uint32_t, kPadRows>;
using I = hn::CappedTag<std::int32_t, kPadRows>;
using VF = hn::Vec<F>;
using VU = hn::Vec<U>;
using VI = hn::Vec<I>;
using MF = hn::Mask<F>;
using MU = hn::Mask<U>;

// All functions that return vectors carry the target's attributes through HWY_BEFORE_NAMESPACE.

HWY_INLINE VF Set(float value) { return hn::Set(F(), value); }
HWY_INLINE VU SetU(std::uint32_t value) { return hn::Set(U(), value); }
HWY_INLINE VF Load(const float* from) { return hn::LoadU(F(), from); }
HWY_INLINE VU Load(const std::uint32_t* from) { return hn::LoadU(U(), from); }
HWY_INLINE void Store(VF value, float* to) { hn::StoreU(value, F(), to); }
HWY_INLINE void Store(VU value, std::uint32_t* to) { hn::StoreU(value, U(), to); }

// Selects the lanes i with row + i < n.
HWY_INLINE MU RowsBelow(std::uint32_t row, std::uint32_t n) { return hn::FirstN(U(), n - row); }
// Stores only the lanes of rows below n, for in-place work on a slice that is followed by the rows
// of another BSDF.
HWY_INLINE void StoreBelow(VF value, float* to, std::uint32_t row, std::uint32_t n) {
  if (row + hn::Lanes(F()) > n) {
    const MF inside = hn::RebindMask(F(), RowsBelow(row, n));
    value = hn::IfThenElse(inside, value, Load(to + row));
  }
  Store(value, to + row);
}

HWY_INLINE VF AsFloat(VU bits) { return hn::BitCast(F(), bits); }
HWY_INLINE VU AsBits(VF value) { return hn::BitCast(U(), value); }
HWY_INLINE VI AsInt(VU value) { return hn::BitCast(I(), value); }
// Values have to be below 2^31; from 2^24 on they are rounded.
HWY_INLINE VF ToFloat(VU value) { return hn::ConvertTo(F(), AsInt(value)); }
// Truncates values in [0, 2^31).
HWY_INLINE VU ToUnsigned(VF value) { return hn::BitCast(U(), hn::ConvertTo(I(), value)); }

// Gathers base[index] from float and uint32 tables; indices are below 2^31.
HWY_INLINE VF Gather(const float* base, VU index) {
  return hn::GatherIndex(F(), base, AsInt(index));
}
HWY_INLINE VU Gather(const std::uint32_t* base, VU index) {
  return hn::GatherIndex(U(), base, AsInt(index));
}

HWY_INLINE VF Clamp(VF value, float low, float high) {
  return hn::Min(hn::Max(value, Set(low)), Set(high));
}
// Returns sqrt(max(value, 0)), for differences that rounding may push below zero.
HWY_INLINE VF SafeSqrt(VF value) { return hn::Sqrt(hn::Max(value, hn::Zero(F()))); }
HWY_INLINE VF IfThen(MF mask, VF yes, VF no) { return hn::IfThenElse(mask, yes, no); }
HWY_INLINE VU IfThen(MU mask, VU yes, VU no) { return hn::IfThenElse(mask, yes, no); }

// Highway has + - * / of two vectors; with these, kernels are written as formulas.
HWY_INLINE VF operator-(VF a) { return hn::Neg(a); }
HWY_INLINE VF operator+(VF a, float b) { return a + Set(b); }
HWY_INLINE VF operator+(float a, VF b) { return Set(a) + b; }
HWY_INLINE VF operator-(VF a, float b) { return a - Set(b); }
HWY_INLINE VF operator-(float a, VF b) { return Set(a) - b; }
HWY_INLINE VF operator*(VF a, float b) { return a * Set(b); }
HWY_INLINE VF operator*(float a, VF b) { return Set(a) * b; }
HWY_INLINE VF operator/(VF a, float b) { return a / Set(b); }
HWY_INLINE VF operator/(float a, VF b) { return Set(a) / b; }

struct V3 {
  VF x, y, z;
};

HWY_INLINE V3 Load3(const float* x, const float* y, const float* z) {
  return {Load(x), Load(y), Load(z)};
}
HWY_INLINE void Store3(const V3& value, float* x, float* y, float* z) {
  Store(value.x, x), Store(value.y, y), Store(value.z, z);
}
HWY_INLINE V3 Set3(const float* values) { return {Set(values[0]), Set(values[1]), Set(values[2])}; }
HWY_INLINE V3 operator+(const V3& a, const V3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
HWY_INLINE V3 operator-(const V3& a, const V3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
HWY_INLINE V3 operator*(const V3& a, const V3& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
HWY_INLINE V3 operator*(const V3& a, VF s) { return {a.x * s, a.y * s, a.z * s}; }
HWY_INLINE V3 operator*(const V3& a, float s) { return a * Set(s); }
HWY_INLINE V3 operator-(const V3& a) { return {-a.x, -a.y, -a.z}; }
HWY_INLINE VF Dot(const V3& a, const V3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
HWY_INLINE V3 Cross(const V3& a, const V3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
HWY_INLINE V3 IfThen(MF mask, const V3& yes, const V3& no) {
  return {IfThen(mask, yes.x, no.x), IfThen(mask, yes.y, no.y), IfThen(mask, yes.z, no.z)};
}
HWY_INLINE V3 Splat(VF value) { return {value, value, value}; }
// These return what lies between two values, the second of which has this share.
HWY_INLINE VF Mix(VF a, VF b, VF share) { return a + share * (b - a); }
HWY_INLINE V3 Mix(const V3& a, const V3& b, VF share) { return a + (b - a) * share; }
HWY_INLINE V3 Normalize(const V3& a) { return a * (1.0f / hn::Sqrt(Dot(a, a))); }
HWY_INLINE VF MaxComponent(const V3& a) { return hn::Max(hn::Max(a.x, a.y), a.z); }

// Two unit vectors s and t complete the unit vector n to a right-handed frame (Duff et al. 2017).
struct Frame {
  V3 s, t, n;
};
HWY_INLINE Frame MakeFrame(const V3& n) {
  const VF sign = hn::CopySign(Set(1.0f), n.z);
  const VF a = -1.0f / (sign + n.z);
  const VF b = n.x * n.y * a;
  const VF sign_x = sign * n.x;
  return {{1.0f + sign_x * n.x * a, sign * b, -sign_x}, {b, sign + n.y * n.y * a, -n.y}, n};
}
HWY_INLINE V3 ToLocal(const Frame& frame, const V3& w) {
  return {Dot(frame.s, w), Dot(frame.t, w), Dot(frame.n, w)};
}
HWY_INLINE V3 ToWorld(const Frame& frame, const V3& w) {
  return frame.s * w.x + frame.t * w.y + frame.n * w.z;
}

// Moves the lanes of `mask` to the front, in order; the lanes after them are unspecified. It is
// built once per vector of rows and applied to every column: a stable compaction at the price of
// one permutation each. (Highway 1.0.3's own Compress copies its table to the stack under g++ 12
// below AVX-512.)
class RowCompressor {
 public:
  HWY_INLINE explicit RowCompressor(MU mask)
      : count_(static_cast<std::uint32_t>(hn::CountTrue(U(), mask))) {
#if HWY_TARGET <= HWY_AVX3
    mask_ = mask;
#elif HWY_TARGET != HWY_SCALAR
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(U(), mask, bits);
    indices_ = hn::LoadU(U(), kCompressTable[bits[0]]);
#endif
  }
  std::uint32_t count() const { return count_; }
  // Appends the selected lanes of from[0..] at `to`; writes a whole vector.
  template <class T>
  HWY_INLINE void Move(const T* from, T* to) const {
    Append(Load(from), to);
  }
  template <class V, class T>
  HWY_INLINE void Append(V value, T* to) const {
#if HWY_TARGET == HWY_SCALAR
    if (count_ != 0) Store(value, to);
#elif HWY_TARGET <= HWY_AVX3
    const VU bits = hn::BitCast(U(), value);
    hn::StoreU(hn::BitCast(hn::DFromV<V>(), hn::Compress(bits, mask_)), hn::DFromV<V>(), to);
#else
    const VU bits = hn::BitCast(U(), value);
    const auto moved = hn::TableLookupLanes(bits, hn::IndicesFromVec(U(), indices_));
    hn::StoreU(hn::BitCast(hn::DFromV<V>(), moved), hn::DFromV<V>(), to);
#endif
  }

 private:
  std::uint32_t count_;
#if HWY_TARGET <= HWY_AVX3
  MU mask_;
#elif HWY_TARGET != HWY_SCALAR
  VU indices_;
#endif
};

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
