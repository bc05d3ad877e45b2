// Anisotropic microfacets have GGX or Beckmann distributions of slopes, of width x along the
// tangent and y across it; conductors are made of either. In local frames z is the normal and x the
// tangent.
#if defined(SKYWAVE_KERNELS_MICROFACET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_MICROFACET_INL_H_
#undef SKYWAVE_KERNELS_MICROFACET_INL_H_
#else
#define SKYWAVE_KERNELS_MICROFACET_INL_H_
#endif

#include "kernels/bsdf/ggx-inl.h"
#include "kernels/simd/exp-inl.h"
#include "kernels/surface/facet_turn-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// A rotation of the shading frame about its normal, by Varying::kTangent.
struct TangentTurn {
  TangentTurn() = default;
  HWY_INLINE TangentTurn(VF c, VF s) : cosine(c), sine(s) {}
  HWY_INLINE TangentTurn(const SurfaceColumns& s, std::uint32_t i)
      : cosine(Load(s.varying_0 + i)), sine(Load(s.varying_1 + i)) {}
  HWY_INLINE V3 To(const V3& w) const {
    return {cosine * w.x + sine * w.y, cosine * w.y - sine * w.x, w.z};
  }
  HWY_INLINE V3 From(const V3& w) const {
    return {cosine * w.x - sine * w.y, cosine * w.y + sine * w.x, w.z};
  }
  VF cosine, sine;
};

// Returns the FacetTurn of surfaces, for the side from which they are seen.
HWY_INLINE FacetTurn FacetTurnOf(const SurfaceColumns& s, std::uint32_t i) {
  FacetTurn turn = UnpackFacetTurn(Load(s.varying_1 + i));
  turn.sine = IfThen(SeenFromBehind(s, i), -turn.sine, turn.sine);
  return turn;
}

// The place of a value between two entries of a table.
struct TablePlace {
  VU low;
  VF share;  // of the next one
};
HWY_INLINE TablePlace PlaceOf(VF from_0_to_1, std::uint32_t count) {
  const VF at = from_0_to_1 * float(count - 1);
  const VU low = hn::Min(ToUnsigned(at), SetU(count - 2));
  return {low, at - ToFloat(low)};
}
// Returns the azimuth of w in the tangent frame as tables have it: |y| / (|x| + |y|).
HWY_INLINE VF AzimuthShare(const V3& w) {
  const VF x = hn::Abs(w.x), y = hn::Abs(w.y);
  return hn::Min(y / hn::Max(x + y, Set(1e-20f)), Set(1.0f));
}

// Returns the sum of the squared slopes of unit h, each over its width.
HWY_INLINE VF ScaledSlope2(const V3& h, VF x, VF y) {
  const VF sx = h.x / x, sy = h.y / y;
  const VF z2 = hn::Max(h.z * h.z, Set(1e-12f));
  return (sx * sx + sy * sy) / z2;
}

struct AnisotropicGgx {
  static constexpr bool kCompensated = true;  // AnisotropicAlbedo is theirs
  // This is eq. 85 of Heitz 2014.
  HWY_INLINE VF Density(const V3& h) const {
    const VF one_plus = 1.0f + ScaledSlope2(h, x, y);
    const VF z2 = hn::Max(h.z * h.z, Set(1e-12f)), z4 = z2 * z2;
    const VF area = kPi * (x * y) * z4;
    return 1.0f / (area * (one_plus * one_plus));
  }
  // This is eq. 86 of Heitz 2014.
  HWY_INLINE VF Lambda(const V3& w) const {
    const VF a = w.x * x, b = w.y * y;
    const VF z2 = hn::Max(w.z * w.z, Set(1e-12f));
    const VF root = hn::Sqrt(1.0f + (a * a + b * b) / z2);
    return 0.5f * (root - 1.0f);
  }
  HWY_INLINE V3 VisibleNormal(const V3& wo, VF u, VF v) const {
    return VisibleGgxNormal(wo, x, y, u, v);
  }
  VF x, y;
};

