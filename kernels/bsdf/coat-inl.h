// Layers over another BSDF: a clear dielectric coat of GGX facets, and sheen. A layer takes from
// the BSDF below it the larger of its albedos for wo and wi: that is reciprocal and reflects at
// most the light that arrives. (Attenuation by 1 - F(wo . h), as glTF writes it, is not
// reciprocal.) Where light passes through that BSDF, the layer is met at the angles of both sides,
// and lies on both.
#if defined(SKYWAVE_KERNELS_COAT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_COAT_INL_H_
#undef SKYWAVE_KERNELS_COAT_INL_H_
#else
#define SKYWAVE_KERNELS_COAT_INL_H_
#endif

#include "kernels/bsdf/bsdf-inl.h"
#include "kernels/bsdf/ggx-inl.h"
#include "kernels/simd/exp-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Returns value and density of a layer of albedos `o` and `i` over `below`. The layer is drawn with
// the probability `share`.
HWY_INLINE BsdfValue Layer(const V3& own, VF own_pdf, VF o, VF i, VF share,
                           const BsdfValue& below) {
  const VF through = 1.0f - hn::Max(o, i);
  return {own + below.value * through, below.pdf + share * (own_pdf - below.pdf)};
}

// Returns the probability with which a layer of this albedo is drawn, as if the BSDF below
// reflected one half.
HWY_INLINE VF LayerShare(VF albedo) {
  const VF below = 0.5f * (1.0f - albedo);
  const VF share = Clamp(albedo / hn::Max(albedo + below, Set(1e-6f)), 0.1f, 0.9f);
  return hn::IfThenElseZero(hn::Gt(albedo, hn::Zero(F())), share);
}
// Makes the uniform of a lobe that was not below `share` uniform in [0, 1) again.
HWY_INLINE VF BelowLayer(VF lobe, VF share) {
  return Clamp((lobe - share) / (1.0f - share), 0.0f, 0x1.fffffep-1f);
}

// `Parameters` reads strength, width and F0 (Schlick) of the coat of each row.
template <class Base, class Parameters>
struct Coated {
  HWY_INLINE Coated(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                    std::uint32_t n)
      : base(s, m, i, n), parameters(s, m, i, n), ggx(parameters.alpha), tables(*m.conductor) {}

  HWY_INLINE VF Albedo(VF cosine) const {
    const VF all = ggx.Table(tables.albedo, cosine), grazing = ggx.Table(tables.grazing, cosine);
    const VF albedo = grazing + parameters.f0 * (all - grazing);
    return parameters.strength * albedo;
  }
  HWY_INLINE VF Reflectance(const V3& wo, const V3& h) const {
    const VF one = Set(1.0f), away5 = Power5(one - Clamp(Dot(wo, h), 0.0f, 1.0f));
    const VF fresnel = parameters.f0 + away5 * (one - parameters.f0);
    return parameters.strength * fresnel;
  }

