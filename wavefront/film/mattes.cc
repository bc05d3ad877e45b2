#include "wavefront/film/mattes.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "base/json.h"
#include "scene/scene.h"

namespace skywave {
namespace {

// MurmurHash3_x86_32 with the seed 0.
std::uint32_t Murmur3(std::string_view bytes) {
  constexpr std::uint32_t kFirst = 0xcc9e2d51, kSecond = 0x1b873593;
  const auto mixed = [](std::uint32_t word) { return std::rotl(word * kFirst, 15) * kSecond; };
  std::uint32_t hash = 0;
  std::size_t at = 0;
  for (; at + 4 <= bytes.size(); at += 4) {
    std::uint32_t word = 0;
    std::memcpy(&word, &bytes[at], 4);
    hash = std::rotl(hash ^ mixed(word), 13) * 5 + 0xe6546b64;
  }
  if (at < bytes.size()) {
    std::uint32_t rest = 0;
    std::memcpy(&rest, &bytes[at], bytes.size() - at);
    hash ^= mixed(rest);
  }
  hash ^= std::uint32_t(bytes.size());
  hash = (hash ^ (hash >> 16)) * 0x85ebca6b;
  hash = (hash ^ (hash >> 13)) * 0xc2b2ae35;
  return hash ^ (hash >> 16);
}

std::vector<std::string> WithDefaults(std::vector<std::string> names, std::string_view kind) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i].empty()) names[i] = fmt::format("{} {}", kind, i + 1);
  }
  return names;
}

constexpr std::string_view kAttributes = "cryptomatte/";

}  // namespace

std::uint32_t MatteId(std::string_view name) {
  const std::uint32_t hash = Murmur3(name), exponent = hash >> 23 & 255;
  return exponent == 0 || exponent == 255 ? hash ^ (1u << 23) : hash;
}

MatteNames MakeMatteNames(std::vector<std::string> names) {
  MatteNames made = {.names = std::move(names), .ids = {}};
  for (const std::string& name : made.names) made.ids.push_back(name.empty() ? 0 : MatteId(name));
  return made;
}

Mattes MakeMattes(const Scene& scene) {
  std::vector<std::string> meshes, materials;
  for (const Mesh& mesh : scene.meshes) {
    meshes.push_back(mesh.node.empty() ? mesh.name : mesh.node);
  }
  for (const Object& object : scene.objects) {
    for (const Mesh& mesh : object.meshes) meshes.push_back(mesh.name);
  }
  for (const Material& material : scene.materials) materials.push_back(material.name);
  meshes = WithDefaults(std::move(meshes), "mesh");
  if (!scene.nodes.empty()) {
    for (const Instance& instance : scene.instances) {
      meshes.push_back(instance.node == kNoNode ? "" : scene.nodes[instance.node]);
    }
  }
  return {MakeMatteNames(std::move(meshes)),
          MakeMatteNames(WithDefaults(std::move(materials), "material"))};
}

std::size_t SlotsOf(const MatteNames& names) {
  std::set<std::uint32_t> ids(names.ids.begin(), names.ids.end());
  ids.erase(0);
  return std::clamp<std::size_t>(ids.size(), 1, kMatteSlots);
}

void AddToMatte(std::size_t pixel, std::uint32_t id, std::uint64_t weight, MatteSums& sums) {
  const std::size_t pixels = sums.ids.size() / sums.slots;
  std::size_t at = pixel;
  const std::size_t end = pixel + sums.slots * pixels;
  while (at < end && sums.ids[at] != 0 && sums.ids[at] < id) at += pixels;
  // The ids from here on are larger; a new one moves them on, and the last one may fall out.
  for (; at < end && id != 0; at += pixels) {
    if (sums.ids[at] == id) {
      sums.weights[at] += weight;
      return;
    }
    std::swap(sums.ids[at], id);
    std::swap(sums.weights[at], weight);
  }
}

std::array<MatteShare, kMatteRanks> RanksOf(const MatteSums& sums, std::size_t pixel) {
  const std::size_t pixels = sums.ids.size() / sums.slots;
  std::array<MatteShare, kMatteSlots> all;
  std::size_t count = 0;
  for (; count < sums.slots && sums.ids[pixel + count * pixels] != 0; ++count) {
    const std::size_t at = pixel + count * pixels;
    all[count] = {sums.ids[at], double(std::int64_t(sums.weights[at]))};
  }
  std::sort(all.begin(), all.begin() + std::ptrdiff_t(count),
            [](const MatteShare& a, const MatteShare& b) {
              return std::pair(-a.weight, a.id) < std::pair(-b.weight, b.id);
            });
  std::array<MatteShare, kMatteRanks> ranks;
  std::copy_n(all.begin(), kMatteRanks, ranks.begin());
  return ranks;
}

Metadata MatteAttributes(std::string_view layer, const MatteNames& names) {
  nlohmann::json manifest = nlohmann::json::object();
  for (std::size_t i = 0; i < names.names.size(); ++i) {
    if (names.ids[i] == 0) continue;
    manifest[names.names[i]] = fmt::format("{:08x}", names.ids[i]);
  }
  const std::string key =
      fmt::format("{}{}/", kAttributes, fmt::format("{:08x}", MatteId(layer)).substr(0, 7));
  return {{key + "name", std::string(layer)},
          {key + "hash", "MurmurHash3_32"},
          {key + "conversion", "uint32_to_float32"},
          {key + "manifest", JsonText(manifest)}};
}

bool IsOfMatte(std::string_view attribute) { return attribute.starts_with(kAttributes); }

}  // namespace skywave
