// Light paths begin here: rays leave the environment, emitting triangles, points, shaped or not,
// spots and distant lights, with their flux over the density of drawing them.
#pragma once

#include <cstdint>
#include <limits>

#include "kernels/columns.h"
#include "kernels/lights/local_lights.h"

namespace skywave {

// A sphere and a box each hold all surfaces of a scene; they are in world space and a little larger
// than need be.
struct SceneSphere {
  static constexpr float kFar = std::numeric_limits<float>::infinity();
  float center[3] = {0, 0, 0};
  float radius = 0;
  float low[3] = {-kFar, -kFar, -kFar}, high[3] = {kFar, kFar, kFar};
};

// A light may have no extent in position or direction; its density there is left out (1), and no
// ray hits it by chance.
inline constexpr std::uint32_t kDeltaPosition = 1;   // points, spots, shaped
inline constexpr std::uint32_t kDeltaDirection = 2;  // distant and directional lights

// One row is the beginning of the light path in the same row of the rays. With d the direction of
// the ray, SmallVCM's recursive quantities (Georgiev et al. 2012, technical report, eqs. 31 to 33)
// begin as dVCM = light_pdf / pdf and, unless `delta`, dVC = cosine / pdf.
struct EmissionColumns {
  // Density of the ray: probability of the light, density of the origin [1/area], density of d
  // [1/sr].
  float* pdf;
  // Density of a light sample of the same light, including its probability: that of the origin on
  // triangles [1/area], of -d where light comes from infinity [1/sr], the probability alone for
  // points. It is 1 for directional lights of a strategy, whose probability `pdf` leaves out too.
  float* light_pdf;
  float* cosine;         // between d and the light's normal; 1 where it has none
  std::uint32_t* light;  // row of LocalLightView::lights; kNoLight: the environment
  std::uint32_t* delta;  // kDeltaPosition | kDeltaDirection

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.pdf), f(self.light_pdf), f(self.cosine), f(self.light), f(self.delta);
  }
};

// Both functions write origins, directions, flux over density as throughput (Le pi R^2 / p for an
// environment, Le cos A / p for a triangle ...), density of the direction as pdf (0: delta), and
// row numbers as `path` and `from` to `rays`. Rays that carry nothing are closed (negative t_far).

// Turns rows [0, n), light samples of the environment (dir, r, g, b, pdf of `samples`, as a
// strategy writes them for one drawn sample), into rays from the disk that the sphere projects to,
// uniform over it: density 1 / (pi R^2). Origins are outside the sphere or, farther along the ray,
// where it enters the box. `disk` gives the places on the disk.
void EmitFromEnvironment(const SceneSphere& sphere, const LightColumns& samples,
                         const UniformColumns& disk, std::uint32_t n, const RayColumns& rays,
                         const EmissionColumns& emission);

// Turns those of rows [0, n) whose pick.u picks a light (LightChoice) into rays that leave it; the
// other rows stay. Rays are uniform over the area of triangles and follow the cosine, on either
// side of those that emit on both; they are uniform over the sphere for points and over the cone
// for spots, and follow the shapes of shaped ones; for distant lights they are like those of the
// environment. The rest of pick.u and pick.v place the origin on a triangle, `aim` the direction,
// or the origin on a disk. `places` gets ng (unit, on the side of the ray), triangle, u and v of
// origins on triangles; geom is kNoHit in all other rows.
void EmitFromLocalLights(const LocalLightView& view, const LightChoice& choice,
                         const SceneSphere& sphere, const UniformColumns& pick,
                         const UniformColumns& aim, std::uint32_t n, const RayColumns& rays,
                         const EmissionColumns& emission, const HitColumns& places);

}  // namespace skywave
