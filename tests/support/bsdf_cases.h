// At least one material of each BSDF. Every test of BSDFs runs over these cases, so a new BSDF is
// tested by the cases added here.
#pragma once

#include <optional>
#include <vector>

#include "tests/support/shading_rows.h"

namespace skywave {

// Returns the BSDFs with a density.
const std::vector<MaterialCase>& DenseCases();
// Returns the others.
const std::vector<MaterialCase>& DeltaCases();
// Returns the first case of each BSDF that reflects some of each channel.
const MaterialCase& ExampleOf(BsdfKind kind);

// Returns the width of the narrowest lobe, which a test must resolve; 1 for diffuse ones.
double LobeWidth(const MaterialCase& material);

// Returns a table of the MERL database for tests: a gloss over a body, dim at grazing angles.
std::vector<float> SyntheticMeasuredTable();

// Returns rough glass that loses nothing, and GGX facets of two widths likewise.
Material RoughGlass(float alpha, float ior);
// Returns materials of BSDFs, or of parts of them, that no built-in scene has.
std::vector<Material> BeyondTheBuiltinOnes();
MaterialRecord Keeping(MaterialRecord anisotropic);

// Returns the glass that a coat lies over, or the BSDF itself.
inline BsdfKind WithoutCoat(BsdfKind kind) {
  if (kind == BsdfKind::kCoatedRoughDielectric) return BsdfKind::kRoughDielectric;
  if (kind == BsdfKind::kCoatedRoughThinDielectric) return BsdfKind::kRoughThinDielectric;
  return kind;
}

// Returns the near index over the far index, 1 if nothing is refracted, or nothing if light cannot
// pass.
inline std::optional<double> TransmissionRatio(const MaterialCase& material) {
  const BsdfKernels& bsdf = Bsdfs()[std::size_t(material.kind)];
  if (!bsdf.transmits || bsdf.delta) return std::nullopt;
  if (!bsdf.refracts) return 1;
  return material.back ? double(material.record.ior) : 1.0 / material.record.ior;
}

}  // namespace skywave
