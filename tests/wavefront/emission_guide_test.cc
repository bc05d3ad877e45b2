// Tests the table that guides light paths of the environment: places on the disk and back, their
// densities, and the table made from guide samples.
#include "kernels/light_paths/emission_guide.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "tests/support/random_rows.h"
#include "tests/support/statistics.h"
#include "tests/support/targets.h"
#include "wavefront/records/emission_guide.h"
#include "wavefront/scratch.h"

namespace skywave {
namespace {

constexpr std::uint32_t kRows = 40000;
const SceneSphere kSphere = {.center = {1, -2, 3}, .radius = 5};

// Most samples are in a small spot of the square and in a strip, different ones for different
// cells.
std::vector<GuideSample> SomeGuideSamples(std::uint32_t count) {
  std::vector<GuideSample> samples;
  Random random(31);
  for (std::uint32_t i = 0; i < count; ++i) {
    GuideSample sample = {.cell = random.Word() % (kGuideCells / 2)};
    sample.weight = 1 + random.Word() % 1000;
    const float turn = float(sample.cell) / float(kGuideCells);
    if (i % 2 == 0) {
      sample.u = 0.2f + turn + 0.01f * random.Float(), sample.v = 0.3f + 0.02f * random.Float();
    } else if (i % 3 != 0) {
      sample.u = random.Float(), sample.v = 0.8f + 0.05f * random.Float();
    } else {
      sample.u = random.Float(), sample.v = random.Float();
    }
    // Points lie in a ball of radius 1 about (2, -2, 3), with a few elsewhere.
    const Vec point =
        Vec{2, -2, 3} + (i % 50 == 0 ? 3.0 : 1.0) * random.Float() * random.Direction();
    Put(point, 0, sample.point, sample.point + 1, sample.point + 2);
    samples.push_back(sample);
  }
  return samples;
}
std::vector<double> SomeShares() {
  std::vector<double> shares(kGuideCells);
  for (std::uint32_t i = 0; i < kGuideCells; ++i) shares[i] = i % 7 == 0 ? 0 : 1 + i % 5;
  const double sum = std::accumulate(shares.begin(), shares.end(), 0.0);
  for (double& share : shares) share /= sum;
  return shares;
}
const EmissionGuide& Guide() {
  static const EmissionGuide guide = MakeGuide(SomeGuideSamples(40000), SomeShares(), kSphere);
  return guide;
}

// A leaf of a tree, reconstructed independently.
struct Leaf {
  double low[2] = {0, 0}, high[2] = {1, 1};
  double Area() const { return (high[0] - low[0]) * (high[1] - low[1]); }
};
void AddLeaves(const float* cuts, std::uint32_t node, int axis, const Leaf& part,
               std::vector<Leaf>& leaves) {
  if (node >= kGuideLeaves) {
    leaves.push_back(part);
    return;
  }
  Leaf lower = part, upper = part;
  lower.high[axis] = upper.low[axis] = cuts[node];
  AddLeaves(cuts, 2 * node, 1 - axis, lower, leaves);
  AddLeaves(cuts, 2 * node + 1, 1 - axis, upper, leaves);
}
std::vector<Leaf> LeavesOf(const EmissionGuide& guide, std::uint32_t cell) {
  std::vector<Leaf> leaves;
  const GuideCell& c = guide.cells[cell];
  AddLeaves(&guide.cuts[cell * kGuideLeaves], 1, 0, {{c.low[0], c.low[1]}, {c.high[0], c.high[1]}},
            leaves);
  return leaves;
}

// Returns the direction of the centre of a cell.
Vec MiddleOf(std::uint32_t cell) {
  const double z = 2 * (cell / kGuideTurns + 0.5) / kGuideRows - 1;
  const double turn = (cell % kGuideTurns + 0.5) / kGuideTurns - 0.5;
  const double s = std::sqrt(1 - z * z);
  return {s * std::cos(2 * kPi * turn), s * std::sin(2 * kPi * turn), z};
}

struct Starts {
  explicit Starts(std::uint32_t n)
      : samples(n), rays(n), emission(n), crowding(n), arrival(n), u(n), v(n) {}
  soa::Table<LightColumns> samples;
  soa::Table<RayColumns> rays;
  soa::Table<EmissionColumns> emission;
  std::vector<double> crowding, arrival;  // derived from the flux and from the emission record
  std::vector<double> u, v;               // position on the disk
};

// Returns the point of the unit square that Shirley and Chiu's map takes to a point of the disc.
void SquareOf(double x, double y, double& u, double& v) {
  const double radius = std::hypot(x, y);
  const bool steep = std::fabs(y) > std::fabs(x);
  const double along = steep ? y : x, across = steep ? x : y;
  const double major = std::copysign(radius, along);
  const double minor = radius * std::atan2(across, std::fabs(along)) / (kPi / 4);
  u = 0.5 * ((steep ? minor : major) + 1), v = 0.5 * ((steep ? major : minor) + 1);
}

// Returns two axes of a disk, as in the kernels (Duff et al. 2017).
void AxesOf(Vec n, Vec& s, Vec& t) {
  const double sign = std::copysign(1.0, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
  s = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x};
  t = {b, sign + n.y * n.y * a, -n.y};
}

// Applies Shirley and Chiu's map, the inverse of SquareOf.
void DiscOf(double u, double v, double& x, double& y) {
  const double a = 2 * u - 1, b = 2 * v - 1;
  const bool steep = std::fabs(b) > std::fabs(a);
  const double major = steep ? b : a, minor = steep ? a : b;
  const double angle = major == 0 ? 0 : minor / major * kPi / 4;
  const double along = major * std::cos(angle), across = major * std::sin(angle);
  x = steep ? across : along, y = steep ? along : across;
}

// Returns true if the focus is on the line along `towards` that enters at (u, v).
bool HitsFocus(Vec towards, double u, double v) {
  double x, y;
  DiscOf(u, v, x, y);
  Vec s, t;
  AxesOf(towards, s, t);
  const SceneSphere& focus = Guide().focus;
  const Vec center = Vec{focus.center[0], focus.center[1], focus.center[2]} -
                     Vec{kSphere.center[0], kSphere.center[1], kSphere.center[2]};
  return std::hypot(5 * x - Dot(center, s), 5 * y - Dot(center, t)) < double(focus.radius);
}

// Returns rays for samples of radiance 1 and density 1/4 in all directions, or in the centre of a
// cell.
Starts StartAt(const EmissionGuide& guide, const UniformColumns& disk, std::uint32_t n, int cell) {
  Starts start(n);
  Random random(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    Put(cell < 0 ? random.Direction() : MiddleOf(std::uint32_t(cell)), i, start.samples->dir_x,
        start.samples->dir_y, start.samples->dir_z);
    start.samples->r[i] = start.samples->g[i] = start.samples->b[i] = 1;
    start.samples->pdf[i] = 0.25f;
  }
  EmitFromEnvironment(kSphere, start.samples, disk, n, start.rays, start.emission);
  GuideStarts(kSphere, guide.view(), disk, nullptr, n, start.rays, start.emission);
  for (std::uint32_t i = 0; i < n; ++i) {
    start.crowding[i] = kPi * 25 / 0.25 / double(start.rays->throughput_g[i]);
    start.arrival[i] = double(start.emission->pdf[i]) / 0.25;
    const Vec from = Get(i, start.rays->org_x, start.rays->org_y, start.rays->org_z) -
                     Vec{kSphere.center[0], kSphere.center[1], kSphere.center[2]};
    Vec s, t;
    AxesOf(Get(i, start.samples->dir_x, start.samples->dir_y, start.samples->dir_z), s, t);
    SquareOf(Dot(from, s) / 5, Dot(from, t) / 5, start.u[i], start.v[i]);
  }
  return start;
}
Starts StartOf(const EmissionGuide& guide, std::uint32_t n, std::uint32_t seed, int cell = -1) {
  return StartAt(guide, RandomUniforms(n, seed), n, cell);
}

TEST(GuideCells, AreEqualAndKnowTheirMiddles) {
  soa::Table<UniformColumns> xy(kRows), z(kRows);
  soa::Table<DiskPlaceColumns> places(kRows);
  for (std::uint32_t i = 0; i < kGuideCells; ++i) {
    Put(MiddleOf(i), i, xy->u, xy->v, z->u);
  }
  FindGuideCells(xy->u, xy->v, z->u, kGuideCells, places->cell);
  for (std::uint32_t i = 0; i < kGuideCells; ++i) ASSERT_EQ(places->cell[i], i);
  Random random(5);
  for (std::uint32_t i = 0; i < kRows; ++i) Put(random.Direction(), i, xy->u, xy->v, z->u);
  FindGuideCells(xy->u, xy->v, z->u, kRows, places->cell);
  std::vector<double> observed(kGuideCells);
  const std::vector<double> expected(kGuideCells, double(kRows) / kGuideCells);
  for (std::uint32_t i = 0; i < kRows; ++i) ++observed[places->cell[i]];
  EXPECT_TRUE(MatchesExpected(observed, expected, SidakLevel(1)));
}

// The place of a line on the disk is recovered from any of its points, wherever the surface lies
// and however far its origin was lifted.
TEST(LocateOnDisk, IsTheInverseOfEmission) {
  const std::uint32_t n = 5000;
  const Starts s = StartOf(Guide(), n, 11);
  soa::Table<SurfaceColumns> surfaces(n);
  soa::Table<DiskPlaceColumns> places(n);
  soa::Table<QueueColumns> rows(n);
  Random random(12);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t row = n - 1 - i;
    const Vec ng = random.Direction();
    const double lift = 0.1 * random.Float();
    const Vec hit = Get(i, s.rays->org_x, s.rays->org_y, s.rays->org_z) +
                    random.Between(0, 10) * Get(i, s.rays->dir_x, s.rays->dir_y, s.rays->dir_z);
    Put(ng, row, surfaces->ng_x, surfaces->ng_y, surfaces->ng_z);
    Put(hit + lift * ng, row, surfaces->org_x, surfaces->org_y, surfaces->org_z);
    surfaces->lift[row] = float(lift);
    rows->queue[i] = row;
  }
  const EnvironmentLines lines = {s.samples->dir_x, s.samples->dir_y, s.samples->dir_z, surfaces,
                                  rows->queue};
  LocateOnDisk(kSphere, lines, n, places);
  std::vector<float> arrival(PaddedRows(n));
  EnvironmentArrivals(kSphere, Guide().view(), lines, n, arrival.data());
  std::uint32_t off = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    ASSERT_NEAR(places->u[i], s.u[i], 2e-5) << i;
    ASSERT_NEAR(places->v[i], s.v[i], 2e-5) << i;
    // On the other side of a cut, the value is that of another leaf.
    off += std::fabs(double(arrival[i]) - s.arrival[i]) > 1e-5 * s.arrival[i];
  }
  EXPECT_LT(off, n / 500);
}

