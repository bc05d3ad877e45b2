#include "wavefront/stages/photon_stages.h"

#include <algorithm>
#include <utility>

#include "kernels/sampler.h"
#include "kernels/surface/surface.h"
#include "wavefront/photons/photon_cover.h"
#include "wavefront/stages/path_stages.h"

namespace skywave {
namespace {

void Append(const Photon& photon, std::uint32_t path, PhotonList& list) {
  list.photons.push_back(photon);
  list.path.push_back(path);
}

// One surface that looks photons up.
struct Lookup {
  const PhotonMapView& map;
  const SurfaceColumns& surfaces;
  std::uint32_t row;
  const BsdfKernels& bsdf;
  MaterialView materials;
};

// Adds what the surface reflects of photons `found` [0, n).
void AddReflected(const Lookup& at, const PhotonQuery& query, const NeighborColumns& found,
                  std::uint32_t n, PhotonTables& t, float* rgb) {
  LoadPhotons(at.map.photons, found, n, query, t.lights);
  RepeatSurface(at.surfaces, at.row, PaddedRows(n) - kPadRows, t.repeated);
  at.bsdf.evaluate(t.repeated, at.materials, t.lights, n, t.values);
  SumReflected(t.values, t.lights, n, rgb);
}

PhotonQuery QueryOf(const PhotonDisk& disk, PhotonKernel kernel, std::uint32_t max_depth) {
  return {.kernel = kernel,
          .radius2 = disk.radius2,
          .normal = {disk.normal[0], disk.normal[1], disk.normal[2]},
          .max_depth = max_depth};
}

PhotonDisk DiskOf(const SurfaceColumns& s, std::uint32_t row, float radius2) {
  return {.point = {s.org_x[row], s.org_y[row], s.org_z[row]},
          .normal = {s.ng_x[row], s.ng_y[row], s.ng_z[row]},
          .radius2 = radius2,
          .height = 0};
}

void AddToPath(const SurfaceColumns& s, std::uint32_t row, float scale, const float* rgb,
               const PathColumns& paths) {
  const std::uint32_t path = s.path[row];
  paths.r[path] += s.throughput_r[row] * (rgb[0] * scale);
  paths.g[path] += s.throughput_g[row] * (rgb[1] * scale);
  paths.b[path] += s.throughput_b[row] * (rgb[2] * scale);
}

// The disk that photons are looked up in: it ends at the farthest of `wanted` neighbors, which then
// does not count itself, or the density would be too high by one photon. If there are fewer within
// the largest distance, it ends there.
float DiskRadius2(const NeighborColumns& found, std::uint32_t count, std::uint32_t wanted,
                  float largest2) {
  if (count < wanted) return largest2;
  const float farthest2 = *std::max_element(found.distance2, found.distance2 + count);
  return std::max(farthest2, 0x1p-40f * largest2);
}

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
  const std::uint32_t gather = frame.options.photons.gather;
  const std::uint32_t each = frame.light_shares().plan.total() + kCandidateBlocks;
  const std::uint32_t room = std::max((kAll - 1 - gather) / each, 1u);
  return kPairBlock * (1 + gather + index % room * each);
}

// Returns how many of rays [0, n) come from BSDFs with a density. They are the first ones.
std::uint32_t CountDense(const RayColumns& rays, std::uint32_t n) {
  return std::uint32_t(std::find(rays.pdf, rays.pdf + n, 0.0f) - rays.pdf);
}

}  // namespace

Photon PhotonAt(const SurfaceColumns& s, std::uint32_t row, std::uint32_t depth) {
  return {.position = {s.org_x[row], s.org_y[row], s.org_z[row]},
          .flux = {s.throughput_r[row], s.throughput_g[row], s.throughput_b[row]},
          .dir = EncodeNormal(s.wo_x[row], s.wo_y[row], s.wo_z[row]),
          .normal = EncodeNormal(s.ng_x[row], s.ng_y[row], s.ng_z[row]),
          .depth = depth};
}

void PhotonList::SortByPath(std::uint32_t paths) {
  std::vector<std::uint32_t> first(paths + 1, 0);
  for (const std::uint32_t p : path) ++first[p + 1];
  for (std::uint32_t p = 0; p < paths; ++p) first[p + 1] += first[p];
  PhotonList sorted;
  sorted.photons.resize(photons.size()), sorted.path.resize(path.size());
  sorted.subpath.resize(subpath.size());
  for (std::size_t i = 0; i < photons.size(); ++i) {
    const std::uint32_t to = first[path[i]]++;
    sorted.photons[to] = photons[i], sorted.path[to] = path[i];
    if (!subpath.empty()) sorted.subpath[to] = subpath[i];
  }
  *this = std::move(sorted);
}

