#include "lights/probe/probe_map.h"

#include <utility>

#include "lights/maps/projections.h"

namespace skywave {

ProbeMap MakeProbeMap(Image image, const std::string& name,
                      const std::optional<Projection>& projection) {
  ProbeMap map;
  map.image = std::move(image);
  map.assumed = projection.has_value();
  map.projection = projection ? *projection : DetectProjection(map.image, name);
  map.bad = RepairRadiance(map.image);
  return map;
}

}  // namespace skywave
