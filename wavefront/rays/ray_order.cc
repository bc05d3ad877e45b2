#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "wavefront/rays/replay.h"

namespace skywave {
namespace {

constexpr std::uint32_t kSortedBatch = 2048;  // rows of a wave by default
constexpr int kMortonBits = 20;               // per coordinate: 60, and 3 for the octant

struct Box {
  float low[3], scale[3];  // scale: cells per unit of length
};

Box BoundOrigins(const std::vector<RayRecorder>& recorders) {
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    float low = std::numeric_limits<float>::infinity(), high = -low;
    for (const RayRecorder& recorder : recorders) {
      for (std::size_t i = 0; i < recorder.size(); ++i) {
        low = std::min(low, recorder.org(axis)[i]);
        high = std::max(high, recorder.org(axis)[i]);
      }
    }
    box.low[axis] = low;
    box.scale[axis] = high > low ? float((1 << kMortonBits) - 1) / (high - low) : 0;
  }
  return box;
}

// Spreads the low 21 bits of `x`, with two zeros between neighbours.
std::uint64_t Spread(std::uint64_t x) {
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

std::uint64_t SortKey(const RayRecorder& recorder, std::size_t i, const Box& box) {
  std::uint64_t octant = 0, morton = 0;
  for (int axis = 0; axis < 3; ++axis) {
    octant |= std::uint64_t(recorder.dir(axis)[i] < 0) << axis;
    const float cell = (recorder.org(axis)[i] - box.low[axis]) * box.scale[axis];
    morton |= Spread(std::uint64_t(cell)) << axis;
  }
  return octant << 3 * kMortonBits | morton;
}

struct KeyedRay {
  std::uint64_t key;
  const RayRecorder* recorder;
  std::size_t row;
};

// Sorts by key; rays of one key stay in the order in which they were traced.
void Sort(std::vector<KeyedRay>& rays) {
  std::stable_sort(rays.begin(), rays.end(),
                   [](const KeyedRay& a, const KeyedRay& b) { return a.key < b.key; });
}

void Append(RayKind kind, bool occlusion, const std::vector<KeyedRay>& rays, RayRecorder& to) {
  std::array<std::vector<float>, 7> columns;
  for (auto& column : columns) column.resize(kSortedBatch);
  std::vector<std::uint32_t> keys(kSortedBatch);
  const bool keyed = !rays.empty() && rays.front().recorder->keys() != nullptr;
  for (std::size_t first = 0; first < rays.size(); first += kSortedBatch) {
    const auto n = std::uint32_t(std::min<std::size_t>(kSortedBatch, rays.size() - first));
    for (std::uint32_t i = 0; i < n; ++i) {
      const KeyedRay& ray = rays[first + i];
      for (int axis = 0; axis < 3; ++axis) {
        columns[axis][i] = ray.recorder->org(axis)[ray.row];
        columns[3 + axis][i] = ray.recorder->dir(axis)[ray.row];
      }
      columns[6][i] = ray.recorder->t_far()[ray.row];
      if (keyed) keys[i] = ray.recorder->keys()[ray.row];
    }
    const float* const org[3] = {columns[0].data(), columns[1].data(), columns[2].data()};
    const float* const dir[3] = {columns[3].data(), columns[4].data(), columns[5].data()};
    to.Record(kind, occlusion, org, dir, columns[6].data(), n, keyed ? keys.data() : nullptr);
  }
}

// Orders the rays of one kind of call, within each batch or over all of them.
void OrderAlike(const std::vector<RayRecorder>& recorders, RayKind kind, bool occlusion,
                RayOrder order, const Box& box, RayRecorder& to) {
  std::vector<KeyedRay> rays;
  const auto flush = [&] {
    Sort(rays);
    Append(kind, occlusion, rays, to);
    rays.clear();
  };
  for (const RayRecorder& recorder : recorders) {
    for (const RayBatch& batch : recorder.batches()) {
      if (batch.kind != kind || batch.occlusion != occlusion) continue;
      for (std::size_t i = batch.begin; i < batch.begin + batch.count; ++i) {
        rays.push_back({SortKey(recorder, i, box), &recorder, i});
      }
      if (order == RayOrder::kWave) flush();
    }
  }
  flush();
}

}  // namespace

std::vector<RayRecorder> OrderRays(const std::vector<RayRecorder>& recorders, RayOrder order) {
  if (order == RayOrder::kTraced) return recorders;
  const Box box = BoundOrigins(recorders);
  std::vector<RayRecorder> ordered(1);
  for (std::uint32_t kind = 0; kind < kRayKinds; ++kind) {
    for (const bool occlusion : {false, true}) {
      OrderAlike(recorders, RayKind(kind), occlusion, order, box, ordered.front());
    }
  }
  return ordered;
}

}  // namespace skywave
