// The irradiance of a map on surfaces from which nothing hides it, for a control variate
// (kernels/lights/irradiance.h).
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "kernels/lights/irradiance.h"
#include "lights/maps/environment_map.h"

namespace skywave {

class VectorIrradiance {
 public:
  // Sums over the very texels that light samples see (Texels). Along a row of the map sums are
  // exact; across rows they are Gaussian quadratures of the texels that the horizon cuts.
  explicit VectorIrradiance(const EnvironmentMap& map);

  IrradianceView view() const;
  std::size_t bytes() const { return nodes_.size() * sizeof(float); }

 private:
  std::vector<float> nodes_;
  std::array<float, 9> map_from_world_;
};

}  // namespace skywave
