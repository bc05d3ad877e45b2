// Scenes of pbrt and OBJ files with a texture of four colours.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "image/image.h"
#include "scene/reader.h"
#include "tests/support/oracle_texture.h"
#include "tests/support/temporary_folder.h"

namespace skywave {

// Writes red, green; blue, white.
inline void WriteFourColors(const TemporaryFolder& folder, const std::string& name) {
  WritePng(folder.Path(name), 2, 2, {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255});
}

inline void ExpectSeen(const Scene& scene, const Material& material, glm::dvec2 uv,
                       glm::dvec3 color) {
  ASSERT_TRUE(material.color_texture);
  const glm::dvec3 seen = LookUpTexture(scene, *material.color_texture, uv);
  EXPECT_LT(glm::length(seen - color), 1e-6) << seen.x << " " << seen.y << " " << seen.z;
}

inline const std::string kTriangle =
    "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2] "
    "\"float uv\" [0 0 1 0 0 1]\n";

class PbrtTextureFiles : public testing::Test {
 protected:
  PbrtTextureFiles() { WriteFourColors(folder_, "t.png"); }
  Scene Read(const std::string& textures, const std::string& material) {
    return ReadScene(
        folder_.Write("s.pbrt", "WorldBegin\n" + textures + "\n" + material + "\n" + kTriangle));
  }
  TemporaryFolder folder_;
};

}  // namespace skywave
