// Scenes of pbrt that a test writes as text.
#pragma once

#include <string>

#include "scene/pbrt/reader.h"
#include "scene/scene.h"

namespace skywave {

inline Scene Parse(const std::string& text) { return ParsePbrt(text, "t.pbrt"); }

inline constexpr const char* kTriangle =
    "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [0 0 0  1 0 0  0 1 0]\n";

// The material of a triangle after `directive`.
inline Material OnlyMaterial(const std::string& directive) {
  const Scene scene = Parse("WorldBegin\n" + directive + "\n" + kTriangle);
  return scene.materials.at(scene.meshes.at(0).material);
}

}  // namespace skywave
