// Implements the functions of the library that take or return pictures and maps.
#include <optional>

#include "api/errors.h"
#include "api/state.h"
#include "bench/measure/json_reports.h"
#include "image/compare.h"
#include "image/flip.h"
#include "lights/maps/projections.h"
#include "lights/maps/resample.h"
#include "lights/maps/sphere_map.h"
#include "lights/probe/probe_info.h"
#include "lights/probe/probe_map.h"

namespace skywave::api {
namespace {

std::string Png(const ImageArray& picture, float exposure, const std::string& tone) {
  const std::optional<ToneCurve> curve = Parse<ToneCurve>(tone);
  Require(curve.has_value(), "tone", "is not " + Choices<ToneCurve>());
  Require(exposure >= -100 && exposure <= 100, "exposure", "is not a number from -100 to 100");
  const skywave::Image image = CopyImage(picture, "image");
  return skywave::EncodePng(image.width, image.height,
                            ToneMap(image, {.exposure_stops = exposure, .curve = *curve}));
}

}  // namespace

Image ReadImage(const std::string& path) {
  return Translated([&] {
    skywave::Image image = skywave::ReadImage(path);
    return Image{image.width, image.height, std::move(image.rgb)};
  });
}

std::string EncodePng(const ImageArray& image, float exposure, const std::string& tone) {
  return Translated([&] { return Png(image, exposure, tone); });
}

std::string Compare(const ImageArray& image, const ImageArray& reference) {
  return Translated([&] {
    const skywave::Image a = CopyImage(image, "image"), b = CopyImage(reference, "reference");
    return JsonText(skywave::Compare(a, b), HdrFlip(a, b));
  });
}

std::string DescribeMap(const ImageArray& image, const std::string& projection) {
  return Translated([&] {
    const std::optional<Projection> given = Parse<Projection>(projection);
    Require(given || projection.empty(), "projection", "is not " + Choices<Projection>());
    const ProbeMap map = MakeProbeMap(CopyImage(image, "map"), "map", given);
    const ProbeInfo info =
        skywave::DescribeMap(MakeSphereMap(ToLatLong(map.image, map.projection)));
    return JsonText(map, info);
  });
}

}  // namespace skywave::api
