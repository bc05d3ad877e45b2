// Where light ends on coarse meshes with smooth normals.
#pragma once

#include <span>

#include "base/names.h"
#include "wavefront/frame.h"
#include "wavefront/render_option.h"
#include "wavefront/worker.h"

namespace skywave {

enum class ShadowTerminator {
  kFacets,  // at the edges of triangles, behind which light cannot come from
  kSmooth   // as on the surface that the normals mean
};
template <>
inline constexpr auto kEnumNames<ShadowTerminator> = std::to_array<Named<ShadowTerminator>>(
    {{ShadowTerminator::kFacets, "facets"}, {ShadowTerminator::kSmooth, "smooth"}});

struct TerminatorOptions {
  ShadowTerminator terminator = ShadowTerminator::kFacets;
};

// The option of integrators that follow paths from the camera alone: what light paths leave on
// triangles is light by area of these, and not of a smooth surface.
std::span<const RenderOption> TerminatorOptionTable();

// Rounds the current surfaces of BSDFs that do not transmit (RoundSurfaces), if the options say so.
// What film keeps of the first surfaces has been kept before, because it is of triangles.
void RoundTerminator(const FrameView& frame, const Worker& w);

}  // namespace skywave
