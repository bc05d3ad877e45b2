// Exported lights parse back, and the six axes follow the convention of every format.
#include "lights/probe/export_lights.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "lights/light_sets/probe_lights.h"
#include "lights/maps/projections.h"
#include "scene/scene.h"
#include "tests/support/light_test_maps.h"

namespace skywave {
namespace {

constexpr double kPi = std::numbers::pi;

DirectionalLight MakeLight(const Vector3& direction, double r, double g, double b) {
  const float rgb[3] = {float(r), float(g), float(b)};
  return {direction, {r, g, b}, Luminance(rgb), 0.1};
}

// Returns all numbers of a line from `from` on, in order.
std::vector<double> Numbers(const std::string& line, std::size_t from = 0) {
  std::vector<double> numbers;
  for (std::size_t i = from; i < line.size();) {
    const bool starts = std::isdigit(static_cast<unsigned char>(line[i])) ||
                        (line[i] == '-' && i + 1 < line.size() &&
                         std::isdigit(static_cast<unsigned char>(line[i + 1])));
    const bool in_word =
        i > 0 && (std::isalnum(static_cast<unsigned char>(line[i - 1])) || line[i - 1] == '_');
    if (!starts || in_word) {
      ++i;
      continue;
    }
    std::size_t used = 0;
    numbers.push_back(std::stod(line.substr(i), &used));
    i += used;
  }
  return numbers;
}

struct Parsed {
  Vector3 direction;  // in the world of the format
  std::array<double, 3> irradiance;
};

// Maya rotates about x, then y, then z; a light shines along its own -z.
Vector3 MayaLight(double x_degrees, double y_degrees) {
  const double x = x_degrees * kPi / 180, y = y_degrees * kPi / 180;
  const Vector3 after_x = {0, std::sin(x), -std::cos(x)};
  const Vector3 shine = {after_x.x * std::cos(y) + after_x.z * std::sin(y), after_x.y,
                         -after_x.x * std::sin(y) + after_x.z * std::cos(y)};
  return -1.0 * shine;
}

// Reads the lights as the renderer would, with its units and conventions.
std::vector<Parsed> Parse(LightFormat format, const std::string& text) {
  std::vector<Parsed> lights;
  std::istringstream lines(text);
  std::string line, maya_color;
  while (std::getline(lines, line)) {
    const auto has = [&](const char* word) { return line.find(word) != std::string::npos; };
    if (format == LightFormat::kPbrt && line.starts_with("LightSource \"distant\"")) {
      const auto n = Numbers(line);
      lights.push_back({{n[3] - n[6], n[4] - n[7], n[5] - n[8]}, {n[0], n[1], n[2]}});
    } else if (format == LightFormat::kPovray && line.starts_with("light_source")) {
      const auto n = Numbers(line);
      lights.push_back({{n[0], n[1], n[2]}, {n[3] * kPi, n[4] * kPi, n[5] * kPi}});
      EXPECT_TRUE(has("parallel"));
    } else if (format == LightFormat::kBlender && line.starts_with("    ((")) {
      const auto n = Numbers(line);
      lights.push_back({{n[0], n[1], n[2]}, {n[3] * n[4], n[3] * n[5], n[3] * n[6]}});
    } else if (format == LightFormat::kMaya && has("-intensity")) {
      maya_color = line.substr(line.find("-intensity"));
    } else if (format == LightFormat::kMaya && has(".rotate")) {
      const auto n = Numbers(line.substr(line.find(".rotate")));
      const auto c = Numbers(maya_color);
      lights.push_back(
          {MayaLight(n[0], n[1]), {c[0] * c[1] * kPi, c[0] * c[2] * kPi, c[0] * c[3] * kPi}});
      EXPECT_EQ(n[2], 0);
    }
  }
  return lights;
}

constexpr LightFormat kScenes[] = {LightFormat::kPbrt, LightFormat::kPovray, LightFormat::kBlender,
                                   LightFormat::kMaya};

TEST(ExportLights, DirectionsAndEnergiesParseBack) {
  const Image image = test::SunMap(128, 64, 1e5f);
  const ProbeLights lights = MakeProbeLights(
      MakeSphereMap(image), {.lights = {.source = LightSource::kVarianceCut, .lights = 40}});
  ASSERT_EQ(lights.set.lights.size(), 40u);
  for (LightFormat format : kScenes) {
    const std::string text = ExportLights(lights.set.lights, {.format = format, .source = "sun"});
    const WorldAxes axes = AxesOf(format);
    const std::vector<Parsed> parsed = Parse(format, text);
    ASSERT_EQ(parsed.size(), 40u) << int(format);
    std::array<double, 3> sum = {}, expected = {};
    for (std::size_t i = 0; i < parsed.size(); ++i) {
      const DirectionalLight& light = lights.set.lights[i];
      EXPECT_LT(AngleBetween(parsed[i].direction, axes.ToWorld(light.direction)), 1e-8);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(parsed[i].irradiance[c] / light.irradiance[c], 1, 1e-8) << int(format);
        sum[c] += parsed[i].irradiance[c];
        expected[c] += light.irradiance[c];
      }
    }
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c] / expected[c], 1, 1e-8);
    double energy = 0;
    for (const DirectionalLight& light : lights.set.lights) energy += light.energy;
    EXPECT_NEAR(energy / MakeSphereMap(image).energy, 1, 1e-9);
    const std::size_t total = text.find("total irradiance");
    ASSERT_NE(total, std::string::npos);
    EXPECT_NEAR(Numbers(text, total)[3] / energy, 1, 1e-8);
  }
}

