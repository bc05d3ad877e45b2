#include "job/denoise/denoise.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "job/denoise/oidn.h"
#include "job/denoise/outliers.h"
#include "job/denoise/planes.h"
#include "kernels/cross_filter.h"
#include "kernels/feature_fit.h"

namespace skywave {
namespace {

template <class F>
void ForEachTile(const PlaneShape& shape, const F& f) {
  const int columns = (shape.width + FilterTile::kWidth - 1) / FilterTile::kWidth;
  const int rows = (shape.height + FilterTile::kHeight - 1) / FilterTile::kHeight;
  tbb::parallel_for(0, columns * rows, [&](int i) {
    const int x = i % columns * FilterTile::kWidth, y = i / columns * FilterTile::kHeight;
    f(FilterTile{.x = x,
                 .y = y,
                 .width = std::min(FilterTile::kWidth, shape.width - x),
                 .height = std::min(FilterTile::kHeight, shape.height - y)});
  });
}

// Calls f(pixel, at) with the number of each pixel and its place on the planes.
template <class F>
void ForEachPixel(const PlaneShape& shape, const F& f) {
  tbb::parallel_for(0, shape.height, [&](int y) {
    for (int x = 0; x < shape.width; ++x) {
      f(std::size_t(y) * std::size_t(shape.width) + std::size_t(x), shape.at(x, y));
    }
  });
}

template <class Planes>
void RepeatEdges(const PlaneShape& shape, const soa::Table<Planes>& planes) {
  std::vector<float*> columns;
  Planes::ForEachColumn(planes.columns(), [&](float* column) { columns.push_back(column); });
  tbb::parallel_for(std::size_t(0), columns.size(),
                    [&](std::size_t i) { RepeatEdge(shape, columns[i]); });
}

DenoiserPlanes ReadPlanes(const DenoiserInput& input) {
  const PlaneShape shape = {input.image.width, input.image.height};
  DenoiserPlanes planes(shape);
  tbb::parallel_for(0, shape.height, [&](int y) { ReadRow(input, y, planes); });
  FillRim(shape, kNoCoverage, planes.features->coverage);
  tbb::parallel_for(0, shape.height, [&](int y) { FindSlopes(shape, y, planes.features); });
  for (const soa::Table<HalfPlanes>& half : planes.halves) RepeatEdges(shape, half);
  RepeatEdges(shape, planes.texture);
  return planes;
}

// Replaces the noise of both halves by what SmoothNoise makes of it.
void SmoothNoises(const DenoiserInput& input, DenoiserPlanes& planes) {
  const PlaneShape& shape = planes.shape;
  std::vector<float> samples(shape.size()), smooth(shape.size());
  for (int h = 0; h < 2; ++h) {
    const HalfPlanes &half = planes.halves[h], &other = planes.halves[1 - h];
    ForEachPixel(shape, [&](std::size_t pixel, std::size_t at) {
      const float second = input.half_samples[pixel];
      samples[at] = h == 1 ? second : input.samples[pixel] - second;
    });
    tbb::parallel_for(0, shape.height, [&](int y) {
      SmoothNoise(shape, half, other, samples.data(), y, smooth.data());
    });
    std::copy(smooth.begin(), smooth.end(), half.noise);
    RepeatEdge(shape, half.noise);
  }
}

// Replaces a plane, whose rim is written, by its means over the pixels around, `around` on each
// side; the rim means nothing then.
void AverageAround(const PlaneShape& shape, int around, std::vector<float>& plane) {
  std::vector<float> rows(shape.size());
  const float scale = 1 / float((2 * around + 1) * (2 * around + 1));
  tbb::parallel_for(-around, shape.height + around, [&](int y) {
    for (int x = 0; x < shape.width; ++x) {
      float sum = 0;
      for (int dx = -around; dx <= around; ++dx) sum += plane[shape.at(x + dx, y)];
      rows[shape.at(x, y)] = sum;
    }
  });
  tbb::parallel_for(0, shape.height, [&](int y) {
    for (int x = 0; x < shape.width; ++x) {
      float sum = 0;
      for (int dy = -around; dy <= around; ++dy) sum += rows[shape.at(x, y + dy)];
      plane[shape.at(x, y)] = scale * sum;
    }
  });
}

// A clean picture, textures divided out, with its estimated squared error.
struct Candidate {
  explicit Candidate(std::uint32_t size)
      : light(size, soa::Touch::kLater), squared_error(size, soa::Touch::kLater) {}
  soa::Table<TexturePlanes> light;
  soa::Table<ErrorPlanes> squared_error;
};

soa::Table<HalfPlanes> NewHalf(const PlaneShape& shape) {
  return soa::Table<HalfPlanes>(std::uint32_t(shape.size()), soa::Touch::kLater);
}

// Returns the mean of halves, without its error.
Candidate MeanOfHalves(const DenoiserInput& input, const PlaneShape& shape,
                       const HalfPlanes (&halves)[2]) {
  Candidate mean(std::uint32_t(shape.size()));
  const float* const values[3][2] = {
      {halves[0].r, halves[1].r}, {halves[0].g, halves[1].g}, {halves[0].b, halves[1].b}};
  float* const light[3] = {mean.light->r, mean.light->g, mean.light->b};
  ForEachPixel(shape, [&](std::size_t pixel, std::size_t at) {
    const float second = input.half_samples[pixel] / input.samples[pixel];
    for (std::size_t c = 0; c < 3; ++c) {
      light[c][at] = (1 - second) * values[c][0][at] + second * values[c][1][at];
    }
  });
  return mean;
}

// Returns the mean of halves that were filtered pixel by pixel, or not at all, with its error.
Candidate WithError(const DenoiserInput& input, const DenoiserPlanes& planes,
                    const HalfPlanes (&halves)[2]) {
  Candidate mean = MeanOfHalves(input, planes.shape, halves);
  const HalfPlanes noisy[2] = {planes.halves[0], planes.halves[1]};
  ForEachTile(planes.shape, [&](const FilterTile& tile) {
    EstimateError(planes.shape, noisy, halves, tile, mean.squared_error);
  });
  return mean;
}

// Writes the estimated squared error of a picture whose halves were cleaned to `clean`, each by
// itself: what they differ by is their variance, and the product of what both have changed is the
// square of their common bias, since the noise of one half knows nothing of the other's. Both are
// means over many pixels: a network errs alike over whole regions, by less than the noise of few.
void EstimateWide(const DenoiserPlanes& planes, const soa::Table<HalfPlanes> (&clean)[2],
                  const ErrorPlanes& squared_error) {
  constexpr int kVarianceAround = 3, kBiasAround = 8;  // pixels on each side
  const PlaneShape& shape = planes.shape;
  const auto colors = [](const HalfPlanes& half) { return std::array{half.r, half.g, half.b}; };
  const auto f0 = colors(clean[0]), f1 = colors(clean[1]);
  const auto x0 = colors(planes.halves[0]), x1 = colors(planes.halves[1]);
  float* const out[3] = {squared_error.r, squared_error.g, squared_error.b};
  std::vector<float> variance(shape.size()), bias(shape.size());
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t at = 0; at < shape.size(); ++at) {
      const float apart = f0[c][at] - f1[c][at];
      variance[at] = 0.25f * apart * apart;
      bias[at] = (f0[c][at] - x0[c][at]) * (f1[c][at] - x1[c][at]);
    }
    AverageAround(shape, kVarianceAround, variance);
    AverageAround(shape, kBiasAround, bias);
    ForEachPixel(shape, [&](std::size_t, std::size_t at) {
      out[c][at] = variance[at] + std::max(bias[at], 0.0f);
    });
  }
}

