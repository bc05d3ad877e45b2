// Other weights for the lights of a picture that has been rendered.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "image/image.h"
#include "job/picture.h"
#include "wavefront/option.h"

namespace skywave {

// Factors of the red, green and blue light of a group (wavefront/film/light_groups.h).
struct LightWeight {
  std::string group;
  std::array<float, 3> factor = {1, 1, 1};
};

// Prints and parses "key=2" and "sky=0.5/0.6/1".
Codec<LightWeight> LightWeights();

// A picture by its groups of lights.
struct LitPicture {
  Picture picture;                  // as it was rendered, without its image and its layers
  std::vector<std::string> groups;  // by their names
  std::vector<Image> lights;        // what each of them brings
};

// Reads an EXR or a film with the layers of its groups. Throws InputError where there are none, and
// where they do not add up to the picture, as those of pictures with catchers.
LitPicture ReadLitPicture(const std::string& path, const ReadLimits& limits);

// Returns the picture with these weights; groups without one have 1. Throws OptionError of
// `weights` for a group that is not there, with the nearest ones.
Image Relit(const LitPicture& lit, const std::vector<LightWeight>& weights);
// Returns the same for each of `rows`, faster than one after the other.
std::vector<Image> RelitAll(const LitPicture& lit, std::span<const std::vector<LightWeight>> rows);

// Reads a table of weights, one picture a row: CSV whose first row names groups, each of them alone
// or three times, with .r, .g and .b. Throws InputError with the line.
std::vector<std::vector<LightWeight>> ReadWeightTable(const std::string& path);

}  // namespace skywave
