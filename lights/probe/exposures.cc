#include "lights/probe/exposures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "base/error.h"

namespace skywave {
namespace {

// ---- Alignment: bitmaps of what is brighter than the median (Ward 2003) ----

struct Grey {
  int width, height;
  std::vector<float> value;
  float At(int x, int y) const {
    return value[std::size_t(y) * std::size_t(width) + std::size_t(x)];
  }
};

Grey GreyOf(const Image& image) {
  Grey grey = {image.width, image.height, {}};
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) grey.value.push_back(image.rgb[i + 1]);
  return grey;
}

Grey Halved(const Grey& fine) {
  Grey half = {fine.width / 2, fine.height / 2, {}};
  for (int y = 0; y < half.height; ++y) {
    for (int x = 0; x < half.width; ++x) {
      half.value.push_back((fine.At(2 * x, 2 * y) + fine.At(2 * x + 1, 2 * y) +
                            fine.At(2 * x, 2 * y + 1) + fine.At(2 * x + 1, 2 * y + 1)) /
                           4);
    }
  }
  return half;
}

// Values are 1 above the median and -1 below it; 0 near it, where noise decides.
std::vector<std::int8_t> Bitmap(const Grey& grey) {
  std::vector<float> sorted = grey.value;
  const auto quantile = [&](double at) {
    const auto place = sorted.begin() + std::ptrdiff_t(at * double(sorted.size() - 1));
    std::nth_element(sorted.begin(), place, sorted.end());
    return *place;
  };
  const float low = quantile(0.46), high = quantile(0.54);
  std::vector<std::int8_t> bits;
  for (const float value : grey.value) {
    bits.push_back(std::int8_t(value > high ? 1 : value < low ? -1 : 0));
  }
  return bits;
}

// Returns (dx, dy) such that `moved` at (x + dx, y + dy) shows what `fixed` shows at (x, y).
std::array<int, 2> ShiftBetween(const Grey& fixed, const Grey& moved) {
  constexpr int kSmallest = 8;  // shorter side of the coarsest level [pixels]
  std::array<int, 2> coarse = {0, 0};
  if (std::min(fixed.width, fixed.height) >= 2 * kSmallest) {
    coarse = ShiftBetween(Halved(fixed), Halved(moved));
  }
  const std::vector<std::int8_t> a = Bitmap(fixed), b = Bitmap(moved);
  std::array<int, 2> best = {2 * coarse[0], 2 * coarse[1]};
  double least = 2;
  // The middle is tried first, so that nothing is moved without a reason.
  for (const int order : {4, 1, 3, 5, 7, 0, 2, 6, 8}) {
    const int dx = 2 * coarse[0] + order % 3 - 1, dy = 2 * coarse[1] + order / 3 - 1;
    std::size_t compared = 0, different = 0;
    for (int y = std::max(0, -dy); y < std::min(fixed.height, fixed.height - dy); ++y) {
      for (int x = std::max(0, -dx); x < std::min(fixed.width, fixed.width - dx); ++x) {
        const std::int8_t p = a[std::size_t(y) * std::size_t(fixed.width) + std::size_t(x)];
        const std::int8_t q =
            b[std::size_t(y + dy) * std::size_t(fixed.width) + std::size_t(x + dx)];
        compared += p * q != 0, different += p * q < 0;
      }
    }
    const double share = compared > 0 ? double(different) / double(compared) : 1;
    if (share < least) least = share, best = {dx, dy};
  }
  return best;
}

// Returns the shift of every exposure against the middle one, from each to its neighbour.
std::vector<std::array<int, 2>> Shifts(const std::vector<Exposure>& exposures, bool align) {
  std::vector<std::array<int, 2>> shift(exposures.size(), {0, 0});
  if (!align) return shift;
  std::vector<Grey> grey;
  for (const Exposure& exposure : exposures) grey.push_back(GreyOf(exposure.image));
  const std::size_t middle = exposures.size() / 2;
  const auto follow = [&](std::size_t from, std::size_t to) {
    const std::array<int, 2> step = ShiftBetween(grey[from], grey[to]);
    shift[to] = {shift[from][0] + step[0], shift[from][1] + step[1]};
  };
  for (std::size_t i = middle; i + 1 < exposures.size(); ++i) follow(i, i + 1);
  for (std::size_t i = middle; i > 0; --i) follow(i, i - 1);
  return shift;
}

void Check(const std::vector<Exposure>& exposures) {
  const auto refuse = [](const Exposure& exposure, const std::string& why) {
    throw InputError(InputPosition::File(exposure.name), why);
  };
  if (exposures.size() < 2) throw InputError({}, "two exposures at least are needed", kExitUsage);
  const Exposure& first = exposures[0];
  for (const Exposure& exposure : exposures) {
    const Image& image = exposure.image;
    if (!(exposure.exposure > 0) || !std::isfinite(exposure.exposure)) {
      refuse(exposure, "has no exposure above 0");
    }
    if (image.width != first.image.width || image.height != first.image.height) {
      refuse(exposure, fmt::format("is {}x{}, and {} is {}x{}", image.width, image.height,
                                   first.name, first.image.width, first.image.height));
    }
    if (exposure.coded != first.coded) {
      refuse(exposure, fmt::format("has {}, and {} has {}", exposure.coded ? "codes" : "radiance",
                                   first.name, first.coded ? "codes" : "radiance"));
    }
  }
  const auto [least, most] = std::minmax_element(
      exposures.begin(), exposures.end(),
      [](const Exposure& a, const Exposure& b) { return a.exposure < b.exposure; });
  if (least->exposure == most->exposure) refuse(*most, "has the exposure of all others");
}

}  // namespace

