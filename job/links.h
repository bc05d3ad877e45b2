// The options `link` and `shadow-link`, which say on which surfaces a light shines and which throw
// its shadows (wavefront/stages/links.h).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "job/request.h"
#include "scene/geometry.h"
#include "scene/scene.h"
#include "wavefront/stages/links.h"

namespace skywave {

// Sets the bits of links in the materials of a scene: links of lights come first. Throws
// OptionError for a link of another form than LIGHT:NAME,... or LIGHT:!NAME,..., and for names that
// nothing has.
void MarkLinks(const JobRequest& request, Scene& scene);

// Sets LinkOptions, and throws OptionError where links do not go together with other options.
void PlanLinks(JobRequest& request, bool has_catchers);

// What a LinkView points to.
struct LightLinks {
  std::vector<std::uint32_t> unlit, of_light;
  std::vector<std::vector<std::uint8_t>> stops;
  std::vector<const std::uint8_t*> stops_of_link;
  LinkView view;
};

// Returns the links of the lights of a scene whose materials have been marked; a scene without
// light from a map has no light that is called environment. Throws OptionError for lights that are
// not there.
LightLinks MakeLinks(const JobRequest& request, const Scene& scene, const Geometry& geometry,
                     const LocalLightView& lights, bool has_environment);

}  // namespace skywave
