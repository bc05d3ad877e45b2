// The tables of portals: each sees a half of the map in the rectified form of
// kernels/lights/portals.h, and portals that lie alike share one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/lights/portals.h"
#include "lights/tables/texels.h"

namespace skywave {

class PortalTables {
 public:
  // Rectified maps have `texels` x `texels` texels, 1 to 4096. The energy of a texel is between
  // that of the map inside it and that of its brightest point everywhere, as far as sample points
  // show, and at least that of the map's narrow texels whose middle lies in it: a sun cannot be
  // missed. There are at most kMaxPortals portals.
  PortalTables(const Texels& map, std::span<const Portal> portals, std::uint32_t texels);

  PortalsView view() const;
  std::size_t bytes() const {
    return records_.size() * sizeof(PortalRecord) + 2 * sums_.size() * sizeof(std::uint32_t);
  }

 private:
  std::uint32_t texels_;
  std::vector<PortalRecord> records_;
  std::vector<std::uint32_t> sums_, columns_;  // of all rectified maps
};

}  // namespace skywave
