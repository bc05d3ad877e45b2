#include "tests/support/picture_estimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tests/support/statistics.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

// Returns I_x(a, b), the regularised incomplete beta function, by its continued fraction
// (Abramowitz and Stegun 26.5.8) with modified Lentz.
double IncompleteBeta(double x, double a, double b) {
  if (x <= 0 || x >= 1) return x <= 0 ? 0 : 1;
  if (x > (a + 1) / (a + b + 2)) return 1 - IncompleteBeta(1 - x, b, a);
  const double front = std::exp(a * std::log(x) + b * std::log1p(-x) + std::lgamma(a + b) -
                                std::lgamma(a) - std::lgamma(b)) /
                       a;
  constexpr double kTiny = 1e-300;
  double c = 1, d = 1 / std::max(1 - (a + b) * x / (a + 1), kTiny), fraction = d;
  for (int m = 1; m < 10000; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    double factor = 1;
    for (const double term : {even, odd}) {
      d = 1 + term * d, c = 1 + term / c;
      if (std::fabs(d) < kTiny) d = kTiny;
      if (std::fabs(c) < kTiny) c = kTiny;
      d = 1 / d;
      factor = c * d;
      fraction *= factor;
    }
    if (std::fabs(factor - 1) < 1e-14) break;
  }
  return front * fraction;
}

// Degrees of freedom of a sum of estimated variances (Welch and Satterthwaite).
class Freedom {
 public:
  void Add(double variance, double freedom) {
    sum_ += variance;
    if (variance > 0) squares_ += variance * variance / freedom;
  }
  double value() const { return squares_ > 0 ? sum_ * sum_ / squares_ : 1; }

 private:
  double sum_ = 0, squares_ = 0;
};

// Raises every variance to at least the mean of its block of 4 x 4 pixels: if a pixel has missed a
// rare and bright sample, its neighbours have not.
PictureEstimate Steadied(PictureEstimate picture) {
  constexpr int kSide = 4;
  const PictureEstimate blocks = MeanOfBlocks(picture, kSide);
  for (std::size_t i = 0; i < picture.mean.size(); ++i) {
    const int x = int(i / 3) % picture.width, y = int(i / 3) / picture.width;
    const std::size_t block = std::size_t(y / kSide * blocks.width + x / kSide) * 3 + i % 3;
    const int columns = std::min(kSide, picture.width - x / kSide * kSide);
    const int rows = std::min(kSide, picture.height - y / kSide * kSide);
    const double around = blocks.variance[block] * columns * rows;
    if (around <= picture.variance[i]) continue;
    picture.variance[i] = around;
    picture.freedom[i] = blocks.freedom[block];
  }
  return picture;
}

struct Worst {
  double p = 1;
  std::string text = "nothing differs";
};

void CompareCells(const PictureEstimate& a, const PictureEstimate& b, double rounding,
                  const std::string& what, Worst& worst) {
  for (std::size_t i = 0; i < a.mean.size(); ++i) {
    const double allowed = rounding * std::max(std::fabs(a.mean[i]), std::fabs(b.mean[i]));
    const double excess = std::max(0.0, std::fabs(a.mean[i] - b.mean[i]) - allowed);
    if (excess == 0) continue;
    const double error = std::sqrt(a.variance[i] + b.variance[i]);
    Freedom freedom;
    freedom.Add(a.variance[i], a.freedom[i]);
    freedom.Add(b.variance[i], b.freedom[i]);
    const double p = error > 0 ? StudentPValue(excess / error, freedom.value()) : 0;
    if (p >= worst.p) continue;
    worst.p = p;
    worst.text = fmt::format("{} ({}, {}) channel {}: {:.6g} +- {:.2g} against {:.6g} +- {:.2g}",
                             what, i / 3 % a.width, i / 3 / a.width, i % 3, a.mean[i],
                             std::sqrt(a.variance[i]), b.mean[i], std::sqrt(b.variance[i]));
  }
}

}  // namespace

double StudentPValue(double t, double freedom) {
  return IncompleteBeta(freedom / (freedom + t * t), 0.5 * freedom, 0.5);
}

PictureEstimate EstimateFrom(const OraclePicture& picture, std::uint32_t samples_per_pixel) {
  const Image& mean = picture.mean;
  return {.width = mean.width,
          .height = mean.height,
          .mean = std::vector<double>(mean.rgb.begin(), mean.rgb.end()),
          .variance = picture.variance,
          .freedom = std::vector<double>(mean.rgb.size(), samples_per_pixel - 1.0)};
}