struct Beckmann {
  static constexpr bool kCompensated = false;
  HWY_INLINE VF Density(const V3& h) const {
    const VF z2 = hn::Max(h.z * h.z, Set(1e-12f)), z4 = z2 * z2;
    const VF area = kPi * (x * y) * z4;
    return Exp(-ScaledSlope2(h, x, y)) / area;
  }
  // This is exact (Heitz 2014, eq. 68), with a = cot / width.
  HWY_INLINE VF Lambda(const V3& w) const {
    const VF b = w.x * x, c = w.y * y;
    const VF across = hn::Sqrt(hn::Max(b * b + c * c, Set(1e-20f)));
    const VF a = Clamp(hn::Abs(w.z) / across, 1e-5f, 6.0f);
    const VF bell = Exp(-(a * a));
    const VF tail = kHalfInvRootPi * bell / a;
    const VF lambda = tail - 0.5f * (1.0f - Erf(a, bell));
    return hn::Max(lambda, hn::Zero(F()));
  }
  // Slopes are drawn as an eye sees them (Heitz and d'Eon 2014): the surface is stretched until its
  // width is 1, and seen along x. The slope across is normal; that along x has the cumulative
  // distribution
  // cos (1 + erf x) / 2 + sin exp(-x^2) / (2 sqrt(pi)) up to the cotangent, which Newton's method
  // inverts between bounds that only shrink.
  HWY_INLINE V3 VisibleNormal(const V3& wo, VF u, VF v) const {
    const VF one = Set(1.0f), half = Set(0.5f), zero = hn::Zero(F());
    const V3 seen = Normalize({wo.x * x, wo.y * y, wo.z});
    const VF cosine = hn::Max(seen.z, Set(1e-6f));
    const VF sine = hn::Sqrt(seen.x * seen.x + seen.y * seen.y);
    const VF over = one / hn::Max(sine, Set(1e-20f));
    const MF upright = hn::Lt(sine, Set(1e-6f));
    const VF c = IfThen(upright, one, seen.x * over);
    const VF s = IfThen(upright, zero, seen.y * over);

    const auto cumulative = [&](VF at, VF bell) HWY_ATTR {
      const VF level = half * cosine * (one + Erf(at, bell));
      return level + kHalfInvRootPi * sine * bell;
    };
    VF low = Set(-4.5f);
    VF high = hn::Min(cosine / hn::Max(sine, Set(1e-6f)), Set(4.5f));
    const VF bell_high = Exp(-(high * high));
    const VF target = u * cumulative(high, bell_high);
    const VF mass = u * (one + Erf(high, bell_high));
    VF slope = hn::Max(hn::Min(ErfInverse(mass - one), high), low);
    for (int step = 0; step < 8; ++step) {
      const VF bell = Exp(-(slope * slope));
      const VF excess = cumulative(slope, bell) - target;
      const MF below = hn::Lt(excess, zero);
      low = IfThen(below, slope, low);
      high = IfThen(below, high, slope);
      const VF rise = (2 * kHalfInvRootPi) * bell * (cosine - slope * sine);
      const VF next = slope - excess / hn::Max(rise, Set(1e-20f));
      const MF between = hn::And(hn::Gt(next, low), hn::Lt(next, high));
      // At the root the rounding of a step may leave the bounds, which must not bisect it away.
      const MF settled = hn::Lt(hn::Abs(excess), Set(1e-6f));
      const VF safe = IfThen(between, next, half * (low + high));
      slope = IfThen(settled, slope, safe);
    }
    const VF across = ErfInverse(v + v - one);
    const VF sx = c * slope - s * across;
    const VF sy = s * slope + c * across;
    return Normalize({-(sx * x), -(sy * y), one});
  }
  static constexpr float kHalfInvRootPi = 0.282094791773878f;
  VF x, y;
};

// One vector of widths of GGX facets and their places in AnisotropicTables.
struct AnisotropicAlbedo {
  static HWY_INLINE VF Between(VF low, VF high, VF share) { return low + share * (high - low); }

  AnisotropicAlbedo() = default;
  HWY_INLINE AnisotropicAlbedo(const AnisotropicTables* from, VF x, VF y)
      : tables(from),
        along(PlaceOf(hn::Sqrt(Clamp(x, 0.0f, 1.0f)), kTabledWidths)),
        across(PlaceOf(hn::Sqrt(Clamp(y, 0.0f, 1.0f)), kTabledWidths)) {}

  // Reads a table of both widths, each entry of which has `words` words, by at(word).
  template <class At>
  HWY_INLINE VF OfWidths(std::uint32_t words, const At& at) const {
    const VU row = along.low * SetU(kTabledWidths) + across.low;
    const VU first = row * SetU(words);
    const VU below = first + SetU(kTabledWidths * words);
    const VF low = Between(at(first), at(first + SetU(words)), across.share);
    const VF high = Between(at(below), at(below + SetU(words)), across.share);
    return Between(low, high, along.share);
  }
  // Returns the albedo of single scattering of light from w, in the tangent frame.
  HWY_INLINE VF Of(const V3& w) const {
    const TablePlace cosine = PlaceOf(hn::Sqrt(Clamp(w.z, 0.0f, 1.0f)), kTabledCosines);
    const TablePlace azimuth = PlaceOf(AzimuthShare(w), kTabledAzimuths);
    const VU within = cosine.low * SetU(kTabledAzimuths) + azimuth.low;
    const float* const words = &tables->albedo[0][0][0][0];
    const auto around = [&](VU at) HWY_ATTR {
      return Between(Gather(words, at), Gather(words, at + SetU(1)), azimuth.share);
    };
    return OfWidths(kTabledCosines * kTabledAzimuths, [&](VU first) HWY_ATTR {
      const VU at = first + within;
      return Between(around(at), around(at + SetU(kTabledAzimuths)), cosine.share);
    });
  }
  HWY_INLINE VF Mean() const {
    const float* const words = &tables->mean_albedo[0][0];
    return OfWidths(1, [&](VU at) HWY_ATTR { return Gather(words, at); });
  }

  const AnisotropicTables* tables;
  TablePlace along, across;
};

