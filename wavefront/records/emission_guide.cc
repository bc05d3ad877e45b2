#include "wavefront/records/emission_guide.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>

namespace skywave {
namespace {

// Fewer samples than this do not show where in a part of the disk light is needed.
constexpr std::ptrdiff_t kLeastGuideSamples = 8;
// One sample counts at most this many means of all of them.
constexpr std::uint64_t kMostMeans = 8;

using GuideSampleSpan = std::span<GuideSample>;

std::uint64_t SumOf(GuideSampleSpan samples) {
  std::uint64_t sum = 0;
  for (const GuideSample& sample : samples) sum += sample.weight;
  return sum;
}

// This is a part of the unit square.
struct Part {
  float low[2] = {0, 0}, high[2] = {1, 1};
};

float Along(const GuideSample& sample, std::uint32_t axis) {
  return axis == 0 ? sample.u : sample.v;
}

// Returns where half of the weight lies below. It is counted in bins, then in those of the bin
// where that is, inside of which the weight is taken as uniform in the end: nothing is sorted.
float Median(GuideSampleSpan samples, std::uint32_t axis, double low, double high) {
  constexpr std::uint32_t kBins = 32, kRounds = 4;
  double left = 0.5 * double(SumOf(samples));
  for (std::uint32_t round = 0; round < kRounds; ++round) {
    std::uint64_t bins[kBins] = {};
    const double width = (high - low) / kBins;
    for (const GuideSample& sample : samples) {
      const double bin = std::floor((double(Along(sample, axis)) - low) / width);
      // Only samples in the range of this round count.
      if (bin >= 0 && bin < kBins) bins[std::uint32_t(bin)] += sample.weight;
    }
    std::uint32_t bin = 0;
    for (; bin + 1 < kBins && double(bins[bin]) < left; ++bin) left -= double(bins[bin]);
    low += bin * width, high = low + width;
    if (round + 1 == kRounds) {
      const double share = bins[bin] > 0 ? std::min(1.0, left / double(bins[bin])) : 0.5;
      return float(low + share * width);
    }
  }
  return float(low);
}

// Cuts a part and its parts into halves of equal weight.
void Cut(GuideSampleSpan samples, const Part& part, std::uint32_t node, float* cuts) {
  if (node >= kGuideLeaves) return;
  const std::uint32_t axis = std::uint32_t(std::bit_width(node) - 1) & 1;
  const float low = part.low[axis], high = part.high[axis];
  // Parts without enough samples, and parts too small to be cut much further, are cut in the
  // middle, as are all of their parts.
  constexpr float kLeastSide = 0x1p-13f;
  if (std::ssize(samples) < kLeastGuideSamples || high - low < kLeastSide) samples = {};
  float cut = 0.5f * (low + high);
  if (!samples.empty()) {
    const float margin = (high - low) / 64;
    cut = std::clamp(Median(samples, axis, low, high), low + margin, high - margin);
  }
  cuts[node] = cut;
  const auto middle =
      std::partition(samples.begin(), samples.end(),
                     [&](const GuideSample& sample) { return Along(sample, axis) < cut; });
  const auto below = std::size_t(middle - samples.begin());
  Part lower = part, upper = part;
  lower.high[axis] = upper.low[axis] = cut;
  Cut(samples.first(below), lower, 2 * node, cuts);
  Cut(samples.subspan(below), upper, 2 * node + 1, cuts);
}

// Returns the box of samples, wider by as much as more of them would have made it.
Part BoxOf(GuideSampleSpan samples) {
  Part box;
  for (std::uint32_t axis = 0; axis < 2; ++axis) {
    const auto [least, most] = std::minmax_element(
        samples.begin(), samples.end(), [axis](const GuideSample& a, const GuideSample& b) {
          return Along(a, axis) < Along(b, axis);
        });
    const float low = Along(*least, axis), high = Along(*most, axis);
    const float margin = (high - low) / float(samples.size()) + 1e-4f;
    box.low[axis] = std::max(0.0f, low - margin), box.high[axis] = std::min(1.0f, high + margin);
  }
  return box;
}

// Returns a sphere in which most of the points that need light lie. It is found in whole numbers,
// so that the order of samples does not matter.
SceneSphere FocusOf(GuideSampleSpan samples, const SceneSphere& sphere) {
  constexpr double kSteps = 1 << 15;  // steps in a radius of the scene
  constexpr int kRounds = 3, kRings = 512;
  constexpr double kInside = 0.9;
  double middle[3] = {};  // [steps]
  double radius = 4 * kSteps;
  const auto offset = [&](const GuideSample& sample, int axis) {
    return std::round((double(sample.point[axis]) - sphere.center[axis]) / sphere.radius * kSteps);
  };
  const auto distance = [&](const GuideSample& sample) {
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) sum += std::pow(offset(sample, axis) - middle[axis], 2);
    return std::sqrt(sum);
  };
  // A round finds the middle of the points inside, and then the radius about it.
  for (int round = 0; round < kRounds; ++round) {
    std::int64_t sums[3] = {}, weight = 0;
    for (const GuideSample& sample : samples) {
      if (distance(sample) > radius) continue;
      weight += std::int64_t(sample.weight);
      for (int axis = 0; axis < 3; ++axis) {
        sums[axis] += std::int64_t(sample.weight) * std::int64_t(offset(sample, axis));
      }
    }
    if (weight == 0) break;
    for (int axis = 0; axis < 3; ++axis) middle[axis] = double(sums[axis]) / double(weight);
    std::uint64_t rings[kRings] = {}, all = 0;
    for (const GuideSample& sample : samples) {
      const int ring = int(distance(sample) / (2 * kSteps) * kRings);
      rings[std::min(ring, kRings - 1)] += sample.weight, all += sample.weight;
    }
    int ring = 0;
    for (std::uint64_t inside = rings[0]; double(inside) < kInside * double(all);) {
      inside += rings[++ring];
    }
    radius = 2 * kSteps * (ring + 1) / kRings;
  }
  if (!(radius < kSteps)) return sphere;
  SceneSphere focus = {.radius = float(radius / kSteps * sphere.radius)};
  for (int axis = 0; axis < 3; ++axis) {
    focus.center[axis] = float(sphere.center[axis] + middle[axis] / kSteps * sphere.radius);
  }
  return focus;
}

// Puts samples in the order of their cells; cell c has [begin[c], begin[c + 1]).
std::vector<std::size_t> SortByCell(std::vector<GuideSample>& samples) {
  std::vector<std::size_t> begin(kGuideCells + 1);
  for (const GuideSample& sample : samples) ++begin[sample.cell + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<std::size_t> next = begin;
  std::vector<GuideSample> sorted(samples.size());
  for (const GuideSample& sample : samples) sorted[next[sample.cell]++] = sample;
  samples = std::move(sorted);
  return begin;
}

}  // namespace

std::size_t EmissionGuide::bytes() const {
  return cuts.size() * sizeof(float) + cells.size() * sizeof(GuideCell) +
         (directions ? directions->table_bytes() : 0) +
         (map ? map->latlong->rgb.size() * sizeof(float) : 0);
}

EmissionGuideView EmissionGuide::view() const {
  return {.cells = empty() ? nullptr : cells.data(), .cuts = cuts.data(), .focus = focus};
}

EmissionGuide MakeGuide(std::vector<GuideSample> samples, std::span<const double> shares,
                        const SceneSphere& sphere) {
  EmissionGuide guide;
  if (SumOf(samples) == 0) return guide;
  const std::uint64_t most =
      std::max<std::uint64_t>(1, kMostMeans * (SumOf(samples) / std::uint64_t(samples.size())));
  for (GuideSample& sample : samples) sample.weight = std::min(sample.weight, most);
  const double all = double(SumOf(samples));
  const std::vector<std::size_t> begin = SortByCell(samples);
  guide.focus = FocusOf(samples, sphere);
  guide.cells.resize(kGuideCells);
  guide.cuts.resize(kGuideCells * kGuideLeaves);
  tbb::parallel_for(0u, kGuideCells, [&](std::uint32_t i) {
    GuideSampleSpan mine = GuideSampleSpan(samples).subspan(begin[i], begin[i + 1] - begin[i]);
    GuideCell& cell = guide.cells[i];
    constexpr double kUnguided = kEvenShare + kFocusShare;
    double unguided = kUnguided;
    if (!shares.empty() && shares[i] > 0) {
      // Uniform starts are a share of those of the whole map: the more often a cell is drawn, the
      // smaller their share in it.
      const double drawn = kUnguided * shares[i] + (1 - kUnguided) * double(SumOf(mine)) / all;
      unguided = kUnguided * shares[i] / drawn;
      cell.gain = float(drawn / shares[i]);
    }
    Part box;
    if (std::ssize(mine) < kLeastGuideSamples) {
      mine = {}, unguided = 1;
    } else {
      box = BoxOf(mine);
    }
    cell.even = float(unguided * kEvenShare / kUnguided);
    cell.focused = float(unguided) - cell.even;
    std::copy_n(box.low, 2, cell.low), std::copy_n(box.high, 2, cell.high);
    Cut(mine, box, 1, &guide.cuts[i * kGuideLeaves]);
  });
  return guide;
}

}  // namespace skywave
