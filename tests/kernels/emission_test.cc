// Tests the rays that leave lights: their origins, directions, densities and flux.

#include "kernels/light_paths/emission.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "tests/support/random_rows.h"
#include "tests/support/statistics.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr std::uint32_t kSamples = 40000;
const SceneSphere kSphere = {.center = {1, -2, 3}, .radius = 5};

// Returns one light of each kind, in the order of the kinds, then a two-sided triangle.
std::vector<LocalLight> Lights() {
  const auto light = [](LocalLightKind kind, std::initializer_list<float> emission) {
    LocalLight l = {.kind = kind};
    std::copy(emission.begin(), emission.end(), l.emission);
    l.position[0] = 2, l.position[1] = 1, l.position[2] = -3;
    return l;
  };
  const Vec axis = {1, 0.5, 0.2}, edge = {-0.3, 0.8, 1}, to = Unit({0.4, -0.7, 0.5});
  const auto put = [](Vec v, float* at) {
    at[0] = float(v.x), at[1] = float(v.y), at[2] = float(v.z);
  };
  std::vector<LocalLight> lights;
  for (const bool both : {false, true}) {
    LocalLight l = light(LocalLightKind::kTriangle, {3, 2, 1});
    put(axis, l.axis), put(edge, l.edge);
    l.area = float(0.5 * Length(Cross(axis, edge)));
    l.two_sided = both, l.triangle = both ? 70 : 50;
    lights.push_back(l);
  }
  lights.push_back(light(LocalLightKind::kPoint, {5, 4, 3}));
  lights.push_back(light(LocalLightKind::kSpot, {9, 7, 8}));
  put(to, lights.back().axis);
  lights.back().edge[0] = 0.7f, lights.back().edge[1] = 1 / (0.95f - 0.7f);
  lights.push_back(light(LocalLightKind::kDistant, {0.2f, 0.3f, 0.1f}));
  put(to, lights.back().axis);
  return lights;
}
enum Row { kOneSided, kBothSides, kPoint, kSpot, kDistant };

// Returns the power of a light in the red channel, computed by hand.
double PowerOf(std::uint32_t row) {
  const LocalLight light = Lights()[row];
  const double e = light.emission[0];
  switch (row) {
    case kOneSided:
      return kPi * e * light.area;
    case kBothSides:
      return 2 * kPi * e * light.area;
    case kPoint:
      return 4 * kPi * e;
    case kSpot:
      // The falloff is symmetric in the cosine, so the range between the cones contributes half.
      return 2 * kPi * e * (1 - 0.5 * (0.95 + 0.7));
    default:
      return kPi * 25 * e;
  }
}

Vec Of(const float* v) { return {v[0], v[1], v[2]}; }

struct Emitted {
  explicit Emitted(std::uint32_t n) : rays(n), emission(n), places(n) {}
  Vec Origin(std::uint32_t i) const { return Get(i, rays->org_x, rays->org_y, rays->org_z); }
  Vec Direction(std::uint32_t i) const { return Get(i, rays->dir_x, rays->dir_y, rays->dir_z); }
  std::vector<std::uint32_t> Bits(std::uint32_t n) const {
    auto bits = ColumnBits(rays.columns(), n);
    for (const auto& more : {ColumnBits(emission.columns(), n)}) {
      bits.insert(bits.end(), more.begin(), more.end());
    }
    return bits;
  }
  soa::Table<RayColumns> rays;
  soa::Table<EmissionColumns> emission;
  soa::Table<HitColumns> places;
};

// Returns rays of light `row` alone, which half of all uniforms select.
Emitted EmitOf(std::uint32_t row, std::uint32_t n, std::uint32_t seed) {
  const std::vector<LocalLight> lights = Lights();
  const std::uint32_t first[] = {0, kChoiceUnits / 2};
  const LocalLightView view = {.lights = &lights[row], .count = 1};
  auto pick = RandomUniforms(n, seed);
  const auto aim = RandomUniforms(n, seed + 1);
  for (std::uint32_t i = 0; i < n; ++i) pick->u[i] *= 0.5f;
  Emitted e(n);
  EmitFromLocalLights(view, {.first = first, .share = 0.5f}, kSphere, pick, aim, n, e.rays,
                      e.emission, e.places);
  return e;
}

