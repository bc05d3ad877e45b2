// The kernels of portals against formulae in double precision of another form.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "base/error.h"
#include "kernels/lights/portals.h"
#include "lights/strategies/strategy.h"
#include "lights/tables/portal_tables.h"
#include "tests/support/adversarial_maps.h"
#include "tests/support/map_cells.h"
#include "tests/support/shade_points.h"
#include "tests/support/statistics.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

Vec Of(const glm::vec3& v) { return {v.x, v.y, v.z}; }

// Whether a ray from `point` passes the rectangle, by the areas on both sides of each edge.
bool Passes(const Portal& portal, Vec point, Vec direction) {
  const Vec a = Of(portal.corner) - point, x = Of(portal.side_x), y = Of(portal.side_y);
  const Vec corners[4] = {a, a + x, a + x + y, a + y};
  if (Dot(Cross(x, y), direction) <= 0 || Dot(Cross(x, y), a) <= 0) return false;
  for (int i = 0; i < 4; ++i) {
    if (Dot(Cross(corners[i], corners[(i + 1) % 4]), direction) < 0) return false;
  }
  return true;
}

struct Fixture {
  Fixture(const std::string& name, std::vector<Portal> portals, double share,
          std::uint32_t texels = 64)
      : Fixture(AdversarialMap(name), std::move(portals), share, texels) {}
  Fixture(Image latlong, std::vector<Portal> portals, double share, std::uint32_t texels = 64)
      : map{std::move(latlong), Orientations()[1].map_from_world, std::move(portals)},
        strategy(MakeStrategy(
            "portal:texels=" + std::to_string(texels) + ",share=" + std::to_string(share), map)) {}

  // Light samples of a surface at `point`.
  soa::Table<LightColumns> Draw(Vec point, std::uint32_t n) {
    surfaces = soa::Table<SurfaceColumns>(n);
    for (std::uint32_t i = 0; i < n; ++i) {
      PutSurface(Unit({0.3, 0.8, 0.5}), i, surfaces);
      Put(point, i, surfaces->org_x, surfaces->org_y, surfaces->org_z);
    }
    soa::Table<LightColumns> out(n);
    strategy->Sample(LambertPoints(surfaces, n), RandomUniforms(n, 5), n, {}, out);
    return out;
  }
  // The density of a direction at surface 0 of the last Draw.
  std::vector<float> Densities(const std::vector<Vec>& directions) {
    soa::Table<EscapeColumns> rows(std::uint32_t(directions.size()));
    for (std::uint32_t i = 0; i < directions.size(); ++i) {
      Put(directions[i], i, rows->dir_x, rows->dir_y, rows->dir_z);
      rows->pdf[i] = 1, rows->from[i] = 0;
    }
    strategy->EvaluateEscaped(LambertPoints(surfaces, 1), std::uint32_t(directions.size()), 1,
                              rows);
    return {rows->light_pdf, rows->light_pdf + directions.size()};
  }

  EnvironmentMap map;
  std::unique_ptr<EnvStrategy> strategy;
  soa::Table<SurfaceColumns> surfaces{1};
};

const Vec kPoints[] = {{0, 0, 0}, {0.7, -0.4, 0.3}, {-3, 1, -2}, {0.1, 0.1, 0.99}, {5, 5, -9}};

// Windows end with texels.
bool Nearly(const Portal& portal, Vec point, Vec direction) {
  for (int i = 0; i < 27; ++i) {
    const Vec aside = {i % 3 - 1.0, i / 3 % 3 - 1.0, i / 9 - 1.0};
    if (Passes(portal, point, direction + 1.5 * kPi / 512 * aside)) return true;
  }
  return false;
}

TEST(Portals, SamplesPassAPortalAndNothingElseHasADensity) {
  Fixture f("Noise", PortalsAroundTheOrigin(), 0, 512);
  for (const Vec point : kPoints) {
    const auto samples = f.Draw(point, 4096);
    std::uint32_t missed = 0, beside = 0;
    for (std::uint32_t i = 0; i < 4096; ++i) {
      const Vec dir = Get(i, samples->dir_x, samples->dir_y, samples->dir_z);
      ASSERT_NEAR(Length(dir), 1, 1e-6);
      bool passes = false, nearly = false;
      for (const Portal& portal : f.map.portals) {
        passes |= Passes(portal, point, dir), nearly |= Nearly(portal, point, dir);
      }
      missed += !nearly, beside += !passes;
    }
    EXPECT_EQ(missed, 0u);
    EXPECT_LT(beside, 4096 / 4u);
    Random random(3);
    std::vector<Vec> directions(4096);
    for (Vec& d : directions) d = random.Direction();
    const std::vector<float> densities = f.Densities(directions);
    for (std::size_t i = 0; i < directions.size(); ++i) {
      bool passes = false, nearly = false;
      for (const Portal& portal : f.map.portals) {
        passes |= Passes(portal, point, directions[i]);
        nearly |= Nearly(portal, point, directions[i]);
      }
      ASSERT_TRUE(densities[i] > 0 || !passes) << "direction " << i;
      ASSERT_TRUE(densities[i] == 0 || nearly) << "direction " << i;
    }
  }
}