TEST(EnvironmentArrivals, AreEvenWithoutAGuide) {
  soa::Table<SurfaceColumns> surfaces(8);
  soa::Table<LightColumns> lights(8);
  std::vector<float> arrival(PaddedRows(8));
  EnvironmentArrivals(kSphere, {}, {lights->dir_x, lights->dir_y, lights->dir_z, surfaces}, 8,
                      arrival.data());
  EXPECT_NEAR(arrival[7], 1 / (kPi * 25), 1e-9);
}

// Applies chi-square to a grid over the square, whose cells expect their part of the overlapping
// leaves.
TEST(GuideStarts, DrawsPlacesWithTheReportedDensity) {
  constexpr int kSide = 16;
  for (const int cell : {0, 3, 77, 127, 200}) {
    SCOPED_TRACE(cell);
    const Starts s = StartOf(Guide(), kRows, 21, cell);
    const std::vector<Leaf> leaves = LeavesOf(Guide(), std::uint32_t(cell));
    ASSERT_EQ(leaves.size(), kGuideLeaves);
    std::vector<double> observed(kSide * kSide), expected(kSide * kSide);
    const GuideCell& c = Guide().cells[std::size_t(cell)];
    const Vec towards = MiddleOf(std::uint32_t(cell));
    const double even = c.even, focused = c.focused, boxed = 1 - even - focused;
    const double narrower = std::pow(5 / double(Guide().focus.radius), 2);
    constexpr int kFine = 32;  // points of a part, for the focus
    for (int y = 0; y < kSide * kFine; ++y) {
      for (int x = 0; x < kSide * kFine; ++x) {
        const bool in_focus =
            HitsFocus(towards, (x + 0.5) / (kSide * kFine), (y + 0.5) / (kSide * kFine));
        expected[std::size_t(y / kFine * kSide + x / kFine)] +=
            kRows * (even + focused * narrower * in_focus) / std::pow(kSide * kFine, 2);
      }
    }
    for (const Leaf& leaf : leaves) {
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          const auto shared = [&](int axis, int k) {
            const double low = std::max(leaf.low[axis], double(k) / kSide);
            return std::max(0.0, std::min(leaf.high[axis], double(k + 1) / kSide) - low);
          };
          expected[std::size_t(y * kSide + x)] +=
              kRows * boxed * shared(0, x) * shared(1, y) / leaf.Area() / kGuideLeaves;
        }
      }
    }
    Moments inverse;
    std::uint32_t wrong = 0;  // rounding has moved a place into the next leaf
    for (std::uint32_t i = 0; i < kRows; ++i) {
      const double u = s.u[i], v = s.v[i];
      ++observed[std::size_t(std::min(int(v * kSide), kSide - 1) * kSide +
                             std::min(int(u * kSide), kSide - 1))];
      const auto in = std::find_if(leaves.begin(), leaves.end(), [&](const Leaf& leaf) {
        return u >= leaf.low[0] && u <= leaf.high[0] && v >= leaf.low[1] && v <= leaf.high[1];
      });
      const double exact = even + focused * narrower * HitsFocus(towards, u, v) +
                           (in == leaves.end() ? 0 : boxed / (kGuideLeaves * in->Area()));
      wrong += std::fabs(s.crowding[i] / exact - 1) > 1e-4;
      inverse.Add(1 / s.crowding[i]);
    }
    EXPECT_LT(wrong, kRows / 500);
    EXPECT_TRUE(MatchesExpected(observed, expected, SidakLevel(10)));
    // This is the integral of the density over the whole disk.
    EXPECT_TRUE(AgreesWith(inverse.mean(), inverse.standard_error(), 1, SidakLevel(10), 1e-6));
  }
}

