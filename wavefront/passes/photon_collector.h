// Collectors keep what light paths store, wave after wave, until maps are full: all passes share
// them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "wavefront/frame.h"
#include "wavefront/records/photon_map.h"
#include "wavefront/stages/photon_stages.h"
#include "wavefront/worker_pool.h"

namespace skywave {

// Collects the photons of a map before it is built: those of the first light paths that have
// `wanted` of them together. They are cut after a path, in the order of paths, so what is kept
// depends on neither threads nor waves nor on how many paths had been traced when the count was
// checked. Because the last path ends the count, what is divided by the number of paths is biased
// by one part in that of photons.
class PhotonCollector {
 public:
  PhotonCollector() = default;  // wants none
  // Collects from light paths that store at most `of_a_path` photons each: there is room for so
  // many more. All memory is allocated here and touched as it fills.
  PhotonCollector(std::uint64_t wanted, std::uint32_t of_a_path, bool with_subpaths);

  bool full() const { return size_ >= wanted_; }
  std::uint64_t wanted() const { return wanted_; }
  std::uint64_t size() const { return size_; }
  std::uint64_t light_paths() const { return light_paths_; }
  // Photons are in the order (light path, surface).
  std::span<const Photon> photons() const { return {photons_.get(), size_}; }
  std::span<const PhotonSubpath> subpaths() const {
    return {subpaths_.get(), subpaths_ ? size_ : 0};
  }

  // Takes and frees the lists `kind` of waves of `wave` light paths each, paths [first, end) in
  // all, in the arena of the caller.
  void Take(std::span<PhotonLists> waves, PhotonList PhotonLists::*kind, std::uint64_t first,
            std::uint64_t end, std::uint64_t wave);

 private:
  std::uint64_t wanted_ = 0, size_ = 0, light_paths_ = 0;
  std::unique_ptr<Photon[]> photons_;
  std::unique_ptr<PhotonSubpath[]> subpaths_;
};

// Traces `count` light paths from the number `first` on and stores them in lists.
using TraceLightPaths =
    std::function<void(const FrameView& frame, std::uint64_t first, std::uint32_t count,
                       Worker& worker, PhotonLists& lists)>;

// Traces light paths [first, first + most) of the frame until both collectors are full. In addition
// to theirs at most 2^20 photons are held, at depths beyond 64 those of 2^14 light paths.
void CollectPhotons(const FrameView& frame, std::uint64_t first, std::uint64_t most,
                    const TraceLightPaths& trace, PhotonCollector& caustic,
                    PhotonCollector& indirect, WorkerPool& pool);

}  // namespace skywave
