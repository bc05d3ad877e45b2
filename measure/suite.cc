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
     {0xc7e7caeed9e06171,
      {0.371280104f, 0.369111329f, 0.372324556f, 0.366615951f, 0.327871174f, 0.268399507f,
       0.561831057f, 0.209679067f, 0.349313736f, 0.279747546f, 0.589113533f, 0.213561207f,
       0.365328968f, 0.309244037f, 0.351444602f, 0.346554697f}}},
    {"spheres",
     320,
     240,
     8,
     {0x7ad5ccb65d2751b9,
      {0.403415322f, 0.400766492f, 0.401018471f, 0.403482288f, 0.265865862f, 0.399389714f,
       0.382242322f, 0.336920619f, 0.23308073f, 0.271482795f, 0.314522952f, 0.302986085f,
       0.347153604f, 0.346647829f, 0.347137392f, 0.347570717f}}},
    {"many-shapes",
     320,
     240,
     8,
     {0xc2d0d2abdad63e7a,
      {0.384848326f, 0.383786708f, 0.384572327f, 0.384537041f, 0.268333137f, 0.20655328f,
       0.242765576f, 0.302666634f, 0.146655232f, 0.186816812f, 0.195749223f, 0.234405234f,
       0.283682287f, 0.217104778f, 0.198177963f, 0.214794472f}}},
};
constexpr SuiteScene kFull[] = {
    {"gallery",
     480,
     360,
     16,
     {0x9262a03ce7a50854,
      {0.371616304f, 0.369224042f, 0.372236997f, 0.366531998f, 0.326970696f, 0.218772501f,
       0.451458901f, 0.213155121f, 0.348066688f, 0.273724824f, 0.326987147f, 0.213060394f,
       0.365697086f, 0.310456157f, 0.361295819f, 0.347755909f}}},
    {"spheres",
     480,
     360,
     16,
     {0x432a3b15ccf5cbd3,
      {0.403274387f, 0.400952101f, 0.400863588f, 0.403521538f, 0.266261578f, 0.411188155f,
       0.449764192f, 0.337928861f, 0.231212094f, 0.274752885f, 0.288497478f, 0.323298484f,
       0.34684217f, 0.357554942f, 0.347275853f, 0.354154646f}}},
    {"many-shapes",
     480,
     360,
     16,
     {0xf60314d03d238e19,
      {0.384917617f, 0.384497166f, 0.384968281f, 0.385023355f, 0.268094569f, 0.207348451f,
       0.241934106f, 0.302880466f, 0.14599371f, 0.188028291f, 0.195511296f, 0.233944908f,
       0.283857226f, 0.217431724f, 0.19810985f, 0.214787006f}}},
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
