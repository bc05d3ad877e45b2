#include "wavefront/option_names.h"

namespace skywave {

std::optional<CameraKind> ParseCameraKind(std::string_view name) {
  for (const CameraKind kind : kCameraKinds) {
    if (name == ToString(kind)) return kind;
  }
  return std::nullopt;
}

std::string_view ToString(CameraKind kind) {
  switch (kind) {
    case CameraKind::kPerspective:
      return "perspective";
    case CameraKind::kOrthographic:
      return "orthographic";
    case CameraKind::kLatLong:
      return "latlong";
    case CameraKind::kEqualArea:
      return "equal-area";
    case CameraKind::kFisheye:
      return "fisheye";
  }
  return "";
}

std::optional<Integrator> ParseIntegrator(std::string_view name) {
  for (const Integrator integrator : kIntegrators) {
    if (name == ToString(integrator)) return integrator;
  }
  return std::nullopt;
}

std::string_view ToString(Integrator integrator) {
  switch (integrator) {
    case Integrator::kDirect:
      return "direct";
    case Integrator::kPath:
      return "path";
    case Integrator::kLight:
      return "light";
    case Integrator::kBdpt:
      return "bdpt";
    case Integrator::kPhoton:
      return "photon";
    case Integrator::kVcm:
      return "vcm";
  }
  return "";
}

std::optional<PhotonKernel> ParsePhotonKernel(std::string_view name) {
  for (const PhotonKernel kernel :
       {PhotonKernel::kConstant, PhotonKernel::kCone, PhotonKernel::kEpanechnikov}) {
    if (name == ToString(kernel)) return kernel;
  }
  return std::nullopt;
}

std::string_view ToString(PhotonKernel kernel) {
  switch (kernel) {
    case PhotonKernel::kConstant:
      return "constant";
    case PhotonKernel::kCone:
      return "cone";
    case PhotonKernel::kEpanechnikov:
      return "epanechnikov";
  }
  return "";
}

std::optional<PixelFilter> ParsePixelFilter(std::string_view name) {
  for (const PixelFilter filter : {PixelFilter::kBox, PixelFilter::kTriangle,
                                   PixelFilter::kGaussian, PixelFilter::kBlackmanHarris}) {
    if (name == ToString(filter)) return filter;
  }
  return std::nullopt;
}

std::string_view ToString(PixelFilter filter) {
  switch (filter) {
    case PixelFilter::kBox:
      return "box";
    case PixelFilter::kTriangle:
      return "triangle";
    case PixelFilter::kGaussian:
      return "gaussian";
    case PixelFilter::kBlackmanHarris:
      return "blackman-harris";
  }
  return "";
}

}  // namespace skywave
