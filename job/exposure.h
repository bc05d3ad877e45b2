// The exposure and tone curve of the PNG of a picture: a request like that of a job, and its
// options.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "image/image.h"
#include "job/request.h"
#include "wavefront/film/aovs.h"
#include "wavefront/option.h"

namespace skywave {

struct ExposureChoice {
  bool automatic = false;  // by the picture (AutomaticExposureStops)
  float stops = 0;         // where it is not automatic
};

struct ExposureRequest {
  std::optional<ExposureChoice> exposure;  // unset: see ResolveExposure
  ToneCurve curve = ToneCurve::kClip;
  PhotographicExposure photo;  // shutter_seconds 0: no camera is simulated
};

// Returns the options exposure, shutter, f-number, iso and tone.
std::vector<OptionOf<ExposureRequest>> ExposureOptions();

// Returns the request with what it leaves open: it is automatic where `job` brings a map of its
// own, whose scale is arbitrary, and no camera is simulated. Throws OptionError for a
// camera whose exposure is to be automatic.
ExposureRequest ResolveExposure(ExposureRequest request, const JobRequest& job);

// Returns whether the picture itself decides.
bool IsAutomatic(const ExposureRequest& resolved);

// Returns the layers by which an automatic exposure tells objects from what is behind them.
AovSet MeteredLayers();

// Returns the exposure and curve of the PNG of `image`, with the exposure of the camera added. If
// the coverage is not among `layers`, all of the picture is metered.
ToneMapping Tone(const ExposureRequest& resolved, const Image& image,
                 std::span<const NamedChannel> layers = {});

}  // namespace skywave
