#include "wavefront/emission_guide.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <numbers>
#include <numeric>

#include "lights/sphere_map.h"
#include "lights/strategy_importance.h"
#include "wavefront/emission_pilot.h"
#include "wavefront/flush_denormals.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

// Fewer needs than this do not say where in a part of the disk they are.
constexpr std::ptrdiff_t kLeastNeeds = 8;
// What one need counts at most, in means of all of them.
constexpr std::uint64_t kMostMeans = 8;
// Columns of a map whose texels are small against cells of directions.
constexpr int kLeastColumns = 256;

using NeedSpan = std::span<SkyNeed>;

std::uint64_t SumOf(NeedSpan needs) {
  std::uint64_t sum = 0;
  for (const SkyNeed& need : needs) sum += need.weight;
  return sum;
}

// A part of the unit square.
struct Part {
  float low[2] = {0, 0}, high[2] = {1, 1};
  double area() const { return (double(high[0]) - low[0]) * (double(high[1]) - low[1]); }
};

// Cuts a part and its parts in halves of what is needed there, of which the share `even` is spread
// evenly over the square and a need of weight 1 counts `each`.
class TreeCutter {
 public:
  TreeCutter(double even, double each, float* cuts) : even_(even), each_(each), cuts_(cuts) {}

  void Cut(NeedSpan needs, const Part& part, std::uint32_t node = 1) {
    if (node >= kGuideLeaves) return;
    const std::uint32_t axis = std::uint32_t(std::bit_width(node) - 1) & 1;
    // Where they say nothing, they are even, and so are all parts.
    if (std::ssize(needs) < kLeastNeeds) needs = {};
    const auto along = [axis](const SkyNeed& need) { return axis == 0 ? need.u : need.v; };
    Part lower = part, upper = part;
    const float cut = needs.empty() ? 0.5f * (part.low[axis] + part.high[axis])
                                    : Median(needs, along, part, axis);
    lower.high[axis] = upper.low[axis] = cuts_[node] = cut;
    const auto middle = std::partition(needs.begin(), needs.end(),
                                       [&](const SkyNeed& need) { return along(need) < cut; });
    const auto below = std::size_t(middle - needs.begin());
    Cut(needs.first(below), lower, 2 * node);
    Cut(needs.subspan(below), upper, 2 * node + 1);
  }

 private:
  // Counts in bins, inside of which all is spread evenly: nothing is sorted.
  template <class Along>
  float Median(NeedSpan needs, const Along& along, const Part& part, std::uint32_t axis) const {
    constexpr int kBins = 32;
    const double low = part.low[axis], width = double(part.high[axis]) - low;
    std::uint64_t bins[kBins] = {};
    for (const SkyNeed& need : needs) {
      bins[std::clamp(int((along(need) - low) / width * kBins), 0, kBins - 1)] += need.weight;
    }
    const double even = even_ * part.area() / kBins;
    double left = 0.5 * (double(SumOf(needs)) * each_ + kBins * even);
    int bin = 0;
    const auto mass = [&] { return double(bins[bin]) * each_ + even; };
    for (; bin + 1 < kBins && mass() < left; ++bin) left -= mass();
    return float(low + width * (bin + std::clamp(left / mass(), 0.0, 1.0)) / kBins);
  }

  double even_, each_;
  float* cuts_;
};

