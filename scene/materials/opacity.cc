#include "scene/materials/opacity.h"

namespace skywave {

std::vector<OpacityRecord> MakeOpacityRecords(const std::vector<Material>& materials) {
  std::vector<OpacityRecord> records;
  for (const Material& material : materials) {
    records.push_back({.factor = material.opacity,
                       .cutoff = material.opacity_cutoff.value_or(-1),
                       .texture = material.opacity_texture ? *material.opacity_texture + 1 : 0,
                       .unused = 0});
  }
  return records;
}

}  // namespace skywave