// Of the stratified points, one falls in each of the 32 x 32 parts of the guided range, and so one
// in each leaf.
TEST(GuideStarts, KeepsPointsStratified) {
  const std::uint32_t n = kGuideLeaves, cell = 5;
  const float even = Guide().cells[cell].even + Guide().cells[cell].focused;
  soa::Table<UniformColumns> disk(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    disk->u[i] = even + (1 - even) * (float(i % 32) + 0.3f) / 32;
    disk->v[i] = (float(i / 32) + 0.6f) / 32;
  }
  const Starts s = StartAt(Guide(), disk, n, int(cell));
  for (const Leaf& leaf : LeavesOf(Guide(), cell)) {
    int inside = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
      inside += s.u[i] > leaf.low[0] && s.u[i] < leaf.high[0] && s.v[i] > leaf.low[1] &&
                s.v[i] < leaf.high[1];
    }
    EXPECT_EQ(inside, 1);
  }
}

// Rays of other lights stay unchanged, and the record uses the given density of light samples.
TEST(GuideStarts, ChangesEnvironmentRaysOnly) {
  const std::uint32_t n = 600;
  const auto disk = RandomUniforms(n, 43);
  Starts s = StartAt(Guide(), disk, n, -1);
  EmitFromEnvironment(kSphere, s.samples, disk, n, s.rays, s.emission);
  for (std::uint32_t i = 0; i < n; i += 3) s.emission->light[i] = 4;
  const std::vector<float> pdf(s.emission->pdf, s.emission->pdf + n);
  const std::vector<float> x(s.rays->org_x, s.rays->org_x + n);
  const std::vector<float> light_pdf(PaddedRows(n), 7.0f);
  GuideStarts(kSphere, Guide().view(), disk, light_pdf.data(), n, s.rays, s.emission);
  for (std::uint32_t i = 0; i < n; ++i) {
    if (i % 3 == 0) {
      ASSERT_EQ(s.emission->pdf[i], pdf[i]);
      ASSERT_EQ(s.rays->org_x[i], x[i]);
      ASSERT_EQ(s.emission->light_pdf[i], 0.25f);
    } else {
      ASSERT_EQ(s.emission->light_pdf[i], 7.0f);
      ASSERT_NEAR(s.emission->pdf[i], 7 * s.arrival[i], 1e-5 * s.emission->pdf[i]);
    }
  }
}

