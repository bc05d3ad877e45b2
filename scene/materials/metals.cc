#include "scene/materials/metals.h"

namespace skywave {
namespace {

struct Entry {
  std::string_view symbol;
  MetalIndex index;
};

// These are the measured spectra of Palik, "Handbook of Optical Constants of Solids", in the tables
// that pbrt and Mitsuba distribute, weighted by the CIE 1931 observer and converted to linear
// Rec. 709. The rounded results are those of the Tungsten renderer's table of conductors.
constexpr Entry kMetals[] = {
    {"Ag", {{0.15526f, 0.11672f, 0.13838f}, {4.82834f, 3.12225f, 2.14695f}}},
    {"Al", {{1.65746f, 0.88037f, 0.52123f}, {9.22387f, 6.26952f, 4.83700f}}},
    {"Au", {{0.14312f, 0.37496f, 1.44248f}, {3.98316f, 2.38572f, 1.60322f}}},
    {"Cu", {{0.20044f, 0.92403f, 1.10221f}, {3.91295f, 2.45285f, 2.14219f}}},
    // Brass is from its indices at 450, 550 and 650 nm (Querry, "Optical constants", 1985),
    // titanium dioxide, which is transparent, from those of its extraordinary ray every 20 nm
    // (Devore, "Refractive Indices of Rutile and Sphalerite", 1951), and magnesia, which is, too,
    // from those that Palik's handbook has; all as means over each channel's share of the observer.
    {"CuZn", {{0.42119f, 0.58340f, 1.10362f}, {3.54640f, 2.70353f, 1.79277f}}},
    {"MgO", {{1.73438f, 1.74079f, 1.75403f}, {0, 0, 0}}},
    {"TiO2", {{2.86756f, 2.95619f, 3.17795f}, {0, 0, 0}}},
};

}  // namespace

std::optional<MetalIndex> FindMetal(std::string_view symbol) {
  for (const Entry& entry : kMetals) {
    if (entry.symbol == symbol) return entry.index;
  }
  return std::nullopt;
}

MetalIndex MetalOfReflectance(const glm::vec3& reflectance) {
  const glm::vec3 r = glm::min(reflectance, glm::vec3(0.9999f));
  return {.eta = glm::vec3(1), .k = 2.0f * glm::sqrt(r / (1.0f - r))};
}

}  // namespace skywave
