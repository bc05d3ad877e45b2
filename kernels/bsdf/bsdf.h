// The BSDFs. Each is a file of this folder and a line in the lists of kernels/columns.h; its traits
// say what it needs of a material and of the other stages, and its kernels do the work.
//
// Conventions: wo points to the eye, wi to the light, both away from the surface. `value` is
// f(wo, wi) |cos| [1/sr], per channel, for radiance transport (transmission scales radiance by the
// squared index ratio). `pdf` is the density of wi given wo [1/sr]. On paths from lights
// (Transport::kFlux) wo points to where the path comes from, the light, and wi to the eye;
// kernels/light_paths/flux.h makes values of them. Reflection needs wi on wo's side of both the
// geometric and the shading normal, and transmission on the other side of both; the light that
// smooth normals would leak through is zero.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "kernels/columns.h"
#include "kernels/lights/irradiance.h"

namespace skywave {

struct AnisotropicTables;
struct CoatTable;
struct ConductorTables;
struct DielectricTable;
struct Material;
struct MeasuredBrdf;
struct SheenTables;
using MeasuredBrdfs = std::span<const MeasuredBrdf>;  // those of a scene

// The tables that BSDF kernels read. A null table is one that no BSDF of the scene reads.
struct MaterialView {
  const MaterialRecord* records;
  const ConductorTables* conductor;
  const SheenTables* sheen = nullptr;
  const float* measured = nullptr;  // MERL tables, see kMeasured* in columns.h
  const CoatTable* coats = nullptr;
  // Some material has a texture of Varying::kAlpha, kCoatWidths or kSecondColor, or of the two
  // widths of brushed metal, or is a metal of its colour.
  bool varied = false;
  // Some rough dielectric has two widths: of BSDFs that may have them, Varying::kAlpha is written
  // and read, textures or not, with a FacetTurn in its second column.
  bool two_widths = false;
  const DielectricTable* dielectrics = nullptr;
  const AnisotropicTables* anisotropic = nullptr;
  // Some material has a coat whose normals are not those of its base: SurfaceColumns::base_normal
  // is written and read.
  bool base_normals = false;
  // The surfaces are of paths from lights (Transport::kFlux), which such bases need to know.
  bool flux = false;
  // Some glass has layers (kernels/bsdf/glass_layers-inl.h): PrepareGlassLayers is called for it.
  bool glass_layers = false;
};

// Light and BSDF samples of the same direction share the work by the power heuristic of exponent 2
// (Veach and Guibas 1995), between the density of light samples (which counts how many there are)
// and that of `bsdf_samples` BSDF samples. Without it light samples count in full and directions
// drawn from a density see no light.
struct MisPolicy {
  bool enabled = true;
  float bsdf_samples = 1;  // number of each surface
};

// A path carries radiance or flux. BSDFs are not symmetric where light is refracted, which scales
// radiance and not flux by the squared index ratio, nor where the shading normal is not that of the
// surface: flux gets |wo.ns| |wi.ng| / (|wo.ng| |wi.ns|) (Veach 1997, 5.2 and 5.3.2).
enum class Transport {
  kRadiance,  // paths from the camera
  kFlux       // paths from lights
};

// The control variate of diffuse light (kernels/lights/irradiance.h). Of the value of a BSDF, the
// part that is a constant times the cosine is known analytically if nothing hides the map; what is
// subtracted for it goes to `out`, one row for each light sample, or for each ray that scatters.
struct LightControl {
  IrradianceView irradiance;
  const float* weight = nullptr;  // of the control at each surface; null: 1
  // True for one of the light samples of a surface: its row takes the integral of the control.
  bool with_integral = false;
  // Shadow-ray length per light sample; infinity for the map. Null: all are of the map.
  const float* reach = nullptr;
  ControlColumns out;
};

// With Russian roulette after scattering, a path goes on with probability min(1, largest
// throughput). Flux has a unit: it goes on with min(1, the share of its largest throughput that the
// surface leaves).
struct ScatterPolicy {
  bool roulette = false;
  std::uint32_t first_row = 0;  // row of the slice's row 0 in the whole surface table
  Transport transport = Transport::kRadiance;
  // Rays whose light is known analytically are controlled, and rays that carry nothing but a
  // control go on too. Null: there is no control.
  const LightControl* control = nullptr;
};

// The uniforms of a scattering event: `direction` draws the direction, `lobe.u` chooses a lobe and
// `lobe.v` decides roulette.
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

// Surface preparation writes these to SurfaceColumns::varying_0 and varying_1 for a BSDF.
enum class Varying {
  kNothing,
  kRoughness,  // GGX width, share of metal
  // This is written, and read, only if MaterialView::varied or two_widths: GGX width; the other
  // column means nothing, or with two_widths is a FacetTurn (kernels/surface/facet_turn-inl.h).
  kAlpha,
  // This only if MaterialView::varied: GGX widths of a metal and of the coat over it.
  kCoatWidths,
  // This only if MaterialView::varied: texture of the second colour, red and green, 16 bits each,
  // and blue.
  kSecondColor,
  // Cosine and sine of the angle from the first axis of the shading frame to the tangent. Rows that
  // have an image of two widths hold the width along the tangent and a FacetTurn instead.
  kTangent,
  // What the textures of layered metallic-roughness say, in four columns
  // (kernels/surface/layers-inl.h).
  kLayers,
};

// The tables that the kernels of a BSDF read besides the records of materials.
struct BsdfTables {
  bool ggx = false, sheen = false, anisotropic = false;  // kernels/bsdf/conductor_tables.h
  bool measured = false;                                 // the MeasuredBrdf that the material names
  bool coat = false;        // a CoatTable of the material (kernels/bsdf/coat_tables.h)
  bool dielectric = false;  // a DielectricTable of the material (kernels/bsdf/dielectric_tables.h)
};

// A field of Material that a BSDF reads (besides reflectance and textures), and the name under
// which users see it.
struct MaterialParameter {
  std::string_view field;  // as Material::ForEachField names it
  std::string_view name = field;
};

// A BSDF as everything but its kernels knows it.
struct BsdfTraits {
  std::string_view name;
  bool lobed = false;  // it chooses between lobes: it needs ScatterUniforms::lobe.u
  Varying varying = Varying::kNothing;
  bool transmits = false;  // light passes through
  bool refracts = false;   // and enters another medium: the value has the squared index ratio
  // With alpha_across its facets have two widths, and a surface needs a tangent.
  bool two_widths = false;
  // The field that has the width across the tangent, of facets whose two widths an image may vary.
  std::optional<MaterialField> across = {};
  bool inside = false;        // light goes through the material itself, which may absorb it
  bool glass_layers = false;  // glass that may have layers (MaterialView::glass_layers)
  BsdfTables tables = {};
  MaterialParameter parameters[16] = {};  // after the last one they have no name (ParametersOf)
  // Packs the parameters into `record`, which holds what all BSDFs have (PackMaterial). Null: the
  // BSDF has no parameters.
  void (*pack)(const Material& material, MeasuredBrdfs measured, MaterialRecord& record) = nullptr;
};

// Returns true if a material has facets of two widths, or another grain, along its tangent.
bool HasTangent(const Material& material);

struct BsdfKernels : BsdfTraits {
  bool delta = false;  // no density: no light samples, value and pdf are 0

