#include "wavefront/guiding/emission_pilot.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "kernels/light_paths/emission_guide.h"
#include "wavefront/guiding/pilot.h"
#include "wavefront/stages/path_stages.h"

namespace skywave {
namespace {

// Collects the guide samples of the paths of a wave, line by line, places first, then weights.
class GuideSampleList {
 public:
  GuideSampleList(const FrameView& pilot, const PilotQuestion& question,
                  std::vector<GuideSample>& samples)
      : pilot_(pilot),
        sphere_(pilot.sphere),
        question_(question),
        surfaces_met_(pilot.options.wave),
        places_(pilot.options.wave),
        unit_(std::accumulate(question.radiance.begin(), question.radiance.end(), 0.0) /
              double(question.radiance.size()) / kGuideSampleUnits),
        needs_(samples) {}

  void SeeRays(const Worker&, const RayColumns&, std::uint32_t) {}

  // Adds what rays [0, n) that left the current surfaces see of the environment, as the strategy
  // has it.
  void SeeEscapes(const Worker& w, std::uint32_t n) {
    pilot_.strategy->EvaluateEscaped(Points(pilot_, w), n,
                                     pilot_.light_shares().strategy_samples(1), w.escaped);
    const EscapeColumns& rays = w.escaped;
    LocateOnDisk(sphere_, {rays.dir_x, rays.dir_y, rays.dir_z, w.surfaces, rays.from}, n, places_);
    for (std::uint32_t i = 0; i < n; ++i) {
      const bool delta = !(rays.pdf[i] > 0);
      const std::uint32_t path = rays.path[i];
      if (surfaces_met_[path] < (delta ? 1 : question_.least_surfaces)) continue;
      const double ratio = delta ? 0 : double(rays.light_pdf[i]) / rays.pdf[i];
      const double seen =
          delta ? question_.radiance[places_->cell[i]]
                : Luminance(rays.radiance_r[i], rays.radiance_g[i], rays.radiance_b[i]);
      const double throughput =
          Luminance(rays.throughput_r[i], rays.throughput_g[i], rays.throughput_b[i]);
      Add(w, i, rays.from[i], path, throughput * seen / (1 + ratio * ratio));
    }
  }

  // Counts surfaces [0, n), which have a density, for their paths, and adds those of their light
  // samples that have arrived from infinitely far away.
  void SeeLightSamples(const Worker& w, std::uint32_t n) {
    for (std::uint32_t i = 0; i < n; ++i) ++surfaces_met_[w.surfaces->path[i]];
    const LightColumns& lights = w.lights;
    LocateOnDisk(sphere_, {lights.dir_x, lights.dir_y, lights.dir_z, w.surfaces}, n, places_);
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t path = w.surfaces->path[i];
      // Occluded rays have a negative reach.
      const bool arrives = lights.t_far[i] == std::numeric_limits<float>::infinity();
      if (!arrives || surfaces_met_[path] < question_.least_surfaces) continue;
      Add(w, i, i, path, Luminance(lights.r[i], lights.g[i], lights.b[i]));
    }
  }

 private:
  // Adds line i, which goes through surface `row`.
  void Add(const Worker& w, std::uint32_t i, std::uint32_t row, std::uint32_t path,
           double luminance) {
    constexpr double kMost = 0x1p40;
    const double weight = luminance / unit_;
    if (!(weight >= 1)) return;
    needs_.push_back(
        {.cell = places_->cell[i],
         .u = std::clamp(places_->u[i], 0.0f, 1.0f),
         .v = std::clamp(places_->v[i], 0.0f, 1.0f),
         .point = {w.surfaces->org_x[row], w.surfaces->org_y[row], w.surfaces->org_z[row]},
         .pixel = w.paths->pixel[path],
         .weight = std::uint64_t(std::min(weight, kMost))});
  }

  const FrameView& pilot_;
  SceneSphere sphere_;
  PilotQuestion question_;
  std::vector<std::uint32_t> surfaces_met_;
  soa::Table<DiskPlaceColumns> places_;
  double unit_;
  std::vector<GuideSample>& needs_;
};

}  // namespace

void TracePilotWave(const FrameView& pilot, const WaveRange& range, const PilotQuestion& question,
                    Worker& w, std::vector<GuideSample>& samples) {
  GuideSampleList list(pilot, question, samples);
  FollowPilotPaths(pilot, range, w, list);
}

}  // namespace skywave
