#include "lights/light_sets/penrose.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "lights/light_sets/penrose_corrections.h"

namespace skywave {
namespace {

struct Candidate {
  BornSample born;
  std::uint32_t texel;
  double mag;  // the least with which it is taken
};

// Returns the next of a sequence of well-mixed numbers in [0, 1) (Steele, Lea and Flood 2014,
// SplitMix).
double NextUniform(std::uint64_t& state) {
  std::uint64_t z = state += 0x9E3779B97F4A7C15u;
  z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
  z = (z ^ z >> 27) * 0x94D049BB133111EBu;
  return double((z ^ z >> 31) >> 11) * 0x1p-53;
}

// A rhombus surrounds the map in a generic position: with the map along its axes whole rows of
// samples would lie on texel borders.
struct Seed {
  Complex origin, axis;
  double unit_side;
};

Seed PlaceSeed(int width, int height, std::uint64_t seed) {
  std::uint64_t state = seed;
  const double turn = 360 * NextUniform(state), grow = std::pow(kPhi, NextUniform(state));
  const double shift_x = NextUniform(state) - 0.5, shift_y = NextUniform(state) - 0.5;
  // The inscribed circle, of radius phi sin(72) / 2 units, holds the map with room for the shift.
  const double inner = kPhi * std::sin(72 * std::numbers::pi / 180) / 2;
  const double radius = std::hypot(width, height) / 2, room = 0.05 * radius;
  Seed result;
  result.unit_side = (radius + room) / inner * grow;
  result.axis = Polar(result.unit_side, turn);
  const Complex centre = {width / 2.0 + shift_x * room, height / 2.0 + shift_y * room};
  result.origin = centre - kPhi * kPhi / 2 * result.axis;
  return result;
}

class Collector {
 public:
  Collector(const MaxPyramid& importance, double mag, double xi)
      : importance_(importance), mag_(mag), xi_(xi) {}

  void Visit(const PlacedTile& tile) {
    if (tile.type == PenroseTile::kA) {
      Consider(tile);
      return;
    }
    if (tile.level >= kMaxPenroseLevel) return;
    // Every sample born below this tile has a further digit, worth F(2 level + 2) or more.
    const double least = double(tile.value + Fibonacci(2 * tile.level + 2));
    if (!(mag_ * importance_.Bound(BoxOf(tile)) >= least - xi_)) return;
    std::array<PlacedTile, 4> children;
    const int count = Subdivide(tile, children);
    for (int i = 0; i < count; ++i) Visit(children[i]);
  }

  std::vector<Candidate> candidates;

 private:
  // Returns the texels that the triangle touches and a little more, since rounding may put a sample
  // outside it.
  static Region BoxOf(const PlacedTile& tile) {
    const std::array<Complex, 3> p = Corners(tile);
    const auto low = [](double a, double b, double c) {
      return int(std::floor(std::clamp(std::min({a, b, c}) - 1e-6, -1e6, 1e6)));
    };
    const auto high = [](double a, double b, double c) {
      return int(std::floor(std::clamp(std::max({a, b, c}) + 1e-6, -1e6, 1e6))) + 1;
    };
    return {low(p[0].re, p[1].re, p[2].re), low(p[0].im, p[1].im, p[2].im),
            high(p[0].re, p[1].re, p[2].re), high(p[0].im, p[1].im, p[2].im)};
  }

  void Consider(const PlacedTile& tile) {
    const double x = std::floor(tile.origin.re), y = std::floor(tile.origin.im);
    if (!(x >= 0 && x < importance_.width() && y >= 0 && y < importance_.height())) return;
    const double importance = importance_.At(int(x), int(y));
    if (!(mag_ * importance >= double(tile.value) - xi_)) return;
    candidates.push_back({{tile.origin, tile.axis, tile.value, tile.level},
                          std::uint32_t(y) * std::uint32_t(importance_.width()) + std::uint32_t(x),
                          (double(tile.value) - xi_) / importance});
  }

