// The table by which paths are guided (kernels/lights/bounce_guide.h), as it is learnt from a
// pilot's rays.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kernels/lights/bounce_guide.h"
#include "lights/tables/places.h"
#include "lights/tables/search_tree.h"

namespace skywave {

// A ray of the pilot that has left a guided surface, and the light that it has brought.
struct BounceRay {
  PlaceWord place;
  std::array<float, 3> dir;  // world space
  float radiance;            // luminance
  friend auto operator<=>(const BounceRay&, const BounceRay&) = default;
};

class BounceGuide {
 public:
  // Learns from rays, which are sorted here: their order does not matter.
  BounceGuide(std::vector<BounceRay>& rays, const PlaceBox& box);

  BounceGuideView view() const;
  std::size_t bytes() const;

 private:
  PlaceTree tree_;
  std::vector<GuidePlace> places_;
  SearchTrees lines_, columns_;
  std::vector<float> density_;
};

}  // namespace skywave
