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
     {0x7d6d59b0fb13d755,
      {0.371280491f, 0.369110018f, 0.372320056f, 0.366621166f, 0.327764213f, 0.268397301f,
       0.561834812f, 0.209672779f, 0.349294484f, 0.279678345f, 0.589060128f, 0.213521436f,
       0.365345389f, 0.309245527f, 0.351429433f, 0.3465271f}}},
    {"spheres",
     320,
     240,
     8,
     {0xf23539da565f6168,
      {0.403420925f, 0.400779098f, 0.401019752f, 0.403486192f, 0.26586473f, 0.399469942f,
       0.382250518f, 0.33693552f, 0.233065292f, 0.271515399f, 0.314538658f, 0.302982986f,
       0.347174138f, 0.346639931f, 0.347124189f, 0.347561836f}}},
    {"many-shapes",
     320,
     240,
     8,
     {0xf82e70f3d7f00c49,
      {0.384878099f, 0.383765757f, 0.384568036f, 0.384523183f, 0.268325746f, 0.20653443f,
       0.242783263f, 0.302672952f, 0.146638989f, 0.186801895f, 0.195763856f, 0.234359279f,
       0.283693463f, 0.217113912f, 0.198163897f, 0.214819729f}}},
};
constexpr SuiteScene kFull[] = {
    {"gallery",
     480,
     360,
     16,
     {0x52cc7ca6789342e3,
      {0.371605992f, 0.369227111f, 0.372236609f, 0.366525412f, 0.326928526f, 0.218776673f,
       0.451455563f, 0.21315442f, 0.348061234f, 0.273703903f, 0.326966196f, 0.213009104f,
       0.365698248f, 0.310467005f, 0.361312538f, 0.347743094f}}},
    {"spheres",
     480,
     360,
     16,
     {0x0f5a304380970941,
      {0.403276175f, 0.400954247f, 0.400865197f, 0.403519183f, 0.266267151f, 0.411279768f,
       0.449756801f, 0.337931544f, 0.231215313f, 0.274779648f, 0.28850776f, 0.32329616f,
       0.346847743f, 0.357567936f, 0.347289056f, 0.354156643f}}},
    {"many-shapes",
     480,
     360,
     16,
     {0xae614129afff0284,
      {0.384936541f, 0.384492964f, 0.384964734f, 0.385025173f, 0.268096864f, 0.207358018f,
       0.241910949f, 0.302873731f, 0.146000609f, 0.188027814f, 0.195518598f, 0.233954087f,
       0.283856899f, 0.217442364f, 0.198120043f, 0.214792252f}}},
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
    const auto strategy = job.MakeOtherStrategy(std::string(factory.name));
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
  base.keep_map = true;
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
                         const SpeedSettings& settings) {
  const JobRequest request = SuiteRequest(scene, base);
  const RenderJob job(request);
  Film film = job.MakeFilm();
  SuiteResult result = {.scene = scene,
                        .options = job.options(),
                        .times = job.times(),
                        .scene_hash = job.scene_hash(),
                        .triangles = job.geometry().triangle_count(),
                        .geometry_bytes = job.geometry().bytes(),
                        .tables = MeasureTables(job)};
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