  const MaxPyramid& importance_;
  double mag_, xi_;
};

std::vector<Candidate> Collect(const MaxPyramid& importance, double mag,
                               const PenroseParameters& parameters) {
  Collector collector(importance, mag, parameters.xi);
  const Seed seed = PlaceSeed(importance.width(), importance.height(), parameters.seed);
  for (const PlacedTile& tile : SeedRhombus(seed.origin, seed.axis)) collector.Visit(tile);
  std::sort(collector.candidates.begin(), collector.candidates.end(),
            [](const Candidate& a, const Candidate& b) {
              if (a.mag != b.mag) return a.mag < b.mag;
              return a.born.value != b.born.value ? a.born.value < b.born.value : a.texel < b.texel;
            });
  return std::move(collector.candidates);
}

// Converts a point of the plane to (u, v): it wraps at the seam and is reflected at the poles.
void PlaceInMap(Complex p, int width, int height, PenroseSample& sample) {
  double u = p.re / width, v = std::fmod(std::abs(p.im / height), 2.0);
  u -= std::floor(u);
  if (v > 1) v = 2 - v;
  const double below_one = std::nextafter(1.0, 0.0);
  sample.u = std::min(u, below_one);
  sample.v = std::min(v, below_one);
}

PenroseSet Finish(const MaxPyramid& importance, const std::vector<Candidate>& candidates,
                  double mag, bool relax) {
  PenroseSet set = {.samples = {}, .mag = mag};
  for (const Candidate& candidate : candidates) {
    PenroseSample sample = {};
    sample.texel = candidate.texel;
    sample.value = candidate.born.value;
    sample.importance = mag * importance.levels[0].value[candidate.texel];
    Complex position = candidate.born.position;
    if (relax) {
      position = position +
                 PenroseCorrection(DefaultPenroseCorrections(), candidate.born, sample.importance);
    }
    PlaceInMap(position, importance.width(), importance.height(), sample);
    set.samples.push_back(sample);
  }
  return set;
}

void CheckParameters(const PenroseParameters& parameters) {
  if (!(parameters.xi >= 0 && parameters.xi < 1)) throw InputError({}, "xi must be in [0, 1)");
}

}  // namespace

PenroseSet PenroseSamples(const MaxPyramid& importance, int count,
                          const PenroseParameters& parameters) {
  CheckParameters(parameters);
  if (count < 1) throw InputError({}, "Penrose sampling needs at least one sample");
  if (!(importance.sum > 0)) return {};
  const double area = PenroseRhombusArea(importance.width(), importance.height(), parameters);
  const double deepest = double(Fibonacci(2 * kMaxPenroseLevel));
  // A few more than requested are collected: counts differ from the closed form by about their
  // square root.
  double mag = (count + std::sqrt(double(count)) + 2) * area / importance.sum;
  std::vector<Candidate> candidates = Collect(importance, mag, parameters);
  while (candidates.size() < std::size_t(count) && mag * importance.maximum() < deepest) {
    mag *= 1.25;
    candidates = Collect(importance, mag, parameters);
  }
  if (candidates.empty()) return {};
  candidates.resize(std::min(candidates.size(), std::size_t(count)));
  return Finish(importance, candidates, candidates.back().mag, parameters.relax);
}

PenroseSet PenroseSamplesAtMag(const MaxPyramid& importance, double mag,
                               const PenroseParameters& parameters) {
  CheckParameters(parameters);
  if (!(mag >= 0 && std::isfinite(mag))) {
    throw InputError({}, "the scale of the importance must be finite and not negative");
  }
  return Finish(importance, Collect(importance, mag, parameters), mag, parameters.relax);
}

double PenroseRhombusArea(int width, int height, const PenroseParameters& parameters) {
  return RhombusArea(PlaceSeed(width, height, parameters.seed).unit_side);
}

std::vector<Vector3> Directions(const PenroseSet& set) {
  std::vector<Vector3> directions;
  for (const PenroseSample& sample : set.samples) {
    directions.push_back(DirectionOfUv(sample.u, sample.v));
  }
  return directions;
}

}  // namespace skywave
