#include "lights/probe_lights.h"

#include <charconv>
#include <numbers>
#include <utility>

#include "base/error.h"
#include "lights/median_cut.h"
#include "lights/variance_cut.h"

namespace skywave {
namespace {

constexpr std::pair<std::string_view, LightMethod> kMethods[] = {
    {"median-cut", LightMethod::kMedianCut},
    {"variance-cut", LightMethod::kVarianceCut},
    {"penrose", LightMethod::kPenrose}};

template <class Number>
bool ParseNumber(std::string_view text, Number& number) {
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, number);
  return result.ec == std::errc() && result.ptr == end;
}

std::vector<Vector3> DirectionsOf(const LightSet& set) {
  std::vector<Vector3> directions;
  for (const DirectionalLight& light : set.lights) directions.push_back(light.direction);
  return directions;
}

LightSet LightsOfMap(const SphereMap& map, const LightRequest& request) {
  const bool clusters = request.stop.clusters > 0 || request.stop.separation > 0;
  LightSet set;
  if (request.method == LightMethod::kPenrose) {
    const PenroseSet samples =
        PenroseSamples(ImportancePyramid(map), request.count, request.penrose);
    set = VoronoiLights(map, Directions(samples), request.position,
                        clusters ? 0 : request.lloyd_steps);
  } else {
    const std::vector<Region> regions = request.method == LightMethod::kMedianCut
                                            ? MedianCut(map, request.count)
                                            : VarianceCut(map, request.count);
    set = LightsOfRegions(map, regions, request.position);
    if (!clusters && request.lloyd_steps > 0) {
      set = VoronoiLights(map, DirectionsOf(set), request.position, request.lloyd_steps);
    }
  }
  if (!clusters || set.lights.empty()) return set;
  const std::vector<CellSums> cells = SumCells(map, set.cell_of_texel, set.lights.size());
  const Clustering clustering =
      ClusterPairwise(DirectionsOf(set), Frequencies(cells, request.frequency), request.stop);
  return VoronoiLights(map, clustering.directions, request.position, request.lloyd_steps);
}

}  // namespace

std::optional<LightMethod> ParseLightMethod(std::string_view name) {
  for (const auto& [key, method] : kMethods) {
    if (key == name) return method;
  }
  return std::nullopt;
}

std::string_view ToString(LightMethod method) { return kMethods[int(method)].first; }

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

Strata DivideMap(const SphereMap& map, const StrataRequest& request) {
  switch (request.kind) {
    case StrataRequest::Kind::kFraction:
      return StrataByFraction(map, request.fraction);
    case StrataRequest::Kind::kLights:
      return StrataByLights(map, request.lights, request.separation);
    case StrataRequest::Kind::kVariation:
      return StrataByVariation(map);
    case StrataRequest::Kind::kNone:
      break;
  }
  return StrataByFraction(map, 1);
}

ProbeLights MakeProbeLights(const SphereMap& map, const LightRequest& request) {
  ProbeLights result;
  result.map_energy = map.energy;
  if (request.strata.kind == StrataRequest::Kind::kNone) {
    result.set = LightsOfMap(map, request);
  } else {
    result.strata = DivideMap(map, request.strata);
    const Image bright = StratumImage(map, *result.strata, true);
    result.set = LightsOfMap(MakeSphereMap(bright), request);
    result.residual = StratumImage(map, *result.strata, false);
    result.residual_energy = MakeSphereMap(result.residual).energy;
  }
  for (const DirectionalLight& light : result.set.lights) result.lights_energy += light.energy;
  return result;
}

}  // namespace skywave
