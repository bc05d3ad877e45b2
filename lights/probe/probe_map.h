// A map that the probe commands look at: repaired, and with its projection.
#pragma once

#include <optional>
#include <string>

#include "image/image.h"
#include "lights/maps/environment_map.h"

namespace skywave {

struct ProbeMap {
  Image image;
  Projection projection = Projection::kLatLong;
  bool assumed = false;  // whether the projection was given, not recognised by the shape
  BadPixels bad;         // those that were repaired
};

// Repairs `image`. Throws InputError(name) if `projection` is unset and does not follow from the
// shape.
ProbeMap MakeProbeMap(Image image, const std::string& name,
                      const std::optional<Projection>& projection);

}  // namespace skywave
