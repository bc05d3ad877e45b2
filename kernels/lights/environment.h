// Illumination maps under the eyes of rays: radiance in a direction, and directions drawn with a
// density proportional to radiance.
//
// The map is a lat-long grid of W x H texels, constant inside a texel where it acts as a light.
// With right, forward and up the axes of the map, a direction has u = 1/2 + atan2(right, forward) /
// 2 pi, v = acos(up) / pi; texel (i, j) covers [i, i + 1) / W x [j, j + 1) / H: u and v themselves,
// no half texel of shift between lookup and density. Inside a texel directions are uniform in solid
// angle, so a density is one number a texel, P(texel) / solid angle, and no sine can vanish at a
// pole.
#pragma once

#include <cstdint>

#include "kernels/columns.h"

namespace skywave {

// A discrete distribution over n items as a tree of cache lines: a node says where the masses of
// its 32 children start, integers on a line of length kNodeMass, so a step of a search is one cache
// line, compared in one or two instructions, without a branch. Levels: 1, 2 or 3 for n up to 32,
// 1024 and 32768. Cumulation keeps the order of the items: the inversion is monotone.
inline constexpr std::uint32_t kNodeFan = 32;
inline constexpr std::uint32_t kNodeMass = 32767;  // the largest 16-bit signed integer
struct alignas(64) SearchNode {
  std::int16_t start[kNodeFan];  // start[0] = 0; a child without mass starts where the next does
};
struct SearchTreeView {
  std::uint32_t levels;
  const SearchNode* level[3];  // root level first; one tree a map row, tree after tree
  std::uint32_t nodes[3];      // of one tree in a level
};

// Where row j lies on the sphere: w = sin^2(theta/2) of a point in the northern half,
// cos^2(theta/2) in the southern, is area-uniform and exact near its pole: w = start + step * y, y
// in [0, 1) down.
struct RowArea {
  float start, step;
};

// Radiance of a texel in four bytes, because lookups are random accesses and pay by the cache line:
// three mantissas of kMantissaBits bits, r lowest, and a common exponent above them (as in
// Radiance's RGBE): channel = mantissa * 2^(exponent - 31) * EnvironmentView::radiance_unit.
using PackedRadiance = std::uint32_t;
inline constexpr std::uint32_t kMantissaBits = 9;
inline constexpr std::uint32_t kMaxExponent = 31;

// A cache line of a map: neighbours in a row, and what an inversion knows of them, so that a random
// access to a map is one line whatever it is for. The line is the last item of an inversion;
// inside, the texels themselves say what they weigh: max(0, luminance - base), luminance in units
// of radiance_unit, times their solid angle.
inline constexpr std::uint32_t kLineTexels = 14;
inline constexpr std::uint32_t kLineWords = 16;
struct alignas(64) TexelLine {
  float density;  // of a texel [1/sr] over its weight without the solid angle
  float left;     // share of the first half of the texels
  PackedRadiance texel[kLineTexels];
};
static_assert(sizeof(TexelLine) == kLineWords * sizeof(std::uint32_t));

struct InversionView {
  SearchTreeView rows;      // one tree over the rows
  SearchTreeView lines;     // one tree a row over its lines
  const TexelLine* texels;  // what weighs: the map's own or, laid out alike, others
  float base;               // below 0: all texels weigh the same, for maps without light
};

struct EnvironmentView {
  const TexelLine* texels;  // from the top, row after row of `lines`: the map as a light
  float radiance_unit;      // power of two [scene radiance]
  const float* rgb;         // three floats a texel: the map as it is seen
  std::uint32_t width, height;
  std::uint32_t lines;      // of a row; texels behind width are black
  float map_from_world[9];  // rows: right, forward, up
  const RowArea* row_area;  // height entries
};

// Density of light samples over the texels [1/sr], tables row-major of `width`: for each sample
// that a surface draws that of an inversion or of a table with a value a texel, and once more,
// whatever the number of samples, that of the fixed ones.
struct TexelDensity {
  const InversionView* inversion = nullptr;
  const float* table = nullptr;
  const float* fixed = nullptr;
};

// `samples` below: light samples of the kind that a surface takes. Densities are multiplied by it,
// so that they say how many samples a steradian gets and combine in multiple importance sampling
// whatever the number.

// Fills dir, r, g, b (radiance) and pdf of rows [0, n) by inversion of the map's density at
// uniforms (u: column, v: row).
void SampleTexels(const EnvironmentView& map, const InversionView& inversion,
                  const UniformColumns& uniforms, std::uint32_t n, float samples,
                  const LightColumns& out);

// Fills radiance and light_pdf of rows [0, n). Rows with pdf == 0 (seen by the camera, directly or
// over mirrors and glass) see the map interpolated between texel centres; the others see the texels
// that the light samples see, which multiple importance sampling needs.
void EvaluateEscaped(const EnvironmentView& map, const TexelDensity& density, std::uint32_t n,
                     float samples, const EscapeColumns& rows);

// Radiance of the texels in directions dir of rows [0, n) of `out`, into r, g, b.
void LookUpTexels(const EnvironmentView& map, std::uint32_t n, const LightColumns& out);

// Directions uniform over the sphere; pdf samples / 4 pi [1/sr].
void SampleSphere(const UniformColumns& uniforms, std::uint32_t n, float samples,
                  const LightColumns& out);

// Directions about the shading normal, pdf samples * cos / pi [1/sr].
void SampleCosine(const SurfaceColumns& surfaces, const UniformColumns& uniforms, std::uint32_t n,
                  float samples, const LightColumns& out);

// The density of SampleCosine at surface rows[i].from in direction rows[i].dir, into light_pdf.
void CosineDensity(const SurfaceColumns& surfaces, std::uint32_t n, float samples,
                   const EscapeColumns& rows);

}  // namespace skywave
