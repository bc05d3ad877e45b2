#include "wavefront/stages/photon_stages.h"

#include <algorithm>
#include <utility>

#include "kernels/surface/surface.h"
#include "wavefront/stages/path_stages.h"
#include "wavefront/stages/photon_cover.h"

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

// What all blocks of a lookup have in common.
struct PhotonLookups {
  const FrameView& frame;
  const PhotonOptions& options;
  PhotonMapView map;
  const SurfaceColumns& surfaces;
  PhotonTables& tables;
  std::uint32_t max_depth;
  std::uint32_t room;  // for the photons of a surface

  // Returns where the photons of surface `i` of a block are.
  NeighborColumns found(std::uint32_t i) const { return Slice(tables.found.columns(), i * room); }
};

// The lookups of a few surfaces. Disks that may be cut come first, `cut` of them; those that look
// whole are counted from the end, from `whole` on. `row` is the surface of each disk in the block;
// photons and searches go by surface.
struct PhotonBlock {
  std::uint32_t cut = 0, whole = kLookupBlock;
  PhotonDisk disks[kLookupBlock];
  DiskSurface seen[kLookupBlock];
  std::uint32_t row[kLookupBlock];
  std::uint32_t count[kLookupBlock];
  RangeSearch searches[kLookupBlock];  // where the radius shrinks from pass to pass
};

// Finds the photons of a block: the nearest ones, or the first of those within a radius that
// shrinks from pass to pass. A disk that looks whole needs no rays. The first part of a range
// search is no fair sample of its disk.
void FindPhotons(const PhotonLookups& of, const BsdfRows& rows, PhotonBlock& block) {
  const SurfaceColumns& s = of.surfaces;
  const bool progressive = of.options.progressive();
  const std::uint32_t wanted = of.options.neighbors;
  if (!progressive) {
    FindNearest(of.map.tree, s.org_x + rows.begin, s.org_y + rows.begin, s.org_z + rows.begin,
                rows.n, wanted, of.map.radius2, of.tables.found, block.count);
  }
  for (std::uint32_t i = 0; i < rows.n; ++i) {
    const NeighborColumns found = of.found(i);
    PhotonDisk disk = DiskOf(s, rows.begin + i, of.map.radius2);
    if (progressive) {
      block.searches[i] = StartRangeSearch(of.map.tree, disk.point, of.map.radius2);
      block.count[i] = FindMore(of.map.tree, block.searches[i], of.room, found);
    } else {
      disk.radius2 = DiskRadius2(found, block.count[i], wanted, of.map.radius2);
    }
    if (block.count[i] == 0) continue;
    const bool doubtful =
        progressive || block.count[i] < wanted ||
        !LooksWhole(disk, of.options.kernel, of.map.photons, of.map.tree, found, block.count[i]);
    const std::uint32_t at = doubtful ? block.cut++ : --block.whole;
    block.disks[at] = disk, block.row[at] = i;
    if (!doubtful) block.seen[at].seen = kAllCells;
  }
}

// Adds what the surfaces of a block reflect of their photons, divided by the area of the part of
// each disk that is surface.
void ReflectPhotons(const PhotonLookups& of, const BsdfKernels& bsdf, const BsdfRows& rows,
                    PhotonBlock& block, const PathColumns& paths) {
  const PhotonMapView& map = of.map;
  for (std::uint32_t i = 0; i < kLookupBlock; ++i) {
    if (i >= block.cut && i < block.whole) continue;
    const std::uint32_t row = block.row[i];
    const NeighborColumns found = of.found(row);
    const Lookup at = {.map = map,
                       .surfaces = of.surfaces,
                       .row = rows.begin + row,
                       .bsdf = bsdf,
                       .materials = of.frame.geometry->materials()};
    const PhotonQuery query = QueryOf(block.disks[i], of.options.kernel, of.max_depth);
    float rgb[3] = {};
    for (std::uint32_t n = block.count[row]; n > 0;) {
      if (i < block.cut) {
        CloseUnseen(block.disks[i], of.options.kernel, block.seen[i], map.photons, map.tree, found,
                    n);
      }
      AddReflected(at, query, found, n, of.tables, rgb);
      n = of.options.progressive() ? FindMore(map.tree, block.searches[row], of.room, found) : 0;
    }
    AddToPath(of.surfaces, at.row, 1 / CoverOf(block.seen[i].seen), rgb, paths);
  }
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
  const auto& options = frame.options.of<PhotonOptions>();
  const PhotonLookups lookups = {.frame = frame,
                                 .options = options,
                                 .map = map.view(),
                                 .surfaces = w.surfaces,
                                 .tables = w.of<PhotonTables>(),
                                 .max_depth = max_depth,
                                 .room = NearestRoom(options.neighbors)};
  ForEachBsdfBlock(
      w.ranges, kDenseBsdfs, kLookupBlock, [&](const BsdfKernels& bsdf, const BsdfRows& rows) {
        PhotonBlock block;
        FindPhotons(lookups, rows, block);
        const CoveredDisks disks = {options.kernel, block.disks, block.seen, block.cut};
        CoverDisks(frame, disks, w.stats, clock);
        ReflectPhotons(lookups, bsdf, rows, block, w.paths);
      });
  clock.Lap(Stage::kPhotons);
}

}  // namespace skywave
