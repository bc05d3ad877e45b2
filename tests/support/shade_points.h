// Surfaces as strategies see them, for tests that have nothing but surfaces.
#pragma once

#include "lights/strategy.h"

namespace skywave {

inline ShadePoints PointsOn(const SurfaceColumns& surfaces) {
  static const SurfaceRanges ranges;
  static const MaterialView materials = {};
  static const PathColumns paths = {};
  return {.surfaces = surfaces, .ranges = ranges, .materials = materials, .paths = paths};
}

}  // namespace skywave
