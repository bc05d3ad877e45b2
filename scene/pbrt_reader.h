// Scene files of pbrt (https://pbrt.org), a first subset of versions 3 and 4.
//
// Read are: comments, Include and Import; all transform directives; attribute and object scopes
// (instances become copies); Camera "perspective", "orthographic", "spherical" and "environment";
// the numbers of Film, Sampler, Integrator and PixelFilter that RenderSettings holds; materials
// (pbrt_materials.h), textures (pbrt_textures.cc), shapes (pbrt_shapes.h), alpha, bumps and normal
// maps (pbrt_surface_maps.h) and LightSource "infinite". Files that are only a piece of a scene,
// without WorldBegin, are read too.
//
// Whatever else is legal pbrt gives one line in Scene::warnings that says what is done instead.
// Syntax errors, directives that pbrt does not have, wrong counts, missing files, singular
// transforms and unbalanced scopes are InputErrors with file and line.
//
// pbrt's world is left-handed: Scene::left_handed is true. Maps of infinite lights are read as
// lat-long: in the light's space the image centre looks along -x, the middle of its right half
// along -y, the top row along +z (pbrt-v3's layout; the square equal-area layout of pbrt-v4 is not
// told apart here).
#pragma once

#include <string>

#include "scene/scene.h"

namespace skywave {

// Includes nest this deep at most, and there are at most so many in all; scopes likewise.
inline constexpr int kMaxPbrtIncludeDepth = 16;
inline constexpr int kMaxPbrtIncludes = 10000;
inline constexpr int kMaxPbrtScopes = 4096;

Scene ReadPbrt(const std::string& path);

// The same with the main file's text in memory; includes are looked up beside `path`.
Scene ParsePbrt(std::string text, const std::string& path);

}  // namespace skywave
