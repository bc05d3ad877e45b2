// These kernels read illumination maps: radiance in a direction, and directions drawn with a
// density proportional to radiance.
//
// The map is a lat-long grid of W x H texels, constant inside a texel where it acts as a light. If
// right, forward and up are the axes of the map, a direction has u = 1/2 + atan2(right, forward) /
// 2 pi, v = acos(up) / pi; texel (i, j) covers [i, i + 1) / W x [j, j + 1) / H, without a shift of
// half a texel between lookup and density. Inside a texel directions are uniform in solid angle, so
// a density is one number per texel, P(texel) / solid angle, and no sine can vanish at a pole.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/lights/search_tree.h"
#include "kernels/packed_radiance.h"

namespace skywave {

// A row lies on the sphere at w = start + step * y, y in [0, 1) downwards. w is sin^2(theta/2) in
// the northern half and cos^2(theta/2) in the southern, which is area-uniform and exact near its
// pole.
struct RowArea {
  float start, step;
};

// A cache line of a map holds neighbours in a row and what an inversion needs of them, so that a
// random access to a map reads one line whatever its purpose. The line is the last item of an
// inversion; inside it the texels' weights follow from the texels: max(0, luminance - base),
// luminance in units of radiance_unit, times their solid angle.
inline constexpr std::uint32_t kLineTexels = 14;
inline constexpr std::uint32_t kLineWords = 16;
struct alignas(64) TexelLine {
  float density;  // density of a texel [1/sr] over its weight without the solid angle
  float left;     // share of the first half of the texels
  PackedRadiance texel[kLineTexels];
};
static_assert(sizeof(TexelLine) == kLineWords * sizeof(std::uint32_t));

struct InversionView {
  SearchTreeView rows;      // one tree over the rows
  SearchTreeView lines;     // one tree per row, over its lines
  const TexelLine* texels;  // the weights: the map's own texels or others of that layout
  float base;               // below 0: all texels weigh the same, for maps without light
};

struct EnvironmentView {
  const TexelLine* texels;  // from the top, row after row of `lines`: the map as a light
  float radiance_unit;      // power of two [scene radiance]
  const float* rgb;         // three floats per texel: the map as it is seen
  std::uint32_t width, height;
  std::uint32_t lines;      // lines per row; texels beyond width are black
  float map_from_world[9];  // rows: right, forward, up
  const RowArea* row_area;  // height entries
};

// The density of light samples over the texels [1/sr] is that of an inversion or of a table for
// each sample that a surface draws, plus that of fixed samples whatever the number of samples.
// Tables are row-major, with one value per texel.
struct TexelDensity {
  const InversionView* inversion = nullptr;
  const float* table = nullptr;
  const float* fixed = nullptr;
};

// Below, `samples` is the number of light samples that a surface takes by that technique. Densities
// are multiplied by it, so they count samples per steradian and combine in multiple importance
// sampling whatever the number.

// Fills dir, r, g, b (radiance) and pdf of rows [0, n) by inversion of the map's density at
// uniforms (u: column, v: row).
void SampleTexels(const EnvironmentView& map, const InversionView& inversion,
                  const UniformColumns& uniforms, std::uint32_t n, float samples,
                  const LightColumns& out);

// Fills radiance and light_pdf of rows [0, n). Rows with pdf == 0 (seen by the camera, directly or
// through mirrors and glass) see the map interpolated between texel centres; the others see the
// texels that the light samples and light paths see, which all techniques for a path have to agree
// about.
void EvaluateEscaped(const EnvironmentView& map, const TexelDensity& density, std::uint32_t n,
                     float samples, const EscapeColumns& rows);

// Writes the radiance of the texels in directions dir of rows [0, n) of `out` to r, g, b.
void LookUpTexels(const EnvironmentView& map, std::uint32_t n, const LightColumns& out);

// Draws directions uniformly over the sphere; pdf is samples / 4 pi [1/sr].
void SampleSphere(const UniformColumns& uniforms, std::uint32_t n, float samples,
                  const LightColumns& out);

// Draws directions about the shading normal; pdf is samples * cos / pi [1/sr].
void SampleCosine(const SurfaceColumns& surfaces, const UniformColumns& uniforms, std::uint32_t n,
                  float samples, const LightColumns& out);

// Writes the density of SampleCosine at surface rows[i].from in direction rows[i].dir to light_pdf.
void CosineDensity(const SurfaceColumns& surfaces, std::uint32_t n, float samples,
                   const EscapeColumns& rows);

}  // namespace skywave