// A conductor of such facets: height-correlated Smith masking, Fresnel of a complex index, visible
// normals. Of GGX facets, the lobe of Kulla and Conty 2017 returns the light that they reflect more
// than once; it is drawn with the probability that they do. Beckmann's facets lose that light.
template <class Facets>
struct MicrofacetConductor {
  HWY_INLINE MicrofacetConductor(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                                 std::uint32_t n)
      : fields(MaterialFields(s, i, n)),
        color(ColorOf(s, i)),
        facets{Field(m, fields, kAlpha), Field(m, fields, kAlphaAcross)},
        eta(Field3(m, fields, kEta)),
        k(Field3(m, fields, kK)),
        turn(s, i),
        albedo(m.anisotropic, facets.x, facets.y) {
    if (m.varied) MetalOfColor(color, eta, k);
    if constexpr (Facets::kCompensated) {
      if (m.varied) VaryWidths(s, m, i, n);
      multiscatter = Field3(m, fields, kMultiscatter);
      compensated = hn::And(Compensates(multiscatter), hn::RebindMask(F(), RowsBelow(i, n)));
      any_compensated = !hn::AllFalse(F(), compensated);
      if (any_compensated && m.varied) multiscatter = Multiscatter(albedo.Mean(), eta, k);
    }
  }

  // Takes widths that have a texture, and the tangent beside them, from PrepareTwoWidths.
  HWY_INLINE void VaryWidths(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                             std::uint32_t n) {
    const VU texture =
        hn::IfThenElseZero(RowsBelow(i, n), IndexField(m, fields, kRoughnessTexture));
    const MF lanes = hn::RebindMask(F(), hn::Ne(texture, hn::Zero(U())));
    if (hn::AllFalse(F(), lanes)) return;
    const FacetTurn varied = FacetTurnOf(s, i);
    turn = {IfThen(lanes, varied.cosine, turn.cosine), IfThen(lanes, varied.sine, turn.sine)};
    facets.x = IfThen(lanes, Clamp(Load(s.varying_0 + i), 1e-3f, 1.0f), facets.x);
    facets.y = IfThen(lanes, Clamp(varied.across, 1e-3f, 1.0f), facets.y);
    albedo = AnisotropicAlbedo(m.anisotropic, facets.x, facets.y);
  }

  HWY_INLINE VF Blurred(const V3& wo, const V3& wi, VF radius) const {
    const Ggx wider(hn::Min(hn::Max(facets.x, facets.y), Set(1.0f)));
    return Luminance(color) * wider.Blurred(wo, wi, radius);
  }

  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi) const {
    const V3 eye = turn.To(wo);
    return InTangentFrame(eye, turn.To(wi), LostFrom(eye));
  }
  // Takes what light from wo loses too, which a draw has looked up already.
  HWY_INLINE BsdfValue InTangentFrame(const V3& wo, const V3& wi, VF lost_o) const {
    const VF one = Set(1.0f);
    const V3 h = Ggx::HalfVector(wo, wi);
    const VF quarter_over_cos = 0.25f / hn::Max(wo.z, Set(1e-6f));
    const VF lobe = facets.Density(h) * quarter_over_cos;
    const VF lambda_o = facets.Lambda(wo), lambda_i = facets.Lambda(wi);
    const VF g2 = one / (one + lambda_o + lambda_i);
    const V3 fresnel = FresnelConductor(hn::Min(hn::Abs(Dot(wo, h)), one), eta, k);
    const VF visible = lobe / (one + lambda_o);
    if constexpr (Facets::kCompensated) {
      if (any_compensated) {
        const VF multiple = lost_o * Lost(wi) * wi.z;
        const V3 again = multiscatter * multiple;
        const VF diffuse = wi.z * kInvPi;
        return {color * (fresnel * (lobe * g2) + again), visible + lost_o * (diffuse - visible)};
      }
    }
    return {color * fresnel * (lobe * g2), visible};
  }
  // Returns the share of the light from w that single scattering loses and the lobe returns.
  HWY_INLINE VF Lost(const V3& w) const {
    return hn::IfThenElseZero(compensated, 1.0f - albedo.Of(w));
  }
  HWY_INLINE VF LostFrom(const V3& wo) const {
    if constexpr (Facets::kCompensated) {
      if (any_compensated) return Lost(wo);
    }
    return hn::Zero(F());
  }

  HWY_INLINE BsdfSample Draw(const V3& wo, VF u, VF v, VF lobe) const {
    const V3 eye = turn.To(wo);
    const V3 h = facets.VisibleNormal(eye, u, v);
    V3 wi = h * (2.0f * Dot(eye, h)) - eye;
    const VF lost = LostFrom(eye);
    if constexpr (Facets::kCompensated) {
      if (any_compensated) wi = IfThen(hn::Lt(lobe, lost), CosineHemisphere(u, v), wi);
    }
    return SampleOf(turn.From(wi), InTangentFrame(eye, wi, lost));
  }

  VU fields;
  V3 color;
  Facets facets;
  V3 eta, k;
  TangentTurn turn;
  AnisotropicAlbedo albedo;  // this and the next ones only for facets that are compensated
  V3 multiscatter;
  MF compensated;
  bool any_compensated = false;
};

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
