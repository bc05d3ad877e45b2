// A map is cut into cells, whatever made them, and directional lights stand for them.
//
// A cell map gives the cell of every texel. A light carries the irradiance of its cell, the sum of
// radiance times solid angle (T 7.1), which is what a surface that faces it receives: not radiance,
// so a light has no size and the lights of a map add up to its energy.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lights/maps/sphere_map.h"
#include "lights/tables/summed_area_table.h"

namespace skywave {

inline constexpr std::uint32_t kNoCell = 0xFFFFFFFFu;
using CellMap = std::vector<std::uint32_t>;  // width * height: cell of a texel, or kNoCell

struct DirectionalLight {
  Vector3 direction;                      // towards the light, unit, map space
  std::array<double, 3> irradiance = {};  // on a surface that faces it [radiance * sr]
  double energy = 0;                      // luminance of the irradiance
  double solid_angle = 0;                 // solid angle of its cell [sr]
};

struct LightSet {
  // Every light has energy > 0. They follow a Hilbert curve over the sphere, so that lights that
  // one uniform picks by their energy keep the stratification of the points that pick them.
  std::vector<DirectionalLight> lights;
  CellMap cell_of_texel;  // index of the light that has the texel's energy
  double bias = 0;        // of lights whose number was chosen for one
};

struct CellSums {
  std::array<double, 3> irradiance = {};
  double energy = 0;
  Vector3 energy_moment;  // integral of luminance * direction
  double solid_angle = 0;
  Vector3 area_moment;  // integral of direction
};

// Returns the sums of cells [0, cells), computed in parallel, in an order that does not depend on
// the threads. Texels of kNoCell are left out.
std::vector<CellSums> SumCells(const SphereMap& map, const CellMap& cell_of_texel,
                               std::size_t cells);

// A cell's light stands at one of these positions. The thesis has kSample; kCentroid is several
// times nearer to the map's irradiance at no cost.
enum class LightPosition {
  kSample,    // the sampler's own: for rectangles their middle in (u, v)
  kCentre,    // mean direction of the cell's area
  kCentroid,  // mean direction of the cell's energy
};

// Makes one light for each cell that has energy; cells without are dropped and their texels become
// kNoCell. `samples` has one unit vector per cell.
LightSet LightsOfCells(const SphereMap& map, CellMap cell_of_texel,
                       std::span<const Vector3> samples, LightPosition position);

// These make cells of rectangles, which must not overlap; texels outside all of them are kNoCell.
CellMap CellsOfRegions(int width, int height, std::span<const Region> regions);
std::vector<Vector3> RegionCentres(int width, int height, std::span<const Region> regions);
LightSet LightsOfRegions(const SphereMap& map, std::span<const Region> regions,
                         LightPosition position);

}  // namespace skywave