// Tests whether pairs of numbers in [0, 1) are uniform and independent by counting in cells.
testing::AssertionResult AreUniform(
    std::uint32_t n, const std::function<std::pair<double, double>(std::uint32_t)>& at) {
  constexpr int kSide = 12;
  std::vector<double> observed(kSide * kSide);
  const std::vector<double> expected(kSide * kSide, double(n) / (kSide * kSide));
  const auto bin = [](double x) { return std::clamp(int(x * kSide), 0, kSide - 1); };
  for (std::uint32_t i = 0; i < n; ++i) {
    const auto [x, y] = at(i);
    if (!(x > -1e-4 && x < 1 + 1e-4 && y > -1e-4 && y < 1 + 1e-4)) {
      return testing::AssertionFailure() << "(" << x << ", " << y << ") in row " << i;
    }
    ++observed[std::size_t(bin(x) * kSide + bin(y))];
  }
  return MatchesExpected(observed, expected, SidakLevel(12));
}

double Turn(Vec d, Vec axis) {
  const Vec s = Unit(Cross(axis, {0.3, 0.2, 0.9})), t = Cross(axis, s);
  return std::atan2(Dot(d, t), Dot(d, s)) / (2 * kPi) + 0.5;
}

// Returns the position on the disk in front of the sphere: the area fraction within the radius, and
// the azimuth.
std::pair<double, double> OnDisk(Vec origin, Vec towards) {
  const Vec from = origin - Of(kSphere.center);
  const Vec across = from - Dot(from, towards) * towards;
  return {Dot(across, across) / 25, Turn(across, towards)};
}

class LightRays : public testing::TestWithParam<std::uint32_t> {};

TEST_P(LightRays, CarryThePowerOfTheLight) {
  const std::uint32_t row = GetParam();
  const Emitted e = EmitOf(row, kSamples, 201);
  Moments flux;
  for (std::uint32_t i = 0; i < kSamples; ++i) flux.Add(e.rays->throughput_r[i]);
  // Half of the paths select the light, so they carry twice its power.
  EXPECT_TRUE(
      AgreesWith(flux.mean(), flux.standard_error(), 2 * PowerOf(row), SidakLevel(5), 1e-5));
}

TEST_P(LightRays, MatchTheRecord) {
  const std::uint32_t row = GetParam();
  const LocalLight light = Lights()[row];
  const Emitted e = EmitOf(row, kSamples, 203);
  const Vec normal = Unit(Cross(Of(light.axis), Of(light.edge)));
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    const Vec d = e.Direction(i);
    ASSERT_NEAR(Length(d), 1, 1e-5);
    double position = 1, direction = 1, cosine = 1, radiance = light.emission[0];
    std::uint32_t delta = 0;
    if (row == kOneSided || row == kBothSides) {
      cosine = std::fabs(Dot(d, normal));
      position = 1 / double(light.area);
      direction = cosine / kPi / (row == kBothSides ? 2 : 1);
      radiance *= cosine;
      ASSERT_EQ(e.places->geom[i], 0u);
      ASSERT_EQ(e.places->triangle[i], light.triangle);
      const Vec ng = Get(i, e.places->ng_x, e.places->ng_y, e.places->ng_z);
      ASSERT_GT(Dot(ng, d), 0);
      ASSERT_NEAR(std::fabs(Dot(ng, normal)), 1, 1e-6);
      const Vec point =
          Of(light.position) + e.places->u[i] * Of(light.axis) + e.places->v[i] * Of(light.edge);
      ASSERT_LT(Length(e.Origin(i) - point), 1e-4);
      ASSERT_GT(Dot(e.Origin(i) - point, ng), 0);
    } else {
      ASSERT_EQ(e.places->geom[i], kNoHit);
    }
    if (row == kPoint) direction = 1 / (4 * kPi), delta = kDeltaPosition;
    if (row == kSpot) {
      direction = 1 / (2 * kPi * (1 - 0.7f)), delta = kDeltaPosition;
      const double t = std::clamp((Dot(d, Of(light.axis)) - 0.7f) / (0.95 - 0.7), 0.0, 1.0);
      radiance *= t * t * (3 - 2 * t);
    }
    if (row == kDistant) position = 1 / (25 * kPi), delta = kDeltaDirection;
    const double pdf = 0.5 * position * direction;
    ASSERT_NEAR(e.emission->pdf[i], pdf, 2e-5 * pdf + 1e-7) << "row " << i;
    const double light_pdf = row == kOneSided || row == kBothSides ? 0.5 * position : 0.5;
    ASSERT_NEAR(e.emission->light_pdf[i], light_pdf, 1e-5 * light_pdf);
    ASSERT_NEAR(e.emission->cosine[i], cosine, 1e-5);
    ASSERT_EQ(e.emission->delta[i], delta);
    ASSERT_EQ(e.emission->light[i], 0u);
    ASSERT_NEAR(e.rays->pdf[i], row == kDistant ? 0 : direction, 1e-5 * direction + 1e-6);
    const double flux = radiance / pdf;
    ASSERT_NEAR(e.rays->throughput_r[i], flux, 1e-4 * flux + 1e-3);
    ASSERT_NEAR(e.rays->throughput_b[i] * light.emission[0],
                e.rays->throughput_r[i] * light.emission[2], 1e-4 * flux);
    ASSERT_EQ(e.rays->t_far[i], flux > 1e-9 ? kInfinity : e.rays->t_far[i]);
    ASSERT_EQ(e.rays->path[i], i);
  }
}

