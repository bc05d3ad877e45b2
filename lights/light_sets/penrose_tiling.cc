#include "lights/light_sets/penrose_tiling.h"

#include <algorithm>
#include <cassert>

namespace skywave {
namespace {

constexpr int kFibonacciCount = 2 * kMaxPenroseLevel + 3;

constexpr std::array<std::uint64_t, kFibonacciCount> kFibonacci = [] {
  std::array<std::uint64_t, kFibonacciCount> f = {0, 1};
  for (int i = 2; i < kFibonacciCount; ++i) f[i] = f[i - 1] + f[i - 2];
  return f;
}();

// A child adds these two digits to the code, as the thesis writes them (T 6.5).
enum class Digits : std::uint8_t { k00, k01, k10 };

struct Production {
  PenroseTile child;
  Digits digits;
  Complex origin;    // in the parent's basis
  Complex rotation;  // turn of the axis, with the shrinking by phi
};

struct Rule {
  int count = 0;
  std::array<Production, 4> children;
};

Production Produce(PenroseTile child, Digits digits, Complex origin, double turn) {
  return {child, digits, origin, Polar(1 / kPhi, turn)};
}

std::array<Rule, 6> MakeRules() {
  using enum PenroseTile;
  using enum Digits;
  const Complex p3_acute = Polar(kPhi, 72), p3_obtuse = Polar(kPhi, 36), unit36 = Polar(1, 36);
  const Complex one = {1, 0};
  std::array<Rule, 6> rules;
  rules[int(kA)] = {1, {Produce(kB, k00, {}, 0)}};
  rules[int(kB)] = {1, {Produce(kA, k00, {}, 180)}};
  rules[int(kC)] = {
      3,
      {Produce(kF, k00, p3_acute, 252), Produce(kC, k10, one, 108), Produce(kA, k10, unit36, 18)}};
  rules[int(kD)] = {2, {Produce(kE, k00, one, 108), Produce(kD, k10, one + Polar(1, 144), 252)}};
  rules[int(kE)] = {4,
                    {Produce(kF, k00, {}, 0), Produce(kC, k10, p3_obtuse, 216),
                     Produce(kE, k01, {kPhi * kPhi, 0}, 144), Produce(kA, k10, unit36, 126)}};
  rules[int(kF)] = {4,
                    {Produce(kE, k00, one, 0), Produce(kD, k10, one + unit36, 144),
                     Produce(kF, k01, p3_obtuse, 216), Produce(kA, k01, one, 270)}};
  return rules;
}

const std::array<Rule, 6>& Rules() {
  static const std::array<Rule, 6> rules = MakeRules();
  return rules;
}

}  // namespace

Complex Polar(double radius, double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

std::uint64_t Fibonacci(int n) { return kFibonacci[n]; }

std::array<Complex, 3> Corners(const PlacedTile& t) {
  static const Complex acute = Polar(kPhi, 72), obtuse = Polar(kPhi, 36);
  if (t.type == PenroseTile::kC || t.type == PenroseTile::kD) {
    return {t.origin, t.origin + t.axis, t.origin + t.axis * acute};
  }
  return {t.origin, t.origin + kPhi * kPhi * t.axis, t.origin + t.axis * obtuse};
}

int Subdivide(const PlacedTile& tile, std::array<PlacedTile, 4>& children) {
  const Rule& rule = Rules()[int(tile.type)];
  const int level = tile.level + 1;
  const std::uint64_t weight[3] = {0, kFibonacci[2 * level], kFibonacci[2 * level + 1]};
  for (int i = 0; i < rule.count; ++i) {
    const Production& p = rule.children[i];
    children[i] = {.type = p.child,
                   .origin = tile.origin + tile.axis * p.origin,
                   .axis = tile.axis * p.rotation,
                   .value = tile.value + weight[int(p.digits)],
                   .level = level};
  }
  return rule.count;
}

std::array<PlacedTile, 2> SeedRhombus(Complex origin, Complex axis) {
  return {PlacedTile{PenroseTile::kF, origin, axis, 0, 0},
          PlacedTile{PenroseTile::kE, origin + kPhi * kPhi * axis, -1.0 * axis, 0, 0}};
}

double RhombusArea(double unit_side) {
  static const double area = kPhi * kPhi * kPhi * std::sin(std::numbers::pi / 5);
  return area * unit_side * unit_side;
}

int LevelOfImportance(double x) {
  int level = 0;
  while (level < kMaxPenroseLevel && double(kFibonacci[2 * level + 2] - 1) < std::floor(x)) ++level;
  return level;
}

double LevelAndPhase(double x) {
  static const double scale = 1 / (2 * std::log(kPhi));
  return std::log1p(std::sqrt(5.0) * x) * scale;
}

int StructuralClass(std::uint64_t value, int level) {
  int result = 0;
  // Greedy division gives the code back, because codes have no two neighbouring ones (Zeckendorf).
  const int top = 2 * level + 1;
  assert(value < kFibonacci[top + 1]);
  for (int j = top; j > top - 6 && j >= 2; --j) {
    if (value < kFibonacci[j]) continue;
    value -= kFibonacci[j];
    result += int(kFibonacci[j - top + 7]);
  }
  return result;
}

int BirthLevel(std::uint64_t value) {
  int level = 1;
  while (kFibonacci[2 * level + 2] <= value) ++level;
  return level;
}

Complex BasisAtLevel(Complex axis, int birth, int level) {
  const int steps = level - birth;
  const double sign = steps / 2 % 2 == 0 ? 1 : -1;
  return sign * std::pow(kPhi, -steps) * axis;
}

}  // namespace skywave
