// Scene files of pbrt (https://pbrt.org), versions 3 and 4, plain or gzip-compressed.
//
// docs/pbrt.md says what of them is rendered. Every directive is parsed; materials are those of
// pbrt_materials.h, shapes of pbrt_shapes.h, alpha, bumps and normal maps of pbrt_surface_maps.h,
// lights of pbrt_lights.cc (a "power" is that of a whole shape, spots fall off as in pbrt-v4,
// lights of objects shine in every instance), instances become copies. Files that are only a piece
// of a scene, without WorldBegin, are read too.
//
// Whatever is legal pbrt and not rendered gives one line in Scene::warnings that says what is done
// instead, or is refused (ReadOptions).
// Syntax errors, directives that pbrt does not have, wrong counts, missing files, singular
// transforms and unbalanced scopes are InputErrors with file and line.
//
// pbrt's world is left-handed: Scene::left_handed is true. Maps of infinite lights are read as
// lat-long: in the light's space the image centre looks along -x, the middle of its right half
// along -y, the top row along +z (pbrt-v3's layout; the square equal-area layout of pbrt-v4 is not
// told apart here).
#pragma once

#include <string>

#include "scene/read_options.h"
#include "scene/scene.h"

namespace skywave {

// Includes nest this deep at most, and there are at most so many in all; scopes likewise.
inline constexpr int kMaxPbrtIncludeDepth = 16;
inline constexpr int kMaxPbrtIncludes = 10000;
inline constexpr int kMaxPbrtScopes = 4096;

Scene ReadPbrt(const std::string& path, const ReadOptions& options = {});

// The same with the main file's text in memory; includes are looked up beside `path`.
Scene ParsePbrt(std::string text, const std::string& path, const ReadOptions& options = {});

}  // namespace skywave
