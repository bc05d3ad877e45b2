// Vectors that agree to a tolerance in each component.
#pragma once

#include <gtest/gtest.h>

#include <glm/glm.hpp>

namespace skywave {

inline void ExpectNear(const glm::vec3& a, const glm::vec3& b, float tolerance = 1e-5f) {
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(a[i], b[i], tolerance) << "(" << a.x << " " << a.y << " " << a.z << ") for (" << b.x
                                       << " " << b.y << " " << b.z << ")";
  }
}

}  // namespace skywave
