// Neighbours are converted to light: each uses its own photon, wherever it lies in the map.
#include "kernels/light_paths/photons.h"

#include <gtest/gtest.h>

#include <bit>
#include <vector>

#include "kernels/surface/surface.h"
#include "tests/support/random_rows.h"
#include "tests/support/targets.h"
#include "wavefront/soa.h"

namespace skywave {
namespace {

constexpr std::uint32_t kPhotons = 500;

// Returns runs of all lengths, with and without gaps, and isolated rows, including the last rows of
// the map.
std::vector<std::uint32_t> Neighbors(std::uint32_t n, unsigned seed) {
  Random random(seed);
  std::vector<std::uint32_t> rows = {kPhotons - 1, 0, kPhotons - 2};
  while (rows.size() < n) {
    auto row = std::uint32_t(random.Between(0, kPhotons - 40));
    const auto length = std::uint32_t(random.Between(1, 20));
    for (std::uint32_t i = 0; i < length; ++i) {
      rows.push_back(row);
      row += random.Between(0, 1) < 0.6 ? 1 : 2;
    }
  }
  rows.resize(n);
  return rows;
}

TEST(Photons, LoadedPhotonsMatchTheirRows) {
  const soa::Table<PhotonColumns> photons(kPhotons);
  for (std::uint32_t i = 0; i < kPhotons; ++i) {
    photons->r[i] = float(i + 1), photons->g[i] = float(2 * i), photons->b[i] = 3;
    photons->dir[i] = EncodeNormal(0, 0.6f, 0.8f);
    photons->normal[i] = i % 5 == 0 ? EncodeNormal(1, 0, 0) : EncodeNormal(0, 0, 1);
    photons->depth[i] = i % 7 == 0 ? 4 : 3;
  }
  const PhotonQuery query = {
      .kernel = PhotonKernel::kConstant, .radius2 = 2, .normal = {0, 0, 1}, .max_depth = 3};
  for (const std::uint32_t n : {1u, 3u, 16u, 17u, 150u}) {
    const std::vector<std::uint32_t> rows = Neighbors(n, n);
    const soa::Table<NeighborColumns> found(n);
    std::copy(rows.begin(), rows.end(), found->point);
    const soa::Table<LightColumns> lights(n);
    ExpectSameOnEveryTarget([&] {
      LoadPhotons(photons, found, n, query, lights);
      std::vector<std::uint32_t> bits;
      for (std::uint32_t i = 0; i < n; ++i) {
        const bool counts = rows[i] % 5 != 0 && rows[i] % 7 != 0;
        const float weight = counts ? 1 / (3.14159265f * 2 * 0.8f) : 0;
        EXPECT_NEAR(lights->r[i], weight * float(rows[i] + 1), 1e-3f * weight * kPhotons);
        EXPECT_NEAR(lights->g[i], weight * float(2 * rows[i]), 1e-3f * weight * kPhotons);
        EXPECT_NEAR(lights->b[i], 3 * weight, 1e-3f);
        EXPECT_NEAR(lights->dir_y[i], 0.6f, 1e-3f);
        for (const float* column :
             {lights->r, lights->g, lights->b, lights->dir_x, lights->dir_z}) {
          bits.push_back(std::bit_cast<std::uint32_t>(column[i]));
        }
      }
      return bits;
    });
  }
}

}  // namespace
}  // namespace skywave
