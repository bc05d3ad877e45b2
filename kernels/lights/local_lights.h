// Local lights: everything that shines but the map. Emitting triangles, points, spots and distant
// suns lie in one table of records; light samples pick from it by power, and BSDF samples that hit
// a triangle of it learn how likely a light sample was to go there.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/surface/texture.h"

namespace skywave {

enum class LocalLightKind : std::uint32_t { kTriangle, kPoint, kSpot, kDistant };
inline constexpr std::uint32_t kLocalLightKinds = 4;

// A light: 16 words, read by gathers at light * 16 + field. World space.
struct LocalLight {
  LocalLightKind kind;
  // Triangle: radiance, times its texture if it has one. Point and spot: intensity [radiance *
  // length^2]. Distant: irradiance of a surface that faces it [radiance * sr].
  float emission[3];
  float position[3];  // triangle: corner 0; point, spot: where it is
  float area;         // triangle
  // Triangle: corner 1 - corner 0. Spot: where it points, unit. Distant: towards it, unit.
  float axis[3];
  std::uint32_t two_sided;  // triangle: 0: shines on the side of axis x edge
  // Triangle: corner 2 - corner 0. Spot: cosine of the angle at which it is dark; 1 / (cosine of
  // the angle up to which it is full - that).
  float edge[3];
  std::uint32_t triangle;  // of the scene; others: index into Scene::lights
};
static_assert(sizeof(LocalLight) == 16 * sizeof(float));

// Which light a uniform u in [0, 1), a multiple of 2^-24, picks: light i if first[i] <= 2^24 u <
// first[i + 1]. Integers, so the probability that is reported is the one that is drawn. From
// `share` on u picks none of them.
struct LightChoice {
  const std::uint32_t* first = nullptr;  // one number more than there are lights; first[0] = 0
  float share = 0;                       // 2^-24 of the last one
};
inline constexpr std::uint32_t kChoiceUnits = 1u << 24;  // in u

struct LocalLightView {
  const LocalLight* lights = nullptr;
  std::uint32_t count = 0;
  // The light of every triangle record of the scene, or kNoLight; null: no triangle shines.
  const std::uint32_t* light_of_triangle = nullptr;
  LightChoice alone;       // share 1: for light samples that nobody else wants
  LightChoice shared;      // with the strategy of the map, by power; share 1: there is no map
  bool has_alpha = false;  // whether rays may pass through some of the triangles
  // Of every light: row in the texture table + 1, 0: none; null: no emission has a texture. Light
  // samples and rays that hit the triangle both see level 0, so they see the same light.
  const std::uint32_t* emission_texture = nullptr;
  TextureView textures = {};
};
inline constexpr std::uint32_t kNoLight = 0xFFFFFFFFu;

// Puts a light sample into each of rows [0, n) whose uniforms.u picks a light: dir, r, g, b and pdf
// of `out`, and in `reach` its distance, less what keeps its own triangle from being hit. The
// others keep what is there, a sample of something else, with an infinite reach. Points of
// triangles are uniform in area. `samples`: picks that a surface makes, which densities count.
// `places`, where it is not null, gets the points: triangle, u and v; geom kNoHit of rows without.
void SampleLocalLights(const LocalLightView& view, const LightChoice& choice,
                       const SurfaceColumns& surfaces, const UniformColumns& uniforms,
                       std::uint32_t n, float samples, const LightColumns& out, float* reach,
                       const HitColumns* places = nullptr);

// Ends the shadow rays [0, n) that are open after `reach`.
void LimitShadows(const float* reach, std::uint32_t n, const LightColumns& lights);

// Appends to `emitter_hits` (from its row 0) those of rays [0, n) that hit the shining side of a
// triangle, in order, with its radiance and the density of SampleLocalLights there; returns their
// number. There is a triangle that shines. `arrival`, where it is not null: see
// kernels/light_paths/arrival.h.
std::uint32_t IntersectEmitters(const LocalLightView& view, const LightChoice& choice,
                                const RayColumns& rays, const HitColumns& hits, std::uint32_t n,
                                float samples, const EscapeColumns& emitter_hits,
                                float* arrival = nullptr);

}  // namespace skywave
