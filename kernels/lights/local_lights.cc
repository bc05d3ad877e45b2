#include "kernels/lights/local_lights.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/lights/local_lights.cc"
#include "hwy/cache_control.h"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/lights/local_lights-inl.h"
#include "kernels/surface/lift-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

constexpr std::uint32_t kAhead = 64;  // rows between the prefetch and the use of an entry

// Returns the density of points that are uniform over a triangle, as directions from a point at
// that distance and with that cosine at the triangle [1/sr]. It is bounded, because infinity would
// mean a directional light.
HWY_INLINE VF SolidAngleDensity(VF probability, VF area, VF distance2, VF cosine) {
  const VF seen = area * hn::Max(cosine, Set(1e-20f));
  return hn::Min(probability * distance2 / seen, Set(1e18f));
}

// These are the light samples of one vector of surfaces, in the terms of LightColumns.
struct DrawnLights {
  V3 dir, radiance;
  VF pdf, reach;
  VF u, v;  // barycentric, on a triangle
};
HWY_INLINE DrawnLights DrawLights(const LightLanes& light, VF probability, VF x, VF y,
                                  const V3& org, VF lift) {
  const VF zero = hn::Zero(F()), one = Set(1.0f);
  const VF infinity = Set(std::numeric_limits<float>::infinity());
  const V3 axis = light.axis(), edge = light.edge();
  const MF triangle = light.Is(LocalLightKind::kTriangle);

  const TrianglePoint on = PointOf(x, y);
  const V3 inside = on.From(axis, edge);
  const V3 point = light.position() + IfThen(triangle, inside, V3{zero, zero, zero});
  const V3 to_light = point - org;
  const VF distance2 = hn::Max(Dot(to_light, to_light), Set(1e-30f));
  const VF distance = hn::Sqrt(distance2);
  // A light at the point itself has no direction; any will do.
  const MF apart = hn::Gt(distance2, Set(1e-30f));
  V3 dir = IfThen(apart, to_light * (one / distance), V3{zero, zero, one});

  const V3 cross = Cross(axis, edge);
  const VF towards = -Dot(cross, dir) / hn::Sqrt(Dot(cross, cross));
  const VF cosine = IfThen(light.two_sided(), hn::Abs(towards), towards);
  const VF density = SolidAngleDensity(probability, light.area(), distance2, cosine);
  const MF shines = hn::And(triangle, hn::And(apart, hn::Gt(cosine, zero)));
  const VF pdf = IfThen(triangle, hn::IfThenElseZero(shines, density), Set(kPunctual));

  const VF intensity_worth = one / (probability * distance2);
  VF worth = IfThen(triangle, one, intensity_worth);
  const MF spot = light.Is(LocalLightKind::kSpot);
  if (!hn::AllFalse(F(), spot)) {
    const VF falloff = SpotFalloff(light, -Dot(axis, dir));
    worth = IfThen(spot, intensity_worth * falloff, worth);
  }
  // A ray ends before the light: by the error of its own length, by how much nearer an origin can
  // come that is moved through its surface, and by the error of where a light with a surface is
  // (LiftOff), which counts for more along a ray that grazes it.
  const VF own = hn::IfThenElseZero(triangle, LiftOff(LargestCoordinate(point), axis, edge));
  const VF rounding = distance * 0x1p-19f;
  const VF grazing = IfThen(triangle, hn::Max(cosine, Set(1.0f / 256)), one);
  VF reach = distance - (own + rounding) / grazing - (lift + lift);
  const MF distant = light.Is(LocalLightKind::kDistant);
  if (!hn::AllFalse(F(), distant)) {
    dir = IfThen(distant, axis, dir);
    worth = IfThen(distant, one / probability, worth);
    reach = IfThen(distant, infinity, reach);
  }
  return {dir, light.emission() * worth, pdf, reach, on.along_axis, on.along_edge};
}

