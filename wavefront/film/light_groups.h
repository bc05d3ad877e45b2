// The beauty is split by the lights that it comes from: one layer per group of lights.
//
// Light arrives at a path stage by stage, and all that arrives at one path in one stage comes from
// one light. So the gain of a path in a stage, counted in the film's units, goes to the group of
// that light: these differences are integers that add up to what the film gets, to the last unit,
// unless samples were invalid or sums saturated.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/columns.h"
#include "kernels/lights/local_lights.h"
#include "scene/geometry.h"
#include "scene/scene.h"
#include "wavefront/film/sky_patches.h"
#include "wavefront/soa.h"

namespace skywave {

// The layer of a group has this in front of the group's name.
inline constexpr std::string_view kLightGroupPrefix = "lights-";

// A film keeps three sums per group and pixel; further groups go into the last one. The patches of
// a sky are not counted.
inline constexpr std::size_t kMaxLightGroups = 32;

struct LightGroups {
  std::vector<std::string> names;       // the environment first, or its patches
  std::vector<std::uint32_t> of_light;  // by local light
  SkyPatches sky = {};

  // Returns the group of light that comes from infinitely far away in a direction.
  std::uint32_t OfDirection(float x, float y, float z) const { return PatchOf(sky, x, y, z); }
};
inline constexpr std::uint32_t kEnvironmentGroup = 0;  // or the first patch

// Returns the name of a local light: that of its group.
std::string NameOfLight(const LocalLight& light, const Scene& scene, const Geometry& geometry);

// Lights of one name are a group: emitting surfaces have the name of their material ("lamps"
// without one), other lights their own, or else that of their kind. Characters of names other than
// letters, digits and '-' become '_'. The environment is one group, or has one for each patch of
// `sky`, "sky-000" and so on.
LightGroups MakeLightGroups(const Scene& scene, const Geometry& geometry,
                            const LocalLightView& lights, const SkyPatches& sky = {});

// One row is one path of the wave, written by the functions of the integrator that give light to
// groups.
struct GroupColumns {
  float *r, *g, *b;      // radiance that groups have received
  std::uint32_t* group;  // of the light of the current stage, by ray or surface

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.r), f(self.g), f(self.b), f(self.group);
  }
};

class Film;

// Light that is kept apart by groups of lights goes here.
struct GroupTables {
  explicit GroupTables(std::uint32_t wave) : given(wave) {}
  soa::Table<GroupColumns> given;
  Film* film = nullptr;  // the one that the current wave is for
};

}  // namespace skywave
