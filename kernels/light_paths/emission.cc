#include "kernels/light_paths/emission.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/light_paths/emission.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/light_paths/emission-inl.h"
#include "kernels/lights/local_lights-inl.h"
#include "kernels/surface/lift-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// This is one vector of rays that leave lights.
struct Emitted {
  V3 org, dir, flux;  // flux is over `pdf`
  VF pdf;             // density of the ray
  VF light_pdf, direction_pdf, cosine;
  VU delta;
};

// Writes the lanes of `rows`; the others keep their values.
HWY_INLINE void StoreEmitted(const Emitted& e, VU light, MF rows, std::uint32_t i,
                             const RayColumns& rays, const EmissionColumns& out) {
  const auto store = [&](VF value, float* to)
                         HWY_ATTR { Store(IfThen(rows, value, Load(to + i)), to + i); };
  const MU rows_u = hn::RebindMask(U(), rows);
  const MF shines = hn::Gt(MaxComponent(e.flux), hn::Zero(F()));
  store(e.org.x, rays.org_x), store(e.org.y, rays.org_y), store(e.org.z, rays.org_z);
  store(e.dir.x, rays.dir_x), store(e.dir.y, rays.dir_y), store(e.dir.z, rays.dir_z);
  store(IfThen(shines, Set(std::numeric_limits<float>::infinity()), Set(-1.0f)), rays.t_far);
  store(e.flux.x, rays.throughput_r), store(e.flux.y, rays.throughput_g);
  store(e.flux.z, rays.throughput_b);
  store(e.direction_pdf, rays.pdf);
  Store(hn::Iota(U(), i), rays.path + i);
  Store(hn::Iota(U(), i), rays.from + i);
  store(e.pdf, out.pdf), store(e.light_pdf, out.light_pdf), store(e.cosine, out.cosine);
  Store(IfThen(rows_u, light, Load(out.light + i)), out.light + i);
  Store(IfThen(rows_u, e.delta, Load(out.delta + i)), out.delta + i);
}

void EmitFromEnvironment(const SceneSphere& sphere, const LightColumns& samples,
                         const UniformColumns& disk, std::uint32_t n, const RayColumns& rays,
                         const EmissionColumns& out) {
  const VF zero = hn::Zero(F()), one = Set(1.0f);
  const VF area = Set(kPi * sphere.radius * sphere.radius);
  const VF infinity = Set(std::numeric_limits<float>::infinity());
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const V3 towards = Load3(samples.dir_x + i, samples.dir_y + i, samples.dir_z + i);
    const VF pdf = Load(samples.pdf + i);
    const MF drawn = hn::Gt(pdf, zero), directional = hn::Eq(pdf, infinity);
    // A directional light has its irradiance over its probability in r, g, b.
    const VF density = IfThen(hn::AndNot(directional, drawn), pdf, one);
    const VF worth = hn::IfThenElseZero(drawn, area / density);
    const Emitted emitted = {
        .org = EnterScene(sphere, towards, Load(disk.u + i), Load(disk.v + i)),
        .dir = -towards,
        .flux = Load3(samples.r + i, samples.g + i, samples.b + i) * worth,
        .pdf = density / area,
        .light_pdf = density,
        .direction_pdf = IfThen(directional, zero, density),
        .cosine = one,
        .delta = hn::IfThenElseZero(hn::RebindMask(U(), directional), SetU(kDeltaDirection))};
    StoreEmitted(emitted, SetU(kNoLight), hn::RebindMask(F(), RowsBelow(i, n)), i, rays, out);
  }
}

// Emits rays from uniform points of triangles, following the cosine; `normal` is of the side that
// they leave from.
HWY_INLINE Emitted EmitFromTriangles(const LightLanes& light, VF probability,
                                     const TrianglePoint& on, VF u, VF v, V3& normal) {
  const VF one = Set(1.0f), half = Set(0.5f);
  const V3 axis = light.axis(), edge = light.edge();
  const V3 point = light.position() + on.From(axis, edge);
  // The first half of v goes to the front where both sides emit.
  const MF two_sided = light.two_sided();
  const MF back = hn::And(two_sided, hn::Ge(v, half));
  const VF twice = v + v - hn::IfThenElseZero(back, one);
  const V3 cross = Normalize(Cross(axis, edge));
  normal = IfThen(back, -cross, cross);
  const V3 local = CosineHemisphere(u, IfThen(two_sided, twice, v));
  const V3 org = point + normal * LiftOff(LargestCoordinate(point), axis, edge);
  const VF share = IfThen(two_sided, half, one);
  const VF light_pdf = probability / light.area();
  const VF direction_pdf = local.z * kInvPi * share;
  return {.org = org,
          .dir = ToWorld(MakeFrame(normal), local),
          // The cosine of the flux and that of the density cancel.
          .flux = light.emission() * (kPi / (light_pdf * share)),
          .pdf = light_pdf * direction_pdf,
          .light_pdf = light_pdf,
          .direction_pdf = direction_pdf,
          .cosine = local.z,
          .delta = SetU(0)};
}

HWY_INLINE Emitted EmitFromPoints(const LightLanes& light, VF probability, VF u, VF v) {
  const VF direction_pdf = Set(0.25f * kInvPi);
  const VF pdf = probability * direction_pdf;
  return {.org = light.position(),
          .dir = UniformSphere(u, v),
          .flux = light.emission() * (1.0f / pdf),
          .pdf = pdf,
          .light_pdf = probability,
          .direction_pdf = direction_pdf,
          .cosine = Set(1.0f),
          .delta = SetU(kDeltaPosition)};
}

