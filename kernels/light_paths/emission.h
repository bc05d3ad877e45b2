// Light paths at their beginning: rays that leave the sky, emitting triangles, points, spots and
// distant lights, with their flux over the density of drawing them.
#pragma once

#include <cstdint>
#include <limits>

#include "kernels/columns.h"
#include "kernels/lights/local_lights.h"

namespace skywave {

// A sphere that holds all surfaces of a scene, and a box; world space, a little larger than need
// be.
struct SceneSphere {
  static constexpr float kFar = std::numeric_limits<float>::infinity();
  float center[3] = {0, 0, 0};
  float radius = 0;
  float low[3] = {-kFar, -kFar, -kFar}, high[3] = {kFar, kFar, kFar};
};

// What a light has no extent in; its density there is left out (1), and no ray meets it by chance.
inline constexpr std::uint32_t kDeltaPosition = 1;   // points, spots
inline constexpr std::uint32_t kDeltaDirection = 2;  // distant and directional lights

// One row = the beginning of the light path in the same row of the rays. With d the direction of
// the ray, SmallVCM's recursive quantities (Georgiev et al. 2012, technical report, eqs. 31 to 33)
// begin as dVCM = light_pdf / pdf and, unless `delta`, dVC = cosine / pdf.
struct EmissionColumns {
  // Of the ray: probability of the light, density of the origin [1/area], density of d [1/sr].
  float* pdf;
  // Of a light sample of the same light, its probability counted: of the origin on triangles
  // [1/area], of -d where light comes from infinity [1/sr], the probability alone for points. 1 for
  // directional lights of a strategy, whose probability `pdf` leaves out too.
  float* light_pdf;
  float* cosine;         // between d and the light's normal; 1 where it has none
  std::uint32_t* light;  // row of LocalLightView::lights; kNoLight: the sky
  std::uint32_t* delta;  // kDeltaPosition | kDeltaDirection

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.pdf), f(self.light_pdf), f(self.cosine), f(self.light), f(self.delta);
  }
};

// In both: `rays` gets origins, directions, flux over density as throughput (Le pi R^2 / p of a
// sky, Le cos A / p of a triangle ...), density of the direction as pdf (0: delta), and row numbers
// as `path` and `from`. Rays that carry nothing are closed (negative t_far).

// Rows [0, n): light samples of the sky (dir, r, g, b, pdf of `samples`, as a strategy writes them
// for one drawn sample) become rays from a disk that the sphere casts its shadow on, even over it:
// density 1 / (pi R^2). Origins are outside the sphere or, farther along the ray, where it enters
// the box. `disk`: where on it.
void EmitFromEnvironment(const SceneSphere& sphere, const LightColumns& samples,
                         const UniformColumns& disk, std::uint32_t n, const RayColumns& rays,
                         const EmissionColumns& emission);

// Those of rows [0, n) whose pick.u picks a light (LightChoice) become rays that leave it; the
// others stay. Even over the area of triangles and by the cosine, on either side of those that
// shine on both; even over the sphere for points and over the cone for spots; as from the sky for
// distant lights. The rest of pick.u and pick.v place the origin on a triangle, `aim` the
// direction, or the origin on a disk. `places`: ng (unit, on the side of the ray), triangle, u and
// v of origins on triangles; geom kNoHit where a light of the table is none.
void EmitFromLocalLights(const LocalLightView& view, const LightChoice& choice,
                         const SceneSphere& sphere, const UniformColumns& pick,
                         const UniformColumns& aim, std::uint32_t n, const RayColumns& rays,
                         const EmissionColumns& emission, const HitColumns& places);

}  // namespace skywave