  // Writes value and pdf of directions wi (dir columns of `lights`), for rows [0, n).
  void (*evaluate)(const SurfaceColumns& surfaces, const MaterialView& materials,
                   const LightColumns& lights, std::uint32_t n,
                   const BsdfValueColumns& out) = nullptr;

  // For rows [0, n), turns the radiance of a light sample into the path's gain if the light is
  // seen, throughput * value * radiance / pdf * MIS weight, and opens (t_far infinite) or closes
  // (t_far negative) its shadow ray. BSDFs that transmit move org of the surfaces to the side of
  // the light (see SurfaceColumns::lift). Null for delta BSDFs.
  void (*evaluate_lights)(const SurfaceColumns& surfaces, const MaterialView& materials,
                          std::uint32_t n, const MisPolicy& mis,
                          const LightColumns& lights) = nullptr;

  // The same, and writes rows [0, n) of control.out, which are 0 where no part of the BSDF is known
  // analytically. Null for delta BSDFs.
  void (*evaluate_controlled_lights)(const SurfaceColumns& surfaces, const MaterialView& materials,
                                     std::uint32_t n, const MisPolicy& mis,
                                     const LightControl& control,
                                     const LightColumns& lights) = nullptr;

  // The weight of a cell is its energy times the luminance of value in its centre, for a BSDF that
  // is blurred to the size of the cell and never below a small share of the mean over all
  // directions. It falls for cells below the horizon and is 0 where no texel of them rises above
  // it.

