// Kernels read a set of directional lights in this form.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "kernels/lights/directional.h"
#include "lights/tables/cells.h"
#include "lights/tables/search_tree.h"

namespace skywave {

// The set is immutable and may be empty. Lights are picked with probability proportional to their
// energy.
class DirectionalLights {
 public:
  DirectionalLights(std::span<const DirectionalLight> lights,
                    const std::array<float, 9>& map_from_world);

  std::uint32_t size() const { return std::uint32_t(records_.size()); }
  std::size_t bytes() const { return records_.size() * sizeof(LightRecord) + tree_.bytes(); }
  const LightRecord& operator[](std::uint32_t index) const { return records_[index]; }
  const LightRecord* records() const { return records_.data(); }
  SearchTreeView tree() const { return tree_.view(); }

 private:
  std::vector<LightRecord> records_;
  SearchTrees tree_;
};

}  // namespace skywave
