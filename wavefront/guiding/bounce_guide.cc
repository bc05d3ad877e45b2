#include "wavefront/guiding/bounce_guide.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>

namespace skywave {
namespace {

// A node is split if at least this many rays began there, until there are this many places.
constexpr std::size_t kSplitRays = 1024, kMostPlaces = 4096;
// The estimate of the node above counts as so many rays in each cell.
constexpr double kPriorRays = 2;
// This share of guided directions goes evenly to all cells.
constexpr double kDefensive = 0.1;
// This share of directions is guided.
constexpr float kGuidedShare = 0.5f;

// Directions in columns, as kernels take them.
struct Directions {
  explicit Directions(std::size_t n) : x(n + kPadRows), y(n + kPadRows), z(n + kPadRows) {}
  LightColumns from(std::size_t begin) {
    LightColumns columns = {};
    columns.dir_x = x.data() + begin;
    columns.dir_y = y.data() + begin;
    columns.dir_z = z.data() + begin;
    return columns;
  }
  std::vector<float> x, y, z;
};

// What is known of a node: its axis, and the second moment of the light of each cell.
struct Learnt {
  float axis[3];
  std::array<double, kBounceCells> square;
};

void SetAxis(const std::array<double, 3>& normal, float* axis) {
  // The square root is rounded alike everywhere, which std::hypot is not.
  const double length =
      std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
  for (std::size_t i = 0; i < 3; ++i) {
    axis[i] = length > 0.1 ? float(normal[i] / length) : float(i == 1);
  }
}

// Learns from rays [begin, end) of a node, with `above` as the prior; null for roots.
Learnt Learn(std::span<const BounceRay> rays, const float* axis, const Learnt* above,
             const LightColumns& directions, std::vector<std::uint32_t>& cell) {
  Learnt learnt;
  std::copy_n(axis, 3, learnt.axis);
  double square[kBounceCells + 1] = {}, count[kBounceCells + 1] = {}, all = 0;
  FindGuideCells(axis, std::uint32_t(rays.size()), directions, cell.data());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const double radiance = rays[i].radiance;
    square[cell[i]] += radiance * radiance, ++count[cell[i]];
    all += radiance * radiance;
  }
  std::array<double, kBounceCells> expected;
  expected.fill(rays.empty() ? 0 : all / double(rays.size()));
  if (above != nullptr) {
    Directions centres(kBounceCells);
    FindCellCentres(axis, centres.from(0));
    FindGuideCells(above->axis, kBounceCells, centres.from(0), cell.data());
    for (std::uint32_t c = 0; c < kBounceCells; ++c) {
      if (cell[c] < kBounceCells) expected[c] = above->square[cell[c]];
    }
  }
  for (std::uint32_t c = 0; c < kBounceCells; ++c) {
    learnt.square[c] = (square[c] + kPriorRays * expected[c]) / (count[c] + kPriorRays);
  }
  return learnt;
}

}  // namespace

BounceGuide::BounceGuide(std::vector<BounceRay>& rays, const PlaceBox& box)
    : lines_(1, 0), columns_(1, 0) {
  tbb::parallel_sort(rays.begin(), rays.end());
  std::vector<PlaceWord> words(rays.size());
  Directions directions(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    words[i] = rays[i].place;
    directions.x[i] = rays[i].dir[0];
    directions.y[i] = rays[i].dir[1];
    directions.z[i] = rays[i].dir[2];
  }
  tree_ = BuildPlaceTree(words, box, kSplitRays, kMostPlaces);
  std::vector<Learnt> learnt;
  learnt.reserve(tree_.nodes.size());
  std::vector<std::uint32_t> cell(std::max<std::size_t>(rays.size(), kBounceCells) + kPadRows);
  for (const PlaceTree::Node& node : tree_.nodes) {
    const std::size_t count = node.end - node.begin;
    float axis[3];
    SetAxis(MeanNormal(std::span(words).subspan(node.begin, count)), axis);
    const bool is_root = node.parent == learnt.size();
    learnt.push_back(Learn(std::span(rays).subspan(node.begin, count), axis,
                           is_root ? nullptr : &learnt[node.parent], directions.from(node.begin),
                           cell));
  }
  const std::size_t count = tree_.places.size();
  places_.resize(count);
  lines_ = SearchTrees(kBounceSide, std::uint32_t(count));
  columns_ = SearchTrees(kBounceSide, std::uint32_t(count * kBounceSide));
  density_.resize(count * kBounceCells);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    const Learnt& here = learnt[tree_.places[i]];
    std::copy_n(here.axis, 3, places_[i].axis);
    double weight[kBounceCells], all = 0, line[kBounceSide] = {};
    for (std::uint32_t c = 0; c < kBounceCells; ++c) all += weight[c] = std::sqrt(here.square[c]);
    // Where no light has been seen to arrive, directions are left to the BSDF.
    places_[i].share = all > 0 ? kGuidedShare : 0;
    for (std::uint32_t c = 0; c < kBounceCells; ++c) {
      weight[c] = all > 0 ? (1 - kDefensive) * weight[c] / all + kDefensive / kBounceCells : 1;
      line[c / kBounceSide] += weight[c];
    }
    std::uint16_t of_line[kBounceSide], of_column[kBounceSide];
    double of_lines, of_columns;
    lines_.Set(std::uint32_t(i), line, of_line, &of_lines);
    for (std::uint32_t l = 0; l < kBounceSide; ++l) {
      const std::size_t tree = i * kBounceSide + l;
      columns_.Set(std::uint32_t(tree), weight + l * kBounceSide, of_column, &of_columns);
      for (std::uint32_t c = 0; c < kBounceSide; ++c) {
        density_[tree * kBounceSide + c] =
            float(kBounceCells * of_lines * of_line[l] * of_columns * of_column[c]);
      }
    }
  });
}

BounceGuideView BounceGuide::view() const {
  return {.places = tree_.view(),
          .place = places_.data(),
          .lines = lines_.view(),
          .columns = columns_.view(),
          .density = density_.data()};
}

std::size_t BounceGuide::bytes() const {
  return tree_.bytes() + places_.size() * sizeof(GuidePlace) + lines_.bytes() + columns_.bytes() +
         density_.size() * sizeof(float);
}

}  // namespace skywave