AssembledExposures AssembleExposures(std::vector<Exposure> exposures, bool align,
                                     ResponseMethod method) {
  Check(exposures);
  // From the longest to the shortest, so that neighbours are most alike; shifts are in the order
  // that was given.
  std::vector<std::size_t> order(exposures.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return exposures[a].exposure > exposures[b].exposure;
  });
  std::vector<Exposure> sorted;
  for (const std::size_t i : order) sorted.push_back(std::move(exposures[i]));
  const std::vector<std::array<int, 2>> shift = Shifts(sorted, align);
  const ExposureStack stack = {sorted, shift};

  AssembledExposures result;
  result.shift.resize(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) result.shift[order[i]] = shift[i];
  const Image& first = sorted[0].image;
  const bool coded = sorted[0].coded;
  // What a linear picture clips is its largest number.
  float white = 1;
  if (!coded) {
    white = 0;
    for (const Exposure& exposure : sorted) {
      for (const float value : exposure.image.rgb) {
        if (std::isfinite(value)) white = std::max(white, value);
      }
    }
    if (!(white > 0)) throw InputError(InputPosition::File(sorted[0].name), "is black");
  } else {
    result.response = FindResponse(stack, method);
    for (const CodeValues& g : *result.response) {
      if (!(g[kCodes - 16] > g[16])) {
        throw InputError(InputPosition::File(sorted[0].name),
                         "codes do not grow with the exposures: these are in another order, or the "
                         "photographs are of different things");
      }
    }
  }

  std::array<CodeValues, 3> worth = {};
  for (std::size_t c = 0; c < 3 && coded; ++c) {
    worth[c] = WeightsOfCodes((*result.response)[c], method);
  }
  // The mean of Debevec and Malik is that of logarithms. Robertson et al. weigh radiance by the
  // square of the exposure, because an error of a code is one of light times exposure.
  const bool linear_mean = coded && method == ResponseMethod::kRobertson;
  result.image = Image(first.width, first.height);
  for (int y = 0; y < first.height; ++y) {
    for (int x = 0; x < first.width; ++x) {
      for (int channel = 0; channel < 3; ++channel) {
        double weights = 0, sum = 0, shortest = 0, longest = 0;
        bool is_white = false, any = false;
        for (std::size_t j = 0; j < sorted.size(); ++j) {
          const float* pixel = stack.Pixel(j, x, y);
          if (pixel == nullptr) continue;
          const float value = pixel[channel];
          double log_exposure, weight;
          if (coded) {
            const int code = CodeOf(value);
            log_exposure = (*result.response)[std::size_t(channel)][std::size_t(code)];
            weight = worth[std::size_t(channel)][std::size_t(code)];
          } else {
            const double share = std::isfinite(value) ? std::clamp(value / white, 0.0f, 1.0f) : 0;
            log_exposure = std::log(std::max(share * white, 1e-12 * white));
            weight = std::min(share, 1 - share);
          }
          const double log_radiance = log_exposure - std::log(sorted[j].exposure);
          if (linear_mean) weight *= sorted[j].exposure * sorted[j].exposure;
          weights += weight, sum += weight * (linear_mean ? std::exp(log_radiance) : log_radiance);
          if (!any) longest = log_radiance;
          any = true, shortest = log_radiance;
          is_white = value >= 0.5f * white;
        }
        if (weights > 0) {
          const double mean = sum / weights;
          result.image.Pixel(x, y)[channel] = float(linear_mean ? mean : std::exp(mean));
          continue;
        }
        ++(is_white ? result.white : result.black);
        result.image.Pixel(x, y)[channel] = float(std::exp(is_white ? shortest : longest));
      }
    }
  }
  return result;
}

}  // namespace skywave
