// This is the material of glTF's KHR_materials_clearcoat and KHR_materials_sheen:
// metallic-roughness under sheen under a clear coat of index 1.5.
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/coated_metallic_roughness.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/coat-inl.h"
#include "kernels/bsdf/metallic_roughness-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct ClothSheen {
  HWY_INLINE ClothSheen(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                        std::uint32_t n)
      : fields(MaterialFields(s, i, n)),
        color(Field3(m, fields, kSheen)),
        alpha(Clamp(Field(m, fields, kSheenAlpha), kMinSheenAlpha, 1.0f)) {}
  VU fields;
  V3 color;
  VF alpha;
};

struct ClearCoat {
  HWY_INLINE ClearCoat(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                       std::uint32_t n)
      : fields(MaterialFields(s, i, n)),
        strength(Field(m, fields, kClearCoat)),
        alpha(Clamp(Field(m, fields, kClearCoatAlpha), 1e-3f, 1.0f)),
        f0(Set(0.04f)) {}
  VU fields;
  VF strength, alpha, f0;
};

using CoatedMetallicRoughness = Coated<Sheened<MetallicRoughness, ClothSheen>, ClearCoat>;

SKYWAVE_BSDF_KERNELS(CoatedMetallicRoughness)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr BsdfTraits CoatedMetallicRoughnessTraits = {
    .name = "coated-metallic-roughness",
    .lobed = true,
    .varying = Varying::kRoughness,
    .tables = {.ggx = true, .sheen = true},
    .parameters =
        {{"alpha"}, {"metallic"}, {"ior"}, {"coat"}, {"coat_alpha"}, {"sheen"}, {"sheen_alpha"}},
    .pack = [](const Material& m, MeasuredBrdfs, MaterialRecord& r) { PackCoatAndSheen(m, r); }};
SKYWAVE_BSDF_TABLE(CoatedMetallicRoughness)

}  // namespace skywave
#endif  // HWY_ONCE
