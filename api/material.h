// Makes materials from the names of a BSDF and of its parameters.
#pragma once

#include <string>
#include <vector>

#include "kernels/bsdf/material.h"
#include "skywave/skywave.h"

namespace skywave::api {

// Throws Error for an unknown BSDF or parameter, for one that the BSDF does not read, and for
// values out of its range.
Material MakeMaterial(const std::string& bsdf, const std::vector<MaterialParameter>& parameters);

}  // namespace skywave::api
