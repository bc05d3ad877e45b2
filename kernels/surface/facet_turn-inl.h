// The tangent of a surface whose facets have two widths, and the width across it, in one word.
#if defined(SKYWAVE_KERNELS_FACET_TURN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_FACET_TURN_INL_H_
#undef SKYWAVE_KERNELS_FACET_TURN_INL_H_
#else
#define SKYWAVE_KERNELS_FACET_TURN_INL_H_
#endif

#include "kernels/simd/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Facets look the same after half a turn, so that the sine s of the tangent stands for the whole
// angle, held as s / (|c| + |s|) in the lower 16 bits; the upper ones hold the square root of the
// width.
struct FacetTurn {
  // Of the angle from the first axis of the shading frame to the tangent; where the surface is seen
  // from behind, of the opposite angle. The frames of a normal and of its opposite share the first
  // axis (Duff et al. 2017), so that a surface that is turned over keeps its word.
  VF cosine, sine;
  VF across;  // 0: there is one width, and the tangent means nothing
};

HWY_INLINE VF PackFacetTurn(const FacetTurn& turn) {
  const VF half = Set(0.5f), steps = Set(65535.0f);
  const VF sum = hn::Max(hn::Abs(turn.cosine) + hn::Abs(turn.sine), Set(1e-20f));
  const VF sine = hn::CopySign(turn.sine, turn.sine * turn.cosine) / sum;
  const VF place = (Clamp(sine, -1.0f, 1.0f) + 1.0f) * half;
  const VF root = hn::Sqrt(Clamp(turn.across, 0.0f, 1.0f));
  const auto whole = [&](VF share) HWY_ATTR { return ToUnsigned(share * steps + half); };
  return AsFloat(hn::Or(whole(place), hn::ShiftLeft<16>(whole(root))));
}

HWY_INLINE FacetTurn UnpackFacetTurn(VF packed) {
  const VU word = AsBits(packed);
  const VF one = Set(1.0f), step = Set(1.0f / 65535);
  const VF place = ToFloat(hn::And(word, SetU(65535))) * step;
  const VF root = ToFloat(hn::ShiftRight<16>(word)) * step;
  const VF s = place + place - one, c = one - hn::Abs(s);
  const VF over = one / hn::Sqrt(s * s + c * c);
  return {c * over, s * over, root * root};
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