TEST_P(LightRays, LeaveWithTheReportedDensity) {
  const std::uint32_t row = GetParam();
  const LocalLight light = Lights()[row];
  const Emitted e = EmitOf(row, kSamples, 205);
  const Vec normal = Unit(Cross(Of(light.axis), Of(light.edge))), axis = Of(light.axis);
  if (row == kOneSided || row == kBothSides) {
    // A triangle maps to a square with uniform density (the inverse of Turk's first map).
    EXPECT_TRUE(AreUniform(kSamples, [&](std::uint32_t i) {
      const double a = e.places->u[i], b = e.places->v[i];
      return std::pair(a + b < 1 ? std::pow(1 - a, 2) : 0, b / std::max(1 - a, 1e-9));
    }));
    EXPECT_TRUE(AreUniform(kSamples, [&](std::uint32_t i) {
      const Vec d = e.Direction(i);
      const double cosine = Dot(d, normal), area = 1 - cosine * cosine;
      if (row == kOneSided) return std::pair(cosine > 0 ? area : 2, Turn(d, normal));
      return std::pair(cosine > 0 ? 0.5 * area : 1 - 0.5 * area, Turn(d, normal));
    }));
    // Position and direction are independent.
    EXPECT_TRUE(AreUniform(kSamples, [&](std::uint32_t i) {
      return std::pair(std::pow(1 - double(e.places->u[i]), 2), Turn(e.Direction(i), normal));
    }));
    return;
  }
  if (row == kDistant) {
    for (std::uint32_t i = 0; i < kSamples; ++i) {
      ASSERT_LT(Length(e.Direction(i) + axis), 1e-6);
      // The origin is outside the sphere.
      ASSERT_GT(Dot(e.Origin(i) - Of(kSphere.center), axis), 5 - 1e-5);
    }
    EXPECT_TRUE(AreUniform(kSamples, [&](std::uint32_t i) { return OnDisk(e.Origin(i), axis); }));
    return;
  }
  const double lowest = row == kSpot ? 0.7f : -1;
  EXPECT_TRUE(AreUniform(kSamples, [&](std::uint32_t i) {
    const Vec d = e.Direction(i), about = row == kSpot ? axis : Vec{0, 0, 1};
    return std::pair((Dot(d, about) - lowest) / (1 - lowest), Turn(d, about));
  }));
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    ASSERT_EQ(Length(e.Origin(i) - Of(light.position)), 0);
  }
}

constexpr const char* kLightNames[] = {"OneSided", "BothSides", "Point", "Spot", "Distant"};
INSTANTIATE_TEST_SUITE_P(All, LightRays, testing::Range(0u, 5u),
                         [](const testing::TestParamInfo<std::uint32_t>& row) {
                           return std::string(kLightNames[row.param]);
                         });

