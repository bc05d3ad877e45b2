// The BSDFs: one file each (bsdf_*.cc), one line each in the table of bsdf.cc.
//
// Conventions: wo points to the eye, wi to the light, both away from the surface. `value` is
// f(wo, wi) |cos| [1/sr], per channel, radiance transport (transmission scales radiance by the
// squared index ratio). `pdf` is of wi given wo [1/sr]. On paths from lights (Transport::kFlux) wo
// points to where the path comes from, the light, and wi to the eye; kernels/light_paths/flux.h
// makes values of them. Reflection needs wi on wo's side of both the geometric and the shading
// normal, transmission on the other side of both; what smooth normals would leak through is zero.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "kernels/columns.h"

namespace skywave {

struct ConductorTables;
struct SheenTables;

// What all BSDF kernels read.
struct MaterialView {
  const MaterialRecord* records;
  const ConductorTables* conductor;
  const SheenTables* sheen = nullptr;
  const float* measured = nullptr;  // MERL tables, see kMeasured* in columns.h
};

// How light and BSDF samples of the same direction share the work: power heuristic, exponent 2
// (Veach and Guibas 1995), between the density of light samples (which counts how many there are)
// and that of `bsdf_samples` BSDF samples. Without it light samples count in full and directions
// drawn from a density see no light.
struct MisPolicy {
  bool enabled = true;
  float bsdf_samples = 1;  // of a surface
};

// What a path carries. BSDFs are not symmetric where light is refracted, which scales radiance and
// not flux by the squared index ratio, nor where the shading normal is not that of the surface:
// flux gets |wo.ns| |wi.ng| / (|wo.ng| |wi.ns|) (Veach 1997, 5.2 and 5.3.2).
enum class Transport {
  kRadiance,  // paths from the camera
  kFlux       // paths from lights
};

// Russian roulette after scattering: a path goes on with probability min(1, largest throughput);
// flux, which has a unit, with min(1, what the surface leaves of its largest throughput).
struct ScatterPolicy {
  bool roulette = false;
  std::uint32_t first_row = 0;  // row of the slice's row 0 in the whole surface table
  Transport transport = Transport::kRadiance;
};

// Uniforms of a scattering event: `direction` for the direction, `lobe.u` to choose a lobe,
// `lobe.v` for roulette.
struct ScatterUniforms {
  UniformColumns direction, lobe;
};

struct BsdfValueColumns {
  float *r, *g, *b;  // value
  float* pdf;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.r), f(self.g), f(self.b), f(self.pdf);
  }
};

// A part of the map as a surface weighs it, for strategies that sample the product of light and
// BSDF: eight floats, read by gathers.
struct LightCell {
  float dir[3];  // centroid of its light, world space, unit
  float energy;  // luminance of its irradiance on a surface that faces it
  float radius;  // root mean square angle between its light and dir [rad]
  float reach;   // sine of the largest angle between its texels and dir; 1 from a right angle on
  float unused[2];
};
inline constexpr int kLogCellWords = 3;
static_assert(sizeof(LightCell) == sizeof(float) << kLogCellWords);

// What surface preparation writes to SurfaceColumns::varying_0 and varying_1 for a BSDF.
enum class Varying {
  kNothing,
  kRoughness,  // GGX width, share of metal
  kTangent,  // cosine and sine of the angle from the first axis of the shading frame to the tangent
};

struct BsdfTraits {
  std::string_view name;
  // As in BsdfKernels.
  bool lobed = false;
  Varying varying = Varying::kNothing;
  bool transmits = false, refracts = false;
};

struct BsdfKernels {
  std::string_view name;
  bool delta;  // no density: no light samples, value and pdf are 0
  bool lobed;  // chooses between lobes: needs ScatterUniforms::lobe.u
  Varying varying;
  bool transmits;  // light passes through
  bool refracts;   // and enters another medium: its value has the squared index ratio

  // Rows [0, n): value and pdf of directions wi (dir columns of `lights`).
  void (*evaluate)(const SurfaceColumns& surfaces, const MaterialView& materials,
                   const LightColumns& lights, std::uint32_t n, const BsdfValueColumns& out);

  // Rows [0, n): turns the radiance of a light sample into what the path gains if the light is
  // seen, throughput * value * radiance / pdf * MIS weight, and opens (t_far
  // infinite) or closes (t_far negative) its shadow ray. BSDFs that transmit move org of the
  // surfaces to the side of the light (see SurfaceColumns::lift). Null for delta BSDFs.
  void (*evaluate_lights)(const SurfaceColumns& surfaces, const MaterialView& materials,
                          std::uint32_t n, const MisPolicy& mis, const LightColumns& lights);

  // The weight of a cell is its energy times the luminance of value in its centre, of a BSDF
  // blurred to the size of the cell and never below a small share of the mean over all directions;
  // less and less for cells below the horizon, 0 where no texel of them rises above it.

  // Rows [0, n) and all of cells [0, count): sums of the weights of cells 0 to k, in
  // sums[k * stride + row]; stride >= PaddedRows(n). Null for delta BSDFs.
  void (*weigh_cells)(const SurfaceColumns& surfaces, const MaterialView& materials,
                      std::uint32_t n, const LightCell* cells, std::uint32_t count, float* sums,
                      std::uint32_t stride);

  // The weight of cell cell[i] for rows i in [0, n). Null for delta BSDFs.
  void (*weigh_cell)(const SurfaceColumns& surfaces, const MaterialView& materials, std::uint32_t n,
                     const LightCell* cells, const std::uint32_t* cell, float* weight);

  // Draws a direction for rows [0, n) and appends the rays that go on to `rays` from its row
  // `appended`; returns the new number of rows. At most one ray a row.
  std::uint32_t (*scatter)(const SurfaceColumns& surfaces, const MaterialView& materials,
                           const ScatterUniforms& uniforms, std::uint32_t n,
                           const ScatterPolicy& policy, const RayColumns& rays,
                           std::uint32_t appended);
};

// In the order of BsdfKind.
std::span<const BsdfKernels, kBsdfKinds> Bsdfs();

#define SKYWAVE_DECLARE(name) BsdfKernels name##Kernels();
SKYWAVE_DENSE_BSDFS(SKYWAVE_DECLARE)
SKYWAVE_DELTA_BSDFS(SKYWAVE_DECLARE)
#undef SKYWAVE_DECLARE

}  // namespace skywave
