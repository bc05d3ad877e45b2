#include "wavefront/policies/visibility_pilot.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "lights/strategies/visibility.h"
#include "wavefront/paths/pilot.h"
#include "wavefront/soa.h"

namespace skywave {
namespace {

// Collects rays that have left surfaces with a density: whether they arrived at the map, and where.
class VisibilityRayList {
 public:
  VisibilityRayList(const FrameView& pilot, const VisibilityStrategy& strategy, const PlaceBox& box,
                    std::vector<VisibilityRay>& rays)
      : strategy_(strategy), box_(box), cells_(PaddedRows(pilot.options.wave)), rays_(rays) {}

  void SeeRays(const Worker& w, const RayColumns& rays, std::uint32_t n) {
    strategy_.CellsOf(rays.dir_x, rays.dir_y, rays.dir_z, n, cells_.data());
    for (std::uint32_t i = 0; i < n; ++i) {
      if (!(rays.pdf[i] > 0)) continue;
      Add(w, rays.from[i], {rays.dir_x[i], rays.dir_y[i], rays.dir_z[i]}, cells_[i],
          w.hits->geom[i] == kNoHit);
    }
  }
  void SeeEscapes(const Worker&, std::uint32_t) {}
  void SeeLightSamples(const Worker& w, std::uint32_t n) {
    const LightColumns& lights = w.lights;
    strategy_.CellsOf(lights.dir_x, lights.dir_y, lights.dir_z, n, cells_.data());
    for (std::uint32_t i = 0; i < n; ++i) {
      if (!(lights.pdf[i] > 0)) continue;
      // Only light from infinitely far away has this reach, unless it is occluded.
      Add(w, i, {lights.dir_x[i], lights.dir_y[i], lights.dir_z[i]}, cells_[i],
          lights.t_far[i] == std::numeric_limits<float>::infinity());
    }
  }

 private:
  // Rays to the other side of a surface are left out: light samples of opaque surfaces that end
  // there have not been traced.
  void Add(const Worker& w, std::uint32_t row, const std::array<float, 3>& dir, std::uint32_t cell,
           bool arrived) {
    const SurfaceColumns& s = w.surfaces;
    const float above = s.ng_x[row] * dir[0] + s.ng_y[row] * dir[1] + s.ng_z[row] * dir[2];
    const float cosine = s.ns_x[row] * dir[0] + s.ns_y[row] * dir[1] + s.ns_z[row] * dir[2];
    if (!(above > 0 && cosine > 0)) return;
    rays_.push_back(PackVisibilityRay(box_, {s.org_x[row], s.org_y[row], s.org_z[row]},
                                      {s.ns_x[row], s.ns_y[row], s.ns_z[row]}, cell, arrived));
  }

  const VisibilityStrategy& strategy_;
  PlaceBox box_;
  std::vector<std::uint32_t> cells_;
  std::vector<VisibilityRay>& rays_;
};

}  // namespace

std::unique_ptr<VisibilityStrategy> LearnVisibility(const FrameView& frame,
                                                    const EnvStrategy& strategy, WorkerPool& pool,
                                                    PilotCounts& counts) {
  const VisibilityStrategy* const untaught = dynamic_cast<const VisibilityStrategy*>(&strategy);
  if (untaught == nullptr || !frame.has_environment()) return nullptr;
  const PlaceBox box = PlaceBoxOf(frame.sphere);
  if (!(box.side > 0)) return nullptr;
  const auto start = Clock::now();
  std::unique_ptr<VisibilityStrategy> taught;
  std::vector<VisibilityRay> rays;
  // The first quarter of the pilot finds out whether and where light is kept out, so that the rest
  // learns more of what comes in.
  const std::uint32_t samples = PilotView(frame, strategy).options.samples_per_pixel;
  for (const auto& [first, end] : {std::pair{0u, samples / 4}, std::pair{samples / 4, samples}}) {
    const VisibilityStrategy& used = taught ? *taught : *untaught;
    FrameView pilot = PilotView(frame, used);
    pilot.options.first_sample = first, pilot.options.samples_per_pixel = end - first;
    if (Describe(frame.options.integrator).direct_light_only) pilot.options.max_depth = 1;
    const std::vector<VisibilityRay> found = TracePilot<VisibilityRay>(
        pilot, pool, [&](const WaveRange& range, Worker& worker, std::vector<VisibilityRay>& some) {
          VisibilityRayList list(pilot, used, box, some);
          FollowPilotPaths(pilot, range, worker, list);
        });
    rays.insert(rays.end(), found.begin(), found.end());
    taught = untaught->Taught(rays, box);
    counts.paths += PilotPaths(pilot);
    if (taught->learnt() == 0) break;  // in the open there is nothing more to learn
  }
  counts.samples += rays.size(), counts.bytes += taught->table_bytes();
  counts.seconds += SecondsSince(start);
  return taught;
}

}  // namespace skywave