TEST(EmissionGuide, BitsDoNotDependOnTargetOrNumberOfRows) {
  const auto disk = RandomUniforms(kFullWave, 51);
  for (const std::uint32_t n : kRowCounts) {
    ExpectSameOnEveryTarget([&] {
      const Starts s = StartAt(Guide(), disk, n, 100);
      soa::Table<SurfaceColumns> surfaces(n);
      std::copy_n(s.rays->org_x, n, surfaces->org_x);
      soa::Table<UniformColumns> arrival(n);
      EnvironmentArrivals(kSphere, Guide().view(),
                          {s.samples->dir_x, s.samples->dir_y, s.samples->dir_z, surfaces}, n,
                          arrival->u);
      auto bits = ColumnBits(s.emission.columns(), n);
      for (std::uint32_t i = 0; i < n; ++i) {
        for (const float f : {s.rays->org_x[i], s.rays->throughput_b[i], arrival->u[i]}) {
          bits.push_back(std::bit_cast<std::uint32_t>(f));
        }
      }
      return bits;
    });
  }
}

TEST(MakeGuide, DoesNotDependOnTheOrderOfSamples) {
  std::vector<GuideSample> samples = SomeGuideSamples(5000);
  const EmissionGuide guide = MakeGuide(samples, SomeShares(), kSphere);
  std::reverse(samples.begin(), samples.end());
  std::swap(samples[7], samples[4000]);
  const EmissionGuide other = MakeGuide(samples, SomeShares(), kSphere);
  EXPECT_EQ(guide.cuts, other.cuts);
  for (std::uint32_t i = 0; i < kGuideCells; ++i) {
    EXPECT_EQ(std::memcmp(&guide.cells[i], &other.cells[i], sizeof(GuideCell)), 0);
  }
}

