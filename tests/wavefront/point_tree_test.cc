// Compares searches in the tree with a search over all points and with nanoflann.

#include "wavefront/records/point_tree.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <limits>
#include <nanoflann.hpp>
#include <numeric>

#include "tests/support/random_rows.h"
#include "tests/support/targets.h"
#include "wavefront/soa.h"

namespace skywave {
namespace {

using Point = std::array<float, 3>;

struct Cloud {
  std::string name;
  std::vector<Point> points;

  // nanoflann requires these functions.
  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const { return points[i][axis]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

PointTree MakeTree(const std::vector<Point>& points) {
  std::vector<TreePoint> numbered;
  for (const Point& p : points) {
    numbered.push_back({.at = {p[0], p[1], p[2]}, .number = std::uint32_t(numbered.size())});
  }
  return PointTree(numbered);
}

// Returns the distance with the rounding of the kernels.
float Distance2(const Point& p, const Point& q) {
  const float d[3] = {p[0] - q[0], p[1] - q[1], p[2] - q[2]};
  return d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
}

Point RandomPoint(Random& random) {
  return {float(random.Between(-2, 2)), random.Float(), float(random.Between(-1, 3))};
}

std::vector<Cloud> Clouds() {
  Random random(7);
  std::vector<Cloud> clouds = {{"empty", {}}, {"one", {{0.5f, 0.25f, 0.75f}}}};
  for (const std::size_t count : {2u, 15u, 16u, 17u, 33u, 1000u, 20000u}) {
    Cloud cloud = {"random " + std::to_string(count), {}};
    for (std::size_t i = 0; i < count; ++i) cloud.points.push_back(RandomPoint(random));
    clouds.push_back(cloud);
  }
  clouds.push_back({"all at one place", std::vector<Point>(3000, Point{0.1f, 0.2f, 0.3f})});
  Cloud twice = {"each point four times", {}}, grid = {"grid", {}}, caustic = {"caustic", {}};
  for (int i = 0; i < 500; ++i) twice.points.insert(twice.points.end(), 4, RandomPoint(random));
  for (int i = 0; i < 4096; ++i) {
    grid.points.push_back({float(i % 16) / 8, float(i / 16 % 16) / 8, float(i / 256) / 8});
  }
  for (int i = 0; i < 8000; ++i) {
    Point p = RandomPoint(random);
    if (i % 4 != 0) p = {1e-3f * p[0], 0.5f + 1e-4f * p[1], 1e-3f * p[2]};
    caustic.points.push_back(p);
  }
  clouds.insert(clouds.end(), {twice, grid, caustic});
  return clouds;
}

std::vector<Point> Queries(const Cloud& cloud) {
  Random random(11);
  std::vector<Point> queries = {{0, 0, 0}, {0.1f, 0.2f, 0.3f}, {100, -100, 50}};
  for (int i = 0; i < 30; ++i) queries.push_back(RandomPoint(random));
  for (std::size_t i = 0; i < cloud.points.size(); i += cloud.points.size() / 10 + 1) {
    queries.push_back(cloud.points[i]);
  }
  return queries;
}

struct Result {
  std::vector<std::uint32_t> points;  // numbers of the points as given, in the order found
  std::vector<float> distance2;       // ascending
};

Result Collect(const PointTree& tree, const NeighborColumns& found, std::uint32_t count) {
  Result result;
  for (std::uint32_t i = 0; i < count; ++i) {
    result.points.push_back(tree.order()[found.point[i]]);
    result.distance2.push_back(found.distance2[i]);
  }
  std::sort(result.distance2.begin(), result.distance2.end());
  return result;
}

std::vector<Result> Nearest(const PointTree& tree, const std::vector<Point>& queries,
                            std::uint32_t k, float radius2) {
  const auto n = std::uint32_t(queries.size());
  std::vector<float> axes[3];
  for (const Point& q : queries) {
    for (std::size_t axis = 0; axis < 3; ++axis) axes[axis].push_back(q[axis]);
  }
  soa::Table<NeighborColumns> found(n * NearestRoom(k));
  std::vector<std::uint32_t> count(n);
  FindNearest(tree.view(), axes[0].data(), axes[1].data(), axes[2].data(), n, k, radius2, found,
              count.data());
  std::vector<Result> results;
  for (std::uint32_t i = 0; i < n; ++i) {
    results.push_back(Collect(tree, Slice(found.columns(), i * NearestRoom(k)), count[i]));
  }
  return results;
}

Result Within(const PointTree& tree, const Point& query, float radius2, std::uint32_t room) {
  soa::Table<NeighborColumns> found(room);
  Result result;
  RangeSearch search = StartRangeSearch(tree.view(), query.data(), radius2);
  while (const std::uint32_t count = FindMore(tree.view(), search, room, found)) {
    EXPECT_LE(count, room);
    const Result more = Collect(tree, found, count);
    result.points.insert(result.points.end(), more.points.begin(), more.points.end());
    result.distance2.insert(result.distance2.end(), more.distance2.begin(), more.distance2.end());
  }
  std::sort(result.distance2.begin(), result.distance2.end());
  return result;
}

std::vector<float> AllWithin(const Cloud& cloud, const Point& query, float radius2) {
  std::vector<float> distances;
  for (const Point& p : cloud.points) {
    if (Distance2(p, query) < radius2) distances.push_back(Distance2(p, query));
  }
  std::sort(distances.begin(), distances.end());
  return distances;
}

// The points must belong to the distances, without duplicates.
void ExpectPointsAt(const Cloud& cloud, const Point& query, const Result& result) {
  std::vector<float> distances;
  for (const std::uint32_t i : result.points) {
    ASSERT_LT(i, cloud.points.size());
    distances.push_back(Distance2(cloud.points[i], query));
  }
  std::sort(distances.begin(), distances.end());
  EXPECT_EQ(distances, result.distance2);
  std::vector<std::uint32_t> numbers = result.points;
  std::sort(numbers.begin(), numbers.end());
  EXPECT_EQ(std::adjacent_find(numbers.begin(), numbers.end()), numbers.end());
}

constexpr float kRadii2[] = {0, 1e-6f, 0.01f, 0.5f, 1e30f};

TEST(PointTree, NearestMatchASearchOfAllPoints) {
  for (const Cloud& cloud : Clouds()) {
    const PointTree tree = MakeTree(cloud.points);
    const std::vector<Point> queries = Queries(cloud);
    for (const float radius2 : kRadii2) {
      std::vector<std::vector<float>> all;
      for (const Point& query : queries) all.push_back(AllWithin(cloud, query, radius2));
      for (const std::uint32_t k : {1u, 7u, 50u, 100u, 3000u}) {
        SCOPED_TRACE(cloud.name + ", k " + std::to_string(k) + ", r2 " + std::to_string(radius2));
        const std::vector<Result> results = Nearest(tree, queries, k, radius2);
        for (std::size_t i = 0; i < queries.size(); ++i) {
          std::vector<float> nearest = all[i];
          nearest.resize(std::min<std::size_t>(nearest.size(), k));
          ASSERT_EQ(results[i].distance2, nearest);
          ExpectPointsAt(cloud, queries[i], results[i]);
        }
      }
    }
  }
}

TEST(PointTree, RangesAreComplete) {
  for (const Cloud& cloud : Clouds()) {
    const PointTree tree = MakeTree(cloud.points);
    for (const Point& query : Queries(cloud)) {
      for (const float radius2 : kRadii2) {
        SCOPED_TRACE(cloud.name + ", r2 " + std::to_string(radius2));
        const std::vector<float> all = AllWithin(cloud, query, radius2);
        for (const std::uint32_t room : {2 * kLeafPoints, 500u}) {
          const Result result = Within(tree, query, radius2, room);
          ASSERT_EQ(result.distance2, all);
          ExpectPointsAt(cloud, query, result);
        }
      }
    }
  }
}

// Counts what nanoflann finds. Its own lists of results have other types in other versions.
struct PointsWithin {
  using DistanceType = float;

  float distance2;
  std::size_t count = 0;

  std::size_t size() const { return count; }
  bool empty() const { return count == 0; }
  bool full() const { return true; }
  float worstDist() const { return distance2; }
  bool addPoint(float found, std::uint32_t) {
    count += found < distance2;
    return true;
  }
  void sort() {}
};

TEST(PointTree, AgreesWithNanoflann) {
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Cloud>,
                                                   Cloud, 3, std::uint32_t>;
  for (const Cloud& cloud : Clouds()) {
    if (cloud.points.empty()) continue;  // nanoflann has no empty trees
    SCOPED_TRACE(cloud.name);
    const PointTree tree = MakeTree(cloud.points);
    const Tree other(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(10));
    const std::vector<Point> queries = Queries(cloud);
    constexpr std::uint32_t kNearest = 50;
    const std::vector<Result> results = Nearest(tree, queries, kNearest, 1e30f);
    for (std::size_t i = 0; i < queries.size(); ++i) {
      std::vector<std::uint32_t> points(kNearest);
      std::vector<float> distances(kNearest);
      distances.resize(
          other.knnSearch(queries[i].data(), kNearest, points.data(), distances.data()));
      ASSERT_EQ(results[i].distance2, distances);
      PointsWithin within = {.distance2 = 0.3f};
      other.radiusSearchCustomCallback(queries[i].data(), within);
      EXPECT_EQ(Within(tree, queries[i], 0.3f, 256).points.size(), within.count);
    }
  }
}

// The order in which neighbours are found matters too because radiance is summed in it.
TEST(PointTree, VectorWidthAndBatchDoNotMatter) {
  const Cloud cloud = Clouds().back();
  const PointTree tree = MakeTree(cloud.points);
  const std::vector<Point> queries = Queries(cloud);
  ExpectSameOnEveryTarget([&] {
    std::vector<std::uint32_t> bits = Within(tree, queries[5], 0.4f, 64).points;
    for (const Result& result : Nearest(tree, queries, 40, 1.0f)) {
      bits.insert(bits.end(), result.points.begin(), result.points.end());
    }
    return bits;
  });
  const std::vector<Result> together = Nearest(tree, queries, 40, 1.0f);
  for (std::size_t i = 0; i < queries.size(); ++i) {
    EXPECT_EQ(Nearest(tree, {queries[i]}, 40, 1.0f)[0].points, together[i].points);
  }
}

TEST(PointTree, ThreadsDoNotMatter) {
  for (const Cloud& cloud : Clouds()) {
    SCOPED_TRACE(cloud.name);
    PointTree trees[2];
    for (int i = 0; i < 2; ++i) {
      tbb::task_arena arena(i == 0 ? 1 : 4);
      arena.execute([&] { trees[i] = MakeTree(cloud.points); });
    }
    EXPECT_TRUE(std::ranges::equal(trees[0].order(), trees[1].order()));
    const PointTreeView a = trees[0].view(), b = trees[1].view();
    for (std::uint32_t i = 1; i < 1u << a.levels; ++i) {
      ASSERT_EQ(a.nodes[i].split, b.nodes[i].split);
      ASSERT_EQ(a.nodes[i].axis, b.nodes[i].axis);
    }
  }
}

}  // namespace
}  // namespace skywave
