// Builds the tree by which surfaces pick local lights (kernels/lights/light_tree.h).
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/lights/light_tree.h"
#include "scene/local_lights.h"
#include "scene/scene.h"

namespace skywave {

// Immutable once built.
class LightTree {
 public:
  LightTree() = default;
  // There is at least one light. The lights are divided by the surface area orientation heuristic
  // (Conty Estevez and Kulla 2018, section 4.4).
  LightTree(const LocalLights& lights, const Scene& scene);

  LightTreeView view() const { return {nodes_.data(), way_.data(), lit_behind_.data()}; }
  const std::vector<LightNode>& nodes() const { return nodes_; }
  std::size_t bytes() const {
    return nodes_.size() * sizeof(LightNode) +
           (way_.size() + lit_behind_.size()) * sizeof(std::uint32_t);
  }

 private:
  std::vector<LightNode> nodes_;
  std::vector<std::uint32_t> way_, lit_behind_;
};

}  // namespace skywave