void StorePhotons(const WantedPhotons& wanted, std::uint32_t depth, Worker& w, PhotonLists& lists,
                  StageClock& clock) {
  const SurfaceColumns& s = w.surfaces;
  for (std::uint32_t row = 0; row < w.ranges.light_sampled(); ++row) {
    const std::uint32_t before = w.history->met[s.path[row]];
    const bool caustic = before == kMetDelta;
    const bool indirect = (before & kMetDense) != 0 || wanted.all_light;
    if (caustic && wanted.caustic) Append(PhotonAt(s, row, depth), s.path[row], lists.caustic);
    if (indirect && wanted.indirect) Append(PhotonAt(s, row, depth), s.path[row], lists.indirect);
  }
  RememberSurfaces(w);
  clock.Lap(Stage::kPhotons);
}

void AddPhotons(const FrameView& frame, const PhotonMap& map, std::uint32_t max_depth, Worker& w,
                StageClock& clock) {
  if (map.size() == 0) return;
  const PhotonOptions& options = frame.options.photons;
  const PhotonMapView view = map.view();
  const SurfaceColumns& s = w.surfaces;
  PhotonTables& t = *w.photon;
  const std::uint32_t room = NearestRoom(options.neighbors);
  ForEachBsdfBlock(
      w.ranges, kDenseBsdfs, kLookupBlock, [&](const BsdfKernels& bsdf, const BsdfRows& block) {
        std::uint32_t count[kLookupBlock], row[kLookupBlock];
        DiskSurface surfaces[kLookupBlock];
        // Disks that may be cut come first; those that look whole are counted from the end.
        std::uint32_t cut = 0, whole = kLookupBlock;
        RangeSearch searches[kLookupBlock];
        PhotonDisk disks[kLookupBlock];
        if (!options.progressive()) {
          FindNearest(view.tree, s.org_x + block.begin, s.org_y + block.begin,
                      s.org_z + block.begin, block.n, options.neighbors, view.radius2, t.found,
                      count);
        }
        for (std::uint32_t i = 0; i < block.n; ++i) {
          const NeighborColumns found = Slice(t.found.columns(), i * room);
          PhotonDisk disk = DiskOf(s, block.begin + i, view.radius2);
          if (options.progressive()) {
            searches[i] = StartRangeSearch(view.tree, disk.point, view.radius2);
            count[i] = FindMore(view.tree, searches[i], room, found);
          } else {
            disk.radius2 = DiskRadius2(found, count[i], options.neighbors, view.radius2);
          }
          if (count[i] == 0) continue;
          // A disk that looks whole needs no rays. The first part of a range search is no fair
          // sample.
          const bool doubtful =
              options.progressive() || count[i] < options.neighbors ||
              !LooksWhole(disk, options.kernel, view.photons, view.tree, found, count[i]);
          if (doubtful) {
            disks[cut] = disk, row[cut++] = i;
          } else {
            disks[--whole] = disk, row[whole] = i, surfaces[whole].seen = kAllCells;
          }
        }
        CoverDisks(frame, disks, cut, w.stats, surfaces, clock);
        for (std::uint32_t i = 0; i < kLookupBlock; ++i) {
          if (i >= cut && i < whole) continue;
          const NeighborColumns found = Slice(t.found.columns(), row[i] * room);
          const Lookup at = {.map = view,
                             .surfaces = s,
                             .row = block.begin + row[i],
                             .bsdf = bsdf,
                             .materials = frame.geometry->materials()};
          const PhotonQuery query = QueryOf(disks[i], options.kernel, max_depth);
          float rgb[3] = {};
          for (std::uint32_t n = count[row[i]]; n > 0;) {
            if (i < cut) {
              CloseUnseen(disks[i], options.kernel, surfaces[i], view.photons, view.tree, found, n);
            }
            AddReflected(at, query, found, n, t, rgb);
            n = options.progressive() ? FindMore(view.tree, searches[row[i]], room, found) : 0;
          }
          AddToPath(s, at.row, 1 / CoverOf(surfaces[i].seen), rgb, w.paths);
        }
      });
  clock.Lap(Stage::kPhotons);
}

void GatherPhotons(const FrameView& frame, std::uint32_t bounce, Worker& w, StageClock& clock) {
  PhotonTables& t = *w.photon;
  const PhotonMaps& maps = *frame.photons;
  const std::uint32_t gather = frame.options.photons.gather, max_depth = frame.options.max_depth;
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
    std::uint32_t n = Scatter(frame, first, w.paths, w.surfaces, dense, 0, bounce,
                              DirectionUniforms(w.scratch), LobeUniforms(w.scratch), *rays);
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
      n = Scatter(frame, end, w.paths, w.surfaces, going, first_kind, scattered,
                  DirectionUniforms(w.scratch), LobeUniforms(w.scratch), *next);
      clock.Lap(Stage::kScatter);
      std::swap(rays, next);
      seeing = CountDense(*rays, n);
    }
    std::swap(w.surfaces, t.surfaces), std::swap(w.ranges, t.ranges);
  }
}

}  // namespace skywave
