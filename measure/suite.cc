#include "measure/suite.h"

#include <sys/resource.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "base/clock.h"
#include "image/image.h"
#include "measure/statistics.h"

namespace skywave {
namespace {

// When a film differs, the error message prints the values that belong here. They change with
// anything that affects the bits of a picture, and every change of them needs an explanation.
constexpr SuiteScene kQuick[] = {
    {"gallery",
     320,
     240,
     8,
     {0x6de7a0d14209b871,
      {0.37129122f, 0.369099498f, 0.372321457f, 0.366617233f, 0.327789605f, 0.268399954f,
       0.56183213f, 0.209684581f, 0.349306792f, 0.279742658f, 0.589099288f, 0.213572964f,
       0.365352184f, 0.309234709f, 0.351433963f, 0.346544832f}}},
    {"spheres",
     320,
     240,
     8,
     {0x865bbf2d608f32db,
      {0.403417945f, 0.40076676f, 0.401019096f, 0.403482944f, 0.265860468f, 0.399390697f,
       0.382244676f, 0.336923063f, 0.233071655f, 0.271489054f, 0.314525008f, 0.302995086f,
       0.347174108f, 0.346646011f, 0.34713015f, 0.347564816f}}},
    {"many-shapes",
     320,
     240,
     8,
     {0xd7a06051676adfc2,
      {0.384872824f, 0.383770376f, 0.384575456f, 0.384523183f, 0.26832661f, 0.206554815f,
       0.242768362f, 0.302665323f, 0.146657735f, 0.186818197f, 0.195750505f, 0.234386504f,
       0.283695608f, 0.21709311f, 0.198177531f, 0.214794397f}}},
};
constexpr SuiteScene kFull[] = {
    {"gallery",
     480,
     360,
     16,
     {0x5cc33a3c3a310ab1,
      {0.371616662f, 0.369224697f, 0.372235179f, 0.36653015f, 0.326977193f, 0.218776435f,
       0.451460838f, 0.213152647f, 0.34807092f, 0.273720175f, 0.326986313f, 0.213056013f,
       0.365688682f, 0.310457587f, 0.361302376f, 0.34775871f}}},
    {"spheres",
     480,
     360,
     16,
     {0xad641bfdf4cef7c0,
      {0.403274328f, 0.400952667f, 0.400864065f, 0.403520942f, 0.266263038f, 0.411207467f,
       0.449763805f, 0.337928861f, 0.231213659f, 0.27474916f, 0.288494825f, 0.323298842f,
       0.346836299f, 0.357554138f, 0.347280651f, 0.35415718f}}},
    {"many-shapes",
     480,
     360,
     16,
     {0x2a0338ac16c83814,
      {0.384922922f, 0.384494454f, 0.384961247f, 0.385019213f, 0.268092811f, 0.207350388f,
       0.241931915f, 0.302869588f, 0.145995989f, 0.188021556f, 0.19551383f, 0.233943239f,
       0.28385216f, 0.217432365f, 0.198110759f, 0.214790165f}}},
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
    const auto strategy = job.MakeOtherStrategy(std::string(factory.name), Integrator::kPath);
    tables.push_back({.name = std::string(factory.name),
                      .bytes = strategy->table_bytes(),
                      .seconds = SecondsSince(start)});
  }
  return tables;
}

// Returns the mean over all scenes, or 0 if any scene was not measured.
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
