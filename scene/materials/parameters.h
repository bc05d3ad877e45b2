// Makes materials from the names of a BSDF and of its parameters, as `skywave info --json` prints
// them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "kernels/bsdf/material.h"

namespace skywave {

// A parameter by its name: one number, or three of a colour; a colour may be given as one number.
struct ParameterValues {
  std::string name;
  std::vector<float> values;
};

// Returns a material of that BSDF with its default values. Throws InputError("bsdf"), which lists
// the BSDFs, for an unknown one. Both functions throw with kExitUsage.
Material MakeMaterial(std::string_view bsdf);

// Changes one parameter of a material. Throws InputError(name of the parameter) for one that the
// BSDF does not read, and lists those that it reads, and for values out of range.
void SetParameter(const ParameterValues& parameter, Material& material);

}  // namespace skywave
