// Names of the values of options whose enums kernels and scenes declare.
#pragma once

#include "base/names.h"
#include "kernels/camera.h"
#include "kernels/light_paths/photons.h"
#include "scene/scene.h"
#include "wavefront/frame.h"

namespace skywave {

template <>
inline constexpr auto kEnumNames<CameraKind> =
    std::to_array<Named<CameraKind>>({{CameraKind::kPerspective, "perspective"},
                                      {CameraKind::kOrthographic, "orthographic"},
                                      {CameraKind::kLatLong, "latlong"},
                                      {CameraKind::kEqualArea, "equal-area"},
                                      {CameraKind::kFisheye, "fisheye"},
                                      {CameraKind::kRealistic, "realistic"}});

template <>
inline constexpr auto kEnumNames<PhotonKernel> =
    std::to_array<Named<PhotonKernel>>({{PhotonKernel::kConstant, "constant"},
                                        {PhotonKernel::kCone, "cone"},
                                        {PhotonKernel::kEpanechnikov, "epanechnikov"}});

template <>
inline constexpr auto kEnumNames<PixelFilter> =
    std::to_array<Named<PixelFilter>>({{PixelFilter::kBox, "box"},
                                       {PixelFilter::kTriangle, "triangle"},
                                       {PixelFilter::kGaussian, "gaussian"},
                                       {PixelFilter::kBlackmanHarris, "blackman-harris"},
                                       {PixelFilter::kMitchell, "mitchell"},
                                       {PixelFilter::kSinc, "sinc"}});

}  // namespace skywave
