// A measured BRDF is a table of the MERL database (Matusik et al. 2003; columns.h), constant within
// a bin, times the colour. It is drawn by visible normals of the GGX lobe that resembles it, with
// the probability kSpecularShare, else by the cosine: a table of its own distribution for each wo
// would be larger than the BRDF.
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/measured.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf_kernels-inl.h"
#include "kernels/bsdf/ggx-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct Measured {
  static constexpr MaterialField kSpecularShare = kIor;       // probability of the GGX lobe
  static constexpr MaterialField kTable = kRoughnessTexture;  // index of its first float

  HWY_INLINE Measured(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                      std::uint32_t n)
      : fields(MaterialFields(s, i, n)),
        color(ColorOf(s, i)),
        table(m.measured),
        // Rows beyond the end have material 0, whose BSDF may be another one.
        first(hn::IfThenElseZero(RowsBelow(i, n), IndexField(m, fields, kTable))),
        ggx(Field(m, fields, kAlpha)),
        share(Field(m, fields, kSpecularShare)) {}

  // Returns the bin of a value in [0, 1].
  static HWY_INLINE VU Bin(VF value, std::uint32_t bins) {
    return hn::Min(ToUnsigned(Clamp(value, 0.0f, 1.0f) * float(bins)), SetU(bins - 1));
  }
  HWY_INLINE V3 LookUp(const V3& wi, const V3& h) const {
    // x, y and Dot(wi, h) are wi in the frame of h whose first axis points away from the normal.
    const VF sine = SafeSqrt(h.x * h.x + h.y * h.y);
    const MF upright = hn::Lt(sine, Set(1e-6f));
    const VF over = 1.0f / hn::Max(sine, Set(1e-6f));
    const VF c = IfThen(upright, Set(1.0f), h.x * over);
    const VF s = IfThen(upright, hn::Zero(F()), h.y * over);
    const VF along = c * wi.x + s * wi.y;
    const VF x = along * h.z - wi.z * sine;
    const VF y = c * wi.y - s * wi.x;
    const VF across = hn::Sqrt(x * x + y * y);

    const VF four = Set(4.0f);  // quarter turns
    const VF half = hn::Sqrt(four * Atan2Turn(sine, hn::Max(h.z, hn::Zero(F()))));
    const VF difference = four * Atan2Turn(across, hn::Max(Dot(wi, h), hn::Zero(F())));
    const VF turn = 2.0f * Atan2Turn(y, x);  // half turns; negative: reciprocity
    const VF turned = IfThen(hn::Lt(turn, hn::Zero(F())), turn + 1.0f, turn);
    VU at =
        Bin(half, kMeasuredHalf) * SetU(kMeasuredDifference) + Bin(difference, kMeasuredDifference);
    at = at * SetU(kMeasuredTurn) + Bin(turned, kMeasuredTurn);
    at = first + (at + (at + at));
    return {Gather(table, at), Gather(table, at + SetU(1)), Gather(table, at + SetU(2))};
  }

  // A table does not blur, so these are the lobes that it is drawn from.
  HWY_INLINE VF Blurred(const V3& wo, const V3& wi, VF radius) const {
    const VF cosine = wi.z * kInvPi;
    const VF mix = share * (ggx.Blurred(wo, wi, radius) - cosine);
    return Luminance(color) * (cosine + mix);
  }

  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi) const {
    const V3 h = Ggx::HalfVector(wo, wi);
    const VF d = Ggx::Distribution(h, ggx.alpha * ggx.alpha);
    const VF lobe = d * (0.25f / hn::Max(wo.z, Set(1e-6f)));
    const VF visible = lobe / (1.0f + ggx.Lambda(wo));
    const VF cosine = wi.z * kInvPi;
    const V3 f = color * LookUp(wi, h);
    return {f * hn::Max(wi.z, hn::Zero(F())), cosine + share * (visible - cosine)};
  }

  HWY_INLINE BsdfSample Draw(const V3& wo, VF u, VF v, VF lobe) const {
    const V3 wi = IfThen(hn::Lt(lobe, share), ggx.Reflect(wo, u, v), CosineHemisphere(u, v));
    return SampleOf(wi, Evaluate(wo, wi));
  }

  VU fields;
  V3 color;
  const float* table;
  VU first;
  Ggx ggx;
  VF share;
};

SKYWAVE_BSDF_KERNELS(Measured)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr BsdfTraits MeasuredTraits = {
    .name = "measured",
    .lobed = true,
    .tables = {.measured = true},
    .parameters = {{"measured"}},
    .pack = [](const Material& m, MeasuredBrdfs measured, MaterialRecord& r) {
      using HWY_NAMESPACE::Measured;
      const MeasuredBrdf& brdf = measured[m.measured];
      PutField(r, MaterialField::kAlpha, MicrofacetWidth(brdf.alpha));
      PutField(r, Measured::kSpecularShare, brdf.specular_share);
      PutField(r, Measured::kTable, m.measured * kMeasuredFloats);
    }};
SKYWAVE_BSDF_TABLE(Measured)

}  // namespace skywave
#endif  // HWY_ONCE
