// The light that a thin film over another surface reflects, by Belcour and Barla 2017 ("A Practical
// Extension to Microfacet Theory for the Modeling of Varying Iridescence"): Airy's series in the
// number of times that light has crossed the film, of which colours keep the first three terms,
// because they integrate the rest away. The integral over wavelengths of a wave of optical path
// difference D is the Fourier transform of the colour matching functions at D, for which they give
// sums of Gaussians. As in glTF's KHR_materials_iridescence, Schlick's formula takes the place of
// Fresnel's, and the surface below has the index that its reflectance at normal incidence implies;
// and what does not depend on the wavelength is grey, though waves have the white of equal energy.
#if defined(SKYWAVE_KERNELS_THIN_FILM_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_THIN_FILM_INL_H_
#undef SKYWAVE_KERNELS_THIN_FILM_INL_H_
#else
#define SKYWAVE_KERNELS_THIN_FILM_INL_H_
#endif

#include "kernels/simd/exp-inl.h"
#include "kernels/simd/math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// A Gaussian in the wave number 1 / wavelength, and its transform: its height, its middle [1/m] and
// its variance [1/m^2].
struct SpectralGaussian {
  float height, middle, variance;
  // Returns the real part at optical path difference `path` [m].
  HWY_INLINE VF At(VF path) const {
    constexpr float kTurn = 6.28318530717959f;
    const VF turns = path * middle;
    VF sine, cosine;
    SinCosTurn(turns - hn::Floor(turns), sine, cosine);
    const VF phase = path * kTurn;
    return hn::Sqrt(Set(kTurn * variance)) * height * cosine * Exp(-(phase * phase * variance));
  }
};

// Returns what a wave of light of path difference `path` [nm] adds to Rec. 709, over what white
// has.
HWY_INLINE V3 ColorOfPath(VF path) {
  constexpr SpectralGaussian kX = {5.4856e-13f, 1.6810e6f, 4.3278e9f};
  constexpr SpectralGaussian kX2 = {9.7470e-14f, 2.2399e6f, 4.5282e9f};
  constexpr SpectralGaussian kY = {4.4201e-13f, 1.7953e6f, 9.3046e9f};
  constexpr SpectralGaussian kZ = {5.2481e-13f, 2.2084e6f, 6.6121e9f};
  constexpr float kWhite = 1 / 1.0685e-7f;
  const VF metres = path * 1e-9f;
  const VF x = (kX.At(metres) + kX2.At(metres)) * kWhite, y = kY.At(metres) * kWhite,
           z = kZ.At(metres) * kWhite;
  return {3.2404542f * x - 1.5371385f * y - 0.4985314f * z,
          1.8760108f * y - 0.9692660f * x + 0.0415560f * z,
          0.0556434f * x - 0.2040259f * y + 1.0572252f * z};
}

// A film of some index and thickness [nm], with air above it.
struct ThinFilm {
  ThinFilm() = default;
  HWY_INLINE ThinFilm(VF index, VF nanometres) : thickness(hn::Max(nanometres, hn::Zero(F()))) {
    const VF one = Set(1.0f);
    // A film thinner than 0.03 nm ceases to be one.
    const VF there = Clamp(thickness / Set(0.03f), 0.0f, 1.0f);
    ior = one + (hn::Max(index, one) - one) * (there * there * (3.0f - 2.0f * there));
    top = AtNormal(ior, one);
  }

  // Returns the reflectance at normal incidence between two indices.
  static HWY_INLINE VF AtNormal(VF a, VF b) {
    const VF amplitude = (a - b) / (a + b);
    return amplitude * amplitude;
  }

  // What the film does to light at one angle of incidence, whatever is below.
  struct Crossing {
    VF reflected;    // at the top
    VF grazing;      // Schlick's factor inside
    V3 once, twice;  // colours of waves that differ by one and by two crossings and back
  };
  // Inlined at its five places it would be half of the code of the BSDFs that have films.
  HWY_NOINLINE Crossing At(VF cosine) const {
    const VF one = Set(1.0f);
    const VF inner = SafeSqrt(one - (one - cosine * cosine) / (ior * ior));
    const VF path = 2.0f * ior * thickness * inner;
    return {top + (one - top) * Power5(one - cosine), Power5(one - inner), ColorOfPath(path),
            ColorOfPath(path + path)};
  }

  VF thickness, ior, top;
};

// A surface under a film that reflects `f0` without it.
struct FilmedSurface {
  FilmedSurface() = default;
  HWY_INLINE FilmedSurface(const ThinFilm& film, const V3& f0) {
    const VF one = Set(1.0f);
    const auto below = [&](VF f, VF& reflectance, VF& turned) HWY_ATTR {
      const VF root = hn::Sqrt(Clamp(f, 0.0f, 0.9999f));
      const VF index = (one + root) / (one - root);
      reflectance = ThinFilm::AtNormal(index, film.ior);
      // One of two reflections at denser media turns the phase, or both do.
      turned = IfThen(hn::Lt(index, film.ior), one, -one);
    };
    below(f0.x, bottom.x, sign.x), below(f0.y, bottom.y, sign.y), below(f0.z, bottom.z, sign.z);
  }

  // Returns what the film and the surface reflect.
  HWY_INLINE V3 Reflectance(const ThinFilm::Crossing& at) const {
    const VF one = Set(1.0f), through = one - at.reflected;
    const auto channel = [&](VF bottom0, VF turned, VF once, VF twice) HWY_ATTR {
      const VF r23 = bottom0 + (one - bottom0) * at.grazing;
      const VF both = Clamp(at.reflected * r23, 1e-5f, 0.9999f), root = hn::Sqrt(both);
      const VF steady = through * through * r23 / (one - both);
      const VF first = (steady - through) * root;
      const VF waves = turned * first * once + first * root * twice;
      return Clamp(at.reflected + steady + 2.0f * waves, 0.0f, 1.0f);
    };
    return {channel(bottom.x, sign.x, at.once.x, at.twice.x),
            channel(bottom.y, sign.y, at.once.y, at.twice.y),
            channel(bottom.z, sign.z, at.once.z, at.twice.z)};
  }

  V3 bottom, sign;
};

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
