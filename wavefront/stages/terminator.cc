#include "wavefront/stages/terminator.h"

#include "kernels/bsdf/bsdf.h"
#include "kernels/surface/terminator.h"
#include "wavefront/option_names.h"

namespace skywave {

std::span<const RenderOption> TerminatorOptionTable() {
  // clang-format off
  static const RenderOption table[] = {
      Refused("rounds surfaces", MakeRenderOption({.name = "shadow-terminator", .group = "Paths", .help = "where light ends on coarse meshes with smooth normals: at the edges of their triangles (facets), or smooth, as on the round surface that the normals mean", .scope = OptionScope::kPixels, .example = "--shadow-terminator smooth"},
                       SKYWAVE_FIELD_OF(TerminatorOptions, terminator), NamesOfEnum<ShadowTerminator>())),
  };
  // clang-format on
  return table;
}

void RoundTerminator(const FrameView& frame, const Worker& w) {
  if (frame.options.of<TerminatorOptions>().terminator == ShadowTerminator::kFacets) return;
  const SurfaceColumns& surfaces = w.surfaces;
  ForEachBsdf(w.ranges, kAllBsdfs, [&](const BsdfKernels& bsdf, const BsdfRows& rows) {
    if (bsdf.transmits) return;
    RoundSurfaces(frame.geometry->triangle_tables(), rows.n, Slice(surfaces, rows.begin));
  });
}

}  // namespace skywave
