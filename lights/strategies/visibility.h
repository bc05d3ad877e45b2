// visibility: cells of the map drawn by how much of their light arrives at the place of a surface.
// A pilot of camera paths learns that before a render (wavefront/policies/visibility_pilot.h), as
// adaptive environment sampling does (Atanasov et al. 2018). So light samples of a room go to its
// windows, whatever else is bright outside.
//
// A place is a leaf of an octree over the surfaces whose normals are closest to the same axis; it
// is split where the pilot has been often enough. Visibility of a cell from a place is a share of
// rays, estimated in the Bayesian way (Vevoda, Kondapaneni and Krivanek 2018): the estimate of the
// node above counts as a few rays more, so a place with few rays is like its surroundings.
// The weight of a cell is its energy times the cosine of the normals of the place times the square
// root of its visibility, which gives the least variance where samples find either all or nothing
// (Rath et al. 2020). The share of the density that diffuse BSDF samples contribute is taken out of
// it
// ("MIS Compensation", Karlik et al. 2019).
//
// Where light and normal alone do about as well, as in the open, nothing is kept, and samples are
// those of `importance`, which are cheaper and better stratified.
//
// Parameters
//   cells=128      number of cells of the map, up to 256, from variance cuts: a sun is one of its
//                  own
//   places=4096    number of places, at most: bounds the memory
//   compensate=1   share of what BSDF samples find that is left to them, 0 to 1: 1 / light samples.
//                  Above 0 it needs BSDF sampling beside it and is refused with --no-mis.
//   defensive=0.1  share of samples of a learnt place that go by light and normal alone, above 0:
//                  bounds the weights
//
// Unbiased, with a density that is positive wherever a learnt place can receive light. Until it is
// taught, the strategy is `importance`.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "kernels/bsdf/bsdf.h"
#include "kernels/lights/visibility.h"
#include "lights/strategies/strategy.h"
#include "lights/tables/cell_sampler.h"
#include "lights/tables/cells.h"
#include "lights/tables/places.h"
#include "lights/tables/search_tree.h"
#include "lights/tables/texels.h"

namespace skywave {

inline constexpr std::uint32_t kMaxVisibilityCells = 256;

// A ray of the pilot: where it left a surface, which cell it looked at, and whether it got out. Of
// the free bits of the word, 8 are those of the cell and the lowest one says "arrived".
using VisibilityRay = PlaceWord;
VisibilityRay PackVisibilityRay(const PlaceBox& box, const std::array<float, 3>& org,
                                const std::array<float, 3>& normal, std::uint32_t cell,
                                bool arrived);

struct VisibilityOptions {
  int cells = 128, places = 4096;
  double compensate = 1, defensive = 0.1;
};

class VisibilityStrategy final : public EnvStrategy {
 public:
  VisibilityStrategy(const EnvironmentMap& map, const VisibilityOptions& options);

  // Returns the same strategy with what `rays` teach, which are sorted here: their order does not
  // matter. It shares the tables of the map.
  std::unique_ptr<VisibilityStrategy> Taught(std::vector<VisibilityRay>& rays,
                                             const PlaceBox& box) const;

  std::string_view name() const override { return "visibility"; }
  bool depends_on_surface() const override { return true; }
  std::size_t table_bytes() const override;
  std::size_t learnt() const { return learnt_; }
  bool complete() const override;
  void Sample(const ShadePoints& points, const UniformColumns& uniforms, std::uint32_t n,
              LightCall call, const LightColumns& out) const override;
  void EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                       const EscapeColumns& rows) const override;

  // Writes the cells of the map in directions [0, n).
  void CellsOf(const float* dir_x, const float* dir_y, const float* dir_z, std::uint32_t n,
               std::uint32_t* cell) const;

 private:
  struct MapTables;
  VisibilityStrategy(std::shared_ptr<const MapTables> tables, const VisibilityOptions& options,
                     std::size_t learnt);
  PlacePicksView Picks() const;
  struct PlaceWeights {
    std::vector<double> of_cells;  // empty if nothing arrives
    bool pays = false;
  };
  // Returns the weights of the cells at a place from the visibility of every cell and the mean of
  // its normals.
  PlaceWeights Weigh(std::span<const float> visibility, const std::array<double, 3>& normal) const;
  void SetPlace(std::size_t place, const std::vector<double>& weights);

  std::shared_ptr<const MapTables> map_;
  VisibilityOptions options_;
  std::size_t learnt_;  // places with tables; others are numbered from there
  PlaceTree tree_;
  SearchTrees trees_;
  std::vector<float> probability_;  // of each cell, place by place
};

}  // namespace skywave
