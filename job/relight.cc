#include "job/relight.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/files.h"
#include "base/nearest_name.h"
#include "image/weighted_sums.h"
#include "job/film_file.h"
#include "wavefront/film/light_groups.h"

namespace skywave {
namespace {

std::string_view WithoutBlanks(std::string_view text) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

// Returns the number that a text is.
std::optional<float> FloatOf(std::string_view cell) {
  const std::string_view text = WithoutBlanks(cell);
  float value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  return parts;
}

Picture PictureOfFilm(const std::string& path, const FilmInFile& read) {
  if (read.file.is_checkpoint || read.file.holds.size() != 1 ||
      read.file.holds[0].window != read.file.window) {
    throw InputError(InputPosition::File(path), "holds no whole picture; finish or merge it first");
  }
  const PicturePart& part = read.file.holds[0];
  return ResolvePicture(read.film, part.samples.count(), read.file.layers, read.file.identity,
                        part);
}

Picture PictureOfExr(const std::string& path, const ReadLimits& limits) {
  std::vector<std::string> wanted;
  for (const std::string& name : ReadLayerNames(path, limits)) {
    if (name.starts_with(kLightGroupPrefix) || name == "A") wanted.push_back(name);
  }
  LayeredImage read = ReadOwnColors(path, wanted, limits);
  Picture picture;
  picture.image = std::move(read.image), picture.layers = std::move(read.layers);
  picture.placement = read.placement, picture.space = read.space;
  picture.metadata = ReadExrMetadata(path, limits);
  picture.alpha = TakeLayer("A", picture.layers);
  if (IsStraight(picture.metadata)) Premultiply(picture.alpha, picture.image);
  return picture;
}

// Takes the layers of groups out of the picture.
LitPicture ByLights(Picture picture) {
  LitPicture lit;
  for (const NamedChannel& layer : picture.layers) {
    if (!layer.name.starts_with(kLightGroupPrefix)) continue;
    const std::size_t dot = layer.name.rfind('.');
    const std::size_t begin = kLightGroupPrefix.size();
    const std::string group = layer.name.substr(begin, dot - begin);
    const std::size_t channel = std::string_view("RGB").find(layer.name.substr(dot + 1));
    if (dot == std::string::npos || channel >= 3) continue;
    if (lit.groups.empty() || lit.groups.back() != group) {
      lit.groups.push_back(group);
      lit.lights.emplace_back(picture.image.width, picture.image.height);
    }
    for (std::size_t i = 0; i < layer.values.size(); ++i) {
      lit.lights.back().rgb[3 * i + channel] = layer.values[i];
    }
  }
  picture.layers.clear();
  lit.picture = std::move(picture);
  return lit;
}

using Factors = std::vector<std::array<float, 3>>;  // of each group

Factors FactorsOf(const LitPicture& lit, const std::vector<LightWeight>& weights) {
  Factors factors(lit.groups.size(), {1, 1, 1});
  for (const LightWeight& weight : weights) {
    const auto found = std::find(lit.groups.begin(), lit.groups.end(), weight.group);
    if (found == lit.groups.end()) {
      throw OptionError(
          "weights", weight.group,
          fmt::format("there is no such group of lights; there are {}",
                      NearestFirst(weight.group, {lit.groups.begin(), lit.groups.end()})));
    }
    factors[std::size_t(found - lit.groups.begin())] = weight.factor;
  }
  return factors;
}

// Throws unless the groups add up to the picture.
void CheckSum(const std::string& path, const LitPicture& lit) {
  constexpr double kRounding = 2e-3;  // of 16-bit floats
  const Image sum = Relit(lit, {});
  double difference = 0, level = 0;
  for (std::size_t i = 0; i < sum.rgb.size(); ++i) {
    difference += std::abs(double(sum.rgb[i]) - double(lit.picture.image.rgb[i]));
    level += std::abs(double(lit.picture.image.rgb[i]));
  }
  if (difference <= kRounding * level) return;
  throw InputError(InputPosition::File(path),
                   "its groups of lights do not add up to the picture: it has catchers, or another "
                   "program has denoised it or divided it by its alpha");
}

}  // namespace

Codec<LightWeight> LightWeights() {
  return {.values = "NAME=WEIGHT or NAME=R/G/B, for example key=2",
          .metavar = "NAME=WEIGHT,...",
          .parse = [](const std::string& text) -> std::optional<LightWeight> {
            const std::size_t equals = text.rfind('=');
            if (equals == std::string::npos || equals == 0) return std::nullopt;
            LightWeight weight = {.group = text.substr(0, equals)};
            const std::vector<std::string> parts = Split(text.substr(equals + 1), '/');
            if (parts.size() != 1 && parts.size() != 3) return std::nullopt;
            for (std::size_t c = 0; c < 3; ++c) {
              const std::optional<float> value = FloatOf(parts[parts.size() == 1 ? 0 : c]);
              if (!value) return std::nullopt;
              weight.factor[c] = *value;
            }
            return weight;
          },
          .print =
              [](const LightWeight& weight) {
                return fmt::format("{}={}/{}/{}", weight.group, weight.factor[0], weight.factor[1],
                                   weight.factor[2]);
              }};
}

LitPicture ReadLitPicture(const std::string& path, const ReadLimits& limits) {
  const bool is_film = std::filesystem::path(path).extension() == ".film";
  LitPicture lit =
      ByLights(is_film ? PictureOfFilm(path, ReadFilm(path)) : PictureOfExr(path, limits));
  if (lit.groups.empty()) {
    throw InputError(InputPosition::File(path),
                     "has no groups of lights; render it with --aovs lights");
  }
  CheckSum(path, lit);
  lit.picture.image = {};
  return lit;
}

Image Relit(const LitPicture& lit, const std::vector<LightWeight>& weights) {
  return std::move(RelitAll(lit, {&weights, 1}).front());
}

std::vector<Image> RelitAll(const LitPicture& lit, std::span<const std::vector<LightWeight>> rows) {
  std::vector<Factors> factors;
  for (const std::vector<LightWeight>& weights : rows) factors.push_back(FactorsOf(lit, weights));
  return WeightedSums(lit.lights, factors);
}

std::vector<std::vector<LightWeight>> ReadWeightTable(const std::string& path) {
  std::istringstream text(ReadFile(path));
  struct Column {
    std::size_t group;
    std::size_t channel;  // 3: all
  };
  std::vector<LightWeight> groups;
  std::vector<Column> columns;
  std::vector<std::vector<LightWeight>> rows;
  std::string line;
  for (std::size_t number = 1; std::getline(text, line); ++number) {
    if (WithoutBlanks(line).empty() || line.front() == '#') continue;
    const std::vector<std::string> cells = Split(line, ',');
    const auto refuse = [&](const std::string& why) {
      return InputError(InputPosition::Line(path, number), why);
    };
    if (columns.empty()) {
      for (const std::string& cell : cells) {
        std::string name(WithoutBlanks(cell));
        std::size_t channel = 3;
        if (name.size() > 2 && name[name.size() - 2] == '.') {
          channel = std::min<std::size_t>(std::string_view("rgb").find(name.back()), 3);
          if (channel < 3) name.resize(name.size() - 2);
        }
        const auto found = std::find_if(groups.begin(), groups.end(),
                                        [&](const LightWeight& g) { return g.group == name; });
        if (name.empty()) throw refuse("a column has no name of a group of lights");
        columns.push_back({std::size_t(found - groups.begin()), channel});
        if (found == groups.end()) groups.push_back({.group = name});
      }
      continue;
    }
    if (cells.size() != columns.size()) {
      throw refuse(fmt::format("has {} weights for {} columns", cells.size(), columns.size()));
    }
    std::vector<LightWeight>& row = rows.emplace_back(groups);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const std::optional<float> value = FloatOf(cells[i]);
      if (!value) throw refuse(fmt::format("'{}' is no weight", cells[i]));
      std::array<float, 3>& factor = row[columns[i].group].factor;
      for (std::size_t c = 0; c < 3; ++c) {
        if (columns[i].channel == 3 || columns[i].channel == c) factor[c] = *value;
      }
    }
  }
  if (rows.empty()) throw InputError(InputPosition::File(path), "has no row of weights");
  return rows;
}

}  // namespace skywave
