// A light set in a file: cells, positions and energies that a tool has made in advance, as the
// thesis's pre-processor does (T 7.3). The form is described in docs/probe.md.
#pragma once

#include <string>
#include <vector>

#include "lights/tables/cells.h"

namespace skywave {

// What stands at the top of a file for those who read it; readers need none of it.
struct LightFileNotes {
  std::string source, method;
  double map_energy = 0;
};

std::string LightFileText(const LightSet& set, int width, int height, const LightFileNotes& notes);

// Returns the lights of a file for a map: the directions of the file, each with what the map has in
// its cell, so a file that was made of the map gives the very lights that were written, and it
// serves the map at any exposure. Without cells in the file those of Voronoi are made. Throws
// InputError with the place in the file, also for cells of a map of another size.
LightSet ReadLightFile(const std::string& path, const SphereMap& map);

// Returns the directions of a file, for a map of any size. Throws as ReadLightFile does.
std::vector<Vector3> ReadLightDirections(const std::string& path);

}  // namespace skywave