// With all lights together, each is selected as often as the choice demands, and the rest is left
// to the environment.
TEST(LightRaysOfAll, ArePickedWithTheReportedProbability) {
  const std::vector<LocalLight> lights = Lights();
  const std::uint32_t first[] = {0,
                                 kChoiceUnits / 16,
                                 kChoiceUnits / 4,
                                 kChoiceUnits / 4 + 1,
                                 kChoiceUnits / 2,
                                 3 * (kChoiceUnits / 4)};
  const LocalLightView view = {.lights = lights.data(), .count = 5};
  const LightChoice choice = {.first = first, .share = 0.75f};
  const auto pick = RandomUniforms(kSamples, 211), aim = RandomUniforms(kSamples, 212);
  Emitted e(kSamples);
  FillWithGarbage(e.rays.columns(), kSamples);
  std::fill_n(e.emission->light, kSamples, 99u);
  EmitFromLocalLights(view, choice, kSphere, pick, aim, kSamples, e.rays, e.emission, e.places);
  std::vector<Moments> flux(5);
  std::vector<double> observed(6), expected(6);
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    const auto unit = std::uint32_t(pick->u[i] * float(kChoiceUnits));
    if (unit >= first[5]) {
      ++observed[5];
      ASSERT_EQ(e.emission->light[i], 99u);
      ASSERT_TRUE(std::isnan(e.rays->org_x[i]));
      ASSERT_EQ(e.places->geom[i], kNoHit);
      continue;
    }
    const auto row = std::uint32_t(std::upper_bound(first, first + 6, unit) - first) - 1;
    ASSERT_EQ(e.emission->light[i], row);
    ASSERT_EQ(e.places->geom[i], row <= kBothSides ? 0 : kNoHit);
    ++observed[row], flux[row].Add(e.rays->throughput_r[i]);
  }
  for (std::uint32_t row = 0; row < 6; ++row) {
    const std::uint32_t end = row < 5 ? first[row + 1] : kChoiceUnits;
    const double probability = double(end - first[row]) / kChoiceUnits;
    expected[row] = kSamples * probability;
    if (row == kPoint || row == 5) continue;  // hardly ever chosen, and the environment
    // Where all rays of a light carry the same flux, only rounding is left.
    EXPECT_TRUE(AgreesWith(probability * flux[row].mean(), probability * flux[row].standard_error(),
                           PowerOf(row), SidakLevel(5), 1e-5 * PowerOf(row)))
        << row;
  }
  EXPECT_TRUE(MatchesExpected(observed, expected, SidakLevel(5), /*strays=*/1));
}

// Light samples of an environment: some have a density, some are directional, some found nothing.
struct EnvironmentSamples {
  explicit EnvironmentSamples(std::uint32_t n) : samples(n) {
    Random random(221);
    for (std::uint32_t i = 0; i < n; ++i) {
      Put(random.Direction(), i, samples->dir_x, samples->dir_y, samples->dir_z);
      samples->r[i] = random.Float(), samples->g[i] = 2, samples->b[i] = 3;
      samples->pdf[i] = i % 3 == 0 ? kInfinity : i % 17 == 0 ? 0 : 0.1f + random.Float();
    }
  }
  soa::Table<LightColumns> samples;
};

TEST(EnvironmentRays, MatchTheSamples) {
  const EnvironmentSamples environment(kSamples);
  const auto disk = RandomUniforms(kSamples, 222);
  Emitted e(kSamples);
  EmitFromEnvironment(kSphere, environment.samples, disk, kSamples, e.rays, e.emission);
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    const LightColumns& s = environment.samples;
    const Vec towards = Get(i, s.dir_x, s.dir_y, s.dir_z);
    ASSERT_EQ(Length(e.Direction(i) + towards), 0);
    ASSERT_GT(Dot(e.Origin(i) - Of(kSphere.center), towards), 5 - 1e-5);
    const bool directional = s.pdf[i] == kInfinity, drawn = s.pdf[i] > 0;
    const double density = directional ? 1 : s.pdf[i];
    ASSERT_EQ(e.rays->t_far[i] > 0, drawn);
    if (!drawn) continue;
    ASSERT_NEAR(e.rays->throughput_g[i], 2 * 25 * kPi / density, 1e-4 / density);
    ASSERT_NEAR(e.emission->pdf[i], density / (25 * kPi), 1e-6 * density);
    ASSERT_EQ(e.emission->light_pdf[i], float(density));
    ASSERT_EQ(e.rays->pdf[i], directional ? 0 : s.pdf[i]);
    ASSERT_EQ(e.emission->cosine[i], 1);
    ASSERT_EQ(e.emission->light[i], kNoLight);
    ASSERT_EQ(e.emission->delta[i], directional ? kDeltaDirection : 0);
  }
  EXPECT_TRUE(
      AreUniform(kSamples, [&](std::uint32_t i) { return OnDisk(e.Origin(i), -e.Direction(i)); }));
}

