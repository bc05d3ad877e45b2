// Material libraries of OBJ files as Skywave's materials.
//
//   d < 1/2, illum 6 or 7, or 4 or 9 with d < 1 or Tf   smooth dielectric of index Ni (1.5 if <= 1)
//   Pm >= 1/2 (metalness)                                conductor: F0 = Kd, alpha = Pr^2
//   Kd = 0, Ks > 0                                       illum 3 or 5: mirror of Ks; else
//   conductor:
//                                                        F0 = Ks, alpha = sqrt(2 / (Ns + 2))
//   Kd > 0, Ks > 0                                       metallic-roughness without metal: a coat
//   of
//                                                        index 1.5 over Kd, alpha as above; how
//                                                        much Ks is does not count
//   everything else                                      Lambert of Kd
//
// d (1 - Tr) is the share of rays that a surface which is no glass stops, and map_d a factor of it:
// the alpha channel of its file, or else its grey. norm, bump, map_bump and map_Bump are maps of
// normals where they are coloured, and grey ones (but for norm) of heights: MTL does not say how
// high white is, here it is bm hundredths of the width of the image.
//
// Ke is radiance, on both sides (the format does not say; windings of OBJ files are not reliable).
// Of map_Ke, a factor of it (of 1 where there is no Ke), each triangle takes the mean.
//
// map_Kd is multiplied with Kd (1 where there is none, or 0) in the last two, its v upwards; its
// options -s, -o and -clamp count. A map whose file is missing is left out, with a warning.
//
// The width of a lobe with exponent Ns is that of Walter et al. 2007, "Microfacet Models for
// Refraction through Rough Surfaces", Section 5.2.
#pragma once

#include <string>
#include <vector>

#include "scene/materials/texture_files.h"
#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

// The materials in the order of the file, with their names. Throws InputError with the line on
// numbers that are none. Warns, with the line, of maps and whatever else is not rendered.
std::vector<Material> ReadMtl(const std::string& path, TextureFiles& textures, Warnings& warnings);

// The same from memory; `path` is for messages.
std::vector<Material> ParseMtl(std::string text, const std::string& path, TextureFiles& textures,
                               Warnings& warnings);

}  // namespace skywave
