#include "wavefront/bidirectional.h"

#include <utility>

#include "kernels/flux.h"

namespace skywave {

void EvaluateBothWays(const MaterialView& materials, const SurfaceColumns& surfaces,
                      const SurfaceRanges& ranges, const LightColumns& lights,
                      const TurnedColumns& turned, const BothWays& out) {
  // In ascending order: the last vector of a BSDF may spill over the first rows of the next.
  for (std::uint32_t kind = 0; kind < kFirstDeltaBsdf; ++kind) {
    const std::uint32_t begin = ranges.begin[kind], n = ranges.count(kind);
    if (n == 0) continue;
    const BsdfKernels& bsdf = Bsdfs()[kind];
    SurfaceColumns rows = Slice(surfaces, begin);
    LightColumns to = Slice(lights, begin);
    bsdf.evaluate(rows, materials, to, n, Slice(out.forward.columns(), begin));
    if (bsdf.transmits) {
      MoveToSide(to, n, rows);
      const TurnedColumns seen = Slice(turned, begin);
      TurnSurfaces(rows, to, n, seen);
      rows.ng_x = seen.ng_x, rows.ng_y = seen.ng_y, rows.ng_z = seen.ng_z;
      rows.ns_x = seen.ns_x, rows.ns_y = seen.ns_y, rows.ns_z = seen.ns_z;
      rows.material = seen.material;
    }
    std::swap(rows.wo_x, to.dir_x), std::swap(rows.wo_y, to.dir_y), std::swap(rows.wo_z, to.dir_z);
    bsdf.evaluate(rows, materials, to, n, Slice(out.backward.columns(), begin));
  }
}

}  // namespace skywave
