// Search trees give every item the probability that they report, and the search draws it.

#include "lights/tables/search_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/support/random_rows.h"
#include "tests/support/statistics.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

constexpr std::uint32_t kSizes[] = {1, 2, 31, 32, 33, 1000, 1024, 1025, 5000, 32768};

struct Weights {
  std::string name;
  std::vector<double> values;
};
std::vector<Weights> WeightsOf(std::uint32_t items) {
  Random random(items);
  std::vector<Weights> list = {
      {"even", std::vector<double>(items, 0.25)},  {"ramp", std::vector<double>(items)},
      {"gaps", std::vector<double>(items)},        {"hot", std::vector<double>(items, 1e-9)},
      {"lonely", std::vector<double>(items, 0.0)}, {"huge range", std::vector<double>(items)}};
  for (std::uint32_t i = 0; i < items; ++i) {
    list[1].values[i] = i + 1;
    list[2].values[i] = random.Float() < 0.7f ? 0 : random.Float();
    list[5].values[i] = std::pow(10, random.Between(-200, 200));
  }
  list[2].values[items / 2] = 0.5;
  list[3].values[items * 2 / 3] = 1e9;
  list[4].values[items - 1] = 3;
  return list;
}

struct Built {
  SearchTrees trees;
  std::vector<std::uint16_t> leaf_mass;
  std::vector<double> leaf;
  // Returns the reported probability.
  double Probability(std::uint32_t item) const { return leaf[item / kNodeFan] * leaf_mass[item]; }
};
Built Build(const std::vector<double>& weights) {
  const auto items = std::uint32_t(weights.size());
  Built built = {SearchTrees(items, 1), std::vector<std::uint16_t>(items), {}};
  built.leaf.resize(built.trees.leaves());
  built.trees.Set(0, weights.data(), built.leaf_mass.data(), built.leaf.data());
  return built;
}

// Returns the probability with which a search draws an item, by the masses along its path through
// the tree.
double WalkedProbability(const SearchTreeView& view, std::uint32_t tree, std::uint32_t item) {
  double probability = 1;
  for (std::uint32_t level = 0; level < view.levels; ++level) {
    std::uint32_t child = item;
    for (std::uint32_t below = level + 1; below < view.levels; ++below) child /= kNodeFan;
    const SearchNode& node = view.level[level][tree * view.nodes[level] + child / kNodeFan];
    const std::uint32_t k = child % kNodeFan;
    const int end = k + 1 < kNodeFan ? node.start[k + 1] : int(kNodeMass);
    probability *= double(end - node.start[k]) / kNodeMass;
  }
  return probability;
}

TEST(SearchTrees, ReportWhatTheSearchDraws) {
  for (const std::uint32_t items : kSizes) {
    for (const Weights& weights : WeightsOf(items)) {
      SCOPED_TRACE(weights.name + ", " + std::to_string(items) + " items");
      const Built built = Build(weights.values);
      const double total = std::accumulate(weights.values.begin(), weights.values.end(), 0.0);
      double sum = 0;
      for (std::uint32_t i = 0; i < items; ++i) {
        const double p = built.Probability(i);
        sum += p;
        ASSERT_NEAR(p, WalkedProbability(built.trees.view(), 0, i), 1e-14 * p) << "item " << i;
        ASSERT_EQ(p > 0, weights.values[i] > 0) << "item " << i;
        ASSERT_LE(built.leaf_mass[i], kNodeMass);
        // An item with a share s of its node deviates by one part in s * kNodeMass per level, or
        // gets the smallest mass; the largest child also takes the rest left by its 31 siblings.
        const double exact = weights.values[i] / total;
        if (exact > 0.01) {
          ASSERT_NEAR(p / exact, 1, 0.02) << "item " << i;
        }
      }
      EXPECT_NEAR(sum, 1, 1e-12);
    }
  }
}

TEST(SearchTrees, NodesAreMonotone) {
  for (const std::uint32_t items : kSizes) {
    for (const Weights& weights : WeightsOf(items)) {
      const Built built = Build(weights.values);
      const SearchTreeView view = built.trees.view();
      EXPECT_EQ(view.levels, items <= 32 ? 1u : items <= 1024 ? 2u : 3u);
      for (std::uint32_t level = 0; level < view.levels; ++level) {
        for (std::uint32_t k = 0; k < view.nodes[level]; ++k) {
          const auto& start = view.level[level][k].start;
          ASSERT_TRUE(std::is_sorted(std::begin(start), std::end(start)));
          ASSERT_EQ(start[0], 0);
          ASSERT_LE(start[kNodeFan - 1], int(kNodeMass));
        }
      }
    }
  }
}

// Trees that share tables do not affect each other.
TEST(SearchTrees, TreesAreIndependent) {
  constexpr std::uint32_t kItems = 1100, kTrees = 3;
  SearchTrees trees(kItems, kTrees);
  std::vector<std::uint16_t> mass[kTrees];
  std::vector<double> leaf[kTrees];
  for (const std::uint32_t tree : {2u, 0u, 1u}) {
    mass[tree].resize(kItems), leaf[tree].resize(trees.leaves());
    trees.Set(tree, WeightsOf(kItems)[tree].values.data(), mass[tree].data(), leaf[tree].data());
  }
  for (std::uint32_t tree = 0; tree < kTrees; ++tree) {
    for (std::uint32_t i = 0; i < kItems; ++i) {
      const double p = leaf[tree][i / kNodeFan] * mass[tree][i];
      ASSERT_NEAR(p, WalkedProbability(trees.view(), tree, i), 1e-14 * p);
    }
  }
}

}  // namespace
}  // namespace skywave
