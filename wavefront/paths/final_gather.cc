#include "wavefront/paths/final_gather.h"

#include <algorithm>
#include <utility>

#include "kernels/sampler.h"
#include "wavefront/stages/path_stages.h"
#include "wavefront/stages/photon_stages.h"

namespace skywave {
namespace {

// The queue of a hit that has been set aside has this bit.
constexpr std::uint32_t kAside = 1u << 31;

// Counts the queues of hits [0, n) anew.
SurfaceRanges RangesOf(const std::uint32_t* queue, std::uint32_t n) {
  std::uint32_t count[kBsdfKinds] = {};
  for (std::uint32_t i = 0; i < n; ++i) {
    if (queue[i] < kBsdfKinds) ++count[queue[i]];
  }
  SurfaceRanges ranges;
  for (std::uint32_t kind = 0; kind < kBsdfKinds; ++kind) {
    ranges.begin[kind + 1] = ranges.begin[kind] + count[kind];
  }
  return ranges;
}

// Leaves those hits of rays [0, n) in their queues at which photons are looked up: on BSDFs with a
// density, at least `near` from where the ray began. The others are set aside.
void SetAside(const RayColumns& rays, float near, std::uint32_t n, SortedHits& hits) {
  std::uint32_t* const queue = hits.queues->queue;
  for (std::uint32_t i = 0; i < n; ++i) {
    const bool stays = queue[i] < kFirstDeltaBsdf && rays.t_far[i] >= near;
    if (!stays) queue[i] |= kAside;
  }
  hits.ranges = RangesOf(queue, n);
}

// Puts the hits back that have been set aside, in exchange for the others.
void ExchangeHits(std::uint32_t n, SortedHits& hits) {
  std::uint32_t* const queue = hits.queues->queue;
  for (std::uint32_t i = 0; i < n; ++i) queue[i] ^= kAside;
  hits.ranges = RangesOf(queue, n);
}

void Scale(const RayColumns& rays, std::uint32_t n, float factor) {
  for (float* const column : {rays.throughput_r, rays.throughput_g, rays.throughput_b}) {
    for (std::uint32_t i = 0; i < n; ++i) column[i] *= factor;
  }
}

SurfaceRanges DenseOnly(SurfaceRanges ranges) {
  std::fill(ranges.begin + kFirstDeltaBsdf, ranges.begin + kBsdfKinds + 1, ranges.light_sampled());
  return ranges;
}

// Returns the pairs of the light samples at surfaces that rays of an index meet. They lie after
// those of all directions; a strategy may draw candidates from kCandidateBlocks more. If there are
// more indices than numbers, some indices share them.
std::uint32_t GatheredLightPairs(const FrameView& frame, std::uint32_t index) {
  constexpr std::uint32_t kAll = kLightPathPairs / kPairBlock;
  const std::uint32_t gather = frame.options.of<PhotonOptions>().gather;
  const std::uint32_t each = frame.light_shares().total() + kCandidateBlocks;
  const std::uint32_t room = std::max((kAll - 1 - gather) / each, 1u);
  return kPairBlock * (1 + gather + index % room * each);
}

// Returns how many of rays [0, n) come from BSDFs with a density. They are the first ones.
std::uint32_t CountDense(const RayColumns& rays, std::uint32_t n) {
  return std::uint32_t(std::find(rays.pdf, rays.pdf + n, 0.0f) - rays.pdf);
}

}  // namespace

void GatherPhotons(const FrameView& frame, std::uint32_t bounce, Worker& w, StageClock& clock) {
  PhotonTables& t = w.of<PhotonTables>();
  const PhotonMaps& maps = *frame.find<PhotonMaps>();
  const std::uint32_t gather = frame.options.of<PhotonOptions>().gather,
                      max_depth = frame.options.max_depth;
  const SurfaceRanges dense = DenseOnly(w.ranges);
  if (dense.total() == 0 || bounce + 1 >= max_depth) return;
  for (std::uint32_t index = 0; index < gather; ++index) {
    soa::Table<RayColumns>*rays = &t.rays[0], *next = &t.rays[1];
    // The rays of an index have random numbers of their own; the first surface's are one sequence.
    const PathEnd first = {.transport = Transport::kRadiance,
                           .pairs = kPairBlock,
                           .split = {.stride = gather, .offset = index}};
    const PathEnd end = {.transport = Transport::kRadiance, .pairs = kPairBlock * (1 + index)};
    const std::uint32_t light_pairs = GatheredLightPairs(frame, index);
    std::uint32_t n = Scatter(frame, PointsIn(dense, frame, w), {first, bounce}, w.scratch, *rays);
    if (gather > 1) Scale(*rays, n, 1.0f / float(gather));
    clock.Lap(Stage::kScatter);
    // The current surfaces make room for those that their rays hit.
    std::swap(w.surfaces, t.surfaces), std::swap(w.ranges, t.ranges);
    // So many rays, the first ones, see lights. Those of the surfaces that gather do not, because
    // their direct light is there already, and what is seen over mirrors and glass are caustics.
    std::uint32_t seeing = 0;
    for (std::uint32_t scattered = bounce + 1; n > 0; ++scattered) {
      SortedHits hits =
          TraceAndSort(frame, end, *rays, n, scattered, /*only_delta=*/false, w, clock);
      const std::uint32_t* const queue = hits.queues->queue;
      const auto escaped = std::uint32_t(std::count(queue, queue + seeing, kMissQueue));
      SeeLights(frame, *rays, hits.queues, seeing, escaped, scattered, FromOwnSurfaces(frame, w), w,
                clock);
      if (scattered == max_depth) break;
      const std::uint32_t left = max_depth - scattered;
      SetAside(*rays, maps.indirect.near, n, hits);
      PrepareHits(frame, end, *rays, n, hits, w, clock);
      AddPhotons(frame, maps.indirect, left, w, clock);
      ExchangeHits(n, hits);
      PrepareHits(frame, end, *rays, n, std::move(hits), w, clock);
      LightSurfaces(frame, scattered, w, clock, light_pairs);
      AddPhotons(frame, maps.caustic, left, w, clock);
      // The last rays only see lights.
      const SurfaceRanges going = left == 1 ? DenseOnly(w.ranges) : w.ranges;
      const std::uint32_t first_kind = left == 1 ? frame.first_bsdf_that_sees_light() : 0;
      n = Scatter(frame, PointsIn(going, frame, w), {end, scattered, first_kind}, w.scratch, *next);
      clock.Lap(Stage::kScatter);
      std::swap(rays, next);
      seeing = CountDense(*rays, n);
    }
    std::swap(w.surfaces, t.surfaces), std::swap(w.ranges, t.ranges);
  }
}

}  // namespace skywave
