#include "lights/light_sets/light_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "base/json.h"
#include "lights/light_sets/voronoi.h"

namespace skywave {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kSchema = "skywave-presample-2";
constexpr double kUnit = 1e-6;  // how far from 1 the length of a direction may be

Json JsonOf(const DirectionalLight& light, double energy_of_all) {
  double u, v;
  UvOfDirection(light.direction, u, v);
  return {{"uv", {u, v}},
          {"direction", {light.direction.x, light.direction.y, light.direction.z}},
          {"irradiance", light.irradiance},
          {"energy", light.energy},
          {"solid_angle", light.solid_angle},
          {"probability", energy_of_all > 0 ? light.energy / energy_of_all : 0}};
}

// Returns "[cell, texels]" for each run of texels of a row with one cell; -1 is none.
std::string RowText(const std::uint32_t* cells, int width) {
  std::string text;
  for (int x = 0; x < width;) {
    const int first = x;
    while (x < width && cells[x] == cells[first]) ++x;
    const std::int64_t cell = cells[first] == kNoCell ? -1 : std::int64_t{cells[first]};
    text += fmt::format("{}[{}, {}]", first == 0 ? "" : ", ", cell, x - first);
  }
  return "[" + text + "]";
}

CellMap ReadCells(const Json& rows, const InputPosition& at, const SphereMap& map,
                  std::size_t samples) {
  CellMap cells;
  cells.reserve(map.texels());
  for (const Json& row : rows) {
    const std::size_t end = cells.size() + std::size_t(map.width);
    for (const Json& run : row) {
      const auto cell = run.at(0).get<std::int64_t>(), length = run.at(1).get<std::int64_t>();
      if (cell < -1 || cell >= std::int64_t(samples)) {
        throw InputError(at, fmt::format("cell {} has no sample: there are {}", cell, samples));
      }
      if (length < 1 || length > std::int64_t(end - cells.size())) {
        throw InputError(at, fmt::format("row {} of the cells is not {} texels long",
                                         end / std::size_t(map.width) - 1, map.width));
      }
      cells.insert(cells.end(), std::size_t(length), cell < 0 ? kNoCell : std::uint32_t(cell));
    }
    if (cells.size() != end) {
      throw InputError(at, fmt::format("row {} of the cells is not {} texels long",
                                       end / std::size_t(map.width) - 1, map.width));
    }
  }
  if (cells.size() != map.texels()) {
    throw InputError(at, fmt::format("there are cells of {} rows, the map has {}",
                                     cells.size() / std::size_t(map.width), map.height));
  }
  return cells;
}

Vector3 DirectionOf(const Json& sample, const InputPosition& at, std::size_t index) {
  const auto refuse = [&](const char* what) -> InputError {
    return {at, fmt::format("sample {} {}", index, what)};
  };
  if (const auto direction = sample.find("direction"); direction != sample.end()) {
    const Vector3 d = {direction->at(0).get<double>(), direction->at(1).get<double>(),
                       direction->at(2).get<double>()};
    if (!(std::abs(Length(d) - 1) <= kUnit))
      throw refuse("has a direction that is not of length 1");
    return d;
  }
  const auto uv = sample.find("uv");
  if (uv == sample.end()) throw refuse("has neither a direction nor uv");
  const double u = uv->at(0).get<double>(), v = uv->at(1).get<double>();
  if (!(u >= 0 && u <= 1 && v >= 0 && v <= 1)) throw refuse("has uv outside [0, 1]");
  return DirectionOfUv(u, v);
}

std::vector<Vector3> DirectionsOf(const Json& json, const InputPosition& at) {
  std::vector<Vector3> directions;
  for (const Json& sample : json.at("samples")) {
    directions.push_back(DirectionOf(sample, at, directions.size()));
  }
  if (directions.empty()) throw InputError(at, "there are no samples");
  return directions;
}

// Returns what `read` makes of the JSON of a file. Throws InputError for what it cannot read.
template <class Read>
auto ReadJson(const std::string& path, Read read) {
  try {
    return read(ParseOrderedJson(ReadFile(path)));
  } catch (const Json::parse_error& error) {
    throw InputError(InputPosition::Byte(path, error.byte), "is not JSON");
  } catch (const Json::exception& error) {
    throw InputError(InputPosition::File(path),
                     fmt::format("is no light set of skywave probe presample: {}", error.what()));
  }
}

}  // namespace

std::string LightFileText(const LightSet& set, int width, int height, const LightFileNotes& notes) {
  double energy = 0;
  for (const DirectionalLight& light : set.lights) energy += light.energy;
  const Json head = {{"schema", kSchema},
                     {"source", notes.source},
                     {"method", notes.method},
                     {"axes", {"right", "forward", "up"}},
                     {"width", width},
                     {"height", height},
                     {"map_energy", notes.map_energy},
                     {"energy", energy}};
  // A line for each item, for people and for tools that compare files.
  std::string text = "{\n";
  for (const auto& [key, value] : head.items()) {
    text += fmt::format(" {}: {},\n", JsonText(Json(key)), JsonText(value));
  }
  text += " \"samples\": [";
  for (std::size_t i = 0; i < set.lights.size(); ++i) {
    text += fmt::format("{}\n  {}", i == 0 ? "" : ",", JsonText(JsonOf(set.lights[i], energy)));
  }
  text += "\n ],\n \"cells\": [";
  for (int y = 0; y < height; ++y) {
    text += fmt::format("{}\n  {}", y == 0 ? "" : ",",
                        RowText(&set.cell_of_texel[std::size_t(y) * std::size_t(width)], width));
  }
  return text + "\n ]\n}\n";
}

LightSet ReadLightFile(const std::string& path, const SphereMap& map) {
  const InputPosition at = InputPosition::File(path);
  return ReadJson(path, [&](const Json& json) {
    const std::vector<Vector3> directions = DirectionsOf(json, at);
    const auto cells = json.find("cells");
    if (cells == json.end()) return VoronoiLights(map, directions, LightPosition::kSample);
    const int width = json.at("width").get<int>(), height = json.at("height").get<int>();
    if (width != map.width || height != map.height) {
      throw InputError(at, fmt::format("has cells of a map of {}x{}, and this one is {}x{}", width,
                                       height, map.width, map.height));
    }
    return LightsOfCells(map, ReadCells(*cells, at, map, directions.size()), directions,
                         LightPosition::kSample);
  });
}

std::vector<Vector3> ReadLightDirections(const std::string& path) {
  return ReadJson(path,
                  [&](const Json& json) { return DirectionsOf(json, InputPosition::File(path)); });
}

}  // namespace skywave
