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

}  // namespace skywave