TEST(ExportLights, AxesFollowEveryConvention) {
  const std::vector<DirectionalLight> lights = {
      MakeLight({1, 0, 0}, 1, 0, 0), MakeLight({0, 1, 0}, 0, 1, 0), MakeLight({0, 0, 1}, 0, 0, 1)};
  struct Expected {
    LightFormat format;
    Vector3 right, forward, up;
  };
  const Expected table[] = {{LightFormat::kPbrt, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
                            {LightFormat::kPovray, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
                            {LightFormat::kBlender, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                            {LightFormat::kMaya, {1, 0, 0}, {0, 0, -1}, {0, 1, 0}}};
  for (const Expected& expected : table) {
    for (double sign : {1.0, -1.0}) {
      std::vector<DirectionalLight> turned = lights;
      for (DirectionalLight& light : turned) light.direction = sign * light.direction;
      const auto parsed = Parse(expected.format, ExportLights(turned, {.format = expected.format}));
      ASSERT_EQ(parsed.size(), 3u);
      EXPECT_LT(Length(parsed[0].direction - sign * expected.right), 1e-9) << int(expected.format);
      EXPECT_LT(Length(parsed[1].direction - sign * expected.forward), 1e-9);
      EXPECT_LT(Length(parsed[2].direction - sign * expected.up), 1e-9) << int(expected.format);
    }
  }
}

// The format's world must be the one in which skywave itself orients maps.
TEST(ExportLights, AxesAreThoseOfTheRenderer) {
  for (LightFormat format : kScenes) {
    const bool left_handed = format == LightFormat::kPbrt || format == LightFormat::kPovray;
    for (char up : {'x', 'y', 'z'}) {
      const glm::mat3 frame = EnvironmentFrame(up, left_handed, 0);
      const WorldAxes axes = AxesOf(format, up);
      const Vector3 columns[3] = {axes.right, axes.forward, axes.up};
      for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(columns[i].x, frame[i].x, 1e-7) << up << i;
        EXPECT_NEAR(columns[i].y, frame[i].y, 1e-7) << up << i;
        EXPECT_NEAR(columns[i].z, frame[i].z, 1e-7) << up << i;
      }
    }
  }
}

TEST(ExportLights, JsonIsJson) {
  const std::vector<DirectionalLight> lights = {MakeLight({0.6, 0, 0.8}, 1, 2, 3)};
  const auto json = nlohmann::json::parse(
      ExportLights(lights, {.format = LightFormat::kJson, .source = "a \"b\" \\ c\n"}));
  EXPECT_EQ(json["lights"].size(), 1u);
  const auto& light = json["lights"][0];
  EXPECT_EQ(light["direction"], (std::vector<double>{0.6, 0, 0.8}));
  EXPECT_EQ(light["irradiance"], (std::vector<double>{1, 2, 3}));
  EXPECT_NEAR(light["energy"].get<double>(), 0.2125 + 2 * 0.7154 + 3 * 0.0721, 1e-6);
  EXPECT_EQ(light["solid_angle"], 0.1);
  EXPECT_EQ(json["total_irradiance"], (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(json["total_energy"], light["energy"]);
  EXPECT_TRUE(nlohmann::json::accept(ExportLights({}, {.format = LightFormat::kJson})));
}

TEST(ExportLights, NoNameEscapesItsComment) {
  for (LightFormat format : kScenes) {
    const std::string text =
        ExportLights({}, {.format = format, .source = "x\nimport os", .residual = "a\"b.exr"});
    EXPECT_EQ(text.find("\nimport os"), std::string::npos);
    EXPECT_EQ(text.find("a\"b"), std::string::npos);
  }
}

TEST(ProbeLights, LightsAndRestHaveTheEnergyOfTheMap) {
  for (const test::NamedMap& map : test::AdversarialMaps()) {
    const SphereMap sphere = MakeSphereMap(map.image);
    for (LightSource source :
         {LightSource::kMedianCut, LightSource::kVarianceCut, LightSource::kPenrose}) {
      for (const char* strata : {"", "0.5", "variation", "8:12"}) {
        for (int clusters : {0, 5}) {
          LightRequest request = {
              .lights = {.source = source, .lights = 23, .lloyd_steps = clusters / 5}};
          if (clusters > 0) request.lights.cluster = ClusterFrequency::kEnergy;
          request.lights.stop.clusters = clusters;
          if (*strata) request.strata = ParseStrata(strata);
          const ProbeLights lights = MakeProbeLights(sphere, request);
          EXPECT_NEAR(lights.lights_energy + lights.residual_energy, sphere.energy,
                      1e-5 * sphere.energy)
              << map.name << " " << ToString(source) << " " << strata << " " << clusters;
          if (clusters) {
            EXPECT_LE(lights.set.lights.size(), 5u);
          }
        }
      }
    }
  }
}

TEST(ProbeLights, StrataAreParsed) {
  EXPECT_EQ(ParseStrata("0.25")->fraction, 0.25);
  EXPECT_EQ(ParseStrata("64:90")->lights, 64);
  EXPECT_NEAR(ParseStrata("64:90")->separation, kPi / 2, 1e-15);
  for (const char* bad : {"", "1.5", "-1", "x", "64:", ":9", "64:400", "0.5x", "nan"}) {
    EXPECT_FALSE(ParseStrata(bad)) << bad;
  }
}

// Returns the point of the square where pbrt looks a direction of its light space up.
ImagePoint PbrtPoint(const Vector3& d) {
  const double x = std::abs(d.x), y = std::abs(d.y),
               r = std::sqrt(std::max(0.0, 1 - std::abs(d.z)));
  const double phi = std::atan2(y, x) * 2 / kPi;
  double v = phi * r, u = r - v;
  if (d.z < 0) {
    std::swap(u, v);
    u = 1 - u, v = 1 - v;
  }
  return {(std::copysign(u, d.x) + 1) / 2, (std::copysign(v, d.y) + 1) / 2};
}

// pbrt sees the light of the rest where the lights that were cut out of it are.
TEST(ExportLights, PbrtSeesTheRestWhereTheMapHasIt) {
  const std::string text = ExportLights({}, {.format = LightFormat::kPbrt, .residual = "rest.exr"});
  const std::size_t at = text.find("Transform");
  ASSERT_NE(at, std::string::npos);
  const std::vector<double> m = Numbers(text.substr(at, text.find('\n', at) - at));
  ASSERT_EQ(m.size(), 16u);
  // pbrt reads columns: where the axes of the light space lie in the world.
  const Vector3 columns[3] = {{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}};
  std::mt19937 random(4);
  for (int i = 0; i < 100; ++i) {
    const Vector3 d = test::RandomDirection(random);
    const Vector3 world = {d.x, d.z, d.y};  // right, up, forward are x, y, z
    const ImagePoint seen =
        PbrtPoint({Dot(world, columns[0]), Dot(world, columns[1]), Dot(world, columns[2])});
    const ImagePoint held = PointOfDirection(Projection::kOctahedral, d);
    EXPECT_NEAR(seen.u, held.u, 1e-6) << i;
    EXPECT_NEAR(seen.v, held.v, 1e-6) << i;
  }
}

// The map's axes, right, up and forward, are the rows of the matrix in the world of POV-Ray, which
// is left-handed. What comes before the matrix was found with POV-Ray 3.7 and the map of `skywave
// probe calibrate`.
TEST(ExportPovray, TheRestOfTheMapIsTheSky) {
  const auto text = [](char up, const char* file) {
    return ExportLights({}, {.format = LightFormat::kPovray, .up_axis = up, .residual = file});
  };
  EXPECT_NE(text('y', "rest.exr").find("image_map { exr \"rest.exr\" gamma 1 map_type 1"),
            std::string::npos);
  EXPECT_NE(text('y', "rest.exr").find("scale <-1, 1, 1> rotate <0, -90, 0>"), std::string::npos);
  EXPECT_NE(text('y', "rest.hdr").find("image_map { hdr \"rest.hdr\""), std::string::npos);
  EXPECT_NE(text('y', "r.exr").find("matrix <1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0>"),
            std::string::npos);
  EXPECT_NE(text('z', "r.exr").find("matrix <1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 0, 0>"),
            std::string::npos)
      << text('z', "r.exr");
  EXPECT_EQ(text('y', "").find("sky_sphere"), std::string::npos);
}

}  // namespace
}  // namespace skywave
