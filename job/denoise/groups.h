// The layers of groups of lights of a picture that is made clean (wavefront/film/light_groups.h).
// They are filtered by the weights that statistics gave the whole picture, and then divide the
// clean picture among them, whoever cleaned it. So they add up to it, and a picture of other
// weights of the lights is clean as well: with weights of 1 it is the clean one.
//
// Weights that the whole picture decides are the only ones there are, because the film keeps no
// noise of groups. Renderers whose light groups are cleaned together do the same. What the light of
// one group shows and the whole does not, as the shadow of a lamp that is outshone, is blurred.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "image/image.h"
#include "job/denoise/planes.h"

namespace skywave {

// Returns whether a channel is one of a group of lights.
bool IsOfLightGroup(std::string_view channel);

// Returns clean channels for those of groups in `layers`, which add up to the picture of `input`;
// none if there are none. `planes` are those of the picture, their outliers taken out and their
// noise smooth; `clean` is the clean picture. Throws InputError about `name` where a group lacks a
// colour.
std::vector<NamedChannel> CleanGroups(const std::string& name, const DenoiserInput& input,
                                      const DenoiserPlanes& planes, const Image& clean,
                                      std::span<const NamedChannel> layers);

}  // namespace skywave
