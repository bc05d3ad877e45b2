#include "wavefront/film/hidden_objects.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "wavefront/rays/ray_recorder.h"

namespace skywave {
namespace {

// Surfaces that a ray goes through at most: foliage has some hundred.
constexpr int kMostSurfaces = 1024;
// Rays go on from this far beyond a surface, in units of their coordinates and distances. Of two
// surfaces that lie nearer together, the second one is missed.
constexpr float kBeyond = 2e-6f;

// Rays and their hits, as far as TraceClosest needs them.
struct Rays {
  float numbers[12][kHiddenObjectRows];
  std::uint32_t indices[2][kHiddenObjectRows];
  std::uint32_t keys[kHiddenObjectRows] = {};  // one key for all rays decides what is a hole

  RayColumns rays = {};
  HitColumns hits = {};

  Rays() {
    float(*next)[kHiddenObjectRows] = numbers;
    for (float** const column :
         {&rays.org_x, &rays.org_y, &rays.org_z, &rays.dir_x, &rays.dir_y, &rays.dir_z, &rays.t_far,
          &hits.ng_x, &hits.ng_y, &hits.ng_z, &hits.u, &hits.v}) {
      *column = *next++;
    }
    hits.triangle = indices[0], hits.geom = indices[1];
  }
};

// Places ray `to` beyond the distance `t` of ray `from`, which is not before it.
void GoOn(const RayColumns& r, std::uint32_t from, float t, std::uint32_t to) {
  const float x = r.org_x[from], y = r.org_y[from], z = r.org_z[from];
  const float beyond = t + kBeyond * (t + std::max({std::abs(x), std::abs(y), std::abs(z)}));
  r.dir_x[to] = r.dir_x[from], r.dir_y[to] = r.dir_y[from], r.dir_z[to] = r.dir_z[from];
  r.org_x[to] = x + beyond * r.dir_x[to];
  r.org_y[to] = y + beyond * r.dir_y[to];
  r.org_z[to] = z + beyond * r.dir_z[to];
  r.t_far[to] = std::numeric_limits<float>::infinity();
}

}  // namespace

void FindHiddenObjects(const Tracer& tracer, const Geometry& geometry, const SurfaceColumns& s,
                       std::uint32_t n, const bool* wanted, float* const* out) {
  assert(n <= kHiddenObjectRows);
  Tracer through = tracer;
  through.recorder = nullptr, through.beside = 0, through.only = nullptr;
  Rays rays;
  const RayColumns& r = rays.rays;
  std::uint32_t rows[kHiddenObjectRows], going = 0;  // rows of the rays that go on
  std::uint32_t found[kHiddenObjectRows] = {};       // objects that a row has
  for (std::uint32_t i = 0; i < n; ++i) {
    if (!wanted[i]) continue;
    for (std::uint32_t k = 0; k < kHiddenObjects; ++k) out[k][i] = 0;
    const std::uint32_t ray = going++;
    r.org_x[ray] = s.org_x[i] - s.ng_x[i] * s.lift[i], r.dir_x[ray] = -s.wo_x[i];
    r.org_y[ray] = s.org_y[i] - s.ng_y[i] * s.lift[i], r.dir_y[ray] = -s.wo_y[i];
    r.org_z[ray] = s.org_z[i] - s.ng_z[i] * s.lift[i], r.dir_z[ray] = -s.wo_z[i];
    GoOn(r, ray, 0, ray);
    rows[ray] = i;
  }
  for (int surface = 0; surface < kMostSurfaces && going > 0; ++surface) {
    const std::uint32_t count = std::exchange(going, 0);
    TraceClosest(through, RayKind::kBounce, r, count, rays.hits,
                 tracer.first_with_alpha ? rays.keys : nullptr);
    for (std::uint32_t ray = 0; ray < count; ++ray) {
      if (rays.hits.geom[ray] == kNoHit) continue;
      const std::uint32_t row = rows[ray], mesh = geometry.MeshOf(rays.hits.triangle[ray]);
      bool known = mesh == geometry.MeshOf(s.triangle[row]);
      for (std::uint32_t k = 0; k < found[row]; ++k)
        known = known || out[k][row] == float(mesh + 1);
      if (!known) out[found[row]++][row] = float(mesh + 1);
      if (found[row] == kHiddenObjects) continue;
      GoOn(r, ray, r.t_far[ray], going);
      rows[going++] = row;
    }
  }
}

}  // namespace skywave
