// Varying::kLayers: what the textures of layered metallic-roughness say, as the bytes of four
// columns, lowest first.
//
//   varying_0  roughness, metallic, coat roughness, sheen roughness
//   varying_1  square root of the factor of the sheen: red, green, blue; turn of the grain, low
//              byte
//   varying_2  square root of that of the specular colour, likewise; specular
//   varying_3  film, thickness of the film, anisotropy; turn of the grain, high byte
//
// Glass has varying_2 and the first two bytes of varying_3 as well (BsdfTraits::glass_layers).
//
// Images have bytes, too, but for colours, whose square roots lose no more by being held so than by
// sRGB. Factors, which every surface of a material shares, stand in its record and lose nothing.
// The turn is that of FacetTurn.
#if defined(SKYWAVE_KERNELS_LAYERS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_LAYERS_INL_H_
#undef SKYWAVE_KERNELS_LAYERS_INL_H_
#else
#define SKYWAVE_KERNELS_LAYERS_INL_H_
#endif

#include "kernels/surface/facet_turn-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Returns a number in [0, 1] as a byte.
HWY_INLINE VU ByteOf(VF share) { return ToUnsigned(Clamp(share, 0.0f, 1.0f) * 255.0f + 0.5f); }
HWY_INLINE VF Bytes(VU b0, VU b1, VU b2, VU b3) {
  const VU low = hn::Or(b0, hn::ShiftLeft<8>(b1));
  return AsFloat(hn::Or(low, hn::ShiftLeft<16>(hn::Or(b2, hn::ShiftLeft<8>(b3)))));
}
// Returns byte k of a column as a number in [0, 1].
template <int k>
HWY_INLINE VF Share(VF column) {
  return ToFloat(hn::And(hn::ShiftRight<8 * k>(AsBits(column)), SetU(255))) * (1.0f / 255);
}
// Returns the colour whose roots are the lowest three bytes of a column.
HWY_INLINE V3 ColorOfRoots(VF column) {
  const VF r = Share<0>(column), g = Share<1>(column), b = Share<2>(column);
  return {r * r, g * g, b * b};
}

// Returns the last bytes of varying_1 and varying_3 for the tangent of a FacetTurn.
HWY_INLINE VU LowTurn(VF packed) { return hn::And(AsBits(packed), SetU(255)); }
HWY_INLINE VU HighTurn(VF packed) { return hn::And(hn::ShiftRight<8>(AsBits(packed)), SetU(255)); }
HWY_INLINE FacetTurn TurnOfLayers(VF varying_1, VF varying_3) {
  const VU low = hn::ShiftRight<24>(AsBits(varying_1));
  const VU high = hn::ShiftRight<24>(AsBits(varying_3));
  return UnpackFacetTurn(AsFloat(hn::Or(low, hn::ShiftLeft<8>(high))));
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
