// A tree over local lights, by which a surface picks one in proportion to about what it would get
// from it (Conty Estevez and Kulla 2018). LightChoice::tree names it.
#pragma once

#include <cstdint>

namespace skywave {

// The lights below a node: where they lie, which way they shine and how much. 16 words, read by
// gathers.
struct LightNode {
  float center[3], radius;  // a sphere around them; not of distant lights
  float axis[3];            // of a cone that holds all normals; distant: towards the lights
  float cos_cone;           // its half angle; a light that shines all around fills the sphere
  float cos_spread;         // how far from a normal light leaves
  float intensity;          // sum over them, the whole tree's: 1
  std::uint32_t count;      // of lights, with the flags below
  std::uint32_t first;      // of two children, which are next to each other; a leaf's: the light
  std::uint32_t unused[4];
};
static_assert(sizeof(LightNode) == 16 * sizeof(std::uint32_t));

// Flags of LightNode::count.
inline constexpr std::uint32_t kTwoSidedNode = 1u << 31;  // a normal may as well be its opposite
inline constexpr std::uint32_t kDistantNode = 1u << 30;   // all lights of it are distant
inline constexpr std::uint32_t kLightNodeCount = kDistantNode - 1;

struct LightTreeView {
  const LightNode* nodes = nullptr;  // the root is the first
  // The way to each light: bit d is set if it goes to the second child at depth d.
  const std::uint32_t* way = nullptr;
  // By material: 1 if light that comes from behind a surface counts, because it is let through.
  const std::uint32_t* lit_behind = nullptr;
};

}  // namespace skywave
