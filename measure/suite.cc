#include "measure/suite.h"

#include <sys/resource.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>

#include "image/image.h"
#include "measure/statistics.h"

namespace skywave {
namespace {

// A film that differs is named with the values that would stand here. They change with whatever
// decides the bits of a picture, and a change of them has to be explained.
constexpr SuiteScene kQuick[] = {
    {"gallery",
     320,
     240,
     8,
     {0x68c398d79bd67c66,
      {0.371289104f, 0.369110197f, 0.372320145f, 0.366621763f, 0.327787191f, 0.268401116f,
       0.5618366f, 0.209673584f, 0.349285096f, 0.279682368f, 0.589098394f, 0.213558391f,
       0.365347028f, 0.309245616f, 0.351430714f, 0.346540689f}}},
    {"spheres",
     320,
     240,
     8,
     {0x9e9a4d40ebbeb674,
      {0.403420746f, 0.400779277f, 0.40102005f, 0.403486699f, 0.265856177f, 0.399404436f,
       0.382250458f, 0.336936206f, 0.23306331f, 0.271483272f, 0.314538479f, 0.302981794f,
       0.347174138f, 0.34663865f, 0.34712556f, 0.347561538f}}},
    {"many-shapes",
     320,
     240,
     8,
     {0x997a7539972efe2a,
      {0.384878695f, 0.383766532f, 0.384569466f, 0.384524614f, 0.268317163f, 0.206535578f,
       0.24278456f, 0.302674115f, 0.146638542f, 0.186802551f, 0.195764586f, 0.234354034f,
       0.283694506f, 0.217112273f, 0.198164582f, 0.214819565f}}},
};
constexpr SuiteScene kFull[] = {
    {"gallery",
     480,
     360,
     16,
     {0x89f56cfcfa0aa548,
      {0.371617734f, 0.369227052f, 0.372236788f, 0.366525769f, 0.326973647f, 0.218777061f,
       0.451454371f, 0.213154435f, 0.348066449f, 0.273717463f, 0.326993823f, 0.213054866f,
       0.365697771f, 0.31046623f, 0.361316502f, 0.347758442f}}},
    {"spheres",
     480,
     360,
     16,
     {0xab4b40197de18442,
      {0.403275609f, 0.400954366f, 0.400865346f, 0.403519332f, 0.266262978f, 0.411196113f,
       0.44975093f, 0.337930202f, 0.231211096f, 0.274760693f, 0.288507015f, 0.32329458f,
       0.346846998f, 0.35756433f, 0.347290963f, 0.354157448f}}},
    {"many-shapes",
     480,
     360,
     16,
     {0x42d17f0b4acd0a53,
      {0.38493371f, 0.384493351f, 0.384965032f, 0.385025769f, 0.268096834f, 0.207358226f,
       0.241911575f, 0.302872062f, 0.146000326f, 0.18802838f, 0.195518643f, 0.233954683f,
       0.283856779f, 0.217440918f, 0.198120341f, 0.214792222f}}},
};

using Clock = std::chrono::steady_clock;
double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double PeakMemoryBytes() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_maxrss) * 1024;
}

// Writes the picture as a render would, to a file that is gone afterwards.
double TimeWrite(const Film& film, std::uint64_t samples) {
  const auto path = std::filesystem::temp_directory_path() /
                    ("skywave-bench-" + std::to_string(::getpid()) + ".exr");
  const auto start = Clock::now();
  WriteExr(path.string(), film.Resolve(samples));
  const double seconds = SecondsSince(start);
  std::filesystem::remove(path);
  return seconds;
}

std::vector<StrategyTable> MeasureTables(const RenderJob& job) {
  std::vector<StrategyTable> tables;
  for (const StrategyFactory& factory : Strategies()) {
    const auto start = Clock::now();
    const auto strategy = job.MakeOtherStrategy(std::string(factory.name), Integrator::kPath);
    tables.push_back({.name = std::string(factory.name),
                      .bytes = strategy->table_bytes(),
                      .seconds = SecondsSince(start)});
  }
  return tables;
}

// Of what was measured for every scene; 0 where it was not.
template <class Value>
double GeometricMean(std::span<const SuiteResult> results, Value value) {
  double sum = 0;
  for (const SuiteResult& result : results) {
    const double x = value(result);
    if (!(x > 0)) return 0;
    sum += std::log(x);
  }
  return results.empty() ? 0 : std::exp(sum / double(results.size()));
}

}  // namespace

