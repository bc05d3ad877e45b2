#include "lights/tables/max_pyramid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

#include "base/error.h"

namespace skywave {
namespace {

MaxPyramid::Level Halve(const MaxPyramid::Level& below) {
  MaxPyramid::Level level = {(below.width + 1) / 2, (below.height + 1) / 2, {}};
  level.value.resize(std::size_t(level.width) * level.height);
  tbb::parallel_for(0, level.height, [&](int y) {
    const float* top = &below.value[std::size_t(2 * y) * below.width];
    const float* bottom = 2 * y + 1 < below.height ? top + below.width : top;
    float* out = &level.value[std::size_t(y) * level.width];
    const int pairs = below.width / 2;
    for (int x = 0; x < pairs; ++x) {
      out[x] = std::max(std::max(top[2 * x], top[2 * x + 1]),
                        std::max(bottom[2 * x], bottom[2 * x + 1]));
    }
    if (pairs < level.width) out[pairs] = std::max(top[2 * pairs], bottom[2 * pairs]);
  });
  return level;
}

}  // namespace

float MaxPyramid::Bound(const Region& rectangle) const {
  const int x0 = std::max(rectangle.x0, 0), x1 = std::min(rectangle.x1, width()) - 1;
  const int y0 = std::max(rectangle.y0, 0), y1 = std::min(rectangle.y1, height()) - 1;
  if (x0 > x1 || y0 > y1) return 0;
  const unsigned extent = unsigned(std::max(x1 - x0, y1 - y0));
  const int k = std::min(std::max(int(std::bit_width(extent)) - 1, 0), int(levels.size()) - 1);
  const Level& level = levels[k];
  float bound = 0;
  for (int y = y0 >> k; y <= y1 >> k; ++y) {
    for (int x = x0 >> k; x <= x1 >> k; ++x) {
      bound = std::max(bound, level.value[std::size_t(y) * level.width + x]);
    }
  }
  return bound;
}

MaxPyramid MakeMaxPyramid(int width, int height, std::vector<float> values) {
  if (width < 1 || height < 1) throw InputError({}, "the importance has no texels");
  assert(values.size() == std::size_t(width) * height);
  MaxPyramid pyramid;
  for (float value : values) {
    if (!(value >= 0 && std::isfinite(value))) {
      throw InputError({}, "importance must be finite and not negative");
    }
    pyramid.sum += value;
  }
  pyramid.levels.push_back({width, height, std::move(values)});
  while (pyramid.levels.back().value.size() > 1) {
    pyramid.levels.push_back(Halve(pyramid.levels.back()));
  }
  return pyramid;
}

MaxPyramid ImportancePyramid(const SphereMap& map) {
  std::vector<float> importance(map.texels());
  const double middle = map.solid_angle[map.height / 2];
  tbb::parallel_for(0, map.height, [&](int y) {
    const float weight = float(map.solid_angle[y] / middle);
    for (int x = 0; x < map.width; ++x) {
      const std::size_t i = std::size_t(y) * map.width + x;
      importance[i] = map.luminance[i] * weight;
    }
  });
  return MakeMaxPyramid(map.width, map.height, std::move(importance));
}

MaxPyramid PlanePyramid(const SphereMap& map) {
  return MakeMaxPyramid(map.width, map.height, {map.luminance.begin(), map.luminance.end()});
}

}  // namespace skywave
