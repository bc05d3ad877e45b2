#include "wavefront/passes/photon_collector.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace skywave {
namespace {

// So many light paths are traced before it is checked how full the maps are, and so many photons
// may have been stored by then.
constexpr std::uint64_t kLeastRound = 1 << 14, kMostHeld = 1 << 20;

// Returns the number of light paths that will most likely fill a collector, by the yield of
// `traced` ones.
double PathsToFill(const PhotonCollector& harvest, std::uint64_t traced) {
  const double missing = double(harvest.wanted() - harvest.size());
  // A second round costs more than a few extra paths.
  return (missing + 2 * std::sqrt(missing)) * double(traced) / double(harvest.size() + 1);
}

// Returns the number of light paths of the next round: until the first collector that is not full
// will be, since paths are spared that nothing needs any more. The first round is short and shows
// how much they yield.
std::uint64_t PathsOfRound(const PhotonCollector& caustic, const PhotonCollector& indirect,
                           std::uint64_t traced, std::uint32_t max_depth) {
  const std::uint64_t most =
      std::max(kLeastRound, kMostHeld / std::max(max_depth, std::uint32_t{1}));
  double paths = double(most);
  for (const PhotonCollector* const harvest : {&caustic, &indirect}) {
    if (!harvest->full()) paths = std::min(paths, PathsToFill(*harvest, traced));
  }
  return std::clamp(std::uint64_t(paths), kLeastRound, most);
}

}  // namespace

PhotonCollector::PhotonCollector(std::uint64_t wanted, std::uint32_t of_a_path, bool with_subpaths)
    : wanted_(wanted) {
  if (wanted == 0) return;
  photons_ = std::make_unique_for_overwrite<Photon[]>(wanted + of_a_path);
  if (with_subpaths) {
    subpaths_ = std::make_unique_for_overwrite<PhotonSubpath[]>(wanted + of_a_path);
  }
}

void PhotonCollector::Take(std::span<PhotonLists> waves, PhotonList PhotonLists::*kind,
                           std::uint64_t first, std::uint64_t end, std::uint64_t wave) {
  struct Part {
    std::size_t count, at;
  };
  std::vector<Part> parts;
  for (const PhotonLists& lists : waves) {
    const PhotonList& list = lists.*kind;
    const std::size_t all = list.path.size();
    std::size_t count = std::min<std::size_t>(all, full() ? 0 : wanted_ - size_);
    while (count > 0 && count < all && list.path[count] == list.path[count - 1]) ++count;
    parts.push_back({.count = count, .at = size_});
    if (!full()) {
      size_ += count;
      light_paths_ = full() ? first + list.path[count - 1] + 1 : std::min(first + wave, end);
    }
    first += wave;
  }
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
    PhotonList& list = waves[i].*kind;
    std::copy_n(list.photons.begin(), parts[i].count, photons_.get() + parts[i].at);
    if (subpaths_) {
      std::copy_n(list.subpath.begin(), parts[i].count, subpaths_.get() + parts[i].at);
    }
    list = {};
  });
}

void CollectPhotons(const FrameView& frame, std::uint64_t first, std::uint64_t most,
                    const TraceLightPaths& trace, PhotonCollector& caustic,
                    PhotonCollector& indirect, WorkerPool& pool) {
  const std::uint32_t wave = frame.options.wave;
  for (std::uint64_t traced = 0; traced < most && !(caustic.full() && indirect.full());) {
    const std::uint64_t round =
        std::min(PathsOfRound(caustic, indirect, traced, frame.options.max_depth), most - traced);
    std::vector<PhotonLists> waves((round + wave - 1) / wave);
    pool.ForEach(waves.size(), [&](std::size_t i, Worker& worker, RayRecorder* recorder) {
      FrameView view = frame;
      view.tracer.recorder = recorder;
      const std::uint64_t before = i * wave;
      const auto count = std::uint32_t(std::min<std::uint64_t>(wave, round - before));
      trace(view, first + traced + before, count, worker, waves[i]);
    });
    caustic.Take(waves, &PhotonLists::caustic, traced, traced + round, wave);
    indirect.Take(waves, &PhotonLists::indirect, traced, traced + round, wave);
    traced += round;
  }
}

}  // namespace skywave
