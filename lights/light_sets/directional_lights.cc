#include "lights/light_sets/directional_lights.h"

#include <algorithm>

namespace skywave {

DirectionalLights::DirectionalLights(std::span<const DirectionalLight> lights,
                                     const std::array<float, 9>& map_from_world)
    : tree_(std::max<std::uint32_t>(std::uint32_t(lights.size()), 1), 1) {
  std::vector<double> energy(tree_.items());
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const DirectionalLight& light = lights[i];
    energy[i] = light.energy;
    LightRecord record = {};
    const std::array<float, 3> direction = WorldFromMap(light.direction, map_from_world);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      record.direction[axis] = direction[axis];
      record.irradiance[axis] = float(light.irradiance[axis]);
    }
    records_.push_back(record);
  }
  std::vector<std::uint16_t> mass(tree_.items());
  std::vector<double> leaf(tree_.leaves());
  tree_.Set(0, energy.data(), mass.data(), leaf.data());
  for (std::size_t i = 0; i < records_.size(); ++i) {
    records_[i].probability = float(leaf[i / kNodeFan] * mass[i]);
  }
}

}  // namespace skywave
