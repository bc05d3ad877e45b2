// Names of options, as flags, files and reports have them.
#pragma once

#include <optional>
#include <string_view>

#include "wavefront/frame.h"

namespace skywave {

std::optional<CameraKind> ParseCameraKind(std::string_view name);
std::string_view ToString(CameraKind kind);
std::optional<Integrator> ParseIntegrator(std::string_view name);
std::string_view ToString(Integrator integrator);
std::optional<PhotonKernel> ParsePhotonKernel(std::string_view name);
std::string_view ToString(PhotonKernel kernel);
std::optional<PixelFilter> ParsePixelFilter(std::string_view name);
std::string_view ToString(PixelFilter filter);

}  // namespace skywave