// Puts needs in the order of their cells; cell c has [begin[c], begin[c + 1]).
std::vector<std::size_t> SortByCell(std::vector<SkyNeed>& needs) {
  std::vector<std::size_t> begin(kGuideCells + 1);
  for (const SkyNeed& need : needs) ++begin[need.cell + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<std::size_t> next = begin;
  std::vector<SkyNeed> sorted(needs.size());
  for (const SkyNeed& need : needs) sorted[next[need.cell]++] = need;
  needs = std::move(sorted);
  return begin;
}

// A map as it is, in more texels.
EnvironmentMap Finer(const EnvironmentMap& map, int factor) {
  const Image& from = map.latlong;
  EnvironmentMap finer = {.latlong = Image(from.width * factor, from.height * factor),
                          .map_from_world = map.map_from_world};
  for (int y = 0; y < finer.latlong.height; ++y) {
    for (int x = 0; x < finer.latlong.width; ++x) {
      std::copy_n(from.Pixel(x / factor, y / factor), 3, finer.latlong.Pixel(x, y));
    }
  }
  return finer;
}

// Of every texel: the cell of its centre, and how often light samples are in it.
struct TexelCells {
  std::vector<std::uint32_t> cell;
  std::vector<double> probability;
};
TexelCells FindTexelCells(const EnvironmentMap& map, const EnvStrategy& strategy) {
  const Image& image = map.latlong;
  const std::size_t width = std::size_t(image.width);
  TexelCells texels;
  texels.cell.resize(width * std::size_t(image.height));
  texels.probability.resize(texels.cell.size());
  tbb::parallel_for(0, image.height, [&](int y) {
    const auto n = std::uint32_t(image.width);
    const soa::Table<EscapeColumns> rows(n);
    for (std::uint32_t x = 0; x < n; ++x) {
      const auto world = WorldFromMap(
          DirectionOfUv((x + 0.5) / image.width, (y + 0.5) / image.height), map.map_from_world);
      rows->dir_x[x] = world[0], rows->dir_y[x] = world[1], rows->dir_z[x] = world[2];
      rows->pdf[x] = 1;
    }
    // Strategies that can emit do not look at surfaces.
    const SurfaceColumns surfaces = {};
    const PathColumns paths = {};
    strategy.EvaluateEscaped({.surfaces = surfaces, .ranges = {}, .materials = {}, .paths = paths},
                             n, 1, rows);
    const double solid_angle = RowSolidAngle(image.width, image.height, y);
    const std::size_t first = std::size_t(y) * width;
    soa::Table<DiskPlaceColumns> places(n);
    FindGuideCells(rows->dir_x, rows->dir_y, rows->dir_z, n, places->cell);
    std::copy_n(places->cell, n, &texels.cell[first]);
    for (std::uint32_t x = 0; x < n; ++x) {
      texels.probability[first + x] = double(rows->light_pdf[x]) * solid_angle;
    }
  });
  return texels;
}

// Mean luminance of each cell. A cell smaller than a texel may have no texel's centre: it gets the
// mean of all.
std::vector<double> CellRadiance(const Image& image, std::span<const std::uint32_t> cells) {
  std::vector<double> energy(kGuideCells), solid_angle(kGuideCells);
  double all = 0;
  for (int y = 0; y < image.height; ++y) {
    const double texel = RowSolidAngle(image.width, image.height, y);
    for (int x = 0; x < image.width; ++x) {
      const float* const rgb = image.Pixel(x, y);
      const std::uint32_t cell = cells[std::size_t(y) * std::size_t(image.width) + std::size_t(x)];
      double luminance = 0;
      for (int c = 0; c < 3; ++c) luminance += double(kLuminance[c]) * rgb[c];
      energy[cell] += luminance * texel, solid_angle[cell] += texel;
      all += luminance * texel;
    }
  }
  for (std::uint32_t cell = 0; cell < kGuideCells; ++cell) {
    energy[cell] =
        solid_angle[cell] > 0 ? energy[cell] / solid_angle[cell] : all / (4 * std::numbers::pi);
  }
  return energy;
}

}  // namespace

std::size_t EmissionGuide::bytes() const {
  return (cuts.size() + gain.size()) * sizeof(float) +
         (directions ? directions->table_bytes() : 0) +
         (map ? map->latlong.rgb.size() * sizeof(float) : 0);
}

EmissionGuideView EmissionGuide::view() const {
  return {.cuts = empty() ? nullptr : cuts.data(), .gain = gain.data()};
}

