// pbrt's materials (version 3 and 4 names) as Skywave's.
//
//   matte, diffuse        Lambert: Kd, reflectance
//   mirror                mirror: Kr
//   metal, conductor      GGX conductor: eta and k as rgb or by name (metal-Cu-eta, Cu.eta.spd), or
//                         reflectance; mirror where roughness is (next to) zero
//   glass, dielectric     smooth dielectric: eta or index, as a number or by name (glass-BK7)
//   plastic, substrate, uber, coateddiffuse   metallic-roughness without metal, of Kd or
//                         reflectance, roughness and eta; Ks and what else they have is left out,
//                         with a warning
//   translucent, shinymetal, disney, diffusetransmission   Lambert, with a warning
//   anything else         grey Lambert, with a warning
//
// A reflectance or Kd may be an image (pbrt_textures.cc); other parameters are constant.
#pragma once

#include <string>

#include "scene/pbrt_parameters.h"
#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

// Throws InputError on values that no surface can have. Warnings say what is approximated.
Material MakePbrtMaterial(const std::string& type, PbrtParameters& parameters,
                          const PbrtTextures& textures, Warnings& warnings);

// True for the types that make a shape a mere boundary between media: it is not seen.
bool IsInvisiblePbrtMaterial(const std::string& type);

}  // namespace skywave
