#include "wavefront/film/hidden_objects.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "wavefront/rays/ray_recorder.h"

namespace skywave {
namespace {

// A ray that has gone through this many surfaces is in a hall of mirrors, or in a pile of sheets.
constexpr int kMostSurfaces = 1024;
// Beyond a surface rays go on from here, in units of their coordinates and distances. What lies
// nearer together is one object: nobody would see it from any side.
constexpr float kBeyond = 2e-6f;

// Rays and their hits, as far as TraceClosest needs them.
class Rays {
 public:
  explicit Rays(std::uint32_t n) : numbers_(kFloats * n), indices_(kIndices * n) {
    float* next = numbers_.data();
    for (float** const column :
         {&rays.org_x, &rays.org_y, &rays.org_z, &rays.dir_x, &rays.dir_y, &rays.dir_z, &rays.t_far,
          &hits.ng_x, &hits.ng_y, &hits.ng_z, &hits.u, &hits.v}) {
      *column = next;
      next += n;
    }
    hits.triangle = indices_.data(), hits.geom = hits.triangle + n, keys = hits.geom + n;
  }

  RayColumns rays = {};
  HitColumns hits = {};
  std::uint32_t* keys;  // 0: one of them decides for all rays what is a hole

 private:
  static constexpr std::size_t kFloats = 12, kIndices = 3;
  std::vector<float> numbers_;
  std::vector<std::uint32_t> indices_;
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
  Tracer through = tracer;
  through.recorder = nullptr, through.beside = 0, through.only = nullptr;
  Rays rays(n);
  const RayColumns& r = rays.rays;
  std::vector<std::uint32_t> rows, found(n);  // rows of the rays; objects that a row has
  for (std::uint32_t i = 0; i < n; ++i) {
    if (!wanted[i]) continue;
    for (std::uint32_t k = 0; k < kHiddenObjects; ++k) out[k][i] = 0;
    const auto ray = std::uint32_t(rows.size());
    r.org_x[ray] = s.org_x[i] - s.ng_x[i] * s.lift[i], r.dir_x[ray] = -s.wo_x[i];
    r.org_y[ray] = s.org_y[i] - s.ng_y[i] * s.lift[i], r.dir_y[ray] = -s.wo_y[i];
    r.org_z[ray] = s.org_z[i] - s.ng_z[i] * s.lift[i], r.dir_z[ray] = -s.wo_z[i];
    GoOn(r, ray, 0, ray);
    rows.push_back(i);
  }
  for (int surface = 0; surface < kMostSurfaces && !rows.empty(); ++surface) {
    TraceClosest(through, RayKind::kBounce, r, std::uint32_t(rows.size()), rays.hits,
                 tracer.first_with_alpha ? rays.keys : nullptr);
    std::uint32_t going = 0;
    for (std::uint32_t ray = 0; ray < rows.size(); ++ray) {
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
    rows.resize(going);
  }
}

}  // namespace skywave
