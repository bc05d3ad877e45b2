#include "lights/tables/cell_sampler.h"

#include <algorithm>
#include <numeric>

#include "lights/maps/environment_map.h"

namespace skywave {
namespace {

// Builds slots [begin, end) with the given weights by Vose's construction; keep is in [0, 1].
void BuildAlias(const std::vector<double>& weight, std::uint32_t begin, std::uint32_t end,
                std::vector<AliasSlot>& slots) {
  const std::uint32_t count = end - begin;
  const double mean =
      std::accumulate(weight.begin() + begin, weight.begin() + end, 0.0) / std::max(count, 1u);
  std::vector<double> share(count);
  std::vector<std::uint32_t> small, large;
  for (std::uint32_t k = 0; k < count; ++k) {
    share[k] = mean > 0 ? weight[begin + k] / mean : 1;
    (share[k] < 1 ? small : large).push_back(k);
  }
  while (!small.empty() && !large.empty()) {
    const std::uint32_t poor = small.back(), rich = large.back();
    small.pop_back();
    slots[begin + poor] = {float(share[poor]), begin + rich};
    share[rich] -= 1 - share[poor];
    if (share[rich] < 1) {
      large.pop_back();
      small.push_back(rich);
    }
  }
  for (const auto& rest : {small, large}) {
    for (const std::uint32_t k : rest) slots[begin + k] = {1, begin + k};
  }
}

}  // namespace

CellSampler::CellSampler(int width, int height, const std::vector<double>& importance,
                         const CellMap& cell_of_texel, std::uint32_t cells)
    : begin_(cells + 1), density_(importance.size()), scale_(cells), tree_(cells, 1) {
  // Slots are texels with importance, sorted by cell, in map order inside a cell.
  for (std::size_t i = 0; i < importance.size(); ++i) {
    if (cell_of_texel[i] != kNoCell && importance[i] > 0) ++begin_[cell_of_texel[i] + 1];
  }
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  texel_.resize(begin_.back());
  slots_.resize(begin_.back());
  std::vector<double> weight(begin_.back()), energy(cells);
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (std::size_t i = 0; i < importance.size(); ++i) {
    const std::uint32_t cell = cell_of_texel[i];
    if (cell == kNoCell || importance[i] <= 0) continue;
    const std::uint32_t slot = next[cell]++;
    texel_[slot] = std::uint32_t(i);
    weight[slot] = importance[i];
    energy[cell] += importance[i];
  }
  std::vector<std::uint16_t> mass(cells);
  std::vector<double> leaf(tree_.leaves());
  tree_.Set(0, energy.data(), mass.data(), leaf.data());
  for (std::uint32_t cell = 0; cell < cells; ++cell) {
    BuildAlias(weight, begin_[cell], begin_[cell + 1], slots_);
    const double probability = leaf[cell / kNodeFan] * mass[cell];
    scale_[cell] = probability > 0 ? float(1 / probability) : 0;
    for (std::uint32_t slot = begin_[cell]; slot < begin_[cell + 1]; ++slot) {
      const double solid_angle =
          RowSolidAngle(width, height, int(texel_[slot] / std::uint32_t(width)));
      density_[texel_[slot]] = float(probability * weight[slot] / energy[cell] / solid_angle);
    }
  }
}

std::size_t CellSampler::bytes() const {
  return (begin_.size() + texel_.size()) * sizeof(std::uint32_t) +
         slots_.size() * sizeof(AliasSlot) + (density_.size() + scale_.size()) * sizeof(float) +
         tree_.bytes();
}

CellsView CellSampler::view() const {
  return {.begin = begin_.data(),
          .slots = slots_.data(),
          .texel = texel_.data(),
          .density = density_.data()};
}

std::vector<float> CellSampler::DensityInCells(const CellMap& cell_of_texel) const {
  std::vector<float> density = density_;
  for (std::size_t i = 0; i < density.size(); ++i) {
    if (cell_of_texel[i] != kNoCell) density[i] *= scale_[cell_of_texel[i]];
  }
  return density;
}

}  // namespace skywave