Candidate FilterByStatistics(const DenoiserInput& input, const DenoiserPlanes& planes) {
  const PlaneShape& shape = planes.shape;
  const HalfPlanes noisy[2] = {planes.halves[0], planes.halves[1]};
  HalfPlanes in[2] = {noisy[0], noisy[1]};
  soa::Table<HalfPlanes> filtered[2], next[2];
  for (int h = 0; h < 2; ++h) filtered[h] = NewHalf(shape), next[h] = NewHalf(shape);
  // Calls filter(out), which reads `in`; the next filter reads what this one has written.
  const auto run = [&](const auto& filter) {
    filter({next[0].columns(), next[1].columns()});
    for (int h = 0; h < 2; ++h) {
      std::swap(filtered[h], next[h]);
      RepeatEdges(shape, filtered[h]);
      in[h] = filtered[h];
    }
  };
  using Halves = HalfPlanes[2];
  for (const FilterLevel& level : kFilterLevels) {
    run([&](const Halves& out) {
      ForEachTile(shape, [&](const FilterTile& tile) {
        CrossFilter(shape, planes.features, in, level, tile, out);
      });
    });
  }
  run([&](const Halves& out) {
    tbb::parallel_for(0, shape.height, [&](int y) {
      FitToFeatures(shape, planes.features, planes.texture, input.brightness, noisy, in, y, out);
    });
  });
  return WithError(input, planes, in);
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
  Candidate whole =
      MeanOfHalves(input, shape, {planes.halves[0].columns(), planes.halves[1].columns()});
  clean({whole.light->r, whole.light->g, whole.light->b});
  if (!with_error) return whole;
  soa::Table<HalfPlanes> halves[2];
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
  if (by == Denoiser::kStatistics) return FilterByStatistics(input, planes);
  if (by == Denoiser::kOidn || by == Denoiser::kQuick) {
    return FilterByOidn(input, planes, /*with_error=*/by == Denoiser::kOidn);
  }
  std::vector<Candidate> candidates;
  candidates.push_back(FilterByStatistics(input, planes));
  candidates.push_back(FilterByOidn(input, planes, /*with_error=*/true));
  candidates.push_back(
      WithError(input, planes, {planes.halves[0].columns(), planes.halves[1].columns()}));
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
                 std::span<const NamedChannel> layers) {
  const DenoiserInput input = FindInput(name, image, layers);
  DenoiserPlanes planes = ReadPlanes(input);
  const PlaneShape& shape = planes.shape;
  const OutlierExcess outliers = TakeOutliers(input, planes);
  if (outliers.outliers != 0) {
    for (const soa::Table<HalfPlanes>& half : planes.halves) RepeatEdges(shape, half);
  }
  SmoothNoises(input, planes);

  Denoised result = {.image = Image(shape.width, shape.height),
                     .error = {},
                     .outliers = outliers.outliers,
                     .oidn = by == Denoiser::kStatistics ? "" : OidnVersion()};
  if (by != Denoiser::kQuick) result.error = {{"error.R", {}}, {"error.G", {}}, {"error.B", {}}};
  const Candidate clean = Clean(by, input, planes, result.shares);
  for (NamedChannel& channel : result.error) channel.values.resize(input.samples.size());
  const float* const lights[3] = {clean.light->r, clean.light->g, clean.light->b};
  const float* const textures[3] = {planes.texture->r, planes.texture->g, planes.texture->b};
  const float* const errors[3] = {clean.squared_error->r, clean.squared_error->g,
                                  clean.squared_error->b};
  const float* const spread[3] = {outliers.spread->r, outliers.spread->g, outliers.spread->b};
  ForEachPixel(shape, [&](std::size_t pixel, std::size_t at) {
    for (std::size_t c = 0; c < 3; ++c) {
      // Where light was spread, the picture is not known to be right.
      const float more = spread[c] != nullptr ? spread[c][at] : 0;
      result.image.rgb[3 * pixel + c] = lights[c][at] * textures[c][at] + more;
      if (result.error.empty()) continue;
      const float error2 = errors[c][at] * textures[c][at] * textures[c][at] + more * more;
      result.error[c].values[pixel] = std::sqrt(error2);
    }
  });
  double spread_sum = 0, sum = 0;
  for (int y = 0; y < shape.height && result.outliers != 0; ++y) {
    for (int x = 0; x < shape.width; ++x) {
      const std::size_t pixel = std::size_t(y) * std::size_t(shape.width) + std::size_t(x);
      for (std::size_t c = 0; c < 3; ++c) {
        spread_sum += spread[c][shape.at(x, y)];
        sum += image.rgb[3 * pixel + c];
      }
    }
  }
  if (sum > 0) result.spread_share = spread_sum / sum;
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
