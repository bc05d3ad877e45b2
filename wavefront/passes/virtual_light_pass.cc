#include "wavefront/passes/virtual_light_pass.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "wavefront/passes/photon_pass.h"
#include "wavefront/paths/light_paths.h"
#include "wavefront/records/photon_map.h"

namespace skywave {
namespace {

// Half of the distance between lights bounds their noise where they are dense, at little bias.
constexpr float kBoundedShare = 0.5f;

// Stores the surfaces of bounce `depth` of light paths that have a density.
void StoreVirtualLights(std::uint32_t depth, const Worker& w, std::vector<VirtualLight>& lights) {
  const SurfaceColumns& s = w.surfaces;
  ForEachBsdf(w.ranges, kDenseBsdfs, [&](const BsdfKernels&, const BsdfRows& rows) {
    for (std::uint32_t row = rows.begin; row < rows.begin + rows.n; ++row) {
      VirtualLight light = {.words = {},
                            .position = {s.org_x[row], s.org_y[row], s.org_z[row]},
                            .kind = rows.kind,
                            .depth = depth,
                            .path = s.path[row]};
      std::uint32_t* word = light.words.data();
      SurfaceColumns::ForEachColumn(
          s, [&](const auto* column) { *word++ = std::bit_cast<std::uint32_t>(column[row]); });
      lights.push_back(light);
    }
  });
}

// Returns the lights that light paths [first, first + count) leave.
std::vector<VirtualLight> LightsOfPaths(const FrameView& frame, std::uint64_t first,
                                        std::uint64_t count, WorkerPool& pool) {
  const FrameView view = LightPathView(frame);
  const std::uint64_t wave = frame.options.wave;
  // A light lights another surface at least.
  const std::uint32_t depth = frame.options.max_depth - 1;
  std::vector<std::vector<VirtualLight>> waves((count + wave - 1) / wave);
  pool.ForEach(waves.size(), [&](std::size_t i, Worker& w, RayRecorder* recorder) {
    StageClock clock(w.stats);
    FrameView of_thread = view;
    of_thread.tracer.recorder = recorder;
    const std::uint64_t before = i * wave;
    FollowLightPaths(of_thread, first + before, std::uint32_t(std::min(wave, count - before)),
                     /*first_kind=*/0, depth, w, clock, [&](std::uint32_t bounce) {
                       StoreVirtualLights(bounce, w, waves[i]);
                       clock.Lap(Stage::kPhotons);
                     });
    std::stable_sort(waves[i].begin(), waves[i].end(),
                     [](const VirtualLight& a, const VirtualLight& b) { return a.path < b.path; });
    clock.Lap(Stage::kPhotons);
  });
  std::vector<VirtualLight> all;
  for (const std::vector<VirtualLight>& some : waves) {
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

// Returns the distance within which a light of a set of `count` has one other, on average. `lights`
// are those of the plan.
float DistanceBetween(const std::vector<VirtualLight>& lights, double count) {
  constexpr std::uint32_t kNeighbors = 50;
  if (lights.empty()) return 0;
  std::vector<Photon> points(lights.size());
  for (std::size_t i = 0; i < lights.size(); ++i) {
    std::copy_n(lights[i].position, 3, points[i].position);
  }
  const float found = PhotonMap(points, 1).TypicalDistance(kNeighbors);
  return found * float(std::sqrt(double(lights.size()) / (kNeighbors * count)));
}

}  // namespace

VirtualLightPlan PlanVirtualLights(const FrameView& frame, WorkerPool& pool) {
  if (frame.options.max_depth < 2) return {};
  const auto& options = frame.options.of<VirtualLightOptions>();
  const std::vector<VirtualLight> lights =
      LightsOfPaths(frame, kFirstPlanningPath, kPlanningPaths, pool);
  const double of_a_path = double(lights.size()) / double(kPlanningPaths);
  const double paths = std::min(std::ceil(double(options.count) / of_a_path),
                                double(options.count * kMostPathsAPhoton));
  const double bounded = kBoundedShare * DistanceBetween(lights, paths * of_a_path);
  return {.light_paths = std::uint64_t(paths),
          .distance = options.distance < 0 ? float(bounded) : options.distance};
}

VirtualLights TraceVirtualLights(const FrameView& frame, const VirtualLightPlan& plan,
                                 std::uint32_t sample, WorkerPool& pool) {
  return {.lights = LightsOfPaths(frame, std::uint64_t{sample} << 32, plan.light_paths, pool),
          .light_paths = plan.light_paths,
          .distance = plan.distance};
}

}  // namespace skywave
