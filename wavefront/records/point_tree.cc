#include "wavefront/records/point_tree.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

namespace skywave {
namespace {

// One thread works on smaller ranges alone.
constexpr std::size_t kLeastParallel = 1 << 12;
// One thread divides at most this many points at a time: they lie on its stack meanwhile, 64 KiB.
constexpr std::size_t kPart = 1 << 12;

// Points along an axis are ordered by coordinate and number, so that no two are alike and halves do
// not depend on how they are found. The key is one whole number, so that one comparison decides.
std::uint64_t KeyOf(const TreePoint& point, std::uint32_t axis) {
  const auto bits = std::bit_cast<std::uint32_t>(point.at[axis] + 0.0f);  // -0 is 0
  const std::uint32_t negative = 0 - (bits >> 31);
  return std::uint64_t(bits ^ (negative | 0x80000000u)) << 32 | point.number;
}

struct Box {
  std::array<float, 3> low, high;
};

Box BoxOf(std::span<const TreePoint> points, Box box) {
  for (const TreePoint& p : points) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.low[axis] = std::min(box.low[axis], p.at[axis]);
      box.high[axis] = std::max(box.high[axis], p.at[axis]);
    }
  }
  return box;
}

Box BoxOf(std::span<const TreePoint> points) {
  Box nothing;
  nothing.low.fill(std::numeric_limits<float>::infinity());
  nothing.high.fill(-std::numeric_limits<float>::infinity());
  if (points.size() <= kLeastParallel) return BoxOf(points, nothing);
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, points.size(), kLeastParallel), nothing,
      [&](const auto& range, const Box& so_far) {
        return BoxOf(points.subspan(range.begin(), range.size()), so_far);
      },
      [](const Box& a, const Box& b) {
        Box both = a;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          both.low[axis] = std::min(a.low[axis], b.low[axis]);
          both.high[axis] = std::max(a.high[axis], b.high[axis]);
        }
        return both;
      });
}

std::uint32_t WidestAxis(std::span<const TreePoint> points) {
  const Box box = BoxOf(points);
  std::uint32_t widest = 0;
  for (std::uint32_t axis = 1; axis < 3; ++axis) {
    if (box.high[axis] - box.low[axis] > box.high[widest] - box.low[widest]) widest = axis;
  }
  return widest;
}

// Puts points before `pivot` first and returns their number; there are at most kPart points. Every
// point is written to both sides: no branch waits for a comparison that could have gone either way,
// and nothing is read that was written just before.
std::size_t DividePart(std::span<TreePoint> points, std::uint64_t pivot, std::uint32_t axis) {
  std::array<TreePoint, kPart> others;
  std::size_t below = 0, above = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const TreePoint point = points[i];
    const bool first = KeyOf(point, axis) < pivot;
    points[below] = others[above] = point;
    below += first, above += !first;
  }
  std::copy_n(others.begin(), above, points.begin() + std::ptrdiff_t(below));
  return below;
}

// Does the same, parts at a time; points that are then on the wrong side of the border are
// exchanged.
std::size_t Divide(std::span<TreePoint> points, std::uint64_t pivot, std::uint32_t axis) {
  if (points.size() <= kPart) return DividePart(points, pivot, axis);
  struct Run {
    std::size_t begin, end;
  };
  std::vector<Run> parts((points.size() + kPart - 1) / kPart);  // points of each that are below
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
    const std::span<TreePoint> part =
        points.subspan(i * kPart, std::min(kPart, points.size() - i * kPart));
    parts[i] = {i * kPart, i * kPart + DividePart(part, pivot, axis)};
  });
  std::size_t border = 0;
  for (const Run& part : parts) border += part.end - part.begin;
  // As many points before the border are not below as there are below ones after it.
  std::vector<Run> high, low;
  for (const Run& part : parts) {
    const std::size_t end = std::min(part.begin + kPart, points.size());
    if (part.end < std::min(end, border)) high.push_back({part.end, std::min(end, border)});
    if (part.end > std::max(part.begin, border)) {
      low.push_back({std::max(part.begin, border), part.end});
    }
  }
  struct Exchange {
    std::size_t a, b, count;
  };
  std::vector<Exchange> exchanges;
  for (std::size_t i = 0, j = 0; i < high.size();) {
    const std::size_t count = std::min(high[i].end - high[i].begin, low[j].end - low[j].begin);
    exchanges.push_back({high[i].begin, low[j].begin, count});
    high[i].begin += count, low[j].begin += count;
    i += high[i].begin == high[i].end;
    j += low[j].begin == low[j].end;
  }
  tbb::parallel_for(std::size_t{0}, exchanges.size(), [&](std::size_t i) {
    const Exchange& e = exchanges[i];
    std::swap_ranges(&points[e.a], &points[e.a] + e.count, &points[e.b]);
  });
  return border;
}

