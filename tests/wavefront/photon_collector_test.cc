// Tests which light paths are kept: the first ones that suffice, and no more than memory allows.
#include "wavefront/passes/photon_collector.h"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>

#include "base/error.h"
#include "scene/builtin/builtin.h"
#include "tests/support/paths.h"
#include "tests/support/program.h"
#include "tests/support/random_rows.h"
#include "tests/support/render_scenes.h"
#include "wavefront/passes/photon_options.h"
#include "wavefront/records/photon_map.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

constexpr std::uint32_t kOfAPath = 4;

// Returns the numbers of photons that light paths store; photons are numbered.
std::vector<std::uint32_t> Counts(std::uint32_t paths, unsigned seed) {
  Random random(seed);
  std::vector<std::uint32_t> counts(paths);
  for (std::uint32_t& count : counts) count = std::uint32_t(random.Between(0, kOfAPath + 0.999));
  return counts;
}

// Returns the lists of paths [first, end), in waves.
std::vector<PhotonLists> Waves(const std::vector<std::uint32_t>& counts, std::uint32_t first,
                               std::uint32_t end, std::uint32_t wave) {
  std::uint32_t number = std::accumulate(counts.begin(), counts.begin() + first, 0u);
  std::vector<PhotonLists> waves((end - first + wave - 1) / wave);
  for (std::uint32_t path = first; path < end; ++path) {
    PhotonList& list = waves[(path - first) / wave].indirect;
    for (std::uint32_t i = 0; i < counts[path]; ++i) {
      list.photons.push_back({.position = {}, .flux = {}, .dir = 0, .normal = 0, .depth = number});
      list.subpath.push_back({float(number), 0});
      list.path.push_back((path - first) % wave);
      ++number;
    }
  }
  return waves;
}

// Paths are kept whole and in order until there are enough photons, in whatever rounds and waves
// they arrive.
TEST(PhotonCollector, KeepsTheFirstPathsThatFillIt) {
  constexpr std::uint32_t kPaths = 100;
  const std::vector<std::uint32_t> counts = Counts(kPaths, 3);
  const std::uint32_t all = std::accumulate(counts.begin(), counts.end(), 0u);
  for (const std::uint32_t wanted : {1u, 2u, 37u, 99u, all - 1, all, all + 1}) {
    std::uint32_t size = 0, paths = 0;
    while (size < wanted && paths < kPaths) size += counts[paths++];
    for (const std::uint32_t round : {1u, 7u, 64u, kPaths}) {
      for (const std::uint32_t wave : {1u, 3u, 200u}) {
        SCOPED_TRACE(testing::Message() << wanted << " of rounds " << round << ", waves " << wave);
        PhotonCollector collector(wanted, kOfAPath, true);
        for (std::uint32_t first = 0; first < kPaths; first += round) {
          const std::uint32_t end = std::min(first + round, kPaths);
          std::vector<PhotonLists> waves = Waves(counts, first, end, wave);
          collector.Take(waves, &PhotonLists::indirect, first, end, wave);
        }
        EXPECT_EQ(collector.full(), wanted <= all);
        EXPECT_EQ(collector.light_paths(), paths);
        ASSERT_EQ(collector.photons().size(), size);
        ASSERT_EQ(collector.subpaths().size(), size);
        for (std::uint32_t i = 0; i < size; ++i) {
          ASSERT_EQ(collector.photons()[i].depth, i);
          ASSERT_EQ(collector.subpaths()[i].d_vcm, float(i));
        }
      }
    }
  }
}

// The passes include some with enough light paths and some without, for both integrators.
TEST(PhotonCollector, PassesKeepAtMostTheRequestedPhotons) {
  constexpr std::uint32_t kDepth = 5;
  for (const Integrator integrator : {Integrator::kPhoton, Integrator::kVcm}) {
    for (const std::uint32_t seed : {1u, 2u, 3u, 4u}) {
      JobRequest request = SmallRequest(16, 12, 2);
      request.integrator = integrator;
      request.max_depth = kDepth;
      request.options.seed = seed;
      request.options.of<PhotonOptions>().indirect = request.options.of<PhotonOptions>().caustic =
          150;
      request.options.of<PhotonOptions>().passes = 1;
      const RenderJob job(BuiltinScene("lamps"), request);
      Film film = job.MakeFilm();
      const PhotonCounts counts = RenderFrame(job.frame(), film).photons;
      EXPECT_LT(counts.indirect, 150 + kDepth) << "seed " << seed;
      EXPECT_LT(counts.caustic, 150 + kDepth);
      EXPECT_GT(counts.indirect, 100u);
    }
  }
}

bool Refused(const RenderOptions& options, std::uint64_t memory) {
  try {
    CheckPhotonMemory(options, options.integrator == Integrator::kVcm, memory);
    return false;
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("photons"), std::string::npos) << error.what();
    EXPECT_EQ(error.exit_code(), kExitUsage);
    return true;
  }
}

TEST(PhotonMemory, IsAsDocumented) {
  EXPECT_EQ(PhotonBytes(false), 77u);
  EXPECT_EQ(PhotonBytes(true), 93u);
}

TEST(PhotonMemory, IsCheckedBeforehand) {
  RenderOptions options;
  options.integrator = Integrator::kPhoton;
  options.of<PhotonOptions>().indirect = 900, options.of<PhotonOptions>().caustic = 100;
  EXPECT_FALSE(Refused(options, 77000));
  EXPECT_TRUE(Refused(options, 76999));
  // A pass has no more vertices than its light paths have surfaces.
  options.integrator = Integrator::kVcm;
  // The film stores whole blocks, here 12 x 6 pixels.
  options.width = 9, options.height = 5, options.max_depth = 4;
  EXPECT_FALSE(Refused(options, 12 * 6 * 4 * 93));
  EXPECT_TRUE(Refused(options, 12 * 6 * 4 * 93 - 1));
  options.of<PhotonOptions>().indirect = 100;
  EXPECT_FALSE(Refused(options, 9300));
  // The number of photons in a map is limited whatever the memory.
  options.of<PhotonOptions>().indirect = kMostPhotons + 1;
  EXPECT_TRUE(Refused(options, std::numeric_limits<std::uint64_t>::max()));
}

using PhotonProgram = Program;

// The machine has the memory, but the process may not use it.
TEST_F(PhotonProgram, SaysWhoseMemoryIsMissing) {
  for (const std::string integrator : {"photon", "vcm --size 4000x4000"}) {
    const Result result =
        Run("--version; ulimit -v 2000000; '" + ProgramPath() +
            "' render lamps --spp 1 --threads 2 --photons 60000000 -o a.exr --integrator " +
            integrator);
    EXPECT_EQ(result.exit_code, kExitUsage) << result.err;
    EXPECT_NE(result.err.find("--photons 60000000"), std::string::npos) << result.err;
    EXPECT_EQ(result.err.find("bad_alloc"), std::string::npos) << result.err;
    EXPECT_TRUE(Files().empty());
  }
}

}  // namespace
}  // namespace skywave
