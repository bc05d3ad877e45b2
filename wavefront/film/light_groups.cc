#include "wavefront/film/light_groups.h"

#include <algorithm>
#include <cctype>
#include <iterator>

#include "scene/local_lights.h"
#include "wavefront/frame.h"

namespace skywave {
namespace {

std::string NameOf(const LocalLight& light, const Scene& scene, const Geometry& geometry) {
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

}  // namespace

LightGroups MakeLightGroups(const Scene& scene, const Geometry& geometry,
                            const LocalLightView& lights) {
  LightGroups groups = {.names = {"environment"}, .of_light = {}};
  for (std::uint32_t i = 0; i < lights.count; ++i) {
    const std::string name = NameOf(lights.lights[i], scene, geometry);
    auto found = std::find(groups.names.begin(), groups.names.end(), name);
    if (found == groups.names.end()) {
      if (groups.names.size() < kMaxLightGroups) {
        groups.names.push_back(groups.names.size() + 1 < kMaxLightGroups ? name : "others");
      }
      found = std::prev(groups.names.end());
    }
    groups.of_light.push_back(std::uint32_t(found - groups.names.begin()));
  }
  return groups;
}

void GroupsOfHits(const FrameView& frame, const HitColumns& hits, std::uint32_t n,
                  std::uint32_t* group) {
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t light = hits.geom[i] == kNoHit || !frame.has_emitters()
                                    ? kNoLight
                                    : frame.local_lights.light_of_triangle[hits.triangle[i]];
    group[i] = light == kNoLight ? kEnvironmentGroup : frame.light_groups->of_light[light];
  }
}

void GroupsOfLightSamples(const FrameView& frame, const LightShares& shares, std::uint32_t index,
                          const float* u, std::uint32_t n, std::uint32_t* group) {
  std::fill_n(group, n, kEnvironmentGroup);
  if (index < shares.plan.fixed || !(shares.local.share > 0)) return;
  const std::uint32_t* const first = shares.local.first;
  const std::uint32_t* const end = first + frame.local_lights.count + 1;
  for (std::uint32_t i = 0; i < n; ++i) {
    const auto target = std::uint32_t(u[i] * float(kChoiceUnits));
    if (target >= end[-1]) continue;
    const auto light = std::upper_bound(first, end, target) - first - 1;
    group[i] = frame.light_groups->of_light[std::size_t(light)];
  }
}

}  // namespace skywave
