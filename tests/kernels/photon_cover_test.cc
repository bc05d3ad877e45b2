// Tests the cells of a photon disk: rays aim at the centres of the cells into which photons are
// sorted.
#include "kernels/light_paths/photon_cover.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/surface/surface.h"
#include "tests/support/targets.h"
#include "wavefront/soa.h"

namespace skywave {
namespace {

constexpr PhotonKernel kKernels[] = {PhotonKernel::kConstant, PhotonKernel::kCone,
                                     PhotonKernel::kEpanechnikov};

PhotonDisk TiltedDisk() {
  return {.point = {3, -2, 5},
          .normal = {2.0f / 3, -1.0f / 3, 2.0f / 3},
          .radius2 = 0.25f,
          .height = 0.2f};
}

// All cells see the plane of the disk, but only those in `seen` count.
DiskSurface Flat(const PhotonDisk& disk, std::uint32_t seen) {
  DiskSurface surface = {.seen = seen};
  for (std::uint32_t i = 0; i < kDiskCells; ++i) {
    surface.x[i] = surface.y[i] = surface.z[i] = 0;
    surface.normal_x[i] = disk.normal[0], surface.normal_y[i] = disk.normal[1];
    surface.normal_z[i] = disk.normal[2];
  }
  return surface;
}

// Places one photon where each ray hits the plane of the disk.
struct Targets {
  soa::Table<RayColumns> rays{kDiskCells};
  std::vector<float> x, y, z;
  soa::Table<NeighborColumns> found{kDiskCells};
  soa::Table<PhotonColumns> photons{kDiskCells};

  Targets(const PhotonDisk& disk, PhotonKernel kernel) {
    AimAtDisk(disk, kernel, rays);
    for (std::uint32_t i = 0; i < kDiskCells; ++i) {
      const float t = rays->t_far[i] / 2;
      x.push_back(rays->org_x[i] + t * rays->dir_x[i]);
      y.push_back(rays->org_y[i] + t * rays->dir_y[i]);
      z.push_back(rays->org_z[i] + t * rays->dir_z[i]);
    }
    const std::uint32_t up = EncodeNormal(disk.normal[0], disk.normal[1], disk.normal[2]);
    std::fill_n(photons->normal, kDiskCells, up);
    std::fill_n(photons->dir, kDiskCells, up);
    Find(disk);
  }
  // Moves a photon along the normal.
  void Move(const PhotonDisk& disk, std::uint32_t photon, float distance) {
    x[photon] += distance * disk.normal[0], y[photon] += distance * disk.normal[1];
    z[photon] += distance * disk.normal[2];
    Find(disk);
  }
  void Find(const PhotonDisk& disk) {
    for (std::uint32_t i = 0; i < kDiskCells; ++i) {
      const float d[3] = {x[i] - disk.point[0], y[i] - disk.point[1], z[i] - disk.point[2]};
      found->point[i] = i;
      found->distance2[i] = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    }
  }
  PointTreeView tree() const {
    return {.x = x.data(), .y = y.data(), .z = z.data(), .count = kDiskCells};
  }
};

TEST(PhotonCover, RaysHitTheirCells) {
  for (const std::int64_t target : TestedTargets()) {
    const TargetScope scope(target);
    for (const PhotonKernel kernel : kKernels) {
      const PhotonDisk disk = TiltedDisk();
      Targets at(disk, kernel);
      for (std::uint32_t cell = 0; cell < kDiskCells; ++cell) {
        at.Find(disk);
        CloseUnseen(disk, kernel, Flat(disk, 1u << cell), at.photons, at.tree(), at.found,
                    kDiskCells);
        for (std::uint32_t i = 0; i < kDiskCells; ++i) {
          EXPECT_EQ(std::isinf(at.found->distance2[i]), i != cell) << "photon " << i;
        }
      }
    }
  }
}

// Each ring holds half of the kernel, and its middle radius splits that in half.
TEST(PhotonCover, RaysLieAsTheKernelWeighs) {
  const double squares[3][2] = {
      {0.25, 0.75}, {0.326352 * 0.326352, 0.673648 * 0.673648}, {1 - std::sqrt(0.75), 0.5}};
  for (const PhotonKernel kernel : kKernels) {
    const PhotonDisk disk = TiltedDisk();
    const Targets at(disk, kernel);
    for (std::uint32_t i = 0; i < kDiskCells; ++i) {
      const double share = double(at.found->distance2[i]) / double(disk.radius2);
      EXPECT_NEAR(share, squares[int(kernel)][i / 8], 1e-4);
    }
  }
}

TEST(PhotonCover, RejectsIncompleteDisks) {
  const PhotonDisk disk = TiltedDisk();
  const PhotonKernel kernel = PhotonKernel::kEpanechnikov;
  Targets at(disk, kernel);
  const std::uint32_t up = EncodeNormal(disk.normal[0], disk.normal[1], disk.normal[2]);
  const std::uint32_t side = EncodeNormal(disk.normal[1], -disk.normal[0], 0);
  const std::uint32_t down = EncodeNormal(-disk.normal[0], -disk.normal[1], -disk.normal[2]);
  const soa::Table<PhotonColumns>& photons = at.photons;
  const auto whole = [&](std::uint32_t n) {
    return LooksWhole(disk, kernel, photons, at.tree(), at.found, n);
  };
  EXPECT_TRUE(whole(kDiskCells));
  EXPECT_TRUE(whole(kDiskCells - 3));
  EXPECT_FALSE(whole(kDiskCells - 4));
  photons->normal[5] = side;
  EXPECT_FALSE(whole(kDiskCells)) << "a photon on another wall";
  photons->normal[5] = down;
  EXPECT_TRUE(whole(kDiskCells)) << "normals are of either side";
  photons->dir[5] = down;
  EXPECT_FALSE(whole(kDiskCells)) << "a photon from behind";
  photons->dir[5] = up;
  EXPECT_TRUE(whole(kDiskCells));
  at.Move(disk, 5, -0.2f);
  EXPECT_FALSE(whole(kDiskCells)) << "a photon on the next floor";
}

// Only the visible layer counts, not everything behind it; a smoothly curved surface is one layer.
TEST(PhotonCover, LeavesOutPhotonsBehindTheSeenLayer) {
  for (const std::int64_t target : TestedTargets()) {
    const TargetScope scope(target);
    const PhotonDisk disk = TiltedDisk();
    const PhotonKernel kernel = PhotonKernel::kEpanechnikov;
    Targets at(disk, kernel);
    DiskSurface surface = Flat(disk, kAllCells);
    at.Move(disk, 3, -0.2f), at.Move(disk, 4, 0.2f), at.Move(disk, 6, -0.02f);
    CloseUnseen(disk, kernel, surface, at.photons, at.tree(), at.found, kDiskCells);
    for (std::uint32_t i = 0; i < kDiskCells; ++i) {
      EXPECT_EQ(std::isinf(at.found->distance2[i]), i == 3 || i == 4) << "photon " << i;
    }
    // If the layer is lower, the lower photon lies on it.
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      float* const column[3] = {surface.x, surface.y, surface.z};
      for (std::uint32_t i = 0; i < kDiskCells; ++i) column[axis][i] = -0.2f * disk.normal[axis];
    }
    at.Find(disk);
    CloseUnseen(disk, kernel, surface, at.photons, at.tree(), at.found, kDiskCells);
    for (std::uint32_t i = 0; i < kDiskCells; ++i) {
      EXPECT_EQ(std::isinf(at.found->distance2[i]), i != 3) << "photon " << i;
    }
  }
}

}  // namespace
}  // namespace skywave
