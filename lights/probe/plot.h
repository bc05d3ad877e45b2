// Plots are pictures of maps with lights, cells and strata on them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lights/light_sets/strata.h"
#include "lights/tables/cells.h"

namespace skywave {

enum class PlotView { kLatLong, kFront, kBack, kLeft, kRight, kUp, kDown };

// Dots of one size and colour (as shown, [0, 1]).
struct PlotDots {
  std::vector<Vector3> directions;
  std::array<double, 3> color;
};

struct PlotRequest {
  bool log_color = true;  // false colour of log luminance; false: tone-mapped
  double exposure_stops = 0;
  // kLatLong shows the whole map, twice as wide as high. The others show the sphere in a square,
  // from outside and from that side; up is at the top (from above: back; from below: front).
  PlotView view = PlotView::kLatLong;
  int height = 512;  // height of the picture [pixels]
  // These are drawn over the map, unless they are null or empty.
  const CellMap* cells = nullptr;        // borders
  const Strata* strata = nullptr;        // B is dimmed, the border of A drawn
  std::vector<DirectionalLight> lights;  // dots; the area grows with the energy's logarithm
  std::vector<PlotDots> dots;            // in the order in which they are drawn
};

// Returns 8-bit RGB, rows from the top; sets width and height. Throws InputError for a height below
// 16 or above 16384.
std::vector<std::uint8_t> PlotMap(const SphereMap& map, const PlotRequest& request, int& width,
                                  int& height);

// Returns every cell in a colour of its own, texel by texel; texels without a cell are black.
std::vector<std::uint8_t> CellColors(const CellMap& cells);

}  // namespace skywave
