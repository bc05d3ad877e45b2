// Keeps the rays that a worker traces, in order, so that a benchmark can replay them raw.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace skywave {

enum class RayKind : std::uint32_t { kCamera, kBounce, kShadow };
inline constexpr std::uint32_t kRayKinds = 3;
inline constexpr std::string_view kRayKindNames[kRayKinds] = {"camera", "bounce", "shadow"};

// A batch is one call of a trace function: rows [begin, begin + count) of the recorder's columns.
struct RayBatch {
  RayKind kind;
  bool occlusion;  // any hit was enough: shadow rays, and others that can only see the map
  std::size_t begin;
  std::uint32_t count;
};

class RayRecorder {
 public:
  // Appends rows [0, n), except closed ones (negative t_far) that are not camera rays. `keys` are
  // those of rays in scenes with alpha, else null, for all rays of a recorder alike.
  void Record(RayKind kind, bool occlusion, const float* const org[3], const float* const dir[3],
              const float* t_far, std::uint32_t n, const std::uint32_t* keys = nullptr);

  std::size_t size() const { return org_[0].size(); }  // rays
  const std::vector<RayBatch>& batches() const { return batches_; }
  const float* org(int axis) const { return org_[axis].data(); }
  const float* dir(int axis) const { return dir_[axis].data(); }
  const float* t_far() const { return t_far_.data(); }
  // Returns null in scenes without alpha.
  const std::uint32_t* keys() const { return keys_.empty() ? nullptr : keys_.data(); }

 private:
  std::vector<RayBatch> batches_;
  std::vector<float> org_[3], dir_[3], t_far_;
  std::vector<std::uint32_t> keys_;
};

}  // namespace skywave