  // For rows [0, n) and cells [0, count), writes the sums of the weights of cells 0 to k to
  // sums[k * stride + row]; stride >= PaddedRows(n). Null for delta BSDFs.
  void (*weigh_cells)(const SurfaceColumns& surfaces, const MaterialView& materials,
                      std::uint32_t n, const LightCell* cells, std::uint32_t count, float* sums,
                      std::uint32_t stride) = nullptr;

  // Writes the weight of cell cell[i] for rows i in [0, n). Null for delta BSDFs.
  void (*weigh_cell)(const SurfaceColumns& surfaces, const MaterialView& materials, std::uint32_t n,
                     const LightCell* cells, const std::uint32_t* cell, float* weight) = nullptr;

  // Draws a direction for rows [0, n) and writes it to `dir` of `directions`; `evaluate` gives its
  // value and density. Null for delta BSDFs.
  void (*draw)(const SurfaceColumns& surfaces, const MaterialView& materials,
               const ScatterUniforms& uniforms, std::uint32_t n,
               const LightColumns& directions) = nullptr;

  // Draws a direction for rows [0, n) and appends the rays that go on to `rays` from its row
  // `appended`, and rows of policy.control->out if there is one; returns the new number of rows. At
  // most one ray a row.
  std::uint32_t (*scatter)(const SurfaceColumns& surfaces, const MaterialView& materials,
                           const ScatterUniforms& uniforms, std::uint32_t n,
                           const ScatterPolicy& policy, const RayColumns& rays,
                           std::uint32_t appended) = nullptr;
};

// Returns the parameters of a material that the BSDF reads, in the order in which users see them.
std::span<const MaterialParameter> ParametersOf(const BsdfTraits& traits);

// Returns all BSDFs, in the order of BsdfKind.
std::span<const BsdfKernels, kBsdfKinds> Bsdfs();

// Rows [begin, begin + n) of a surface table, all of BSDF `kind`.
struct BsdfRows {
  std::uint32_t kind, begin, n;
};

// BSDFs [first, end).
struct BsdfSpan {
  std::uint32_t first, end;
};
inline constexpr BsdfSpan kAllBsdfs = {0, kBsdfKinds};
inline constexpr BsdfSpan kDenseBsdfs = {0, kFirstDeltaBsdf};

// Calls f(bsdf, rows) for each of `bsdfs` that has rows. The order is ascending, because the last
// vector that a kernel writes for a BSDF may spill over the first rows of the next one.
template <class F>
void ForEachBsdf(const SurfaceRanges& ranges, const BsdfSpan& bsdfs, const F& f) {
  for (std::uint32_t kind = bsdfs.first; kind < bsdfs.end; ++kind) {
    const std::uint32_t begin = ranges.begin[kind], n = ranges.count(kind);
    if (n > 0) f(Bsdfs()[kind], BsdfRows{.kind = kind, .begin = begin, .n = n});
  }
}

// Calls f(bsdf, rows) likewise, for blocks of at most `most` rows.
template <class F>
void ForEachBsdfBlock(const SurfaceRanges& ranges, const BsdfSpan& bsdfs, std::uint32_t most,
                      const F& f) {
  ForEachBsdf(ranges, bsdfs, [&](const BsdfKernels& bsdf, const BsdfRows& all) {
    for (std::uint32_t done = 0; done < all.n; done += most) {
      f(bsdf,
        BsdfRows{.kind = all.kind, .begin = all.begin + done, .n = std::min(most, all.n - done)});
    }
  });
}

#define SKYWAVE_DECLARE(name) BsdfKernels name##Kernels();
SKYWAVE_DENSE_BSDFS(SKYWAVE_DECLARE)
SKYWAVE_DELTA_BSDFS(SKYWAVE_DECLARE)
#undef SKYWAVE_DECLARE

}  // namespace skywave
