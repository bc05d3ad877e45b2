// The suite of skywave bench: built-in scenes at fixed sizes, whose pictures are known, so that a
// score is only given for the right work.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "measure/speed.h"

namespace skywave {

// What a finished film is compared by: a hash of its sums, and the mean radiance of blocks of the
// picture, 4 x 4, row by row.
struct Fingerprint {
  std::uint64_t hash = 0;
  std::array<float, 16> means = {};
};
Fingerprint FingerprintOf(const Film& film, std::uint64_t samples);

struct SuiteScene {
  std::string_view name;
  int width, height;
  std::uint32_t samples_per_pixel;
  Fingerprint expected;
};
// Quick: under a minute on two cores. Full: some minutes.
std::span<const SuiteScene> SuiteScenes(bool full);

// `base` with the scene and sizes of `scene`.
JobRequest SuiteRequest(const SuiteScene& scene, JobRequest base);

// How a picture was compared with the one that is known.
enum class PictureCheck {
  kSameBits,      // where Embree's hits have the bits of AVX2
  kWithinBounds,  // on other instruction sets: the means of all blocks are near enough
  kWrong
};
template <>
inline constexpr auto kEnumNames<PictureCheck> =
    std::to_array<Named<PictureCheck>>({{PictureCheck::kSameBits, "same bits"},
                                        {PictureCheck::kWithinBounds, "within bounds"},
                                        {PictureCheck::kWrong, "wrong"}});

// Largest relative difference of a block that another instruction set may cause; seen with SSE2,
// SSE4.2 and AVX: 0.00012 and less. Another seed makes more than 0.004.
inline constexpr double kPictureBound = 0.002;

// `exact`: hits have the bits of AVX2, see HasReferenceHits.
PictureCheck CheckPicture(const Fingerprint& expected, const Fingerprint& found, bool exact);
// Largest relative difference of the means of a block.
double BlockDifference(const Fingerprint& a, const Fingerprint& b);
// Whether Embree, set up like this, finds the hits from which the expected pictures were made.
bool HasReferenceHits(const JobRequest& request);

struct StrategyTable {
  std::string name;
  std::size_t bytes = 0;
  double seconds = 0;  // to build
};

// A scene of the suite, measured.
struct SuiteResult {
  SuiteScene scene;
  RenderOptions options;
  JobTimes times;
  double write_seconds = 0;
  std::uint64_t scene_hash = 0;
  std::size_t triangles = 0, geometry_bytes = 0;
  // Of every strategy, for this scene's map; empty: not measured.
  std::vector<StrategyTable> tables;
  Fingerprint found;
  PictureCheck check = PictureCheck::kWrong;
  Speed speed;
  double peak_memory_bytes = 0;  // of the process up to now

  double msamples_per_second() const;
  double mrays_per_second() const;
};

// `tables`: whether to build those of every strategy, which takes longer than a few renders.
SuiteResult MeasureScene(const SuiteScene& scene, const JobRequest& base,
                         const SpeedSettings& settings, bool tables);

// Over scenes: geometric means, so that each scene counts alike. 0: not measured.
struct SuiteSummary {
  double msamples_per_s = 0, mrays_per_s = 0, embree_fraction = 0, scaling_2 = 0;
};
SuiteSummary Summarize(std::span<const SuiteResult> results);

// 1, 2, 4 ... and `available`.
std::vector<int> ScalingThreads(int available);

}  // namespace skywave
