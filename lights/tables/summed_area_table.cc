#include "lights/tables/summed_area_table.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace skywave {
namespace {

// value(x, y) returns the Sums of one texel.
template <int kChannels, class Value>
SummedAreaTable<kChannels> Build(const SphereMap& map, const Value& value) {
  SummedAreaTable<kChannels> table;
  table.width = map.width;
  table.height = map.height;
  const std::size_t stride = std::size_t(map.width) + 1;
  table.corner.resize(stride * (map.height + 1));
  auto* corner = table.corner.data();
  tbb::parallel_for(0, map.height, [&](int y) {
    auto* row = corner + (y + 1) * stride;
    typename SummedAreaTable<kChannels>::Sums sums = {};
    for (int x = 0; x < map.width; ++x) {
      const auto add = value(x, y);
      for (int c = 0; c < kChannels; ++c) sums[c] += add[c];
      row[x + 1] = sums;
    }
  });
  tbb::parallel_for(tbb::blocked_range<std::size_t>(1, stride, 256), [&](const auto& columns) {
    for (int y = 1; y < map.height; ++y) {
      const auto* above = corner + y * stride;
      auto* row = corner + (y + 1) * stride;
      for (std::size_t x = columns.begin(); x < columns.end(); ++x) {
        for (int c = 0; c < kChannels; ++c) row[x][c] += above[x][c];
      }
    }
  });
  return table;
}

}  // namespace

SummedAreaTable<1> EnergyTable(const SphereMap& map) {
  return Build<1>(map, [&](int x, int y) { return std::array{map.Energy(x, y)}; });
}

SummedAreaTable<4> MomentTable(const SphereMap& map) {
  return Build<4>(map, [&](int x, int y) {
    const double luminance = map.luminance[std::size_t(y) * map.width + x];
    const Vector3 moment = luminance * map.DirectionIntegral(x, y);
    return std::array{luminance * map.solid_angle[y], moment.x, moment.y, moment.z};
  });
}

SummedAreaTable<3> IrradianceTable(const SphereMap& map) {
  return Build<3>(map, [&](int x, int y) {
    const float* rgb = map.image->Pixel(x, y);
    const double weight = map.solid_angle[y];
    return std::array{rgb[0] * weight, rgb[1] * weight, rgb[2] * weight};
  });
}

}  // namespace skywave
