#include "wavefront/records/photon_map.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace skywave {
namespace {

PointTree TreeOf(std::span<const Photon> photons) {
  const auto points = std::make_unique_for_overwrite<TreePoint[]>(photons.size());
  tbb::parallel_for(std::size_t{0}, photons.size(), [&](std::size_t i) {
    const float* const at = photons[i].position;
    points[i] = {.at = {at[0], at[1], at[2]}, .number = std::uint32_t(i)};
  });
  return PointTree({points.get(), photons.size()});
}

}  // namespace

PhotonMap::PhotonMap(std::span<const Photon> photons, std::uint64_t light_paths,
                     std::span<const PhotonSubpath> subpaths)
    : tree_(TreeOf(photons)),
      photons_(std::uint32_t(photons.size()), soa::Touch::kLater),
      subpaths_(std::uint32_t(subpaths.size()), soa::Touch::kLater),
      light_paths_(light_paths) {
  const double share = light_paths > 0 ? 1 / double(light_paths) : 0;
  const PhotonColumns& to = photons_.columns();
  tbb::parallel_for(std::uint32_t{0}, size(), [&](std::uint32_t i) {
    const Photon& photon = photons[tree_.order()[i]];
    to.r[i] = float(photon.flux[0] * share);
    to.g[i] = float(photon.flux[1] * share);
    to.b[i] = float(photon.flux[2] * share);
    to.dir[i] = photon.dir, to.normal[i] = photon.normal, to.depth[i] = photon.depth;
  });
  tbb::parallel_for(std::uint32_t{0}, subpaths_.rows(), [&](std::uint32_t i) {
    const PhotonSubpath& subpath = subpaths[tree_.order()[i]];
    subpaths_->d_vcm[i] = subpath.d_vcm;
    subpaths_->d_vc[i] = subpath.d_vc;
  });
}

float PhotonMap::TypicalDistance(std::uint32_t neighbors) const {
  constexpr std::uint32_t kAsked = 255;
  const PointTreeView tree = tree_.view();
  const soa::Table<NeighborColumns> found(NearestRoom(neighbors));
  std::vector<float> distances2;
  for (std::uint32_t i = 0; i < std::min(kAsked, size()); ++i) {
    const auto row = std::uint32_t(std::uint64_t(i) * size() / std::min(kAsked, size()));
    std::uint32_t count = 0;
    FindNearest(tree, tree.x + row, tree.y + row, tree.z + row, 1, neighbors,
                std::numeric_limits<float>::max(), found, &count);
    distances2.push_back(*std::max_element(found->distance2, found->distance2 + count));
  }
  if (distances2.empty()) return 0;
  const auto middle = distances2.begin() + std::ptrdiff_t(distances2.size() / 2);
  std::nth_element(distances2.begin(), middle, distances2.end());
  return std::sqrt(*middle);
}

std::size_t PhotonMap::bytes() const {
  return tree_.bytes() + soa::BytesPerRow<PhotonColumns>() * std::size_t(size()) +
         soa::BytesPerRow<SubpathColumns>() * std::size_t(subpaths_.rows());
}

}  // namespace skywave
