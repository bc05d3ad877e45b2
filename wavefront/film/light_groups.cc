#include "wavefront/film/light_groups.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <iterator>

#include "scene/local_lights.h"

namespace skywave {

std::string NameOfLight(const LocalLight& light, const Scene& scene, const Geometry& geometry) {
  std::string name;
  if (light.kind == LocalLightKind::kTriangle) {
    const Mesh& mesh = scene.meshes[geometry.MeshOf(light.triangle)];
    name = scene.materials[mesh.material].name;
    if (name.empty()) name = "lamps";
  } else {
    name = scene.lights[light.triangle].name;
    if (name.empty()) name = ToString(light.kind);
  }
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-') c = '_';
  }
  return name;
}

LightGroups MakeLightGroups(const Scene& scene, const Geometry& geometry,
                            const LocalLightView& lights, const SkyPatches& sky) {
  LightGroups groups = {.names = {"environment"}, .of_light = {}, .sky = sky};
  const std::uint32_t patches = CountPatches(sky.division);
  if (patches > 0) groups.names.clear();
  for (std::uint32_t i = 0; i < patches; ++i) groups.names.push_back(fmt::format("sky-{:03}", i));
  const std::size_t first = groups.names.size() - 1;
  for (std::uint32_t i = 0; i < lights.count; ++i) {
    const std::string name = NameOfLight(lights.lights[i], scene, geometry);
    auto found = std::find(groups.names.begin(), groups.names.end(), name);
    if (found == groups.names.end()) {
      if (groups.names.size() < first + kMaxLightGroups) {
        groups.names.push_back(groups.names.size() + 1 < first + kMaxLightGroups ? name : "others");
      }
      found = std::prev(groups.names.end());
    }
    groups.of_light.push_back(std::uint32_t(found - groups.names.begin()));
  }
  return groups;
}

}  // namespace skywave
