// The lights of rooms in tests that combine them.
#pragma once

#include "tests/support/render_scenes.h"

namespace skywave {

// The lights of a room; any combination is possible.
enum Lights {
  kLamp = 1,
  kBall = 2,
  kPoint = 4,
  kSpot = 8,
  kDistant = 16,
  kEnvironment = 32,
  kShaped = 64
};
inline constexpr int kLocal = kLamp | kBall | kPoint | kSpot | kDistant;

// Adds those of kSpot, kDistant and kShaped that are among `lights`.
inline void AddSlantingLights(Scene& scene, int lights) {
  if (lights & kSpot) scene.lights.push_back(SlantingSpot());
  if (lights & kDistant) scene.lights.push_back(SlantingSun());
  if (lights & kShaped) {
    for (const PunctualLight& light : ShapedLights(scene)) scene.lights.push_back(light);
  }
}

}  // namespace skywave
