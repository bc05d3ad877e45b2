// What a camera writes into a JPEG about its exposure (Exif 2.32, JEITA CP-3451).
#pragma once

#include <optional>
#include <string_view>

namespace skywave {

struct CameraExposure {
  std::optional<double> seconds, f_number, iso;
};

// Returns what the bytes of a file say; nothing for what they do not, and for a file that is no
// JPEG or whose Exif is damaged.
CameraExposure ReadCameraExposure(std::string_view bytes);

}  // namespace skywave