// Chi-square over squares of the two angles of the first portal, which belong to no texel's grid.
TEST(Portals, DirectionsFollowTheDensity) {
  constexpr std::uint32_t kSamples = 50000, kBins = 16, kFine = 80;
  for (const char* const name : {"Noise", "Sun", "Constant"}) {
    Fixture f(name, PortalsAroundTheOrigin(), 0);
    // From farther away windows are too small for the midpoint rule.
    for (const Vec point : {kPoints[0], kPoints[1], kPoints[3]}) {
      const auto samples = f.Draw(point, kSamples);
      std::vector<double> observed(kBins * kBins + 1), expected(kBins * kBins + 1);
      const auto bin = [&](Vec d) {
        if (d.z <= 0) return kBins * kBins;
        const auto place = [&](double across) {
          return std::min(std::uint32_t((std::atan2(across, d.z) / kPi + 0.5) * kBins), kBins - 1);
        };
        return place(d.y) * kBins + place(d.x);
      };
      for (std::uint32_t i = 0; i < kSamples; ++i) {
        ++observed[bin(Get(i, samples->dir_x, samples->dir_y, samples->dir_z))];
      }
      std::vector<Vec> directions;
      std::vector<double> solid_angles;
      const std::uint32_t across = kBins * kFine;
      const double step = kPi / across;
      for (std::uint32_t y = 0; y < across; ++y) {
        for (std::uint32_t x = 0; x < across; ++x) {
          const double b = std::tan((y + 0.5) * step - kPi / 2);
          const double a = std::tan((x + 0.5) * step - kPi / 2);
          // The solid angle of a small square of the plane z = 1 is its area over distance^3.
          const double distance = std::sqrt(1 + a * a + b * b);
          directions.push_back({a / distance, b / distance, 1 / distance});
          solid_angles.push_back(step * step * (1 + a * a) * (1 + b * b) /
                                 (distance * distance * distance));
        }
      }
      const std::vector<float> densities = f.Densities(directions);
      double integral = 0;
      for (std::size_t i = 0; i < directions.size(); ++i) {
        const double share = densities[i] * solid_angles[i];
        expected[bin(directions[i])] += kSamples * share;
        integral += share;
      }
      expected.back() = std::max(0.0, kSamples * (1 - integral));
      EXPECT_TRUE(MatchesExpected(observed, expected, SidakLevel(9), 4e-3 * kSamples))
          << name << " at " << point.x << " " << point.y << " " << point.z;
    }
  }
}

// Light through the portals alone, against the map summed over all directions that pass one.
TEST(Portals, EstimatesAreTheLightOfTheWindows) {
  for (const char* const name : {"Noise", "Sun", "Ramp"}) {
    for (const double share : {0.0, 0.125}) {
      Fixture f(name, PortalsAroundTheOrigin(), share);
      const MapCells cells(f.map, 1536);
      for (const Vec point : kPoints) {
        const auto passes = [&](Vec direction) {
          for (const Portal& portal : f.map.portals) {
            if (Passes(portal, point, direction)) return true;
          }
          return false;
        };
        const Image held = HeldMap(f.map);
        double exact = 0, whole = 0;
        for (std::size_t i = 0; i < cells.size(); ++i) {
          double u, v;
          MapPosition(f.map.map_from_world, cells.directions()[i], u, v);
          const float* rgb = held.Pixel(std::min(int(u * held.width), held.width - 1),
                                        std::min(int(v * held.height), held.height - 1));
          whole += double(Luminance(rgb)) * cells.solid_angle(i);
          if (passes(cells.directions()[i])) exact += double(rgb[1]) * cells.solid_angle(i);
        }
        constexpr std::uint32_t kSamples = 200000;
        const auto samples = f.Draw(point, kSamples);
        Moments moments;
        double most = 0;
        for (std::uint32_t i = 0; i < kSamples; ++i) {
          const bool counts =
              samples->pdf[i] > 0 && passes(Get(i, samples->dir_x, samples->dir_y, samples->dir_z));
          moments.Add(counts ? samples->g[i] / samples->pdf[i] : 0);
          const float rgb[] = {samples->r[i], samples->g[i], samples->b[i]};
          if (counts) most = std::max(most, double(Luminance(rgb)) / samples->pdf[i]);
        }
        EXPECT_TRUE(AgreesWith(moments.mean(), moments.standard_error(), exact, SidakLevel(30),
                               5e-3 * exact))
            << name << " at " << point.x << ", share " << share;
        // The share bounds the weight of what rectified texels lose of the map's.
        if (share > 0) {
          EXPECT_LT(most, 1.001 * whole / share) << name << " at " << point.x;
        }
      }
    }
  }
}