// Directions keep a positive probability, and no line becomes much rarer than before.
TEST(MakeGuide, LeavesEveryStartPossible) {
  const std::vector<double> shares = SomeShares();
  double sum = 0;
  for (std::uint32_t i = 0; i < kGuideCells; ++i) {
    const GuideCell& cell = Guide().cells[i];
    sum += shares[i] * double(cell.gain);
    if (shares[i] > 0) {
      ASSERT_GT(cell.gain * cell.even, 0.999 * kEvenShare);
      ASSERT_GT(cell.gain * cell.focused, 0.999 * kFocusShare);
    }
    for (const Leaf& leaf : LeavesOf(Guide(), i)) ASSERT_GT(leaf.Area(), 0);
  }
  // No light path starts where light samples never are, even if guide samples are there.
  EXPECT_LT(sum, 1);
  EXPECT_GT(sum, 0.8);
}

TEST(MakeGuide, IsDenseWhereGuideSamplesAre) {
  const std::uint32_t cell = 17;
  std::vector<GuideSample> samples;
  Random random(3);
  for (int i = 0; i < 4000; ++i) {
    // The samples are at two places.
    const float u = i % 4 == 0 ? 0.1f : 0.7f;
    samples.push_back({.cell = cell,
                       .u = u + 0.01f * random.Float(),
                       .v = 0.1f + 0.01f * random.Float(),
                       .weight = 100});
  }
  const auto share_inside = [&](const EmissionGuide& guide) {
    double inside = 0;
    for (const Leaf& leaf : LeavesOf(guide, cell)) {
      inside += leaf.low[0] > 0.69 && leaf.high[0] < 0.72 && leaf.high[1] < 0.12;
    }
    return inside / kGuideLeaves;
  };
  const std::vector<double> shares(kGuideCells, 1.0 / kGuideCells);
  const EmissionGuide guide = MakeGuide(samples, shares, kSphere);
  constexpr double kUnguided = kEvenShare + kFocusShare;
  EXPECT_NEAR(guide.cells[cell].gain, kUnguided + (1 - kUnguided) * kGuideCells, 1e-3);
  EXPECT_NEAR(guide.cells[cell].even * guide.cells[cell].gain, kEvenShare, 1e-6);
  EXPECT_NEAR(guide.cells[cell + 1].gain, kUnguided, 1e-6);
  EXPECT_NEAR(guide.cells[cell + 1].even + guide.cells[cell + 1].focused, 1, 1e-6);
  // One place holds three quarters of the weight, minus what the leaves at its border take.
  EXPECT_GT(share_inside(guide), 0.6);
  EXPECT_LE(share_inside(guide), 0.75);
  // Without directions, every cell has the same even share.
  const EmissionGuide places = MakeGuide(samples, {}, kSphere);
  EXPECT_EQ(places.cells[cell].gain, 1);
  EXPECT_EQ(places.cells[cell].even, float(kEvenShare));
  EXPECT_EQ(share_inside(places), share_inside(guide));
}