  HWY_INLINE VF Blurred(const V3& wo, const V3& wi, VF radius) const requires kBlurs<Base> {
    const VF coat = Reflectance(wo, Ggx::HalfVector(wo, wi)) * ggx.Blurred(wo, wi, radius);
    const VF through = 1.0f - hn::Max(Albedo(wo.z), Albedo(wi.z));
    return coat + through * base.Blurred(wo, wi, radius);
  }

  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi) const {
    const VF one = Set(1.0f);
    V3 up = wi;
    if constexpr (kTransmits<Base>) up.z = hn::Abs(wi.z);
    const V3 h = Ggx::HalfVector(wo, up);
    const VF d = Ggx::Distribution(h, ggx.alpha * ggx.alpha);
    VF lobe = d * (0.25f / hn::Max(wo.z, Set(1e-6f)));
    if constexpr (kTransmits<Base>) lobe = hn::IfThenElseZero(hn::Gt(wi.z, hn::Zero(F())), lobe);
    const VF lambda_o = ggx.Lambda(wo), lambda_i = ggx.Lambda(up);
    const VF own = Reflectance(wo, h) * (lobe / (one + lambda_o + lambda_i));
    const VF albedo_o = Albedo(wo.z);
    return Layer({own, own, own}, lobe / (one + lambda_o), albedo_o, Albedo(up.z),
                 LayerShare(albedo_o), base.Evaluate(wo, wi));
  }
  HWY_INLINE V3 Direction(const V3& wo, VF u, VF v, VF lobe) const {
    const VF share = LayerShare(Albedo(wo.z));
    return IfThen(hn::Lt(lobe, share), ggx.Reflect(wo, u, v),
                  base.Direction(wo, u, v, BelowLayer(lobe, share)));
  }
  HWY_INLINE BsdfSample Draw(const V3& wo, VF u, VF v, VF lobe) const {
    if constexpr (kTransmits<Base>) {
      return DrawFromBothSides(wo, u, v, lobe);
    } else {
      const V3 wi = Direction(wo, u, v, lobe);
      return SampleOf(wi, Evaluate(wo, wi));
    }
  }
  // What a lobe scatters to the wrong side is dead, and not light of the other lobe.
  HWY_INLINE BsdfSample DrawFromBothSides(const V3& wo, VF u, VF v, VF lobe) const {
    const VF share = LayerShare(Albedo(wo.z)), zero = hn::Zero(F());
    const MF by_coat = hn::Lt(lobe, share);
    const V3 mirrored = ggx.Reflect(wo, u, v);
    const BsdfSample below = base.Draw(wo, u, v, BelowLayer(lobe, share));
    const V3 wi = IfThen(by_coat, mirrored, below.wi);
    BsdfSample sample = SampleOf(wi, Evaluate(wo, wi));
    const MF alive = hn::Gt(IfThen(by_coat, mirrored.z, below.pdf), zero);
    sample.pdf = hn::IfThenElseZero(alive, sample.pdf);
    return sample;
  }
  HWY_INLINE V3 Diffuse(const V3& wo) const requires kDiffuse<Base> {
    return base.Diffuse(wo) * (1.0f - Albedo(wo.z));
  }

  Base base;
  Parameters parameters;
  Ggx ggx;
  const ConductorTables& tables;
};
template <class Base, class Parameters>
inline constexpr bool kTransmits<Coated<Base, Parameters>> = kTransmits<Base>;
template <class Base, class Parameters>
inline constexpr bool kRefracts<Coated<Base, Parameters>> = kRefracts<Base>;
template <class Base, class Parameters>
HWY_INLINE VF RatioOf(const Coated<Base, Parameters>& coated) {
  return RatioOf(coated.base);
}

// Sheen over `Base` (SheenTables), drawn by the cosine. `Parameters` reads its colour and width of
// each row.
template <class Base, class Parameters>
struct Sheened {
  HWY_INLINE Sheened(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                     std::uint32_t n)
      : base(s, m, i, n),
        parameters(s, m, i, n),
        color(parameters.color),
        width(parameters.alpha),
        tables(*m.sheen) {}

  HWY_INLINE VF Albedo(VF cosine) const {
    return MaxComponent(color) * width.Table(tables.albedo, cosine);
  }
  HWY_INLINE VF Blurred(const V3& wo, const V3& wi, VF radius) const {
    const VF through = 1.0f - hn::Max(Albedo(wo.z), Albedo(wi.z));
    return Luminance(color) * Lobe(wo, wi) + through * base.Blurred(wo, wi, radius);
  }
  HWY_INLINE VF Lobe(const V3& wo, const V3& wi) const {
    const VF power = 1.0f / width.alpha;
    const V3 h = Ggx::HalfVector(wo, wi);
    const VF sine = SafeSqrt(h.x * h.x + h.y * h.y);
    const VF d = (2.0f + power) * (0.5f * kInvPi) * Pow(sine, power);
    const VF spread = wo.z + wi.z - wo.z * wi.z;
    const VF visible = 0.25f / hn::Max(spread, Set(1e-6f));
    return d * visible * (width.Mean(tables.scale) * wi.z);
  }
  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi) const {
    const VF albedo_o = Albedo(wo.z);
    return Layer(color * Lobe(wo, wi), wi.z * kInvPi, albedo_o, Albedo(wi.z), LayerShare(albedo_o),
                 base.Evaluate(wo, wi));
  }
  HWY_INLINE V3 Direction(const V3& wo, VF u, VF v, VF lobe) const {
    const VF share = LayerShare(Albedo(wo.z));
    return IfThen(hn::Lt(lobe, share), CosineHemisphere(u, v),
                  base.Direction(wo, u, v, BelowLayer(lobe, share)));
  }
  HWY_INLINE V3 Diffuse(const V3& wo) const { return base.Diffuse(wo) * (1.0f - Albedo(wo.z)); }

  Base base;
  Parameters parameters;
  V3 color;
  Ggx width;  // only its rows in the tables are used
  const SheenTables& tables;
};

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
