// What layers of glTF have for parameters: the sheen of KHR_materials_sheen, whose textures say a
// tint and a roughness, the coat of KHR_materials_clearcoat, of index 1.5, and what the dielectric
// reflects by KHR_materials_specular.
#if defined(SKYWAVE_KERNELS_GLTF_LAYERS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_GLTF_LAYERS_INL_H_
#undef SKYWAVE_KERNELS_GLTF_LAYERS_INL_H_
#else
#define SKYWAVE_KERNELS_GLTF_LAYERS_INL_H_
#endif

#include "kernels/bsdf/coat-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct ClothSheen {
  HWY_INLINE ClothSheen(const MaterialView& m, VU fields, const V3& tint, VF roughness)
      : color(Field3(m, fields, kSheen) * tint),
        alpha(
            Clamp(Field(m, fields, kSheenAlpha) * (roughness * roughness), kMinSheenAlpha, 1.0f)) {}
  V3 color;
  VF alpha;
};

// Returns what a dielectric reflects at normal incidence with a colour and a share of its own, if
// it reflects `plain` without them.
HWY_INLINE V3 DielectricF0(VF plain, const V3& color, VF specular) {
  const auto reflects = [&](VF share)
                            HWY_ATTR { return hn::Min(plain * share, Set(1.0f)) * specular; };
  return {reflects(color.x), reflects(color.y), reflects(color.z)};
}

struct ClearCoat {
  HWY_INLINE ClearCoat(const MaterialView& m, VU fields, VF roughness)
      : strength(Field(m, fields, kClearCoat)),
        alpha(Clamp(Field(m, fields, kClearCoatAlpha) * (roughness * roughness), 1e-3f, 1.0f)),
        f0(Set(0.04f)) {}
  VF strength, alpha, f0;
};
// The same over glass.
struct GlassCoat {
  HWY_INLINE GlassCoat(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                       std::uint32_t n) {
    const VU fields = MaterialFields(s, i, n);
    strength = Field(m, fields, kGlassCoat);
    alpha = Clamp(Field(m, fields, kGlassCoatAlpha), 1e-3f, 1.0f);
    f0 = Set(0.04f);
  }
  VF strength, alpha, f0;
};

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
