// One material or more of each BSDF, which every test of BSDFs runs over: a new BSDF is tested by
// the cases that it gets here.
#pragma once

#include <optional>
#include <vector>

#include "tests/support/shading_rows.h"

namespace skywave {

// BSDFs with a density.
const std::vector<MaterialCase>& DenseCases();
// The others.
const std::vector<MaterialCase>& DeltaCases();
// The first case of each BSDF that reflects something of each channel.
const MaterialCase& ExampleOf(BsdfKind kind);

// The width of the lobe that is narrowest, 1 for diffuse ones: what a test must resolve.
double LobeWidth(const MaterialCase& material);

// A table of the MERL database for tests: a gloss over a body, dim at grazing angles.
std::vector<float> SyntheticMeasuredTable();

// Value and density in double, from the formulae of the papers; local frame, z the normal, x the
// tangent. Unknown where a table has a step.
struct FormulaValue {
  double rgb[3] = {};
  double pdf = 0;
  bool known = true;
};
FormulaValue BsdfFormula(const MaterialCase& material, Vec wo, Vec wi);

// Index near over far, 1 where nothing is bent; none where light does not pass through.
inline std::optional<double> TransmissionRatio(const MaterialCase& material) {
  if (material.kind == BsdfKind::kDiffuseTransmission) return 1;
  if (material.kind != BsdfKind::kRoughDielectric) return std::nullopt;
  return material.back ? double(material.record.ior) : 1.0 / material.record.ior;
}

}  // namespace skywave
