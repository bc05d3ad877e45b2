#include "scene/materials/merl.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "base/error.h"
#include "base/files.h"

namespace skywave {
namespace {

constexpr std::size_t kBins = kMeasuredFloats / 3;
constexpr std::size_t kHeader = 3 * sizeof(std::int32_t);
constexpr std::size_t kFileBytes = kHeader + 3 * kBins * sizeof(double);
// These are the factors of the numbers of a file, as in the database's own reader.
constexpr double kScale[3] = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};

template <class T>
T At(std::string_view bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

// Returns the mean of the green values of one half angle over difference angles below 45 degrees.
double Profile(const MeasuredBrdf& brdf, std::uint32_t half) {
  constexpr std::uint32_t kSteep = kMeasuredDifference / 2;
  double sum = 0;
  for (std::uint32_t i = 0; i < kSteep * kMeasuredTurn; ++i) {
    const std::size_t bin = std::size_t{half} * kMeasuredDifference * kMeasuredTurn + i;
    sum += brdf.rgb[3 * bin + 1];
  }
  return sum / (kSteep * kMeasuredTurn);
}

double HalfAngle(double bin) {
  const double root = bin / kMeasuredHalf;
  return std::numbers::pi / 2 * root * root;
}

// Fits the width of the GGX lobe, about D(h) = 1 / (1 + tan^2 / alpha^2)^2, so that it falls to a
// half where the gloss does, and the share of the gloss in the albedo seen from above, where the
// half angle is half of the light's angle.
void FitLobe(MeasuredBrdf& brdf) {
  double profile[kMeasuredHalf];
  for (std::uint32_t half = 0; half < kMeasuredHalf; ++half) profile[half] = Profile(brdf, half);
  constexpr auto kFlat = std::uint32_t(kMeasuredHalf * 0.7);  // 44 degrees
  const double body = *std::min_element(profile, profile + kFlat);
  const double gloss = profile[0] - body;
  std::uint32_t half = 0;
  while (half < kFlat && profile[half] - body > 0.5 * gloss) ++half;
  const double tangent = std::tan(HalfAngle(half));
  brdf.alpha = float(std::clamp(tangent / std::sqrt(std::sqrt(2.0) - 1), 0.01, 1.0));
  double glossy = 0;
  for (std::uint32_t i = 0; i < kFlat; ++i) {
    const double low = 2 * HalfAngle(i), high = 2 * HalfAngle(i + 1);
    const double solid_cosine =
        std::numbers::pi * (std::pow(std::sin(high), 2) - std::pow(std::sin(low), 2));
    glossy += std::max(0.0, profile[i] - body) * std::max(0.0, solid_cosine);
  }
  const double total = glossy + std::numbers::pi * body;
  brdf.specular_share = total > 0 ? float(std::clamp(glossy / total, 0.1, 0.9)) : 0.5f;
}

}  // namespace

MeasuredBrdf ParseMerl(std::string_view bytes, const std::string& path) {
  const InputPosition file = InputPosition::File(path);
  if (bytes.size() < kHeader) throw InputError(file, "too short for a BRDF of the MERL format");
  const std::int32_t dims[3] = {At<std::int32_t>(bytes, 0), At<std::int32_t>(bytes, 4),
                                At<std::int32_t>(bytes, 8)};
  if (dims[0] != int(kMeasuredHalf) || dims[1] != int(kMeasuredDifference) ||
      dims[2] != int(kMeasuredTurn)) {
    throw InputError(file, fmt::format("a BRDF of the MERL format has {} x {} x {} bins, not "
                                       "{} x {} x {}",
                                       kMeasuredHalf, kMeasuredDifference, kMeasuredTurn, dims[0],
                                       dims[1], dims[2]));
  }
  if (bytes.size() != kFileBytes) {
    throw InputError(file, fmt::format("a BRDF of the MERL format has {} bytes, not {}", kFileBytes,
                                       bytes.size()));
  }
  MeasuredBrdf brdf;
  brdf.rgb.resize(kMeasuredFloats);
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      const std::size_t offset = kHeader + (c * kBins + bin) * sizeof(double);
      const double value = At<double>(bytes, offset) * kScale[c];
      if (!(std::fabs(value) < 1e30)) {
        throw InputError(InputPosition::Byte(path, offset), "a value that is not finite");
      }
      brdf.rgb[3 * bin + c] = float(std::max(value, 0.0));
    }
  }
  FitLobe(brdf);
  return brdf;
}

MeasuredBrdf ReadMerl(const std::string& path) {
  return ParseMerl(ReadFile(path, kFileBytes + 1), path);
}

}  // namespace skywave
