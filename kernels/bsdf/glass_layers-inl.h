// What glTF lays over an interface of glass: a share and a colour of what it reflects
// (KHR_materials_specular), and a thin film (KHR_materials_iridescence). What it then does not
// reflect of its brightest channel goes through, without a colour of these layers, as glTF mixes
// layers by their largest channel. So that channel loses nothing, and the others lose at most what
// it reflects.
//
// Fresnel's formulae stand in the place of Schlick's: they say how far the reflectance is between
// those of normal incidence and of grazing angles. From inside, the film is crossed at the angle
// that the light has outside: layers that do not absorb reflect as much of light from either side
// (Born and Wolf, 1.6). Total reflection knows no layers.
#if defined(SKYWAVE_KERNELS_GLASS_LAYERS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_GLASS_LAYERS_INL_H_
#undef SKYWAVE_KERNELS_GLASS_LAYERS_INL_H_
#else
#define SKYWAVE_KERNELS_GLASS_LAYERS_INL_H_
#endif

#include "kernels/bsdf/fresnel-inl.h"
#include "kernels/bsdf/gltf_layers-inl.h"
#include "kernels/bsdf/thin_film-inl.h"
#include "kernels/surface/layers-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct GlassLayers {
  HWY_INLINE GlassLayers(const SurfaceColumns& s, const MaterialView& m, VU fields, std::uint32_t i,
                         std::uint32_t n) {
    if (!m.glass_layers) return;
    const VF one = Set(1.0f), zero = hn::Zero(F());
    const VF of_dielectric = Load(s.varying_2 + i), of_film = Load(s.varying_3 + i);
    specular = Field(m, fields, kSpecular) * Share<3>(of_dielectric);
    const V3 color = Field3(m, fields, kSpecularColor) * ColorOfRoots(of_dielectric);
    film = Field(m, fields, kFilm) * Share<0>(of_film);
    const MF rows = hn::RebindMask(F(), RowsBelow(i, n));
    const MF filmed = hn::And(rows, hn::Gt(film, zero));
    const MF tinted = hn::Or(hn::Or(hn::Ne(color.x, one), hn::Ne(color.y, one)),
                             hn::Or(hn::Ne(color.z, one), hn::Ne(specular, one)));
    there = hn::Or(filmed, hn::And(rows, tinted));
    any = !hn::AllFalse(F(), there);
    if (!any) return;
    behind = SeenFromBehind(s, i);
    plain = ThinFilm::AtNormal(Field(m, fields, kIor), one);
    f0 = DielectricF0(plain, color, specular);
    any_film = !hn::AllFalse(F(), filmed);
    if (!any_film) return;
    layer = ThinFilm(Field(m, fields, kFilmIor),
                     Mix(Field(m, fields, kGlassFilmThin), Field(m, fields, kGlassFilmThick),
                         Share<1>(of_film)));
    surface = FilmedSurface(layer, f0);
  }

  // Returns the cosine outside of light that meets glass at cosine cos_o and refracts so.
  HWY_INLINE VF Outside(const Refraction& refraction, VF cos_o) const {
    return IfThen(behind, refraction.cosine, cos_o);
  }

  // What the interface reflects: that of its brightest channel, which is the probability of a
  // reflection, and its colour, in which that channel is 1.
  struct Reflection {
    VF chance;
    V3 tint;
  };
  // `fresnel` is what it reflects without layers.
  HWY_INLINE Reflection Over(VF fresnel, VF outside) const {
    const VF one = Set(1.0f);
    const VF grazing = Clamp((fresnel - plain) / hn::Max(one - plain, Set(1e-6f)), 0.0f, 1.0f);
    V3 reflected = f0 + (Splat(specular) - f0) * grazing;
    if (any_film) {
      const V3 filmed = surface.Reflectance(layer.At(Clamp(outside, 0.0f, 1.0f)));
      reflected = Mix(reflected, filmed, film);
    }
    const VF largest = MaxComponent(reflected);
    const MF layered = hn::And(there, hn::Lt(fresnel, one));
    const V3 tint = reflected * (one / hn::Max(largest, Set(1e-20f)));
    return {IfThen(layered, largest, fresnel), IfThen(layered, tint, Splat(one))};
  }

  bool any = false;
  // The rest exists only if any, and the last two only if any_film.
  bool any_film;
  MF there, behind;
  VF plain;           // what the dielectric reflects at normal incidence without layers
  V3 f0;              // with the first one; specular at grazing angles
  VF specular, film;  // film: share of the surface that has one
  ThinFilm layer;
  FilmedSurface surface;
};

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
