// Local lights are all emitters but the map. Emitting triangles, points, spots, distant lights and
// points with a shape lie in one table of records; light samples pick from it by power, and BSDF
// samples that hit a triangle of it get the density with which light samples go there.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/lights/light_shapes.h"
#include "kernels/lights/light_tree.h"
#include "kernels/surface/texture.h"

namespace skywave {

enum class LocalLightKind : std::uint32_t { kTriangle, kPoint, kSpot, kDistant, kShaped };
inline constexpr std::uint32_t kLocalLightKinds = 5;

// A light is 16 words in world space, read by gathers at light * 16 + field.
struct LocalLight {
  LocalLightKind kind;
  // Triangle: radiance, times its texture if it has one. Point, spot, and shaped, times its shape:
  // intensity [radiance * length^2]. Distant: irradiance of a surface that faces it [radiance *
  // sr].
  float emission[3];
  float position[3];  // triangle: corner 0; point, spot, shaped: position
  float area;         // triangle
  // Triangle: corner 1 - corner 0. Spot: its direction, unit. Distant: direction towards it, unit.
  float axis[3];
  union {
    std::uint32_t two_sided;  // triangle: 0 if only the side of axis x edge emits
    std::uint32_t shape;      // shaped: row of LightShapeView::shapes
  };
  union {
    float edge[3];  // triangle: corner 2 - corner 0
    struct {
      float cos_dark;       // cosine of the outer cone's angle
      float inverse_range;  // 1 / (cosine of the inner cone's angle - that)
      SpotCurve curve;
    } cone;  // spot
  };
  std::uint32_t triangle;  // triangle: its index; others: index into Scene::lights
};
static_assert(sizeof(LocalLight) == 16 * sizeof(float));

// A uniform u in [0, 1), a multiple of 2^-24, picks light i if first[i] <= 2^24 u < first[i + 1].
// These are integers, so the probability that is reported is the one that is drawn. From `share` on
// u picks no light. With a tree each surface has intervals of its own, which end there too.
struct LightChoice {
  const std::uint32_t* first = nullptr;  // one entry more than there are lights; first[0] = 0
  float share = 0;                       // 2^-24 times the last entry
  const LightTreeView* tree = nullptr;
};

// As many lights can each take a light sample of every surface.
inline constexpr std::uint32_t kMostOfEach = 4096;
// A scene has no more lights.
inline constexpr std::uint32_t kMaxLocalLights = 1u << 22;

struct LocalLightView {
  const LocalLight* lights = nullptr;
  std::uint32_t count = 0;
  // The light of every triangle record of the scene, or kNoLight; null if no triangle emits.
  const std::uint32_t* light_of_triangle = nullptr;
  LightChoice alone;   // share 1: for light samples of local lights only, by power
  LightChoice shared;  // with the map's strategy, by power; share 1 without a map
  LightChoice alike_alone, alike_shared;  // likewise, each light and the map equally often
  // Choice of the one light k: first = only + count - k, share 1. Null for more than kMostOfEach.
  const std::uint32_t* only = nullptr;
  // The density of hits if each light takes a sample is that of `each_samples` picks by `each`.
  LightChoice each;
  float each_samples = 1;
  const LightTreeView* tree = nullptr;  // null: none is asked for
  bool has_alpha = false;               // true if rays may pass through some triangles
  // Row in the texture table + 1 per light, 0 for none; null if no emission has a texture. Light
  // samples and rays that hit the triangle both read level 0, so they see the same light.
  const std::uint32_t* emission_texture = nullptr;
  TextureView textures = {};
  LightShapeView shapes = {};  // empty if no light has one
};
inline constexpr std::uint32_t kNoLight = 0xFFFFFFFFu;

// How far light samples reach and which local lights they go to.
struct ReachColumns {
  float* distance;  // to the light, less a margin that keeps its own triangle from being hit
  float* light;     // its number; -1: none was picked; null: nobody asks

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.distance), f(self.light);
  }
};
static_assert(kMaxLocalLights <= 1u << 24, "a float holds the number of a light");

// Puts a light sample into each of rows [0, n) whose uniforms.u picks a light: dir, r, g, b and pdf
// of `out`, and its `reach`. The other rows keep what they hold, with an infinite distance. Points
// on triangles are uniform in area. `samples` is the number of picks per surface, which densities
// include. `places`, if it is not null, gets the points: triangle, u and v; geom is kNoHit in rows
// without one.
void SampleLocalLights(const LocalLightView& view, const LightChoice& choice,
                       const SurfaceColumns& surfaces, const UniformColumns& uniforms,
                       std::uint32_t n, float samples, const LightColumns& out,
                       const ReachColumns& reach, const HitColumns* places = nullptr);

// Ends the open ones of shadow rays [0, n) at `reach`.
void LimitShadows(const float* reach, std::uint32_t n, const LightColumns& lights);

// Copies those of rays [0, n) that hit the emitting side of a triangle to `emitter_hits`, in order,
// from its row 0 on, with its radiance and the density of SampleLocalLights there; returns their
// number. At least one triangle emits. `left` are the surfaces that the rays have left, which a
// choice with a tree reads. For `arrival`, if it is not null, see
// kernels/light_paths/arrival.h.
std::uint32_t IntersectEmitters(const LocalLightView& view, const LightChoice& choice,
                                const RayColumns& rays, const HitColumns& hits, std::uint32_t n,
                                float samples, const SurfaceColumns& left,
                                const EscapeColumns& emitter_hits, float* arrival = nullptr);

}  // namespace skywave
