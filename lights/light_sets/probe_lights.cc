#include "lights/light_sets/probe_lights.h"

#include <charconv>
#include <numbers>

#include "lights/light_sets/light_file.h"

namespace skywave {
namespace {

template <class Number>
bool ParseNumber(std::string_view text, Number& number) {
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, number);
  return result.ec == std::errc() && result.ptr == end;
}

}  // namespace

std::optional<StrataRequest> ParseStrata(std::string_view text) {
  StrataRequest request;
  if (text == "variation") {
    request.kind = StrataRequest::Kind::kVariation;
    return request;
  }
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) {
    request.kind = StrataRequest::Kind::kFraction;
    if (!ParseNumber(text, request.fraction)) return std::nullopt;
    if (!(request.fraction >= 0 && request.fraction <= 1)) return std::nullopt;
    return request;
  }
  request.kind = StrataRequest::Kind::kLights;
  double degrees = 0;
  if (!ParseNumber(text.substr(0, colon), request.lights)) return std::nullopt;
  if (!ParseNumber(text.substr(colon + 1), degrees)) return std::nullopt;
  if (request.lights < 0 || !(degrees >= 0 && degrees <= 360)) return std::nullopt;
  request.separation = degrees * std::numbers::pi / 180;
  return request;
}

ProbeLights MakeProbeLights(const SphereMap& map, const LightRequest& request) {
  ProbeLights result;
  result.map_energy = map.energy;
  LightOptions lights = request.lights;
  if (!request.follow.empty()) lights.start = ReadLightDirections(request.follow);
  if (!request.strata) {
    result.set = BuildLights(map, lights);
  } else {
    result.strata = DivideMap(map, *request.strata);
    const Image bright = StratumImage(map, *result.strata, true);
    result.set = BuildLights(MakeSphereMap(bright), lights);
    for (std::size_t i = 0; i < map.texels(); ++i) {
      if (result.strata->in_a[i] == 0) result.set.cell_of_texel[i] = kNoCell;
    }
    result.residual = StratumImage(map, *result.strata, false);
    result.residual_energy = MakeSphereMap(result.residual).energy;
  }
  for (const DirectionalLight& light : result.set.lights) result.lights_energy += light.energy;
  return result;
}

}  // namespace skywave
