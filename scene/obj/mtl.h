// Converts material libraries of OBJ files to Skywave's materials.
//
//   illum 6 or 7, or 4 or 9 with d < 1 or Tf
//                                  smooth dielectric of index Ni (1.5 if <= 1)
//   Pr, Pm, Ps, Pc, Pcr, map_Pr or map_Pm (the physically based statements that Blender and others
//   write)                         metallic-roughness of the colour Kd with the roughness Pr (or by
//                                  Ns, or 1/2), metal Pm, index Ni, sheen Ps and coat Pc of the
//                                  roughness Pcr; the maps stand in the place of Pr and Pm. Ks is
//                                  ignored with a note, aniso with a warning
//   Kd = 0, Ks > 0, illum 3 or 5   mirror of reflectance Ks
//   Kd = 0, Ks > 0, other illum    conductor: F0 = Ks, alpha = sqrt(2 / (Ns + 2))
//   Kd > 0, Ks > 0                 metallic-roughness without metal: a coat of index 1.5 over Kd,
//                                  alpha as above; the value of Ks is ignored
//   everything else                Lambert of reflectance Kd
//
// d (1 - Tr) is the fraction of rays that a surface other than glass stops (but Tr 1 without d
// is opaque, as MeshLab means it), and map_d multiplies it: the alpha channel of its file, or
// else its grey. norm, bump, map_bump and map_Bump hold normals if they are coloured; grey ones
// (except norm) hold heights. MTL does not define the height of white: here it is bm hundredths
// of the width of the image.
//
// Ke is radiance, emitted on both sides (the format does not define the side, and windings of OBJ
// files are not reliable). map_Ke multiplies it, or stands alone if there is no Ke.
//
// map_Kd multiplies Kd (or 1 if Kd is missing or 0) of what is not glass, with v upwards; the
// options -s, -o and -clamp of maps are honoured. A map whose file is missing or cannot be read is
// left out, with a warning.
//
// The width of a lobe with exponent Ns follows Walter et al. 2007, "Microfacet Models for
// Refraction through Rough Surfaces", Section 5.2.
#pragma once

#include <string>
#include <vector>

#include "scene/materials/texture_files.h"
#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

// Returns the materials in the order of the file, with their names. Throws InputError with the line
// for words that are not numbers. Warnings name, with their lines, maps and anything else that is
// not rendered.
std::vector<Material> ReadMtl(const std::string& path, TextureFiles& textures, Warnings& warnings);

// Parses the same from memory; `path` appears in messages.
std::vector<Material> ParseMtl(std::string text, const std::string& path, TextureFiles& textures,
                               Warnings& warnings);

}  // namespace skywave
