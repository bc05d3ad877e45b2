// The suite of skywave bench: built-in scenes at fixed sizes with known pictures, so that a score
// is only given for correct work.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bench/measure/speed.h"

namespace skywave {

// The values by which a finished film is compared: a hash of its sums, and the mean radiance of 4 x
// 4 blocks of the picture, row by row.
struct Fingerprint {
  std::uint64_t hash = 0;
  std::array<float, 16> means = {};
};
Fingerprint FingerprintOf(const Film& film, std::uint64_t samples);

struct SuiteScene {
  std::string_view name;
  int width, height;
  std::uint32_t samples_per_pixel;
  Fingerprint expected;        // with the hash that processors of Intel find
  std::uint64_t amd_hash = 0;  // 0: not known
};
// The quick suite takes under a minute on two cores, the full one some minutes.
std::span<const SuiteScene> SuiteScenes(bool full);

// Returns `base` with the scene and sizes of `scene`.
JobRequest SuiteRequest(const SuiteScene& scene, JobRequest base);

// The result of comparing a picture with the known one.
enum class PictureCheck {
  kSameBits,      // expected where the hash is known (KnownHash)
  kWithinBounds,  // elsewhere: the means of all blocks are close enough
  kWrong
};
template <>
inline constexpr auto kEnumNames<PictureCheck> =
    std::to_array<Named<PictureCheck>>({{PictureCheck::kSameBits, "same bits"},
                                        {PictureCheck::kWithinBounds, "within bounds"},
                                        {PictureCheck::kWrong, "wrong"}});

// The largest relative difference of a block that another instruction set may cause. SSE2, SSE4.2
// and AVX were observed to cause at most 0.00012; another seed causes more than 0.004.
inline constexpr double kPictureBound = 0.002;

// `known_hash` is that of KnownHash.
PictureCheck CheckPicture(const Fingerprint& expected, const Fingerprint& found,
                          std::optional<std::uint64_t> known_hash);
// Returns the largest relative difference between the means of a block.
double BlockDifference(const Fingerprint& a, const Fingerprint& b);
// Returns the hash of the film that this processor makes of a scene of the suite, or nothing where
// none is known. Embree's hits have other bits for each instruction set, and for AVX2 by the vendor
// of the processor, because Embree multiplies by estimates of reciprocals (vrcpps), and the
// vendors' estimates differ.
std::optional<std::uint64_t> KnownHash(const SuiteScene& scene, const JobRequest& request);

struct StrategyTable {
  std::string name;
  std::size_t bytes = 0;
  double seconds = 0;  // build time
};

// The measurements of one scene of the suite.
struct SuiteResult {
  SuiteScene scene;
  RenderOptions options;
  JobTimes times;
  double write_seconds = 0;
  std::uint64_t scene_hash = 0;
  std::size_t triangles = 0, geometry_bytes = 0;
  // The tables of every strategy for this scene's map; empty: not measured.
  std::vector<StrategyTable> tables;
  Fingerprint found;
  PictureCheck check = PictureCheck::kWrong;
  Speed speed;
  double peak_memory_bytes = 0;  // peak of the process so far

  double msamples_per_second() const;
  double mrays_per_second() const;
};

// `tables` says whether to build those of every strategy, which takes longer than a few renders.
SuiteResult MeasureScene(const SuiteScene& scene, const JobRequest& base,
                         const SpeedSettings& settings, bool tables);

// Geometric means over scenes, so that each scene has equal weight. 0: not measured.
struct SuiteSummary {
  double msamples_per_s = 0, mrays_per_s = 0, embree_fraction = 0, scaling_2 = 0;
};
SuiteSummary Summarize(std::span<const SuiteResult> results);

// Returns 1, 2, 4 ... and `available`.
std::vector<int> ScalingThreads(int available);

}  // namespace skywave
