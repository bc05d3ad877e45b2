#include "wavefront/passes/footprint.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "wavefront/paths/pilot.h"

namespace skywave {

float PixelRadius(const FrameView& frame, WorkerPool& pool) {
  constexpr float kPixels = 2;
  constexpr std::uint64_t kPaths = 1 << 12;
  const FrameView pilot = CoarseView(frame, kPaths, 1);
  std::vector<float> sizes = TracePilot<float>(
      pilot, pool, [&](const WaveRange& range, Worker& w, std::vector<float>& found) {
        FollowToSurfaces(pilot, range, kFirstDeltaBsdf, pilot.options.max_depth, w,
                         [&](const std::vector<float>& length) {
                           for (std::uint32_t i = 0; i < w.ranges.light_sampled(); ++i) {
                             const float distance = length[w.surfaces->path[i]];
                             found.push_back(PixelSize(frame.camera, distance));
                           }
                         });
      });
  if (sizes.empty()) return std::numeric_limits<float>::infinity();
  const auto middle = sizes.begin() + std::ptrdiff_t(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return kPixels * *middle;
}

}  // namespace skywave
