#include "wavefront/guiding/bounce_pilot.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "wavefront/guiding/pilot.h"

namespace skywave {
namespace {

// A ray whose contribution is not known yet: radiance is that of its path when it left.
struct PendingRay {
  BounceRay ray;
  float throughput;
  std::uint32_t path;
};

// Keeps the rays that have left guided surfaces, in the order of their surfaces.
void KeepRays(const PlaceBox& box, const Worker& w, const RayColumns& rays, std::uint32_t n,
              std::vector<PendingRay>& pending) {
  const SurfaceColumns& s = w.surfaces;
  std::uint32_t kind = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t row = rays.from[i], path = rays.path[i];
    while (row >= w.ranges.begin[kind + 1]) ++kind;
    if (!Bsdfs()[kind].guided) continue;
    const auto throughput =
        float(Luminance(rays.throughput_r[i], rays.throughput_g[i], rays.throughput_b[i]));
    if (!(throughput > 0)) continue;
    pending.push_back({.ray = {.place = PackPlace(box, {s.org_x[row], s.org_y[row], s.org_z[row]},
                                                  {s.ns_x[row], s.ns_y[row], s.ns_z[row]}),
                               .dir = {rays.dir_x[i], rays.dir_y[i], rays.dir_z[i]},
                               .radiance = float(Luminance(w.paths->r[path], w.paths->g[path],
                                                           w.paths->b[path]))},
                       .throughput = throughput,
                       .path = path});
  }
}

// Follows paths as `path` does, and appends what their rays have brought that roulette did not
// choose.
void FollowAndKeepRays(const FrameView& pilot, const PlaceBox& box, const WaveRange& range,
                       Worker& w, std::vector<BounceRay>& found) {
  StageClock clock(w.stats);
  std::vector<PendingRay> pending;
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  GenerateRays(pilot, range, FilmUniforms(w.scratch), LensUniforms(w.scratch), w.paths, *rays);
  std::uint32_t n = range.count;
  for (std::uint32_t bounce = 0; n > 0; ++bounce) {
    if (bounce == pilot.options.max_depth) {
      IntersectLights(pilot, *rays, n, bounce, w, clock);
      break;
    }
    IntersectSurfaces(pilot, *rays, n, bounce, /*only_delta=*/false, w, clock);
    LightSurfaces(pilot, bounce, w, clock);
    n = ScatterSurfaces(pilot, kCameraEnd, 0, bounce, *next, w, clock);
    if (bounce < kFirstRouletteBounce) KeepRays(box, w, *next, n, pending);
    std::swap(rays, next);
  }
  for (const PendingRay& ray : pending) {
    const auto radiance =
        float(Luminance(w.paths->r[ray.path], w.paths->g[ray.path], w.paths->b[ray.path]));
    found.push_back(ray.ray);
    // A path of next to no throughput says nothing about large numbers.
    constexpr float kMost = 1e18f;
    const float brought = (radiance - ray.ray.radiance) / ray.throughput;
    found.back().radiance = std::min(std::max(0.0f, brought), kMost);
  }
}

}  // namespace

std::unique_ptr<BounceGuide> LearnBounces(const FrameView& frame, WorkerPool& pool,
                                          GuideCounts& counts) {
  const PlaceBox box = PlaceBoxOf(frame.sphere);
  if (!(box.side > 0)) return nullptr;
  const auto start = Clock::now();
  std::unique_ptr<BounceGuide> guide;
  std::vector<BounceRay> rays;
  // The first quarter of the pilot is not guided; the rest is guided by what it has learnt.
  constexpr std::uint64_t kMostPaths = 1 << 20;  // of some 250 bytes each while they are learnt
  const FrameView whole =
      PilotView(frame, *frame.strategy, PilotShare(frame, kMostPilotPaths, kMostPaths));
  const std::uint32_t samples = whole.options.samples_per_pixel;
  for (const auto& [first, end] : {std::pair{0u, samples / 4}, std::pair{samples / 4, samples}}) {
    FrameView pilot = whole;
    if (guide) pilot.bounce_guide = guide->view();
    pilot.options.first_sample = first, pilot.options.samples_per_pixel = end - first;
    const std::vector<BounceRay> found = TracePilot<BounceRay>(
        pilot, pool, [&](const WaveRange& range, Worker& worker, std::vector<BounceRay>& some) {
          FollowAndKeepRays(pilot, box, range, worker, some);
        });
    rays.insert(rays.end(), found.begin(), found.end());
    guide = std::make_unique<BounceGuide>(rays, box);
    counts.paths += PilotPaths(pilot);
  }
  counts.samples += rays.size(), counts.bytes += guide->bytes();
  counts.seconds += SecondsSince(start);
  return guide;
}

}  // namespace skywave
