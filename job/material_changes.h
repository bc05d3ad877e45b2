// The option `material`, which gives materials of a scene another BSDF or other parameters.
//
// A change is NAME=BSDF[:KEY=VALUE,...]. The material NAME becomes a new one of that BSDF, whose
// parameters have their defaults where no KEY gives them; textures are those that a KEY gives.
// NAME=:KEY=VALUE,... changes only these parameters of the material as it is. Keys are the names
// that `skywave info --json` prints, a VALUE is a number, and a colour has one number or three, as
// in 0.8/0.2/0.1. All materials with the name are changed, in the order of the changes.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"

namespace skywave {

// Throws OptionError for a change that cannot be read, for a name that no material has, and for
// BSDFs, parameters and values that do not exist; each lists what there is.
void ChangeMaterials(const std::vector<std::string>& changes, Scene& scene);

// Leaves out the light that the facets of rough conductors and dielectrics scatter more than once
// (the option `energy-compensation`).
void LeaveOutCompensation(Scene& scene);

}  // namespace skywave
