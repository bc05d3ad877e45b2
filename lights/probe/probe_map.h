// A map as it is looked at: repaired, with its projection.
#pragma once

#include <optional>
#include <string>

#include "image/image.h"
#include "lights/maps/environment_map.h"

namespace skywave {

struct ProbeMap {
  Image image;
  Projection projection = Projection::kLatLong;
  bool assumed = false;  // given, instead of recognised by the shape
  BadPixels bad;         // repaired ones
};

// Repairs `image`. Throws InputError(name) if `projection` is unset and the shape tells none.
ProbeMap MakeProbeMap(Image image, const std::string& name,
                      const std::optional<Projection>& projection);

}  // namespace skywave
