// The delta BSDFs. A mirror reflects by the Fresnel reflectance of a complex index (eta = k = 0 is
// a perfect mirror). A dielectric is smooth glass: it reflects with the probability of the
// unpolarised Fresnel reflectance and refracts otherwise (Snell), where radiance is scaled by the
// squared index ratio. A thin dielectric is a sheet of it. Both may have another colour for what
// they reflect (GlassReflection), and layers of glTF (GlassLayers).
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/delta.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf_kernels-inl.h"
#include "kernels/bsdf/fresnel-inl.h"
#include "kernels/bsdf/glass_layers-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Returns the normal about which a delta BSDF acts, in world space: the shading normal, or the
// geometric one where the reflection about the shading normal would go into the surface.
HWY_INLINE V3 DeltaNormal(const V3& ns, const V3& ng, const V3& wo) {
  const VF twice = 2.0f * Dot(ns, wo);
  const V3 reflected = ns * twice - wo;
  return IfThen(hn::Gt(Dot(reflected, ng), hn::Zero(F())), ns, ng);
}

// Value and density are zero: no direction but the BSDF's own can meet light.
void EvaluateDelta(const SurfaceColumns&, const MaterialView&, const LightColumns&, std::uint32_t n,
                   const BsdfValueColumns& out) {
  const VF zero = hn::Zero(F());
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    Store3({zero, zero, zero}, out.r + i, out.g + i, out.b + i);
    Store(zero, out.pdf + i);
  }
}

// Mirror and glass work in world space; only the normal of the shading frame is needed.
HWY_INLINE V3 WorldWo(const SurfaceColumns& s, std::uint32_t i) {
  return Load3(s.wo_x + i, s.wo_y + i, s.wo_z + i);
}

std::uint32_t ScatterMirror(const SurfaceColumns& s, const MaterialView& m,
                            const ScatterUniforms& uniforms, std::uint32_t n,
                            const ScatterPolicy& policy, const RayColumns& rays,
                            std::uint32_t appended) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const ShadingLanes lanes(s, i);
    const V3 wo = WorldWo(s, i);
    const V3 normal = DeltaNormal(lanes.frame.n, lanes.ng, wo);
    const VF cosine = Dot(normal, wo);
    const V3 wi = normal * (2.0f * cosine) - wo;
    const VU fields = MaterialFields(s, i, n);
    V3 weight = ColorOf(s, i) * FresnelConductor(Clamp(cosine, 0.0f, 1.0f), Field3(m, fields, kEta),
                                                 Field3(m, fields, kK));
    if (policy.transport == Transport::kFlux) {
      weight = weight * ShadingNormalFactor(normal, lanes.ng, wo, wi);
    }
    const MF alive = hn::Gt(Dot(lanes.ng, wi), hn::Zero(F()));
    appended = AppendScattered(s, lanes, i, n, wi, weight, hn::Zero(F()), alive,
                               Load(uniforms.lobe.v + i), policy, rays, appended);
  }
  return appended;
}