Fingerprint FingerprintOf(const Film& film, std::uint64_t samples) {
  Fingerprint print;
  print.hash = XXH64(film.sums().data(), film.sums().size_bytes(), 0);
  const Image image = film.Resolve(samples);
  std::array<double, 16> sums = {}, counts = {};
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const auto block = std::size_t(y * 4 / image.height * 4 + x * 4 / image.width);
      const float* const pixel = image.Pixel(x, y);
      sums[block] += double(pixel[0]) + pixel[1] + pixel[2];
      counts[block] += 3;
    }
  }
  for (std::size_t i = 0; i < sums.size(); ++i) {
    print.means[i] = float(sums[i] / std::max(counts[i], 1.0));
  }
  return print;
}

std::span<const SuiteScene> SuiteScenes(bool full) { return full ? kFull : kQuick; }

JobRequest SuiteRequest(const SuiteScene& scene, JobRequest base) {
  base.scene = std::string(scene.name);
  base.width = scene.width, base.height = scene.height;
  base.samples_per_pixel = scene.samples_per_pixel;
  return base;
}

std::string_view ToString(PictureCheck check) {
  switch (check) {
    case PictureCheck::kSameBits:
      return "same bits";
    case PictureCheck::kWithinBounds:
      return "within bounds";
    case PictureCheck::kWrong:
      return "wrong";
  }
  return "";
}

double BlockDifference(const Fingerprint& a, const Fingerprint& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.means.size(); ++i) {
    const double scale = std::max({std::abs(a.means[i]), std::abs(b.means[i]), 1e-30f});
    const double difference = std::abs(double(a.means[i]) - b.means[i]) / scale;
    if (!std::isfinite(difference)) return std::numeric_limits<double>::infinity();
    largest = std::max(largest, difference);
  }
  return largest;
}

PictureCheck CheckPicture(const Fingerprint& expected, const Fingerprint& found, bool exact) {
  if (exact) {
    return found.hash == expected.hash ? PictureCheck::kSameBits : PictureCheck::kWrong;
  }
  return BlockDifference(expected, found) <= kPictureBound ? PictureCheck::kWithinBounds
                                                           : PictureCheck::kWrong;
}

bool HasReferenceHits(const JobRequest& request) {
  const std::string& config = request.embree_config;
  return (config.empty() ? DefaultEmbreeConfig() : config) == "isa=avx2";
}

double SuiteResult::msamples_per_second() const {
  return double(speed.first.stats.samples) / speed.render_seconds() * 1e-6;
}

double SuiteResult::mrays_per_second() const {
  return double(speed.first.stats.total_rays()) / speed.render_seconds() * 1e-6;
}

SuiteResult MeasureScene(const SuiteScene& scene, const JobRequest& base,
                         const SpeedSettings& settings, bool tables) {
  const JobRequest request = SuiteRequest(scene, base);
  const RenderJob job(request);
  Film film = job.MakeFilm();
  SuiteResult result = {.scene = scene,
                        .options = job.options(),
                        .times = job.times(),
                        .scene_hash = job.scene_hash(),
                        .triangles = job.geometry().triangle_count(),
                        .geometry_bytes = job.geometry().bytes(),
                        .tables = tables ? MeasureTables(job) : std::vector<StrategyTable>()};
  result.speed = MeasureSpeed(job, settings, film);
  result.found = FingerprintOf(film, scene.samples_per_pixel);
  result.check = CheckPicture(scene.expected, result.found, HasReferenceHits(request));
  result.write_seconds = TimeWrite(film, scene.samples_per_pixel);
  result.peak_memory_bytes = PeakMemoryBytes();
  return result;
}

SuiteSummary Summarize(std::span<const SuiteResult> results) {
  const auto mean = [&](auto value) { return GeometricMean(results, value); };
  return {.msamples_per_s = mean([](const SuiteResult& r) { return r.msamples_per_second(); }),
          .mrays_per_s = mean([](const SuiteResult& r) { return r.mrays_per_second(); }),
          .embree_fraction = mean([](const SuiteResult& r) { return r.speed.embree_fraction(); }),
          .scaling_2 = mean([](const SuiteResult& r) { return r.speed.speed_up(2); })};
}

std::vector<int> ScalingThreads(int available) {
  std::vector<int> counts;
  for (int threads = 1; threads < available; threads *= 2) counts.push_back(threads);
  counts.push_back(available);
  return counts;
}

}  // namespace skywave