// Light that covers a part of a texel is drawn with half of its own density at least, wherever the
// texel's border cuts it, and light between the points of a texel with that of the whole texel.
TEST(Portals, NoLightIsDrawnMuchTooRarely) {
  const Portal portal = {.corner = {-1, -1, 1}, .side_x = {2, 0, 0}, .side_y = {0, 2, 0}};
  constexpr double kTexels = 64, kTexel = kPi / kTexels;  // side of a texel [rad]
  struct Row {
    int width;
    double luminance;
  };
  // Lamps of several texels, and of a seventh of one.
  for (const Row& row : {Row{48, 50}, Row{1024, 2e5}}) {
    Random random(17);
    int seen = 0;
    for (int lamp = 0; lamp < 400 && seen < 12; ++lamp) {
      Image image(row.width, row.width / 2);
      for (float& value : image.rgb) value = 1;
      const auto x = int(random.Word() % std::uint32_t(image.width));
      const auto y = int(random.Word() % std::uint32_t(image.height));
      std::fill_n(image.Pixel(x, y), 3, float(row.luminance));
      const EnvironmentMap placed = {image, Orientations()[1].map_from_world, {}};
      const double u = (x + 0.5) / image.width, v = (y + 0.5) / image.height;
      const Vec middle = WorldDirection(placed.map_from_world, u, v);
      if (!Passes(portal, {0, 0, 0}, middle) || std::fabs(v - 0.5) > 0.35) continue;
      ++seen;
      Fixture f(image, {portal}, 0);
      f.Draw({0, 0, 0}, 1);
      // Of the light that comes in: the sky's 1 through a sixth of the sphere, and the lamp's.
      const double solid_angle =
          2 * kPi / image.width *
          (std::cos(kPi * y / image.height) - std::cos(kPi * (y + 1) / image.height));
      const double light = 4 * kPi / 6 + row.luminance * solid_angle;
      std::vector<Vec> directions;
      for (int i = 0; i < 400; ++i) {
        const Vec d =
            WorldDirection(placed.map_from_world, (x + random.Between(0.01, 0.99)) / image.width,
                           (y + random.Between(0.01, 0.99)) / image.height);
        if (Passes(portal, {0, 0, 0}, d)) directions.push_back(d);
      }
      const double own = row.luminance / light;
      const double spread = row.luminance * solid_angle / (kTexel * kTexel) / light;
      const std::vector<float> densities = f.Densities(directions);
      // A narrow lamp may have its middle in the next texel.
      if (row.width > kTexels * 2) {
        const float at_middle = f.Densities({middle})[0];
        EXPECT_GT(at_middle, 0.5 * spread) << "lamp at " << x << ", " << y;
      } else {
        for (const float density : densities) {
          ASSERT_GT(density, 0.3 * own) << "lamp at " << x << ", " << y;
        }
      }
    }
    EXPECT_EQ(seen, 12);
  }
}

