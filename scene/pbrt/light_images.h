// The images of pbrt's lights. pbrt-v4 names them "filename"; pbrt-v3 names them "mapname", lays
// them otherwise, and takes bytes as they are. A light whose image is missing or cannot be read
// shines as if it were white, with a warning.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "scene/pbrt/state.h"

namespace skywave {

// The path of a light's image; empty: it is missing.
struct PbrtLightFile {
  std::string path;
  bool v4;
};
// Returns nothing for a light that names none.
std::optional<PbrtLightFile> FindPbrtLightFile(PbrtReader& reader, PbrtParameters& parameters);

// Returns the image, which is white where there is none.
struct PbrtLightImage {
  std::uint32_t index;  // into Scene::images
  bool v4;
};
PbrtLightImage FindPbrtLightImage(PbrtReader& reader, PbrtParameters& parameters);

// Returns the equal-area square of an image around a light, which is one already in pbrt-v4, and
// its mean. Throws InputError for one of pbrt-v4 that is no square.
PbrtSphereImage SphereImageOf(PbrtReader& reader, const PbrtParameters& parameters,
                              const PbrtLightImage& given);

// Warns that a light shines without its image, for this reason.
void WarnOfPbrtLightImage(PbrtReader& reader, const PbrtParameters& parameters,
                          const InputError& error);

}  // namespace skywave