// Environment rays may start as close as the box permits, but on the same lines and with the same
// light.
TEST(EnvironmentRays, BeginWhereTheyEnterTheBox) {
  SceneSphere boxed = kSphere;
  const double low[3] = {-3, -0.1, -3.9}, high[3] = {3, 0.4, 3.9};
  for (int axis = 0; axis < 3; ++axis) {
    boxed.low[axis] = boxed.center[axis] + float(low[axis]);
    boxed.high[axis] = boxed.center[axis] + float(high[axis]);
  }
  const EnvironmentSamples environment(kSamples);
  const auto disk = RandomUniforms(kSamples, 222);
  Emitted from_disk(kSamples), from_box(kSamples);
  EmitFromEnvironment(kSphere, environment.samples, disk, kSamples, from_disk.rays,
                      from_disk.emission);
  EmitFromEnvironment(boxed, environment.samples, disk, kSamples, from_box.rays, from_box.emission);
  std::uint32_t entered = 0;
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    const Vec dir = from_disk.Direction(i), before = from_disk.Origin(i);
    const Vec shift = from_box.Origin(i) - before;
    ASSERT_EQ(Length(from_box.Direction(i) - dir), 0);
    ASSERT_LT(Length(shift - Dot(shift, dir) * dir), 1e-5) << "row " << i;
    ASSERT_GE(Dot(shift, dir), -1e-5);
    ASSERT_EQ(from_box.emission->pdf[i], from_disk.emission->pdf[i]);
    double enters = 0, leaves = 10;
    const double org[3] = {before.x, before.y, before.z}, along[3] = {dir.x, dir.y, dir.z};
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (double(boxed.low[axis]) - org[axis]) / along[axis];
      const double b = (double(boxed.high[axis]) - org[axis]) / along[axis];
      enters = std::max(enters, std::min(a, b)), leaves = std::min(leaves, std::max(a, b));
    }
    if (enters >= leaves) continue;
    ASSERT_NEAR(Dot(shift, dir), enters, 1e-5 / std::fabs(dir.y)) << "row " << i;
    ++entered;
  }
  EXPECT_GT(entered, kSamples / 10);
}

TEST(Emission, BitsDoNotDependOnTargetOrNumberOfRows) {
  const EnvironmentSamples environment(kFullWave);
  const std::vector<LocalLight> lights = Lights();
  const std::uint32_t first[] = {0,
                                 kChoiceUnits / 8,
                                 kChoiceUnits / 4,
                                 3 * (kChoiceUnits / 8),
                                 kChoiceUnits / 2,
                                 3 * (kChoiceUnits / 4)};
  const LocalLightView view = {.lights = lights.data(), .count = 5};
  const auto pick = RandomUniforms(kFullWave, 231), aim = RandomUniforms(kFullWave, 232);
  const auto emit = [&](std::uint32_t n) {
    Emitted e(kFullWave);
    EmitFromEnvironment(kSphere, environment.samples, aim, n, e.rays, e.emission);
    EmitFromLocalLights(view, {.first = first, .share = 0.75f}, kSphere, pick, aim, n, e.rays,
                        e.emission, e.places);
    return e.Bits(n);
  };
  for (const std::uint32_t n : kRowCounts) ExpectSameOnEveryTarget([&] { return emit(n); });
}

}  // namespace
}  // namespace skywave
