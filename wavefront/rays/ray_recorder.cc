#include "wavefront/rays/ray_recorder.h"

namespace skywave {

void RayRecorder::Record(RayKind kind, bool occlusion, const float* const org[3],
                         const float* const dir[3], const float* t_far, std::uint32_t n,
                         const std::uint32_t* keys) {
  const std::size_t begin = org_[0].size();
  for (std::uint32_t i = 0; i < n; ++i) {
    // Beams stay whole, so that the packets that were traced are replayed.
    if (t_far[i] < 0 && kind != RayKind::kCamera) continue;
    for (int axis = 0; axis < 3; ++axis) {
      org_[axis].push_back(org[axis][i]);
      dir_[axis].push_back(dir[axis][i]);
    }
    t_far_.push_back(t_far[i]);
    if (keys != nullptr) keys_.push_back(keys[i]);
  }
  const auto count = std::uint32_t(org_[0].size() - begin);
  if (count == 0) return;
  batches_.push_back({.kind = kind, .occlusion = occlusion, .begin = begin, .count = count});
}

}  // namespace skywave
