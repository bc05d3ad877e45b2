#include "bench/measure/suite.h"

#include <sys/resource.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "base/clock.h"
#include "bench/measure/statistics.h"
#include "image/image.h"

namespace skywave {
namespace {

// When a film differs, the error message prints the values that belong here. They change with
// anything that affects the bits of a picture, and every change of them needs an explanation.
constexpr SuiteScene kQuick[] = {
    {"gallery",
     320,
     240,
     8,
     {0x95ffcc9d5c0085f1,
      {
          0.371728539f,
          0.369301796f,
          0.372360766f,
          0.366628259f,
          0.326032609f,
          0.268787444f,
          0.561254799f,
          0.209990412f,
          0.348662466f,
          0.292756468f,
          0.623118699f,
          0.213039741f,
          0.365211576f,
          0.309879869f,
          0.350163639f,
          0.347795397f,
      }},
     0xfb62de48ba5da76a},
    {"spheres",
     320,
     240,
     8,
     {0x12005bd1be9c30c1,
      {
          0.403425634f,
          0.400949031f,
          0.401057929f,
          0.403446406f,
          0.26595211f,
          0.399869561f,
          0.381715208f,
          0.336684972f,
          0.23163265f,
          0.273174614f,
          0.316337019f,
          0.291359872f,
          0.346729249f,
          0.347047418f,
          0.347249776f,
          0.346839905f,
      }},
     0x85663e3081048ef1},
    {"many-shapes",
     320,
     240,
     8,
     {0x112fa749675a62f6,
      {
          0.384741157f,
          0.384281129f,
          0.385263532f,
          0.384872884f,
          0.26825875f,
          0.207243815f,
          0.242296726f,
          0.302976608f,
          0.146033272f,
          0.187824801f,
          0.195700526f,
          0.23406361f,
          0.283681214f,
          0.217091888f,
          0.198131397f,
          0.214703336f,
      }},
     0x572773e051d316e3},
};
constexpr SuiteScene kFull[] = {
    {"gallery",
     480,
     360,
     16,
     {0xcf7612a08957448f,
      {
          0.371616542f,
          0.369355947f,
          0.37228933f,
          0.366510004f,
          0.326024532f,
          0.218928844f,
          0.450966239f,
          0.212928683f,
          0.348264247f,
          0.273897946f,
          0.352039337f,
          0.212708473f,
          0.365617871f,
          0.310347557f,
          0.359394014f,
          0.348072141f,
      }},
     0xc259ba9f64a81231},
    {"spheres",
     480,
     360,
     16,
     {0x29b8e8715ed9cd8b,
      {
          0.403374881f,
          0.400966227f,
          0.400981545f,
          0.403345674f,
          0.266100645f,
          0.410650402f,
          0.449564338f,
          0.337761432f,
          0.231162369f,
          0.275269121f,
          0.291924298f,
          0.318648309f,
          0.346753627f,
          0.357048303f,
          0.347008377f,
          0.354115218f,
      }},
     0x13411e11560a5857},
    {"many-shapes",
     480,
     360,
     16,
     {0x859650bdc3ab26a1,
      {
          0.384803891f,
          0.384547979f,
          0.385100722f,
          0.384907275f,
          0.268158585f,
          0.207409456f,
          0.241982594f,
          0.302927405f,
          0.145929635f,
          0.187911972f,
          0.195810959f,
          0.233823672f,
          0.283676177f,
          0.217123657f,
          0.197961152f,
          0.214902833f,
      }},
     0x9355b511bc611e4b},
};

double PeakMemoryBytes() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_maxrss) * 1024;
}

// Writes the picture to a temporary file exactly as a render would.
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
    if (factory.needs_portals && job.frame().map->portals.empty()) continue;
    const auto start = Clock::now();
    const RenderMethod method = job.MakeMethod(std::string(factory.name), Integrator::kPath);
    tables.push_back({.name = std::string(factory.name),
                      .bytes = method.strategy->table_bytes(),
                      .seconds = SecondsSince(start)});
  }
  return tables;
}

// Returns the mean over all scenes, or 0 if any scene was not measured.
template <class Value>
double MeanOfScenes(std::span<const SuiteResult> results, Value value) {
  std::vector<double> values;
  for (const SuiteResult& result : results) {
    values.push_back(value(result));
    if (!(values.back() > 0)) return 0;
  }
  return values.empty() ? 0 : GeometricMean(values);
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

PictureCheck CheckPicture(const Fingerprint& expected, const Fingerprint& found,
                          std::optional<std::uint64_t> known_hash) {
  if (known_hash) {
    return found.hash == *known_hash ? PictureCheck::kSameBits : PictureCheck::kWrong;
  }
  return BlockDifference(expected, found) <= kPictureBound ? PictureCheck::kWithinBounds
                                                           : PictureCheck::kWrong;
}

std::optional<std::uint64_t> KnownHash(const SuiteScene& scene, const JobRequest& request) {
  const std::string& config = request.embree_config;
  if ((config.empty() ? DefaultEmbreeConfig() : config) != "isa=avx2") return std::nullopt;
  if (__builtin_cpu_is("intel")) return scene.expected.hash;
  if (__builtin_cpu_is("amd") && scene.amd_hash != 0) return scene.amd_hash;
  return std::nullopt;
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
  result.check = CheckPicture(scene.expected, result.found, KnownHash(scene, request));
  result.write_seconds = TimeWrite(film, scene.samples_per_pixel);
  result.peak_memory_bytes = PeakMemoryBytes();
  return result;
}

SuiteSummary Summarize(std::span<const SuiteResult> results) {
  const auto mean = [&](auto value) { return MeanOfScenes(results, value); };
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
