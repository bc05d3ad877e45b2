#include "wavefront/passes/merging_pass.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "wavefront/passes/footprint.h"
#include "wavefront/passes/photon_collector.h"
#include "wavefront/paths/light_paths.h"
#include "wavefront/stages/merging.h"

namespace skywave {
namespace {

// Merges blur light at edges, and connections find most of it without them: half of the lookup
// distance of photons is enough.
constexpr float kMergedDistance = 0.5f;

// Surfaces near each other are merged with the same light paths, so the noise of merges does not
// average out over pixels as that of other techniques does, and weights by densities alone overrate
// them (Grittmann, Georgiev and Slusallek 2021). They count as this share of their number.
constexpr float kMergeWorth = 0.3f;

// Traces light sub-paths [first, first + count) of the frame and stores their vertices with a
// density in the order (path, surface), with what weights need.
void TraceVertexWave(const FrameView& frame, std::uint64_t first, std::uint32_t count, Worker& w,
                     PhotonList& list) {
  StageClock clock(w.stats);
  FollowLightSubpaths(frame, first, count, w, clock,
                      [&](std::uint32_t bounce) { StoreVertices(bounce, w, list, clock); });
  list.SortByPath(count);
  clock.Lap(Stage::kPhotons);
}

// Returns the vertices of light paths [first, first + count) of the frame, or of the first of them
// that have `most` together.
PhotonMap MapOfVertices(const FrameView& frame, std::uint64_t first, std::uint64_t count,
                        std::uint64_t most, WorkerPool& pool) {
  const std::uint32_t max_depth = frame.options.max_depth;
  PhotonCollector caustic, vertices(std::min(most, count * max_depth), max_depth, true);
  const auto trace = [](const FrameView& view, std::uint64_t number, std::uint32_t paths,
                        Worker& worker, PhotonLists& lists) {
    TraceVertexWave(view, number, paths, worker, lists.indirect);
  };
  CollectPhotons(frame, first, count, trace, caustic, vertices, pool);
  return PhotonMap(vertices.photons(), vertices.light_paths(), vertices.subpaths());
}

}  // namespace

float MergePlan::MergedArea(const PhotonPass& pass) const {
  const float r = radius * pass.shrink;
  return kMergeWorth * std::numbers::pi_v<float> * r * r * float(light_paths);
}

MergePlan PlanMerging(const FrameView& frame, WorkerPool& pool) {
  const RenderOptions& options = frame.options;
  const auto& wanted = options.of<PhotonOptions>();
  if (options.max_depth == 0) return {.light_paths = 0, .radius = 0};
  const std::uint64_t samples = PictureSamples(options).count() / PhotonPasses(options).size();
  const std::uint64_t most = frame.light_paths() * samples;
  const std::uint64_t traced = std::min(most, kPlanningPaths);
  const PhotonMap map = MapOfVertices(frame, kFirstPlanningPath, traced,
                                      std::numeric_limits<std::uint64_t>::max(), pool);
  const double vertices = double(map.size()) / double(traced);  // per light path
  MergePlan plan = {.light_paths = most, .radius = wanted.distance};
  if (vertices * double(most) > wanted.indirect) {
    plan.light_paths = std::uint64_t(std::ceil(wanted.indirect / vertices));
  }
  if (plan.radius <= 0) {
    const float more = float(double(plan.light_paths) / double(traced));
    plan.radius =
        std::min(kMergedDistance * map.TypicalDistance(wanted.neighbors) / std::sqrt(more),
                 PixelRadius(frame, pool));
  }
  return plan;
}

PhotonMap TraceVertices(const FrameView& frame, const MergePlan& plan, const PhotonPass& pass,
                        WorkerPool& pool) {
  const std::uint64_t first = std::uint64_t(pass.samples.first) << 32;
  PhotonMap map =
      MapOfVertices(frame, first, TechniquesOf(frame).eta_vcm > 0 ? plan.light_paths : 0,
                    frame.options.of<PhotonOptions>().indirect, pool);
  map.radius = plan.radius * pass.shrink;
  return map;
}

}  // namespace skywave
