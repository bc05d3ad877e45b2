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
     {0x020902ec0297bb99,
      {
          0.371663779f,
          0.369300604f,
          0.372360766f,
          0.366631269f,
          0.326165736f,
          0.268927723f,
          0.56127888f,
          0.209984407f,
          0.348699003f,
          0.292751878f,
          0.60580802f,
          0.213086098f,
          0.365204394f,
          0.309873492f,
          0.350026518f,
          0.34775874f,
      }},
     0x3d732df34c4da6b3},
    {"spheres",
     320,
     240,
     8,
     {0x0a062a19cca1a9cf,
      {
          0.403425634f,
          0.400949031f,
          0.401057929f,
          0.403446406f,
          0.265951812f,
          0.399864167f,
          0.381727904f,
          0.336695641f,
          0.231664807f,
          0.273231745f,
          0.316340744f,
          0.29140985f,
          0.346723586f,
          0.347049624f,
          0.347251058f,
          0.346851856f,
      }},
     0xd4b79a3597084faa},
    {"many-shapes",
     320,
     240,
     8,
     {0x97caedd9b302c920,
      {
          0.384741127f,
          0.384266645f,
          0.385263592f,
          0.384872884f,
          0.268302351f,
          0.207230911f,
          0.242268831f,
          0.302972317f,
          0.1460834f,
          0.187806442f,
          0.195730716f,
          0.234076589f,
          0.283698767f,
          0.217135742f,
          0.198164612f,
          0.214667037f,
      }},
     0x94e9580f9efb5d2b},
};
constexpr SuiteScene kFull[] = {
    {"gallery",
     480,
     360,
     16,
     {0xd0b457c7ecbb8bb9,
      {
          0.371621698f,
          0.369353473f,
          0.37228933f,
          0.366508156f,
          0.326137662f,
          0.218973964f,
          0.450968742f,
          0.212933555f,
          0.348248869f,
          0.273906708f,
          0.349472404f,
          0.213004366f,
          0.365591973f,
          0.310344756f,
          0.359728992f,
          0.348112792f,
      }},
     0xcd544ca939720cca},
    {"spheres",
     480,
     360,
     16,
     {0xeb98937e3873a763,
      {
          0.403374881f,
          0.400966227f,
          0.400981545f,
          0.403345674f,
          0.266100556f,
          0.41064921f,
          0.449566841f,
          0.337780952f,
          0.231173173f,
          0.275385827f,
          0.290037334f,
          0.318657517f,
          0.346752405f,
          0.357049555f,
          0.347008973f,
          0.354116499f,
      }},
     0xdee62c32cdd446cc},
    {"many-shapes",
     480,
     360,
     16,
     {0x963215235cc66307,
      {
          0.384803891f,
          0.38454771f,
          0.385100663f,
          0.384907246f,
          0.268207192f,
          0.207448214f,
          0.242010877f,
          0.30293256f,
          0.145968288f,
          0.187926352f,
          0.195814148f,
          0.23383154f,
          0.28370446f,
          0.217173249f,
          0.197973177f,
          0.21489504f,
      }},
     0x5fd2c6d071dc4e19},
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
  if (__builtin_cpu_is("amd")) return scene.expected.hash;
  if (__builtin_cpu_is("intel")) return scene.intel_hash;
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
