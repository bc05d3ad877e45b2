// These are powers, logarithms and the error function on vectors of floats. They keep the promise
// of math-inl.h: plain arithmetic, the same bits on every target.
#if defined(SKYWAVE_KERNELS_EXP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_EXP_INL_H_
#undef SKYWAVE_KERNELS_EXP_INL_H_
#else
#define SKYWAVE_KERNELS_EXP_INL_H_
#endif

#include "kernels/simd/math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Returns log2 of a normal x > 0: x = m 2^e with m in [sqrt(1/2), sqrt(2)), and log2(m) by the
// series of the inverse hyperbolic tangent. The relative error is below 3e-7, near x = 1 too.
HWY_INLINE VF Log2(VF x) {
  const VU bits = AsBits(x), shifted = bits - SetU(0x3F3504F3u);
  const VI exponent = hn::ShiftRight<23>(AsInt(shifted));
  const VU scale = hn::ShiftLeft<23>(hn::BitCast(U(), exponent));
  const VF m = AsFloat(bits - scale);
  const VF t = (m - 1.0f) / (m + 1.0f), t2 = t * t;
  constexpr float kTwoLog2E = 2.88539008177793f;
  const VF series =
      Polynomial(t2, {kTwoLog2E, kTwoLog2E / 3, kTwoLog2E / 5, kTwoLog2E / 7, kTwoLog2E / 9});
  return hn::ConvertTo(F(), exponent) + t * series;
}

// Returns 2^x for x clamped to [-126, 126], the fraction by a Taylor series. The relative error is
// below 2e-7.
HWY_INLINE VF Exp2(VF x) {
  x = Clamp(x, -126.0f, 126.0f);
  const VF whole = hn::Round(x);
  const VF t = (x - whole) * 0.693147180559945f;
  const VF fraction = Polynomial(
      t, {1.0f, 1.0f, 1.0f / 2, 1.0f / 6, 1.0f / 24, 1.0f / 120, 1.0f / 720, 1.0f / 5040});
  const VI exponent = hn::ConvertTo(I(), whole) + hn::Set(I(), 127);
  return fraction * AsFloat(hn::BitCast(U(), hn::ShiftLeft<23>(exponent)));
}

HWY_INLINE VF Exp(VF x) { return Exp2(x * 1.44269504088896f); }
HWY_INLINE VF Log(VF x) { return Log2(x) * 0.693147180559945f; }
// Returns x^y for x >= 0; 0^y is 0 except for rounding.
HWY_INLINE VF Pow(VF x, VF y) { return Exp2(y * Log2(hn::Max(x, Set(1e-37f)))); }

// Returns erf(x) by Abramowitz and Stegun 7.1.26, given exp(-x^2), which callers have. The error is
// at most 2e-7.
HWY_INLINE VF Erf(VF x, VF exp_minus_x2) {
  const VF t = 1.0f / (1.0f + 0.3275911f * hn::Abs(x));
  const VF series =
      t * Polynomial(t, {0.254829592f, -0.284496736f, 1.421413741f, -1.453152027f, 1.061405429f});
  return hn::CopySign(1.0f - series * exp_minus_x2, x);
}

// Returns the inverse of erf for x in (-1, 1) (Giles 2010, "Approximating the erfinv function",
// single precision).
HWY_INLINE VF ErfInverse(VF x) {
  const VF one = Set(1.0f);
  const VF away = hn::Max((one - x) * (one + x), Set(1e-20f));
  const VF w = -Log(away);
  const VF middle = Polynomial(
      w - 2.5f, {1.50140941f, 0.246640727f, -0.00417768164f, -0.00125372503f, 0.00021858087f,
                 -4.39150654e-06f, -3.5233877e-06f, 3.43273939e-07f, 2.81022636e-08f});
  const VF tail = Polynomial(
      SafeSqrt(w) - 3.0f, {2.83297682f, 1.00167406f, 0.00943887047f, -0.0076224613f, 0.00573950773f,
                           -0.00367342844f, 0.00134934322f, 0.000100950558f, -0.000200214257f});
  return x * IfThen(hn::Lt(w, Set(5.0f)), middle, tail);
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