void SampleLocalLights(const LocalLightView& view, const LightChoice& choice,
                       const SurfaceColumns& surfaces, const UniformColumns& uniforms,
                       std::uint32_t n, float samples, const LightColumns& out,
                       const ReachColumns& reach, const HitColumns* places) {
  const VF infinity = Set(std::numeric_limits<float>::infinity()), none = Set(-1.0f);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const LightPick pick(view, choice, uniforms.u, i, n, &surfaces);
    if (pick.none()) {
      Store(infinity, reach.distance + i);
      if (reach.light != nullptr) Store(none, reach.light + i);
      if (places != nullptr) Store(SetU(kNoHit), places->geom + i);
      continue;
    }
    const V3 org = Load3(surfaces.org_x + i, surfaces.org_y + i, surfaces.org_z + i);
    const LightLanes light(view, pick.light);
    DrawnLights drawn = DrawLights(light, pick.probability * samples, pick.rest,
                                   Load(uniforms.v + i), org, hn::Abs(Load(surfaces.lift + i)));
    const MF picked = pick.picked;
    if (view.emission_texture != nullptr) {
      drawn.radiance = TexturedEmission(view, light, pick.light, hn::RebindMask(U(), picked),
                                        drawn.u, drawn.v, drawn.radiance);
    }
    if (!view.shapes.empty()) {
      const ShapedLights shaped(view, light, picked);
      const V3 seen = ShapeValue(shaped.shape, PlaceOf(shaped.shape, -drawn.dir));
      drawn.radiance = IfThen(shaped.lanes, drawn.radiance * seen, drawn.radiance);
    }
    Store3(IfThen(picked, drawn.dir, Load3(out.dir_x + i, out.dir_y + i, out.dir_z + i)),
           out.dir_x + i, out.dir_y + i, out.dir_z + i);
    Store3(IfThen(picked, drawn.radiance, Load3(out.r + i, out.g + i, out.b + i)), out.r + i,
           out.g + i, out.b + i);
    Store(IfThen(picked, drawn.pdf, Load(out.pdf + i)), out.pdf + i);
    Store(IfThen(picked, drawn.reach, infinity), reach.distance + i);
    if (reach.light != nullptr) {
      Store(IfThen(picked, ToFloat(pick.light), none), reach.light + i);
    }
    if (places == nullptr) continue;
    const MF inside = hn::And(picked, light.Is(LocalLightKind::kTriangle));
    Store(IfThen(hn::RebindMask(U(), inside), SetU(0), SetU(kNoHit)), places->geom + i);
    Store(light.triangle(), places->triangle + i);
    Store(drawn.u, places->u + i);
    Store(drawn.v, places->v + i);
  }
}

void LimitShadows(const float* reach, std::uint32_t n, const LightColumns& lights) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    Store(hn::Min(Load(lights.t_far + i), Load(reach + i)), lights.t_far + i);
  }
}

// Returns the probability with which the surfaces that rays i and on have left pick `light` from
// `units` units. Rays without a density may have left none, and need none.
HWY_NOINLINE VF ProbabilityInTree(const LightTreeView& tree, std::uint32_t units,
                                  const RayColumns& rays, const SurfaceColumns& left,
                                  std::uint32_t i, MU emits, VU light) {
  const MU drawn = hn::RebindMask(U(), hn::Gt(Load(rays.pdf + i), hn::Zero(F())));
  const Receivers from = ReceiversOf(tree, left, Load(rays.from + i), hn::And(emits, drawn));
  return ToFloat(UnitsInLightTree(tree, from, light, SetU(units))) * (1.0f / kChoiceUnits);
}