HWY_INLINE Emitted EmitFromSpots(const LightLanes& light, VF probability, VF u, VF v) {
  const VF one = Set(1.0f), widest = one - light.Number(12);
  const V3 local = InCone(u, v, widest);
  const VF direction_pdf = (0.5f * kInvPi) / hn::Max(widest, Set(1e-7f));
  const VF pdf = probability * direction_pdf;
  return {.org = light.position(),
          .dir = ToWorld(MakeFrame(light.axis()), local),
          .flux = light.emission() * (SpotFalloff(light, local.z) / pdf),
          .pdf = pdf,
          .light_pdf = probability,
          .direction_pdf = direction_pdf,
          .cosine = one,
          .delta = SetU(kDeltaPosition)};
}

HWY_INLINE Emitted EmitFromShapes(const LightLanes& light, const ShapeLanes& shape, VF probability,
                                  VF u, VF v) {
  const DrawnDirection drawn = DrawDirection(shape, u, v);
  const VF pdf = probability * drawn.pdf;
  return {.org = light.position(),
          .dir = drawn.dir,
          .flux = light.emission() * drawn.value * (1.0f / pdf),
          .pdf = pdf,
          .light_pdf = probability,
          .direction_pdf = drawn.pdf,
          .cosine = Set(1.0f),
          .delta = SetU(kDeltaPosition)};
}

HWY_INLINE Emitted EmitFromDistant(const LightLanes& light, VF probability,
                                   const SceneSphere& sphere, VF u, VF v) {
  const VF area = Set(kPi * sphere.radius * sphere.radius);
  const V3 towards = light.axis();
  return {.org = EnterScene(sphere, towards, u, v),
          .dir = -towards,
          .flux = light.emission() * (area / probability),
          .pdf = probability / area,
          .light_pdf = probability,
          .direction_pdf = hn::Zero(F()),
          .cosine = Set(1.0f),
          .delta = SetU(kDeltaDirection)};
}

void EmitFromLocalLights(const LocalLightView& view, const LightChoice& choice,
                         const SceneSphere& sphere, const UniformColumns& pick,
                         const UniformColumns& aim, std::uint32_t n, const RayColumns& rays,
                         const EmissionColumns& out, const HitColumns& places) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    Store(SetU(kNoHit), places.geom + i);
    const LightPick picked(view, choice, pick.u, i, n, nullptr);
    if (picked.none()) continue;
    const LightLanes light(view, picked.light);
    const VF u = Load(aim.u + i), v = Load(aim.v + i);
    const auto rows = [&](LocalLightKind kind)
                          HWY_ATTR { return hn::And(picked.picked, light.Is(kind)); };
    if (const MF triangles = rows(LocalLightKind::kTriangle); !hn::AllFalse(F(), triangles)) {
      const TrianglePoint on = PointOf(picked.rest, Load(pick.v + i));
      V3 normal;
      Emitted emitted = EmitFromTriangles(light, picked.probability, on, u, v, normal);
      if (view.emission_texture != nullptr) {
        emitted.flux = TexturedEmission(view, light, picked.light, hn::RebindMask(U(), triangles),
                                        on.along_axis, on.along_edge, emitted.flux);
      }
      StoreEmitted(emitted, picked.light, triangles, i, rays, out);
      Store(IfThen(hn::RebindMask(U(), triangles), SetU(0), SetU(kNoHit)), places.geom + i);
      Store3(normal, places.ng_x + i, places.ng_y + i, places.ng_z + i);
      Store(light.triangle(), places.triangle + i);
      Store(on.along_axis, places.u + i);
      Store(on.along_edge, places.v + i);
    }
    if (const MF points = rows(LocalLightKind::kPoint); !hn::AllFalse(F(), points)) {
      StoreEmitted(EmitFromPoints(light, picked.probability, u, v), picked.light, points, i, rays,
                   out);
    }
    if (const MF spots = rows(LocalLightKind::kSpot); !hn::AllFalse(F(), spots)) {
      StoreEmitted(EmitFromSpots(light, picked.probability, u, v), picked.light, spots, i, rays,
                   out);
    }
    if (!view.shapes.empty()) {
      const ShapedLights shaped(view, light, picked.picked);
      StoreEmitted(EmitFromShapes(light, shaped.shape, picked.probability, u, v), picked.light,
                   shaped.lanes, i, rays, out);
    }
    if (const MF distant = rows(LocalLightKind::kDistant); !hn::AllFalse(F(), distant)) {
      StoreEmitted(EmitFromDistant(light, picked.probability, sphere, u, v), picked.light, distant,
                   i, rays, out);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(EmitFromEnvironment);
HWY_EXPORT(EmitFromLocalLights);

void EmitFromEnvironment(const SceneSphere& sphere, const LightColumns& samples,
                         const UniformColumns& disk, std::uint32_t n, const RayColumns& rays,
                         const EmissionColumns& emission) {
  HWY_DYNAMIC_DISPATCH(EmitFromEnvironment)(sphere, samples, disk, n, rays, emission);
}
void EmitFromLocalLights(const LocalLightView& view, const LightChoice& choice,
                         const SceneSphere& sphere, const UniformColumns& pick,
                         const UniformColumns& aim, std::uint32_t n, const RayColumns& rays,
                         const EmissionColumns& emission, const HitColumns& places) {
  HWY_DYNAMIC_DISPATCH(EmitFromLocalLights)
  (view, choice, sphere, pick, aim, n, rays, emission, places);
}

}  // namespace skywave
#endif  // HWY_ONCE
