// This is the material of glTF's KHR_materials_clearcoat and KHR_materials_sheen:
// metallic-roughness under sheen under a clear coat of index 1.5.
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/coated_metallic_roughness.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf_kernels-inl.h"
#include "kernels/bsdf/gltf_layers-inl.h"
#include "kernels/bsdf/metallic_roughness-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct EvenSheen : ClothSheen {
  HWY_INLINE EvenSheen(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                       std::uint32_t n)
      : ClothSheen(m, MaterialFields(s, i, n), Splat(Set(1.0f)), Set(1.0f)) {}
};
struct EvenCoat : ClearCoat {
  HWY_INLINE EvenCoat(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                      std::uint32_t n)
      : ClearCoat(m, MaterialFields(s, i, n), Set(1.0f)) {}
};

using CoatedMetallicRoughness = Coated<Sheened<MetallicRoughness, EvenSheen>, EvenCoat>;

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
