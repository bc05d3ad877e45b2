#include "wavefront/stages/merging.h"

#include <algorithm>

#include "kernels/accumulate.h"
#include "kernels/light_paths/photons.h"
#include "wavefront/stages/bidirectional.h"

namespace skywave {
namespace {

// Adds what the pairs in rows [0, n) bring to their paths, whose surfaces have the BSDF `kind`.
// Pairs of a path are added one after the other, so it does not matter which of them share a table.
void AddMerged(const FrameView& frame, const SubpathColumns& vertices, std::uint32_t kind,
               std::uint32_t n, Worker& w) {
  MergeTables& t = w.of<MergeTables>();
  const MaterialView materials = frame.geometry->materials();
  SurfaceRanges ranges;
  std::fill(ranges.begin + kind + 1, ranges.begin + kBsdfKinds + 1, n);
  Bsdfs()[kind].evaluate(t.surfaces, materials, t.lights, n, t.seen.forward);
  EvaluateBackward(materials, t.surfaces, ranges, t.lights, t.turned, t.seen.backward);
  MergeVertices(t.surfaces, t.at, t.seen.forward, t.seen.backward->pdf, vertices, t.found->point, n,
                TechniquesOf(frame), t.lights);
  AddUnoccludedRadiance(t.lights, t.surfaces->path, n, w.paths);
}

// Copies the surface in `row` to rows [begin, begin + n) of the pairs.
void RepeatVertex(const Worker& w, std::uint32_t row, std::uint32_t begin, std::uint32_t n) {
  const MergeTables& t = w.of<MergeTables>();
  const SurfaceColumns& s = w.surfaces;
  const SubpathColumns& at = w.of<BidirectionalTables>().at;
  RepeatSurface(s, row, n, Slice(t.surfaces.columns(), begin));
  const auto repeat = [&](const auto* column, auto* copies) {
    std::fill_n(copies + begin, n, column[row]);
  };
  repeat(s.throughput_r, t.surfaces->throughput_r);
  repeat(s.throughput_g, t.surfaces->throughput_g);
  repeat(s.throughput_b, t.surfaces->throughput_b);
  repeat(s.path, t.surfaces->path);
  repeat(at.d_vcm, t.at->d_vcm);
  repeat(at.d_vc, t.at->d_vc);
}

}  // namespace

void StoreVertices(std::uint32_t depth, Worker& w, PhotonList& list, StageClock& clock) {
  const SubpathColumns& at = w.of<BidirectionalTables>().at;
  for (std::uint32_t row = 0; row < w.ranges.light_sampled(); ++row) {
    list.photons.push_back(PhotonAt(w.surfaces, row, depth));
    list.path.push_back(w.surfaces->path[row]);
    list.subpath.push_back({at.d_vcm[row], at.d_vc[row]});
  }
  clock.Lap(Stage::kPhotons);
}

void MergeSurfaces(const FrameView& frame, std::uint32_t bounce, Worker& w, StageClock& clock) {
  const PhotonMap& map = frame.find<PhotonMaps>()->indirect;
  if (map.size() == 0) return;
  const PhotonMapView view = map.view();
  const MergeTables& t = w.of<MergeTables>();
  const SurfaceColumns& s = w.surfaces;
  ForEachBsdf(w.ranges, kDenseBsdfs, [&](const BsdfKernels&, const BsdfRows& rows) {
    std::uint32_t pairs = 0;
    for (std::uint32_t row = rows.begin; row < rows.begin + rows.n; ++row) {
      const float position[3] = {s.org_x[row], s.org_y[row], s.org_z[row]};
      const PhotonQuery query = {.kernel = frame.options.of<PhotonOptions>().kernel,
                                 .radius2 = view.radius2,
                                 .normal = {s.ng_x[row], s.ng_y[row], s.ng_z[row]},
                                 .max_depth = frame.options.max_depth - bounce};
      RangeSearch search = StartRangeSearch(view.tree, position, view.radius2);
      while (const std::uint32_t found = FindMore(view.tree, search, MergeTables::kRows - pairs,
                                                  Slice(t.found.columns(), pairs))) {
        LoadPhotons(view.photons, Slice(t.found.columns(), pairs), found, query,
                    Slice(t.lights.columns(), pairs));
        RepeatVertex(w, row, pairs, found);
        pairs += found;
        if (pairs + 2 * kLeafPoints <= MergeTables::kRows) continue;
        AddMerged(frame, view.subpaths, rows.kind, pairs, w);
        pairs = 0;
      }
    }
    if (pairs > 0) AddMerged(frame, view.subpaths, rows.kind, pairs, w);
  });
  clock.Lap(Stage::kPhotons);
}

}  // namespace skywave
