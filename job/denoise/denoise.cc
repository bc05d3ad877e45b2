#include "job/denoise/denoise.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "job/denoise/candidate.h"
#include "job/denoise/groups.h"
#include "job/denoise/oidn.h"
#include "job/denoise/outliers.h"
#include "job/denoise/planes.h"
#include "job/denoise/statistics.h"

namespace skywave {
namespace {

Candidate FilterByStatistics(const DenoiserPlanes& planes) {
  const HalfTables halves = FilterHalves(planes);
  return WithError(planes, {halves[0].columns(), halves[1].columns()});
}

// The whole of the picture and, for its error, the halves are cleaned one by one. Pixels that see
// nothing but the map have no noise, and stay.
Candidate FilterByOidn(const DenoiserInput& input, const DenoiserPlanes& planes, bool with_error) {
  const PlaneShape& shape = planes.shape;
  const std::size_t values = input.image.rgb.size();
  std::vector<float> albedo(values), normal(values), color(values);
  const float* const textures[3] = {planes.texture->r, planes.texture->g, planes.texture->b};
  ForEachPixel(shape, [&](std::size_t pixel, std::size_t) {
    const float coverage = input.coverage[pixel];
    for (std::size_t c = 0; c < 3; ++c) {
      const float seen = coverage * input.albedo[c][pixel] + (1 - coverage);
      albedo[3 * pixel + c] = std::clamp(seen, 0.0f, 1.0f);
      normal[3 * pixel + c] = coverage * input.normal[c][pixel];
    }
  });
  // Replaces light by what the network makes of it.
  const auto clean = [&](float* const(&light)[3]) {
    ForEachPixel(shape, [&](std::size_t pixel, std::size_t at) {
      for (std::size_t c = 0; c < 3; ++c) color[3 * pixel + c] = light[c][at] * textures[c][at];
    });
    const std::vector<float> result =
        DenoiseByOidn({shape.width, shape.height, color, albedo, normal});
    ForEachPixel(shape, [&](std::size_t pixel, std::size_t at) {
      for (std::size_t c = 0; c < 3 && input.coverage[pixel] > 0; ++c) {
        light[c][at] = result[3 * pixel + c] / textures[c][at];
      }
    });
  };
  Candidate whole = MeanOfHalves(planes, {planes.halves[0].columns(), planes.halves[1].columns()});
  clean({whole.light->r, whole.light->g, whole.light->b});
  if (!with_error) return whole;
  HalfTables halves;
  for (int h = 0; h < 2; ++h) {
    halves[h] = NewHalf(shape);
    const HalfPlanes from = planes.halves[h], to = halves[h];
    for (const auto& [source, target] :
         {std::pair(from.r, to.r), {from.g, to.g}, {from.b, to.b}, {from.noise, to.noise}}) {
      std::copy_n(source, shape.size(), target);
    }
    clean({to.r, to.g, to.b});
    RepeatEdges(shape, halves[h]);
  }
  EstimateWide(planes, halves, whole.squared_error);
  return whole;
}

// Returns the squared error of a candidate as a mean over the pixels around: that of one pixel is
// itself an estimate from few, by which a choice would follow the noise.
std::vector<float> Score(const PlaneShape& shape, const Candidate& candidate) {
  constexpr int kAround = 8;  // pixels on each side
  const ErrorPlanes& error = candidate.squared_error;
  std::vector<float> score(shape.size());
  ForEachPixel(shape, [&](std::size_t, std::size_t at) {
    score[at] = error.r[at] + error.g[at] + error.b[at];
  });
  RepeatEdge(shape, score.data());
  AverageAround(shape, kAround, score);
  return score;
}

// Returns the mean of candidates, weighted by the inverse squares of their scores. Errors of
// pictures that come from the same samples go together, so the root of that of the mean is the mean
// of the roots. Adds the weights up in `shares`.
Candidate Combine(const PlaneShape& shape, const std::vector<Candidate>& candidates,
                  double (&shares)[3]) {
  std::vector<std::vector<float>> scores;
  for (const Candidate& candidate : candidates) scores.push_back(Score(shape, candidate));
  Candidate mean(std::uint32_t(shape.size()));
  std::vector<std::array<double, 3>> of_rows(std::size_t(shape.height));
  tbb::parallel_for(0, shape.height, [&](int y) {
    for (int x = 0; x < shape.width; ++x) {
      const std::size_t at = shape.at(x, y);
      std::array<float, 3> weights = {};
      float all = 0;
      for (std::size_t i = 0; i < candidates.size(); ++i) {
        weights[i] = 1 / (scores[i][at] * scores[i][at] + 1e-30f);
        all += weights[i];
      }
      float light[3] = {}, error[3] = {};
      for (std::size_t i = 0; i < candidates.size(); ++i) {
        const float weight = weights[i] / all;
        of_rows[std::size_t(y)][i] += double(weight);
        const TexturePlanes& l = candidates[i].light;
        const ErrorPlanes& e = candidates[i].squared_error;
        const float lights[] = {l.r[at], l.g[at], l.b[at]}, squares[] = {e.r[at], e.g[at], e.b[at]};
        for (std::size_t c = 0; c < 3; ++c) {
          light[c] += weight * lights[c], error[c] += weight * std::sqrt(squares[c]);
        }
      }
      mean.light->r[at] = light[0], mean.light->g[at] = light[1], mean.light->b[at] = light[2];
      mean.squared_error->r[at] = error[0] * error[0];
      mean.squared_error->g[at] = error[1] * error[1];
      mean.squared_error->b[at] = error[2] * error[2];
    }
  });
  for (const std::array<double, 3>& row : of_rows) {
    for (std::size_t i = 0; i < 3; ++i) shares[i] += row[i] / (double(shape.width) * shape.height);
  }
  return mean;
}

// Returns the picture by the method; `shares` are those of Denoised.
Candidate Clean(Denoiser by, const DenoiserInput& input, const DenoiserPlanes& planes,
                double (&shares)[3]) {
  if (by == Denoiser::kStatistics) return FilterByStatistics(planes);
  if (by == Denoiser::kOidn || by == Denoiser::kQuick) {
    return FilterByOidn(input, planes, /*with_error=*/by == Denoiser::kOidn);
  }
  std::vector<Candidate> candidates;
  candidates.push_back(FilterByStatistics(planes));
  candidates.push_back(FilterByOidn(input, planes, /*with_error=*/true));
  candidates.push_back(WithError(planes, {planes.halves[0].columns(), planes.halves[1].columns()}));
  return Combine(planes.shape, candidates, shares);
}

}  // namespace

Denoiser ResolveDenoiser(Denoiser by) {
  if (by == Denoiser::kAuto) {
    return OidnVersion().empty() ? Denoiser::kStatistics : Denoiser::kBest;
  }
  if (by != Denoiser::kNone && by != Denoiser::kStatistics) RequireOidn();
  return by;
}

Denoised Denoise(Denoiser by, const std::string& name, const Image& image,
                 std::span<const NamedChannel> layers, const NoiseLayers& noise) {
  const DenoiserInput input = FindInput(name, image, layers, noise);
  DenoiserPlanes planes = ReadPlanes(input);
  const OutlierExcess outliers = TakeOutliers(input, planes);
  SmoothNoises(input, planes);
  double shares[3] = {};
  const Candidate clean = Clean(by, input, planes, shares);
  Denoised result = PictureOf(planes, outliers, clean, /*with_error=*/by != Denoiser::kQuick);
  if (noise.prefix.empty()) result.groups = CleanGroups(name, input, planes, result.image, layers);
  if (by != Denoiser::kStatistics) result.oidn = OidnVersion();
  std::copy_n(shares, 3, result.shares);
  return result;
}

std::vector<std::string> NotesOf(const Denoised& denoised) {
  std::vector<std::string> notes;
  if (denoised.outliers != 0) {
    notes.push_back(fmt::format(
        "the denoiser spread {:.2g} % of the picture's light, the excess of {} outlier{}",
        100 * denoised.spread_share, denoised.outliers, denoised.outliers == 1 ? "" : "s"));
  }
  const double* const shares = denoised.shares;
  if (shares[0] + shares[1] + shares[2] > 0) {
    notes.push_back(fmt::format(
        "the denoiser took {:.0f} % of the picture from statistics, {:.0f} % from Open Image "
        "Denoise {}, and left {:.0f} % as it was",
        100 * shares[0], 100 * shares[1], denoised.oidn, 100 * shares[2]));
  }
  return notes;
}

}  // namespace skywave