TEST(MakeGuide, FocusesOnMostGuideSamples) {
  const SceneSphere& focus = Guide().focus;
  EXPECT_NEAR(focus.center[0], 2, 0.05);
  EXPECT_NEAR(focus.center[1], -2, 0.05);
  EXPECT_NEAR(focus.center[2], 3, 0.05);
  EXPECT_NEAR(focus.radius, 0.92, 0.03);
  // If the samples are all over the scene, so is the focus.
  std::vector<GuideSample> samples = SomeGuideSamples(5000);
  Random random(8);
  for (GuideSample& sample : samples)
    Put(8 * random.Direction(), 0, sample.point, sample.point + 1, sample.point + 2);
  EXPECT_EQ(MakeGuide(samples, {}, kSphere).focus.radius, kSphere.radius);
}

TEST(MakeGuide, IsEvenWithoutEnoughSamples) {
  EXPECT_TRUE(MakeGuide({}, SomeShares(), kSphere).empty());
  EXPECT_EQ(EmissionGuide().view().cells, nullptr);
  // A few samples do not make a density, so cells with so few are even.
  const EmissionGuide guide =
      MakeGuide({{5, 0.9f, 0.9f, {}, 0, 10}, {5, 0.9f, 0.8f, {}, 0, 10}}, {}, kSphere);
  EXPECT_NEAR(guide.cells[5].even + guide.cells[5].focused, 1, 1e-6);
  for (const Leaf& leaf : LeavesOf(guide, 5)) EXPECT_EQ(leaf.Area() * kGuideLeaves, 1);
  // All samples are at one point and one of them outweighs all others: the parts become small but
  // keep an area.
  std::vector<GuideSample> same(100, {9, 0.25f, 0.75f, {}, 0, 3});
  same[50].weight = std::uint64_t{1} << 40;
  for (const Leaf& leaf : LeavesOf(MakeGuide(same, {}, kSphere), 9)) EXPECT_GT(leaf.Area(), 0);
}

TEST(GuideStarts, DirectionalLightsHaveNoGain) {
  const std::uint32_t n = 2000;
  const auto disk = RandomUniforms(n, 61);
  Starts s = StartAt(Guide(), disk, n, -1);
  EmitFromEnvironment(kSphere, s.samples, disk, n, s.rays, s.emission);
  for (std::uint32_t i = 0; i < n; ++i) {
    s.emission->light[i] = 4, s.emission->delta[i] |= kDeltaDirection;
  }
  GuideStarts(kSphere, Guide().view(), disk, nullptr, n, s.rays, s.emission);
  soa::Table<SurfaceColumns> surfaces(n);
  std::vector<float> arrival(PaddedRows(n));
  const std::vector<float> punctual(PaddedRows(n), kPunctual);
  for (std::uint32_t i = 0; i < n; ++i) {
    Put(Get(i, s.rays->org_x, s.rays->org_y, s.rays->org_z), i, surfaces->org_x, surfaces->org_y,
        surfaces->org_z);
    surfaces->lift[i] = 0;
  }
  EnvironmentArrivals(
      kSphere, Guide().view(),
      {s.samples->dir_x, s.samples->dir_y, s.samples->dir_z, surfaces, nullptr, punctual.data()}, n,
      arrival.data());
  std::uint32_t off = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    const double flux = s.rays->throughput_g[i];
    ASSERT_NEAR(double(s.emission->pdf[i]) * flux, 1, 1e-4) << i;
    // On the other side of a cut, the value is that of another leaf.
    off += std::fabs(0.25 * double(arrival[i]) * flux - 1) > 1e-3;
  }
  EXPECT_LT(off, n / 200);
}

}  // namespace
}  // namespace skywave
