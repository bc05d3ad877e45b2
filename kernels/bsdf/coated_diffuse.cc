// A diffuse body under a dielectric coat, smooth or rough, clear or not (tabled_coat-inl.h). Light
// is reflected between the body and the coat, which makes the colours of the body deeper: a
// reflectance r shows as r / (1 - r F), where F is the share that the coat throws back.
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/pack.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/bsdf/coated_diffuse.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf_kernels-inl.h"
#include "kernels/bsdf/tabled_coat-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

struct DiffuseBody {
  static constexpr MaterialField kCoatWidth = kAlpha;
  static constexpr bool kMayMirror = false;

  HWY_INLINE DiffuseBody(const SurfaceColumns& s, const MaterialView&, std::uint32_t i,
                         std::uint32_t n)
      : fields(MaterialFields(s, i, n)), color(ColorOf(s, i)) {}

  // Takes the width of the coat, which may have an image in `lanes`, and returns it.
  static HWY_INLINE VF Vary(const SurfaceColumns& s, std::uint32_t i, MU lanes, CoatLanes& coat) {
    const VF width = Clamp(Load(s.varying_0 + i), 1e-3f, 1.0f);
    coat.coats = coat.Approach(width, lanes, kCoatWords);
    return width;
  }

  // A clear coat lets all channels through alike.
  static HWY_INLINE V3 Through(const CoatLanes& coat, VF cosine) {
    const auto place = CoatLanes::PlaceOf(cosine);
    if (coat.has_medium) return coat.Look3(offsetof(CoatTable, through), place);
    const VF grey = coat.Look(offsetof(CoatTable, through), place);
    return {grey, grey, grey};
  }
  // Returns the colour after all reflections between body and coat.
  HWY_INLINE V3 Repeated(const CoatLanes& coat) const {
    const V3 returned = coat.Constants(offsetof(CoatTable, returned));
    const auto series = [&](VF r, VF back)
                            HWY_ATTR { return r / hn::Max(1.0f - r * back, Set(1e-6f)); };
    return {series(color.x, returned.x), series(color.y, returned.y), series(color.z, returned.z)};
  }

  HWY_INLINE BsdfValue Evaluate(const CoatLanes& coat, const V3& wo, const V3& wi) const {
    const V3 both = Through(coat, wo.z) * Through(coat, wi.z);
    return {Repeated(coat) * both * wi.z, wi.z * kInvPi};
  }
  HWY_INLINE V3 Direction(const V3&, VF u, VF v, VF) const { return CosineHemisphere(u, v); }
  HWY_INLINE V3 Diffuse(const CoatLanes& coat, const V3& wo) const {
    const V3 mean = coat.Constants(offsetof(CoatTable, mean_through));
    return Repeated(coat) * Through(coat, wo.z) * mean;
  }
  HWY_INLINE VF Blurred(const CoatLanes& coat, const V3& wo, const V3& wi, VF) const {
    return Luminance(Diffuse(coat, wo)) * wi.z;
  }

  VU fields;
  V3 color;
};

using CoatedDiffuse = UnderCoat<DiffuseBody>;

SKYWAVE_BSDF_KERNELS(CoatedDiffuse)

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

inline constexpr BsdfTraits CoatedDiffuseTraits = {
    .name = "coated-diffuse",
    .lobed = true,
    .varying = Varying::kAlpha,
    .tables = {.coat = true},
    .parameters = {{"alpha"}, {"ior"}},
    .pack = [](const Material& m, MeasuredBrdfs, MaterialRecord& r) {
      PackAlpha(m, r);
      PutField(r, MaterialField::kIor, m.ior);
      PutField(r, MaterialField::kCoatMedium, m.coat_thickness > 0 ? 1.0f : 0.0f);
    }};
SKYWAVE_BSDF_TABLE(CoatedDiffuse)

}  // namespace skywave
#endif  // HWY_ONCE
