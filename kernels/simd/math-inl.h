// These are elementary functions on vectors of floats: polynomials evaluated with plain
// multiplications and additions, so that every target gives the same bits.
#if defined(SKYWAVE_KERNELS_MATH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_MATH_INL_H_
#undef SKYWAVE_KERNELS_MATH_INL_H_
#else
#define SKYWAVE_KERNELS_MATH_INL_H_
#endif

#include "kernels/simd/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

inline constexpr float kPi = 3.14159265358979f;
inline constexpr float kInvPi = 0.318309886183791f;

// Returns c[0] + c[1] x + ... by Horner's scheme.
template <std::size_t N>
HWY_INLINE VF Polynomial(VF x, const float (&c)[N]) {
  VF sum = Set(c[N - 1]);
  for (std::size_t i = N - 1; i-- > 0;) sum = sum * x + c[i];
  return sum;
}

HWY_INLINE VF Power5(VF x) {
  const VF x2 = x * x;
  return x2 * x2 * x;
}

// Computes sin and cos of 2 pi t for t in [0, 1]: the turn is split exactly into quarters, and the
// rest is a Taylor polynomial in [-pi/4, pi/4]. The error is below 2e-7.
HWY_INLINE void SinCosTurn(VF t, VF& sine, VF& cosine) {
  const VF quarters = t * 4.0f;
  const VF nearest = hn::Round(quarters);
  const VF x = (quarters - nearest) * (0.5f * kPi);
  const VF x2 = x * x;
  const VF s = x * Polynomial(x2, {1.0f, -1.0f / 6, 1.0f / 120, -1.0f / 5040, 1.0f / 362880});
  const VF c = Polynomial(x2, {1.0f, -0.5f, 1.0f / 24, -1.0f / 720, 1.0f / 40320});
  const VU quadrant = ToUnsigned(nearest);
  const MF swap = hn::RebindMask(F(), hn::TestBit(quadrant, SetU(1)));
  const VF sine_sign = AsFloat(hn::ShiftLeft<30>(hn::And(quadrant, SetU(2))));
  const VF cosine_sign = AsFloat(hn::ShiftLeft<30>(hn::And(quadrant + SetU(1), SetU(2))));
  sine = hn::Xor(IfThen(swap, c, s), sine_sign);
  cosine = hn::Xor(IfThen(swap, s, c), cosine_sign);
}

// Returns atan2(y, x) / (2 pi) in [-1/2, 1/2], and 0 for (0, 0). The ratio is brought below
// tan(pi/8) by atan(q) = pi/4 + atan((q - 1) / (q + 1)), which needs only one division. The error
// is below 3e-8 turns.
HWY_INLINE VF Atan2Turn(VF y, VF x) {
  const VF ax = hn::Abs(x), ay = hn::Abs(y);
  const VF low = hn::Min(ax, ay), high = hn::Max(ax, ay);
  const MF shift = hn::Gt(low, high * 0.41421356f);
  const VF numerator = IfThen(shift, low - high, low);
  const VF denominator = IfThen(shift, low + high, high);
  const VF q = numerator / hn::Max(denominator, Set(1e-37f));
  const VF q2 = q * q;
  // This is atan(q) / (2 pi q), interpolated at the Chebyshev nodes of [0, tan(pi/8)].
  const VF series = Polynomial(q2, {0.1591549430f, -0.05305160562f, 0.03182809684f, -0.02266292012f,
                                    0.01682240504f, -0.009591162693f});
  VF turn = q * series;
  turn = IfThen(shift, turn + 0.125f, turn);
  turn = IfThen(hn::Gt(ay, ax), 0.25f - turn, turn);
  turn = IfThen(hn::Lt(x, hn::Zero(F())), 0.5f - turn, turn);
  return hn::CopySign(turn, y);
}