TEST(Portals, SurfacesThatSeeNoneDrawByImportance) {
  const Portal portal = {.corner = {-1, -1, 1}, .side_x = {2, 0, 0}, .side_y = {0, 2, 0}};
  Fixture f("Noise", {portal}, 0.125);
  const auto importance = MakeStrategy("importance", f.map);
  constexpr std::uint32_t kRows = 500;
  for (const Vec point : {Vec{0, 0, 1}, Vec{0.3, 0.2, 1.5}, Vec{4, 4, 1}, Vec{0, 0, 30}}) {
    const auto samples = f.Draw(point, kRows);
    soa::Table<LightColumns> expected(kRows);
    importance->Sample(LambertPoints(f.surfaces, kRows), RandomUniforms(kRows, 5), kRows, {},
                       expected);
    for (std::uint32_t i = 0; i < kRows; ++i) {
      ASSERT_EQ(samples->dir_x[i], expected->dir_x[i]) << i << " at " << point.z;
      ASSERT_EQ(samples->pdf[i], expected->pdf[i]) << i << " at " << point.z;
      ASSERT_EQ(samples->r[i], expected->r[i]) << i << " at " << point.z;
    }
  }
}

// Points in the plane of a portal, on its rim, and so close that they see half of everything.
TEST(Portals, SamplesNearAPortalAreFinite) {
  const Portal portal = {.corner = {-1, -1, 1}, .side_x = {2, 0, 0}, .side_y = {0, 2, 0}};
  for (const double share : {0.0, 0.125}) {
    Fixture f("Sun", {portal, portal}, share);
    for (const double z : {1 - 1e-7, 1 - 1e-5, 0.999, 1.0, 1 + 1e-6, -1e6}) {
      for (const double x : {0.0, 1.0, -1.0, 1 + 1e-6, 3.0, 1e7}) {
        const auto samples = f.Draw({x, -1, z}, 300);
        for (std::uint32_t i = 0; i < 300; ++i) {
          const Vec dir = Get(i, samples->dir_x, samples->dir_y, samples->dir_z);
          ASSERT_NEAR(Length(dir), 1, 2e-6) << x << " " << z;
          ASSERT_TRUE(std::isfinite(samples->pdf[i]) && samples->pdf[i] >= 0) << x << " " << z;
        }
      }
    }
  }
}

// The rectified map holds the energy of its half, wherever its texels lie.
TEST(Portals, ARectifiedMapHoldsTheLightOfItsHalf) {
  const Portal portal = {.corner = {0, 0, 0}, .side_x = {0.6f, 0.8f, 0}, .side_y = {0, 0, 2}};
  const EnvironmentMap map = {AdversarialMap("Ramp"), Orientations()[2].map_from_world, {portal}};
  const Texels texels(map);
  const PortalTables tables(texels, map.portals, 256);
  const PortalsView view = tables.view();
  const double units = view.sums[257 * 257 - 1];
  const MapCells cells(map, 1024);
  const Image held = HeldMap(map);
  double half = 0, all = 0;
  const Vec ahead = Unit(Cross(Of(portal.side_x), Of(portal.side_y)));
  for (std::size_t i = 0; i < cells.size(); ++i) {
    double u, v;
    MapPosition(map.map_from_world, cells.directions()[i], u, v);
    const float* rgb = held.Pixel(std::min(int(u * held.width), held.width - 1),
                                  std::min(int(v * held.height), held.height - 1));
    const double energy = double(Luminance(rgb)) * cells.solid_angle(i);
    all += energy;
    if (Dot(cells.directions()[i], ahead) > 0) half += energy;
  }
  // Texels that straddle two of the map count half of the brighter one.
  EXPECT_NEAR(units * view.portals[0].unit, half / all, 0.03 * half / all);
  EXPECT_GE(units * view.portals[0].unit, 0.999 * half / all);
}

TEST(Portals, TablesAreSharedByPortalsThatLieAlike) {
  const Portal portal = {.corner = {0, 0, 0}, .side_x = {1, 0, 0}, .side_y = {0, 1, 0}};
  Portal beside = portal, turned = portal;
  beside.corner.x = 3, beside.side_x.x = 0.5f;
  std::swap(turned.side_x, turned.side_y);
  const EnvironmentMap map = {AdversarialMap("Ramp"), Orientations()[0].map_from_world, {}};
  const Texels texels(map);
  const auto bytes = [&](std::vector<Portal> portals) {
    return PortalTables(texels, portals, 128).bytes() - portals.size() * sizeof(PortalRecord);
  };
  EXPECT_EQ(bytes({portal, beside}), bytes({portal}));
  EXPECT_EQ(bytes({portal, turned}), 2 * bytes({portal}));
}

TEST(Portals, AMapWithoutThemIsRefused) {
  const EnvironmentMap map = {AdversarialMap("Ramp"), Orientations()[0].map_from_world, {}};
  EXPECT_THROW(MakeStrategy("portal", map), OptionError);
}

}  // namespace
}  // namespace skywave