EmissionGuide MakeGuide(std::vector<SkyNeed> needs, std::span<const double> shares) {
  EmissionGuide guide;
  if (needs.empty()) return guide;
  const std::uint64_t most =
      std::max<std::uint64_t>(1, kMostMeans * (SumOf(needs) / std::uint64_t(needs.size())));
  for (SkyNeed& need : needs) need.weight = std::min(need.weight, most);
  const double all = double(SumOf(needs));
  const std::vector<std::size_t> begin = SortByCell(needs);
  guide.cuts.assign(kGuideCells * kGuideLeaves, 0);
  guide.gain.assign(kGuideCells, 1);
  tbb::parallel_for(0u, kGuideCells, [&](std::uint32_t cell) {
    const NeedSpan mine = NeedSpan(needs).subspan(begin[cell], begin[cell + 1] - begin[cell]);
    const double needed = double(SumOf(mine));
    // What is spread evenly is that of the whole: all the less, the more often a cell is drawn.
    double even = kUnguided;
    if (!shares.empty() && shares[cell] > 0) {
      const double drawn = kUnguided * shares[cell] + (1 - kUnguided) * needed / all;
      even = kUnguided * shares[cell] / drawn;
      guide.gain[cell] = float(drawn / shares[cell]);
    }
    const double each = needed > 0 ? (1 - even) / needed : 0;
    TreeCutter(even, each, &guide.cuts[cell * kGuideLeaves]).Cut(mine, {});
  });
  return guide;
}

EmissionGuide LearnEmission(const FrameView& frame, std::vector<std::unique_ptr<Worker>>& workers,
                            GuideCounts& counts) {
  const auto start = std::chrono::steady_clock::now();
  const EnvStrategy& strategy = *frame.emitter;
  const int factor = (kLeastColumns + frame.map->latlong.width - 1) / frame.map->latlong.width;
  std::unique_ptr<EnvironmentMap> finer;
  if (factor > 1) finer = std::make_unique<EnvironmentMap>(Finer(*frame.map, factor));
  const EnvironmentMap& map = finer ? *finer : *frame.map;
  TexelCells texels = FindTexelCells(map, strategy);
  const std::vector<double> radiance = CellRadiance(map.latlong, texels.cell);

  const FrameView pilot = PilotView(frame);
  const Tile tile = PilotTile(pilot);
  const std::uint64_t total =
      std::uint64_t(tile.width) * tile.height * pilot.options.samples_per_pixel;
  const std::uint64_t wave = pilot.options.wave;
  std::vector<std::vector<SkyNeed>> waves((total + wave - 1) / wave);
  tbb::parallel_for(std::size_t{0}, waves.size(), [&](std::size_t i) {
    const FlushDenormals flush;
    Worker& worker = *workers[OwnWorker(frame.options, workers)];
    const RenderStats stats = worker.stats;
    const WaveRange range = {
        .tile = tile,
        .first = i * wave,
        .count = std::uint32_t(std::min<std::uint64_t>(wave, total - i * wave))};
    TracePilotWave(pilot, range, radiance, worker, waves[i]);
    worker.stats = stats;
  });
  std::vector<SkyNeed> needs;
  for (const std::vector<SkyNeed>& some : waves) {
    needs.insert(needs.end(), some.begin(), some.end());
  }
  counts.paths = total, counts.needs = needs.size();

  // Lights that stand for parts of the map are drawn by nobody but their strategy.
  std::vector<double> shares;
  if (strategy.unbiased()) {
    shares.resize(kGuideCells);
    for (std::size_t i = 0; i < texels.cell.size(); ++i) {
      shares[texels.cell[i]] += texels.probability[i];
    }
  }
  EmissionGuide guide = MakeGuide(std::move(needs), shares);
  if (!guide.empty() && strategy.unbiased()) {
    for (std::size_t i = 0; i < texels.cell.size(); ++i) {
      texels.probability[i] *= double(guide.gain[texels.cell[i]]);
    }
    guide.directions = std::make_unique<ImportanceStrategy>(map, texels.probability);
    guide.map = std::move(finer);
  }
  counts.bytes = guide.bytes();
  counts.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return guide;
}

}  // namespace skywave
