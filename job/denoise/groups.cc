#include "job/denoise/groups.h"

#include <array>
#include <cstddef>
#include <string>

#include "job/denoise/candidate.h"
#include "job/denoise/statistics.h"
#include "wavefront/film/light_groups.h"

namespace skywave {
namespace {

std::string ChannelName(const std::string& layer, std::size_t c) { return layer + '.' + "RGB"[c]; }

using Colors = std::array<std::vector<float>, 3>;  // one value per place of the planes

struct Group {
  std::string layer;
  std::array<std::span<const float>, 3> colors;
};

// Returns the groups of a picture that `name` calls; channels may have any order.
std::vector<Group> GroupsOf(const std::string& name, std::size_t pixels,
                            std::span<const NamedChannel> layers) {
  std::vector<Group> groups;
  for (const NamedChannel& layer : layers) {
    if (!IsOfLightGroup(layer.name) || !layer.name.ends_with(".R")) continue;
    Group& group = groups.emplace_back(Group{layer.name.substr(0, layer.name.size() - 2), {}});
    for (std::size_t c = 0; c < 3; ++c) {
      group.colors[c] = FindChannel(name, pixels, layers, ChannelName(group.layer, c));
    }
  }
  return groups;
}

// Returns the factors that make light of the planes, which has no texture and no outliers, out of
// the values of a pixel.
Colors LightOfValues(const DenoiserInput& input, const DenoiserPlanes& planes) {
  const Candidate mean =
      MeanOfHalves(planes, {planes.halves[0].columns(), planes.halves[1].columns()});
  const float* const lights[3] = {mean.light->r, mean.light->g, mean.light->b};
  const float* const textures[3] = {planes.texture->r, planes.texture->g, planes.texture->b};
  Colors factors;
  for (std::size_t c = 0; c < 3; ++c) factors[c].resize(planes.shape.size());
  ForEachPixel(planes.shape, [&](std::size_t pixel, std::size_t at) {
    for (std::size_t c = 0; c < 3; ++c) {
      const float all = input.image.rgb[3 * pixel + c];
      factors[c][at] = all != 0 ? lights[c][at] / all : 1 / textures[c][at];
    }
  });
  return factors;
}

// Returns light that is filtered by the guides; value(c, pixel) is channel c of a pixel.
template <class Value>
soa::Table<HalfPlanes> Filtered(const DenoiserPlanes& planes, const std::vector<HalfTables>& guides,
                                const Colors& factors, const Value& value) {
  soa::Table<HalfPlanes> part = NewHalf(planes.shape);
  float* const lights[3] = {part->r, part->g, part->b};
  ForEachPixel(planes.shape, [&](std::size_t pixel, std::size_t at) {
    for (std::size_t c = 0; c < 3; ++c) lights[c][at] = value(c, pixel) * factors[c][at];
    part->noise[at] = 0;
  });
  RepeatEdges(planes.shape, part);
  FilterByGuides(planes, guides, part);
  return part;
}

}  // namespace

bool IsOfLightGroup(std::string_view channel) { return channel.starts_with(kLightGroupPrefix); }

std::vector<NamedChannel> CleanGroups(const std::string& name, const DenoiserInput& input,
                                      const DenoiserPlanes& planes, const Image& clean,
                                      std::span<const NamedChannel> layers) {
  const std::size_t pixels = clean.rgb.size() / 3;
  const std::vector<Group> groups = GroupsOf(name, pixels, layers);
  if (groups.empty()) return {};
  const std::vector<HalfTables> guides = FilterGuides(planes);
  const Colors factors = LightOfValues(input, planes);
  const soa::Table<HalfPlanes> whole =
      Filtered(planes, guides, factors,
               [&](std::size_t c, std::size_t pixel) { return input.image.rgb[3 * pixel + c]; });
  const float* const wholes[3] = {whole->r, whole->g, whole->b};
  std::vector<NamedChannel> result;
  for (const Group& group : groups) {
    const soa::Table<HalfPlanes> part =
        Filtered(planes, guides, factors,
                 [&](std::size_t c, std::size_t pixel) { return group.colors[c][pixel]; });
    const float* const parts[3] = {part->r, part->g, part->b};
    for (std::size_t c = 0; c < 3; ++c) {
      NamedChannel& channel = result.emplace_back(
          NamedChannel{ChannelName(group.layer, c), std::vector<float>(pixels)});
      ForEachPixel(planes.shape, [&](std::size_t pixel, std::size_t at) {
        // Where no sample has found light, none is known to be of a group more than of others.
        const float share =
            wholes[c][at] > 0 ? parts[c][at] / wholes[c][at] : 1 / float(groups.size());
        channel.values[pixel] = share * clean.rgb[3 * pixel + c];
      });
    }
  }
  return result;
}

}  // namespace skywave