// A `thin` dielectric is both faces of a sheet at once. The reflections between them add up to
// 2 R / (1 + R), and transmitted light goes straight on. With a colour of its own for what it
// reflects, light is reflected once, at its surface, and everything else goes through, as glTF's
// KHR_materials_transmission has it: what is reflected within would have the colour of the pane.
// All reflections of a pane have the colour that its layers give to the first one.
HWY_INLINE std::uint32_t ScatterGlass(const SurfaceColumns& s, const MaterialView& m,
                                      const ScatterUniforms& uniforms, std::uint32_t n,
                                      const ScatterPolicy& policy, const RayColumns& rays,
                                      std::uint32_t appended, bool thin) {
  const VF one = Set(1.0f), zero = hn::Zero(F());
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const ShadingLanes lanes(s, i);
    const V3 wo = WorldWo(s, i);
    const V3 normal = DeltaNormal(lanes.frame.n, lanes.ng, wo);
    const VU fields = MaterialFields(s, i, n);
    const VF ratio = thin ? one / Field(m, fields, kIor) : IndexRatio(s, m, fields, i);
    const VF cos_o = Clamp(Dot(normal, wo), 0.0f, 1.0f);
    const VF ratio2 = ratio * ratio;
    const Refraction refraction = FresnelDielectric(cos_o, ratio);
    const V3 color = ColorOf(s, i);
    const GlassReflection own(m, fields);
    V3 mirror = own.Or(color);
    VF reflectance = refraction.reflectance;
    if (const GlassLayers layers(s, m, fields, i, n); layers.any) {
      const VF outside = thin ? cos_o : layers.Outside(refraction, cos_o);
      const GlassLayers::Reflection layered = layers.Over(reflectance, outside);
      reflectance = layered.chance, mirror = mirror * layered.tint;
    }
    if (thin) {
      const VF both = (reflectance + reflectance) / (one + reflectance);
      reflectance = IfThen(own.given, reflectance, both);
    }
    const MF reflects = hn::Lt(Load(uniforms.lobe.u + i), reflectance);

    const V3 reflected = normal * (2.0f * cos_o) - wo;
    const V3 refracted = Normalize(normal * (ratio * cos_o - refraction.cosine) - wo * ratio);
    const V3 wi = IfThen(reflects, reflected, thin ? -wo : refracted);
    const VF side = Dot(lanes.ng, wi);
    const MF alive =
        hn::Or(hn::And(reflects, hn::Gt(side, zero)), hn::AndNot(reflects, hn::Lt(side, zero)));
    VF factor = IfThen(reflects, one, thin ? one : ratio2);
    if (policy.transport == Transport::kFlux) {
      factor = ShadingNormalFactor(normal, lanes.ng, wo, wi);
    }
    const V3 weight = IfThen(reflects, mirror, color) * factor;
    appended = AppendScattered(s, lanes, i, n, wi, weight, zero, alive, Load(uniforms.lobe.v + i),
                               policy, rays, appended);
  }
  return appended;
}

std::uint32_t ScatterDielectric(const SurfaceColumns& s, const MaterialView& m,
                                const ScatterUniforms& uniforms, std::uint32_t n,
                                const ScatterPolicy& policy, const RayColumns& rays,
                                std::uint32_t appended) {
  return ScatterGlass(s, m, uniforms, n, policy, rays, appended, false);
}
std::uint32_t ScatterThinDielectric(const SurfaceColumns& s, const MaterialView& m,
                                    const ScatterUniforms& uniforms, std::uint32_t n,
                                    const ScatterPolicy& policy, const RayColumns& rays,
                                    std::uint32_t appended) {
  return ScatterGlass(s, m, uniforms, n, policy, rays, appended, true);
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(EvaluateDelta);
HWY_EXPORT(ScatterMirror);
HWY_EXPORT(ScatterDielectric);
HWY_EXPORT(ScatterThinDielectric);

namespace {

BsdfKernels DeltaKernels(const BsdfTraits& traits, decltype(BsdfKernels::scatter) scatter) {
  BsdfKernels kernels{traits};
  kernels.delta = true;
  kernels.evaluate = SKYWAVE_EVALUATE(EvaluateDelta);
  kernels.scatter = scatter;
  return kernels;
}

void PackIndex(const Material& m, MeasuredBrdfs, MaterialRecord& r) {
  PutField(r, MaterialField::kIor, m.ior);
  PackReflection(m, r);
  PackGlassLayers(m, r);
}

constexpr BsdfTraits kMirrorTraits = {
    .name = "mirror",
    .parameters = {{"eta"}, {"k"}},
    .pack = [](const Material& m, MeasuredBrdfs, MaterialRecord& r) { PackConductorIndex(m, r); }};
constexpr BsdfTraits kDielectricTraits = WithGlassLayers({.name = "dielectric",
                                                          .lobed = true,
                                                          .transmits = true,
                                                          .refracts = true,
                                                          .inside = true,
                                                          .parameters = {{"ior"}, {"reflection"}},
                                                          .pack = PackIndex});
constexpr BsdfTraits kThinDielectricTraits =
    WithGlassLayers({.name = "thin-dielectric",
                     .lobed = true,
                     .transmits = true,
                     .parameters = {{"ior"}, {"reflection"}},
                     .pack = PackIndex});

}  // namespace

BsdfKernels MirrorKernels() { return DeltaKernels(kMirrorTraits, SKYWAVE_SCATTER(ScatterMirror)); }
BsdfKernels DielectricKernels() {
  return DeltaKernels(kDielectricTraits, SKYWAVE_SCATTER(ScatterDielectric));
}
BsdfKernels ThinDielectricKernels() {
  return DeltaKernels(kThinDielectricTraits, SKYWAVE_SCATTER(ScatterThinDielectric));
}

}  // namespace skywave
#endif  // HWY_ONCE
