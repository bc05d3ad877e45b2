// Lights of pbrt that tests read from text.
#pragma once

#include <gtest/gtest.h>

#include <glm/glm.hpp>
#include <string>

#include "image/image.h"
#include "scene/pbrt/reader.h"
#include "tests/support/temporary_folder.h"

namespace skywave {

inline constexpr char kTriangle[] = " Shape \"trianglemesh\" \"point3 P\" [0 0 0 2 0 0 0 2 0] ";

inline void ExpectNear(const glm::vec3& a, const glm::vec3& b) {
  EXPECT_LT(glm::length(a - b), 1e-4f * (1 + glm::length(b)))
      << a.x << " " << a.y << " " << a.z << " against " << b.x << " " << b.y << " " << b.z;
}

inline Scene Parse(const std::string& text) { return ParsePbrt("WorldBegin\n" + text, "t.pbrt"); }

// Reads a file beside which `image` lies as image.pfm.
inline Scene ParseWithImage(const Image& image, const std::string& text) {
  const TemporaryFolder folder;
  WriteImage(folder.Path("image.pfm"), image);
  return ParsePbrt("WorldBegin " + text, folder.Path("t.pbrt"));
}

}  // namespace skywave
