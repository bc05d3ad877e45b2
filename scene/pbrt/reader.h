// Reads scene files of pbrt (https://pbrt.org), versions 3 and 4, plain or gzip-compressed.
//
// docs/pbrt.md lists the features that are rendered. Every directive is parsed: materials by
// materials.h, shapes by shapes.h, alpha, bumps and normal maps by surface_maps.h, lights by
// lights.cc ("power" is the power of a whole shape, spots fall off as in pbrt-v4, lights of objects
// shine in every instance). Instances become copies. Files that hold only part of a scene, without
// WorldBegin, are read too.
//
// Each legal pbrt feature that is not rendered produces one line in Scene::warnings that names the
// substitute, or is refused (ReadOptions). Syntax errors, unknown directives, wrong counts, missing
// files, singular transforms and unbalanced scopes are InputErrors with file and line.
//
// pbrt's world is left-handed: Scene::left_handed is true. Maps of infinite lights are read as
// lat-long: in the light's space the image centre looks along -x, the middle of its right half
// along -y, and the top row along +z (pbrt-v3's layout; the square equal-area layout of pbrt-v4 is
// not recognised here).
#pragma once

#include <string>

#include "scene/read_options.h"
#include "scene/scene.h"

namespace skywave {

// Limits on the nesting of includes, on their total number, and on the nesting of scopes.
inline constexpr int kMaxPbrtIncludeDepth = 16;
inline constexpr int kMaxPbrtIncludes = 100000;
inline constexpr int kMaxPbrtScopes = 4096;

Scene ReadPbrt(const std::string& path, const ReadOptions& options = {});

// Parses the same with the main file's text in memory; includes are looked up relative to `path`.
Scene ParsePbrt(std::string text, const std::string& path, const ReadOptions& options = {});

}  // namespace skywave
