// The BSDFs whose gloss lies beside a body or stands alone, by the papers (bsdf_formulas.h).
#pragma once

#include "tests/support/bsdf_formulas.h"

namespace skywave {

FormulaValue PhongFormula(const MaterialRecord& m, Vec wo, Vec wi);
FormulaValue GlossyDiffuseFormula(const MaterialCase& material, Vec wo, Vec wi);
FormulaValue FresnelBlendFormula(const MaterialRecord& m, Vec wo, Vec wi);
FormulaValue BlinnFormula(const MaterialRecord& m, Vec wo, Vec wi);
FormulaValue WardFormula(const MaterialRecord& m, Vec wo, Vec wi);

}  // namespace skywave