PictureEstimate EstimateFromOracle(const Scene& scene, const RenderJob& job, int runs) {
  RenderOptions options = job.options();
  options.samples_per_pixel *= std::uint32_t(runs);
  options.seed = 4711;
  return EstimateFrom(Oracle(scene).Render(options), options.samples_per_pixel);
}

PictureEstimate EstimateFromEngine(const RenderJob& job, int runs, std::uint32_t seed) {
  return EstimateFromEngine(job, job.frame(), runs, seed);
}

PictureEstimate EstimateFromEngine(const RenderJob& job, FrameView frame, int runs,
                                   std::uint32_t seed) {
  std::vector<Moments> moments;
  for (int run = 0; run < runs; ++run) {
    frame.options.seed = seed + std::uint32_t(run);
    Film film = job.MakeFilm();
    RenderFrame(frame, film);
    const Image image = film.Resolve(frame.options.samples_per_pixel);
    moments.resize(image.rgb.size());
    for (std::size_t i = 0; i < moments.size(); ++i) moments[i].Add(image.rgb[i]);
  }
  PictureEstimate estimate = {.width = frame.options.width, .height = frame.options.height};
  for (const Moments& m : moments) {
    estimate.mean.push_back(m.mean());
    estimate.variance.push_back(m.variance() / double(m.count()));
    estimate.freedom.push_back(runs - 1.0);
  }
  return estimate;
}

PictureEstimate MeanOfBlocks(const PictureEstimate& picture, int side) {
  PictureEstimate blocks = {.width = (picture.width + side - 1) / side,
                            .height = (picture.height + side - 1) / side};
  for (int by = 0; by < blocks.height; ++by) {
    for (int bx = 0; bx < blocks.width; ++bx) {
      for (int c = 0; c < 3; ++c) {
        double mean = 0, variance = 0, count = 0;
        Freedom freedom;
        for (int y = by * side; y < std::min(picture.height, (by + 1) * side); ++y) {
          for (int x = bx * side; x < std::min(picture.width, (bx + 1) * side); ++x) {
            const std::size_t i = (std::size_t(y) * picture.width + x) * 3 + c;
            mean += picture.mean[i], variance += picture.variance[i], ++count;
            freedom.Add(picture.variance[i], picture.freedom[i]);
          }
        }
        blocks.mean.push_back(mean / count);
        blocks.variance.push_back(variance / (count * count));
        blocks.freedom.push_back(freedom.value());
      }
    }
  }
  return blocks;
}

double RelativeDifference(const PictureEstimate& picture, const PictureEstimate& expected) {
  double sum = 0, scale = 0;
  for (std::size_t i = 0; i < expected.mean.size(); ++i) {
    sum += std::pow(picture.mean[i] - expected.mean[i], 2);
    scale += std::pow(expected.mean[i], 2);
  }
  return std::sqrt(sum / scale);
}

testing::AssertionResult SamePicture(const PictureEstimate& a, const PictureEstimate& b,
                                     double level, double rounding) {
  if (a.width != b.width || a.height != b.height) {
    return testing::AssertionFailure() << "the pictures are not of one size";
  }
  Worst worst;
  std::size_t cells = 0;
  for (const int side : {1, 4, 12, std::max(a.width, a.height)}) {
    const PictureEstimate block_a = side == 1 ? Steadied(a) : MeanOfBlocks(a, side);
    const PictureEstimate block_b = side == 1 ? Steadied(b) : MeanOfBlocks(b, side);
    CompareCells(block_a, block_b, rounding,
                 side == 1 ? "pixel" : fmt::format("block of {} pixels", side), worst);
    cells += block_a.mean.size();
  }
  if (worst.p >= SidakLevel(cells, level)) return testing::AssertionSuccess();
  return testing::AssertionFailure()
         << fmt::format("p = {:.3g} below the level {:.3g} of {}: {}", worst.p,
                        SidakLevel(cells, level), cells, worst.text);
}

testing::AssertionResult SameAsPaths(const Scene& scene, JobRequest request, int runs,
                                     double level) {
  const RenderJob other(scene, request);
  const PictureEstimate tested = MeanOfBlocks(EstimateFromEngine(other, runs, 100), 3);
  request.integrator = Integrator::kPath;
  request.samples_per_pixel = 4 * *request.samples_per_pixel;
  const RenderJob path(scene, request);
  const PictureEstimate expected = MeanOfBlocks(EstimateFromEngine(path, runs, 1000), 3);
  return SamePicture(tested, expected, level);
}

}  // namespace skywave
