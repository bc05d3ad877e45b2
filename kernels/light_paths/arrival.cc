#include "kernels/light_paths/arrival.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/light_paths/arrival.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/lights/local_lights-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

void SampleArrivals(const LocalLightView& view, const LightChoice& choice, const SurfaceColumns& s,
                    const float* u, const LightColumns& samples, std::uint32_t n, float* arrival) {
  const VF one = Set(1.0f);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const LightPick pick(view, choice, u, i, n, &s);
    if (pick.none()) continue;
    const LightLanes light(view, pick.light);
    // Triangles emit by the cosine over the squared distance, and that is what turns the density of
    // the sample's place into that of its direction.
    const VF sides = IfThen(light.two_sided(), Set(2 * kPi), Set(kPi));
    const VF places = pick.probability / (light.area() * sides);
    const VF pdf = hn::Max(Load(samples.pdf + i), Set(1e-20f));
    const V3 to_light = light.position() - Load3(s.org_x + i, s.org_y + i, s.org_z + i);
    const VF inverse2 = one / hn::Max(Dot(to_light, to_light), Set(1e-30f));
    const VF cone = hn::Max(one - light.Number(12), Set(1e-7f));
    const VF from_point = (0.25f * kInvPi) * inverse2;
    const VF from_spot = (0.5f * kInvPi) / cone * inverse2;
    const VF distant = Load(arrival + i);
    VF value = distant;
    value = IfThen(light.Is(LocalLightKind::kTriangle), places / pdf, value);
    value = IfThen(light.Is(LocalLightKind::kPoint), from_point, value);
    value = IfThen(light.Is(LocalLightKind::kSpot), from_spot, value);
    if (!view.shapes.empty()) {
      const ShapedLights shaped(view, light, pick.picked);
      const VF density = ShapeDensity(shaped.shape, PlaceOf(shaped.shape, -to_light));
      value = IfThen(shaped.lanes, density * inverse2, value);
    }
    Store(IfThen(pick.picked, value, distant), arrival + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(SampleArrivals);

void SampleArrivals(const LocalLightView& view, const LightChoice& choice,
                    const SurfaceColumns& surfaces, const float* u, const LightColumns& samples,
                    std::uint32_t n, float* arrival) {
  HWY_DYNAMIC_DISPATCH(SampleArrivals)(view, choice, surfaces, u, samples, n, arrival);
}

}  // namespace skywave
#endif  // HWY_ONCE
