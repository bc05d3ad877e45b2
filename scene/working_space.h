// Scenes in other spaces of red, green and blue than that of their files.
#pragma once

#include "image/rgb_space.h"
#include "scene/scene.h"

namespace skywave {

// Converts the colours of a scene, which are of Rec. 709, to a space: those of materials, textures,
// vertices, measured BRDFs and lights without extent. Colours that multiply each other do so in the
// space. Metals keep the real part of their index, if they can, and get the imaginary one that
// reflects their converted colour at normal incidence. Maps of the environment stay as they are;
// constant environments too.
void ConvertScene(RgbSpace space, Scene& scene);

}  // namespace skywave
