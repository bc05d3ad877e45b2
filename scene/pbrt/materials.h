// Converts pbrt's materials (names of versions 3 and 4) to Skywave's.
//
//   matte, diffuse        Lambert: Kd, reflectance; Oren-Nayar if matte has a sigma
//   diffusetransmission   diffuse transmission: reflectance, transmittance, scale
//   translucent           the sum of diffuse transmission, from Kd, reflect and transmit, and of a
//                         rough dielectric, from Ks and the same
//   mirror                mirror: Kr
//   metal, conductor      GGX conductor: eta and k as rgb or by name (metal-Cu-eta, Cu.eta.spd), or
//                         reflectance; anisotropic if uroughness and vroughness differ; mirror
//                         if roughness is (close to) zero
//   coatedconductor       a conductor under a dielectric coat
//   coateddiffuse         a diffuse body under a dielectric coat
//   glass, dielectric     dielectric, smooth or rough: eta or index, as a number or by name
//   thindielectric        both faces of a pane at once: eta
//   plastic, uber         glossy-diffuse: Kd, Ks, roughness and, of uber, eta or index; uber with
//   Kr
//                         or Kt is the sum with a smooth dielectric; opacity is that of the surface
//   substrate             Fresnel-blend: Kd, Ks, roughness
//   measured              a BRDF of the MERL database: filename (.binary)
//   mix                   one of two named materials, chosen at every hit: materials or
//                         namedmaterial1 and 2, amount (also a float image)
//   shinymetal, disney    Lambert, with a warning
//   anything else         grey Lambert, with a warning
//
// A reflectance, Kd, Ks or transmittance may be an image (textures.cc), and so may the roughness of
// conductors, dielectrics and coats and the amount of mix; all but Ks and transmittance may vary in
// space (solid_baking.h). A reflectance that varies in space is that of a diffuse body. Other
// parameters are constant.
#pragma once

#include <string>

#include "scene/pbrt/parameters.h"
#include "scene/scene.h"

namespace skywave {

struct PbrtReader;

// `reader` supplies textures, named materials and files, and receives warnings and measured BRDFs.
// Throws InputError on values that no surface can have. Warnings name approximations.
Material MakePbrtMaterial(const std::string& type, PbrtParameters& parameters, PbrtReader& reader);

// Returns true for the types that make a shape an invisible boundary between media.
bool IsInvisiblePbrtMaterial(const std::string& type);

}  // namespace skywave
