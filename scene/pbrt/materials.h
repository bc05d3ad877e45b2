// pbrt's materials (version 3 and 4 names) as Skywave's.
//
//   matte, diffuse        Lambert: Kd, reflectance; Oren-Nayar where matte has a sigma
//   diffusetransmission   diffuse transmission: reflectance, transmittance, scale
//   translucent           the same, of Kd, reflect and transmit; its gloss is left out
//   mirror                mirror: Kr
//   metal, conductor      GGX conductor: eta and k as rgb or by name (metal-Cu-eta, Cu.eta.spd), or
//                         reflectance; anisotropic where uroughness and vroughness differ; mirror
//                         where roughness is (next to) zero
//   coatedconductor       a conductor under a coat that takes what it reflects itself
//   glass, dielectric     dielectric, smooth or rough: eta or index, as a number or by name
//   thindielectric        both faces of a pane at once: eta
//   plastic, substrate, uber, coateddiffuse   metallic-roughness without metal, of Kd or
//                         reflectance, roughness and eta: the same model, a specular coat over a
//                         diffuse body; Ks and what else they have is left out, with a warning
//   measured              a BRDF of the MERL database: filename (.binary)
//   mix                   one of two named materials, chosen hit by hit: materials or
//                         namedmaterial1 and 2, amount
//   shinymetal, disney    Lambert, with a warning
//   anything else         grey Lambert, with a warning
//
// A reflectance or Kd may be an image (pbrt_textures.cc); other parameters are constant.
#pragma once

#include <string>

#include "scene/pbrt/parameters.h"
#include "scene/scene.h"

namespace skywave {

struct PbrtReader;

// `reader` gives textures, named materials, files, and takes warnings and measured BRDFs. Throws
// InputError on values that no surface can have. Warnings say what is approximated.
Material MakePbrtMaterial(const std::string& type, PbrtParameters& parameters, PbrtReader& reader);

// True for the types that make a shape a mere boundary between media: it is not seen.
bool IsInvisiblePbrtMaterial(const std::string& type);

}  // namespace skywave