// Reverses the bits of every lane.
HWY_INLINE VU ReverseBits(VU v) {
#if HWY_TARGET == HWY_SCALAR
  const VU m1 = SetU(0x55555555u), m2 = SetU(0x33333333u), m4 = SetU(0x0F0F0F0Fu),
           m8 = SetU(0x00FF00FFu);
  v = hn::Or(hn::And(hn::ShiftRight<1>(v), m1), hn::ShiftLeft<1>(hn::And(v, m1)));
  v = hn::Or(hn::And(hn::ShiftRight<2>(v), m2), hn::ShiftLeft<2>(hn::And(v, m2)));
  v = hn::Or(hn::And(hn::ShiftRight<4>(v), m4), hn::ShiftLeft<4>(hn::And(v, m4)));
  v = hn::Or(hn::And(hn::ShiftRight<8>(v), m8), hn::ShiftLeft<8>(hn::And(v, m8)));
  return hn::RotateRight<16>(v);
#else
  // Tables of sixteen bytes reverse the nibbles; then the bytes of each lane are reversed.
  alignas(16) static constexpr std::uint8_t kLow[16] = {0x00, 0x80, 0x40, 0xC0, 0x20, 0xA0,
                                                        0x60, 0xE0, 0x10, 0x90, 0x50, 0xD0,
                                                        0x30, 0xB0, 0x70, 0xF0};
  alignas(16) static constexpr std::uint8_t kHigh[16] = {0x0, 0x8, 0x4, 0xC, 0x2, 0xA, 0x6, 0xE,
                                                         0x1, 0x9, 0x5, 0xD, 0x3, 0xB, 0x7, 0xF};
  alignas(16) static constexpr std::uint8_t kOrder[16] = {3,  2,  1, 0, 7,  6,  5,  4,
                                                          11, 10, 9, 8, 15, 14, 13, 12};
  const hn::Repartition<std::uint8_t, U> bytes;
  const auto nibble = hn::Set(bytes, std::uint8_t{0x0F});
  const auto b = hn::BitCast(bytes, v);
  const auto low = hn::TableLookupBytes(hn::LoadDup128(bytes, kLow), hn::And(b, nibble));
  const auto shifted = hn::BitCast(bytes, hn::ShiftRight<4>(v));
  const auto high = hn::TableLookupBytes(hn::LoadDup128(bytes, kHigh), hn::And(shifted, nibble));
  return hn::BitCast(U(), hn::TableLookupBytes(hn::Or(low, high), hn::LoadDup128(bytes, kOrder)));
#endif
}

// Maps 32 random bits to [0, 1) by the top 24, which a float holds exactly.
HWY_INLINE VF ToUnitFloat(VU bits) { return ToFloat(hn::ShiftRight<8>(bits)) * (0x1p-24f); }

// Returns the unit vector of a TriangleRecord normal: two's complement 16-bit octahedral
// coordinates, x in the low half (Cigolle et al. 2014). EncodeNormal is its inverse, as is
// that of kernels/surface/surface.h.
HWY_INLINE V3 DecodeNormal(VU packed) {
  const VF scale = Set(1.0f / 32767.0f);
  const VI bits = AsInt(packed);
  const VF x = hn::ConvertTo(F(), hn::ShiftRight<16>(hn::ShiftLeft<16>(bits))) * scale;
  const VF y = hn::ConvertTo(F(), hn::ShiftRight<16>(bits)) * scale;
  const VF z = 1.0f - hn::Abs(x) - hn::Abs(y);
  const VF fold = hn::Max(-z, hn::Zero(F()));  // the lower half is mirrored at the diagonals
  return Normalize({x - hn::CopySign(fold, x), y - hn::CopySign(fold, y), z});
}
HWY_INLINE VU EncodeNormal(const V3& n) {
  const VF one = Set(1.0f), over = one / (hn::Abs(n.x) + hn::Abs(n.y) + hn::Abs(n.z));
  const VF x = n.x * over, y = n.y * over;
  const MF folded = hn::Lt(n.z, hn::Zero(F()));
  const auto quantize = [](VF value) HWY_ATTR {
    return hn::BitCast(U(), hn::NearestInt(value * Set(32767.0f)));
  };
  const VU low = quantize(IfThen(folded, hn::CopySign(one - hn::Abs(y), x), x));
  const VU high = quantize(IfThen(folded, hn::CopySign(one - hn::Abs(x), y), y));
  return hn::Or(hn::And(low, SetU(0xFFFF)), hn::ShiftLeft<16>(high));
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