// Puts the k-th point in its place, with the lower ones before it. Pivots are a little to either
// side of where a sample puts it, so that few points are moved more than once (Floyd and Rivest
// 1975).
void Select(std::span<TreePoint> points, std::size_t k, std::uint32_t axis) {
  constexpr std::size_t kFew = 32, kMostSamples = 1024;
  std::array<std::uint64_t, kMostSamples> samples;
  while (points.size() > kFew) {
    const std::size_t n = points.size();
    const std::size_t count =
        std::clamp(std::size_t(std::sqrt(double(n))), std::size_t{5}, kMostSamples);
    const std::size_t step = n / count;
    for (std::size_t i = 0; i < count; ++i) samples[i] = KeyOf(points[i * step], axis);
    std::sort(samples.begin(), samples.begin() + std::ptrdiff_t(count));
    const std::size_t rank = k * count / n, margin = std::size_t(std::sqrt(double(count)));
    // The pivot is never the first of them, so that something is always before it.
    const std::size_t at =
        2 * rank < count ? std::min(rank + margin, count - 1) : std::max(rank, margin + 1) - margin;
    const std::size_t below = Divide(points, samples[at], axis);
    if (k < below) {
      points = points.first(below);
    } else {
      points = points.subspan(below), k -= below;
    }
  }
  std::nth_element(
      points.begin(), points.begin() + std::ptrdiff_t(k), points.end(),
      [axis](const TreePoint& a, const TreePoint& b) { return KeyOf(a, axis) < KeyOf(b, axis); });
}

struct Builder {
  std::span<TreePoint> points;
  std::span<PointTreeNode> nodes;
  std::uint32_t levels;

  std::size_t FirstOfLeaf(std::size_t leaf) const { return leaf * points.size() >> levels; }

  // Builds the subtree of `node` over leaves [leaf, leaf + count).
  void Build(std::uint32_t node, std::size_t leaf, std::size_t count) const {
    const std::size_t begin = FirstOfLeaf(leaf), end = FirstOfLeaf(leaf + count);
    const std::span<TreePoint> mine = points.subspan(begin, end - begin);
    if (count == 1) {
      std::sort(mine.begin(), mine.end(),
                [](const TreePoint& a, const TreePoint& b) { return a.number < b.number; });
      return;
    }
    const std::uint32_t axis = WidestAxis(mine);
    const std::size_t middle = FirstOfLeaf(leaf + count / 2) - begin;
    Select(mine, middle, axis);
    nodes[node] = {.split = mine[middle].at[axis], .axis = axis};
    const auto left = [&] { Build(2 * node, leaf, count / 2); };
    const auto right = [&] { Build(2 * node + 1, leaf + count / 2, count / 2); };
    if (mine.size() < kLeastParallel) {
      left(), right();
    } else {
      tbb::parallel_invoke(left, right);
    }
  }
};

// Returns the levels of splits that bring `count` points down to kLeafPoints per leaf.
std::uint32_t LevelsFor(std::uint32_t count) {
  std::uint32_t levels = 0;
  while ((std::uint64_t(kLeafPoints) << levels) < count) ++levels;
  return levels;
}

}  // namespace

PointTree::PointTree(std::span<TreePoint> points)
    : count_(std::uint32_t(points.size())),
      levels_(LevelsFor(count_)),
      nodes_(std::size_t{1} << levels_),
      rows_(count_, soa::Touch::kLater) {
  assert(points.size() < std::size_t{1} << 31);
  const Builder builder = {.points = points, .nodes = nodes_, .levels = levels_};
  if (count_ > 0) builder.Build(1, 0, std::size_t{1} << levels_);
  tbb::parallel_for(std::uint32_t{0}, count_, [&](std::uint32_t i) {
    rows_->x[i] = points[i].at[0], rows_->y[i] = points[i].at[1], rows_->z[i] = points[i].at[2];
    rows_->number[i] = points[i].number;
  });
}

PointTreeView PointTree::view() const {
  return {.nodes = nodes_.data(),
          .x = rows_->x,
          .y = rows_->y,
          .z = rows_->z,
          .count = count_,
          .levels = levels_};
}

std::size_t PointTree::bytes() const {
  return nodes_.size() * sizeof(PointTreeNode) +
         std::size_t(count_) * soa::BytesPerRow<TreeRowColumns>();
}

}  // namespace skywave
