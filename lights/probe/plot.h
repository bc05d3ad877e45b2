// Pictures of maps with lights, cells and strata on them.
#pragma once

#include <cstdint>
#include <vector>

#include "lights/light_sets/strata.h"
#include "lights/tables/cells.h"

namespace skywave {

enum class PlotView { kLatLong, kFront, kBack, kLeft, kRight, kUp, kDown };

struct PlotRequest {
  bool log_color = true;  // false colour of log luminance; false: tone-mapped
  double exposure_stops = 0;
  // kLatLong: the whole map, twice as wide as high. Others: the sphere seen from outside from that
  // side, square; up is up (from above: back is up; from below: front is).
  PlotView view = PlotView::kLatLong;
  int height = 512;  // of the picture [pixels]
  // What is drawn over the map; null or empty: nothing.
  const CellMap* cells = nullptr;        // borders
  const Strata* strata = nullptr;        // B is dimmed, the border of A drawn
  std::vector<DirectionalLight> lights;  // dots; the area grows with the energy's logarithm
};

// 8-bit RGB, rows from the top; sets width and height. Throws InputError for a height below 16 or
// above 16384.
std::vector<std::uint8_t> PlotMap(const SphereMap& map, const PlotRequest& request, int& width,
                                  int& height);

// Every cell in a colour of its own, texel by texel; texels without a cell are black.
std::vector<std::uint8_t> CellColors(const CellMap& cells);

}  // namespace skywave