std::uint32_t IntersectEmitters(const LocalLightView& view, const LightChoice& choice,
                                const RayColumns& rays, const HitColumns& hits, std::uint32_t n,
                                float samples, const SurfaceColumns& left,
                                const EscapeColumns& emitter_hits, float* arrival) {
  std::uint32_t to = 0;
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    for (std::uint32_t ahead = i + kAhead; ahead < i + kAhead + hn::Lanes(U()); ++ahead) {
      if (ahead < n && hits.geom[ahead] != kNoHit) {
        hwy::Prefetch(view.light_of_triangle + hits.triangle[ahead]);
      }
    }
    const MU hit = hn::And(RowsBelow(i, n), hn::Ne(Load(hits.geom + i), SetU(kNoHit)));
    const VU found =
        Gather(view.light_of_triangle, hn::IfThenElseZero(hit, Load(hits.triangle + i)));
    const MU emits = hn::And(hit, hn::Ne(found, SetU(kNoLight)));
    if (hn::AllFalse(U(), emits)) continue;

    const VU index = hn::IfThenElseZero(emits, found);
    const LightLanes light(view, index);
    const V3 ng = Load3(hits.ng_x + i, hits.ng_y + i, hits.ng_z + i);
    const V3 dir = Load3(rays.dir_x + i, rays.dir_y + i, rays.dir_z + i);
    const VF towards = -(Dot(ng, dir) / hn::Sqrt(Dot(ng, ng)));
    const VF cosine = IfThen(light.two_sided(), hn::Abs(towards), towards);
    const MF shines = hn::Gt(cosine, hn::Zero(F()));
    const RowCompressor rows(hn::And(emits, hn::RebindMask(U(), shines)));
    if (rows.count() == 0) continue;

    const VF t = Load(rays.t_far + i);
    const VF probability =
        (choice.tree != nullptr ? ProbabilityInTree(*choice.tree, choice.first[view.count], rays,
                                                    left, i, emits, index)
                                : Probability(choice, index)) *
        samples;
    V3 radiance = light.emission();
    if (view.emission_texture != nullptr) {
      radiance =
          TexturedEmission(view, light, index, emits, Load(hits.u + i), Load(hits.v + i), radiance);
    }
    rows.Move(rays.dir_x + i, emitter_hits.dir_x + to);
    rows.Move(rays.dir_y + i, emitter_hits.dir_y + to);
    rows.Move(rays.dir_z + i, emitter_hits.dir_z + to);
    rows.Move(rays.throughput_r + i, emitter_hits.throughput_r + to);
    rows.Move(rays.throughput_g + i, emitter_hits.throughput_g + to);
    rows.Move(rays.throughput_b + i, emitter_hits.throughput_b + to);
    rows.Move(rays.pdf + i, emitter_hits.pdf + to);
    rows.Move(rays.path + i, emitter_hits.path + to);
    rows.Move(rays.from + i, emitter_hits.from + to);
    rows.Append(radiance.x, emitter_hits.radiance_r + to);
    rows.Append(radiance.y, emitter_hits.radiance_g + to);
    rows.Append(radiance.z, emitter_hits.radiance_b + to);
    rows.Append(SolidAngleDensity(probability, light.area(), t * t, cosine),
                emitter_hits.light_pdf + to);
    if (arrival != nullptr) {
      const VF sides = IfThen(light.two_sided(), Set(2 * kPi), Set(kPi));
      rows.Append(cosine / (sides * (t * t)), arrival + to);
    }
    to += rows.count();
  }
  return to;
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(SampleLocalLights);
HWY_EXPORT(LimitShadows);
HWY_EXPORT(IntersectEmitters);

void SampleLocalLights(const LocalLightView& view, const LightChoice& choice,
                       const SurfaceColumns& surfaces, const UniformColumns& uniforms,
                       std::uint32_t n, float samples, const LightColumns& out,
                       const ReachColumns& reach, const HitColumns* places) {
  HWY_DYNAMIC_DISPATCH(SampleLocalLights)
  (view, choice, surfaces, uniforms, n, samples, out, reach, places);
}
void LimitShadows(const float* reach, std::uint32_t n, const LightColumns& lights) {
  HWY_DYNAMIC_DISPATCH(LimitShadows)(reach, n, lights);
}
std::uint32_t IntersectEmitters(const LocalLightView& view, const LightChoice& choice,
                                const RayColumns& rays, const HitColumns& hits, std::uint32_t n,
                                float samples, const SurfaceColumns& left,
                                const EscapeColumns& emitter_hits, float* arrival) {
  return HWY_DYNAMIC_DISPATCH(IntersectEmitters)(view, choice, rays, hits, n, samples, left,
                                                 emitter_hits, arrival);
}

}  // namespace skywave
#endif  // HWY_ONCE
