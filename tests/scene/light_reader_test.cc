// Tests local lights of scene files: how readers convert them, and what they refuse.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "base/error.h"
#include "image/image.h"
#include "scene/geometry.h"
#include "scene/local_lights.h"
#include "scene/pbrt/reader.h"
#include "tests/support/made_image.h"
#include "tests/support/oracle_lights.h"
#include "tests/support/pbrt_lights.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

constexpr double kPi = 3.14159265358979323846;

PunctualLight OnlyLight(const std::string& text) {
  const Scene scene = Parse(text);
  EXPECT_EQ(scene.lights.size(), 1u) << text;
  EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.at(0);
  return scene.lights.at(0);
}

TEST(PbrtLights, PointLightsAreRead) {
  const PunctualLight v3 = OnlyLight(
      "Translate 1 2 3 LightSource \"point\" \"rgb I\" [1 2 3] \"rgb scale\" [2 2 4] "
      "\"point from\" [0 1 0]");
  EXPECT_EQ(v3.kind, LocalLightKind::kPoint);
  ExpectNear(v3.emission, {2, 4, 12});
  ExpectNear(v3.position, {1, 3, 3});
  const PunctualLight v4 = OnlyLight(
      "Scale 2 2 2 LightSource \"point\" \"float scale\" 0.5 \"float power\" 8 \"point3 from\" "
      "[1 0 0]");
  ExpectNear(v4.emission, glm::vec3(float(0.5 * 8 / (4 * kPi))));
  ExpectNear(v4.position, {2, 0, 0});
  ExpectNear(OnlyLight("LightSource \"point\" \"float power\" -1").emission, glm::vec3(1));
}

TEST(PbrtLights, SpotLightsAreRead) {
  const PunctualLight light = OnlyLight(
      "Rotate 90 0 0 1 LightSource \"spot\" \"rgb I\" [3 2 1] \"point3 from\" [1 0 0] \"point3 "
      "to\" "
      "[2 0 0] \"float coneangle\" 40 \"float conedeltaangle\" 10");
  EXPECT_EQ(light.kind, LocalLightKind::kSpot);
  ExpectNear(light.emission, {3, 2, 1});
  ExpectNear(light.position, {0, 1, 0});
  ExpectNear(light.direction, {0, 1, 0});
  EXPECT_NEAR(light.cos_dark, std::cos(glm::radians(40.0f)), 1e-6);
  EXPECT_NEAR(light.cos_full, std::cos(glm::radians(30.0f)), 1e-6);
  const PunctualLight plain = OnlyLight("LightSource \"spot\" \"float power\" 5");
  ExpectNear(plain.direction, {0, 0, 1});
  EXPECT_NEAR(plain.cos_dark, std::cos(glm::radians(30.0f)), 1e-6);
  EXPECT_NEAR(plain.cos_full, std::cos(glm::radians(25.0f)), 1e-6);
  // The range between the cones counts half of its solid angle.
  const double sr = 2 * kPi * (1 - plain.cos_full) + kPi * (plain.cos_full - plain.cos_dark);
  EXPECT_NEAR(plain.emission.x * sr, 5, 1e-4);
  EXPECT_EQ(plain.curve, SpotCurve::kSmoothStep);
  // An inner cone of a negative angle is one of the same cosine.
  const PunctualLight beyond =
      OnlyLight("LightSource \"spot\" \"float coneangle\" 30 \"float conedeltaangle\" 40");
  EXPECT_NEAR(beyond.cos_full, std::cos(glm::radians(10.0f)), 1e-6);
}

// In pbrt-v3, light falls by the fourth power between the cones.
TEST(PbrtLights, SpotsOfVersion3FallFaster) {
  PunctualLight spot = {.cos_full = 0.9f, .cos_dark = 0.4f, .curve = SpotCurve::kFourth};
  EXPECT_NEAR(SpotSolidAngle(spot), 2 * kPi * (0.1 + 0.5 / 5), 1e-6);
  spot.curve = SpotCurve::kSquare;
  EXPECT_NEAR(SpotSolidAngle(spot), 2 * kPi * (0.1 + 0.5 / 3), 1e-6);
  const Scene scene =
      ParsePbrt("WorldBegin LightSource \"spot\" \"float coneangle\" 40 Shape \"sphere\" WorldEnd",
                "v3.pbrt", {});
  EXPECT_EQ(scene.lights.at(0).curve, SpotCurve::kFourth);
}

// A uniform sky of radiance 1 gives every surface pi.
TEST(PbrtLights, SkiesHaveTheirIlluminance) {
  const std::string sky = "LightSource \"infinite\" \"rgb L\" [1 2 3] \"float scale\" 2 ";
  const Scene scene = Parse(sky + "\"float illuminance\" 6");
  EXPECT_EQ(scene.warnings, std::vector<std::string>{});
  ExpectNear(scene.environments.at(0).scale, glm::vec3(2, 4, 6) * float(6 / kPi));
  for (const char* none : {"-1", "0"}) {
    ExpectNear(Parse(sky + "\"float illuminance\" " + none).environments.at(0).scale, {2, 4, 6});
  }
}

// A map's own illuminance is that of its upper half, of which pbrt-v4 counts a half.
TEST(PbrtLights, MapsHaveTheirIlluminance) {
  const TemporaryFolder folder;
  Image square(64, 64);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      // The upper half lies around the middle; what is below does not count.
      const bool above = std::abs(x - 31.5) + std::abs(y - 31.5) < 32;
      for (int c = 0; c < 3; ++c) square.Pixel(x, y)[c] = above ? 2.0f : 7.0f;
    }
  }
  WriteImage(folder.Path("sky.pfm"), square);
  const auto scale = [&](const std::string& more) {
    const Scene scene =
        ParsePbrt("WorldBegin LightSource \"infinite\" \"string filename\" \"sky.pfm\" " + more,
                  folder.Path("t.pbrt"), {.strict = true});
    return scene.environments.at(0).scale.y;
  };
  EXPECT_EQ(scale(""), 1);
  EXPECT_NEAR(scale("\"float illuminance\" 6"), 6 / (0.5 * 2 * kPi), 2e-3);
  WriteImage(folder.Path("sky.pfm"), Image(64, 32));
  EXPECT_ANY_THROW(scale("\"float illuminance\" 6")) << "strict";
}

// The speed of the film makes all light brighter.
TEST(PbrtLights, FollowTheSpeedOfTheFilm) {
  const Scene scene = ParsePbrt(
      "Film \"rgb\" \"float iso\" 250\nWorldBegin\n"
      "LightSource \"infinite\" \"rgb L\" [1 2 4] LightSource \"point\" \"rgb I\" [2 4 6]\n"
      "AreaLightSource \"diffuse\" \"rgb L\" [4 0 2] Shape \"disk\"",
      "t.pbrt", {.strict = true});
  ExpectNear(scene.environments.at(0).scale, {2.5f, 5, 10});
  ExpectNear(scene.lights.at(0).emission, {5, 10, 15});
  ExpectNear(scene.materials.at(scene.meshes.at(0).material).emission, {10, 0, 5});
  EXPECT_THROW(ParsePbrt("Film \"rgb\" \"float iso\" 0", "t.pbrt"), InputError);
}

// So does the time for which the shutter is open, in version 4.
TEST(PbrtLights, FollowTheShutter) {
  const auto scale = [](const std::string& times, const std::string& end) {
    const Scene scene =
        ParsePbrt("Film \"rgb\" \"float iso\" 200\nCamera \"perspective\" " + times +
                      "\nWorldBegin LightSource \"infinite\" \"rgb L\" [1 2 4]\n" + end,
                  "t.pbrt", {.strict = true});
    return scene.environments.at(0).scale;
  };
  ExpectNear(scale("\"float shutterclose\" .25", ""), {0.5f, 1, 2});
  ExpectNear(scale("\"float shutteropen\" .25", ""), {1.5f, 3, 6});
  ExpectNear(scale("\"float shutteropen\" 3 \"float shutterclose\" 5", ""), {4, 8, 16});
  ExpectNear(scale("\"float shutterclose\" .25", "WorldEnd"), {2, 4, 8});
  const std::string never = "Camera \"orthographic\" \"float shutterclose\" ";
  EXPECT_THROW(ParsePbrt(never + "0", "t.pbrt"), InputError);
  EXPECT_THROW(ParsePbrt(never + "-1", "t.pbrt"), InputError);
  EXPECT_NO_THROW(ParsePbrt(never + "0 WorldBegin WorldEnd", "t.pbrt"));
}

// Returns what a light sends from its position to a point of the world, over its emission.
glm::dvec3 SentTo(const Scene& scene, const glm::dvec3& point) {
  const PunctualLight& light = scene.lights.at(0);
  return OracleLightFactor(light, scene.images, point - glm::dvec3(light.position));
}

// A cone that its transform stretches is no cone of a circle any more: below the light the ellipse
// is 1 wide and 3 deep, in units of the round one.
TEST(PbrtLights, StretchedSpotsAreRead) {
  const std::string spot = "LightSource \"spot\" \"point3 from\" [0 4 0] \"point3 to\" [0 0 0]";
  const Scene scene = Parse("Translate 1 0 0 Scale 1 1 3 " + spot);
  EXPECT_TRUE(scene.warnings.empty());
  const double rim = 4 * std::tan(kPi / 6), full = 4 * std::tan(25 * kPi / 180);
  for (const auto& [x, z] : {std::pair{1.0, 0.0}, {0.0, 3.0}, {0.6, 0.8 * 3}}) {
    EXPECT_EQ(SentTo(scene, {1 + 1.001 * rim * x, 0, 1.001 * rim * z}).x, 0) << x;
    EXPECT_GT(SentTo(scene, {1 + 0.99 * rim * x, 0, 0.99 * rim * z}).x, 0) << x;
    EXPECT_LT(SentTo(scene, {1 + 1.01 * full * x, 0, 1.01 * full * z}).x, 1) << x;
    EXPECT_NEAR(SentTo(scene, {1 + 0.999 * full * x, 0, 0.999 * full * z}).x, 1, 1e-6) << x;
  }
  EXPECT_EQ(Parse("Rotate 30 1 2 3 Scale 3 3 -3 " + spot).lights.at(0).kind, LocalLightKind::kSpot);
}

// pbrt-v4 lays the square with its middle along y and its sides along x and z.
TEST(PbrtLights, GoniometricLightsAreRead) {
  const std::string light =
      "Translate 1 2 3 LightSource \"goniometric\" \"rgb I\" [1 2 3] "
      "\"string filename\" \"image.pfm\" ";
  const auto parse = [&](const std::string& more) {
    const auto color = [](int x, int y) { return glm::vec3(1 + x, 1 + x, 1 + x + 30 * y); };
    return ParseWithImage(MadeImage(4, 4, color), light + more);
  };
  const Scene scene = parse("\"float scale\" 2");
  EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.at(0);
  ExpectNear(scene.lights.at(0).emission, {2, 4, 6});
  ExpectNear(scene.lights.at(0).position, {1, 2, 3});
  // Texel (x, y) has the value 1 + x + 10 y in every channel. Up (y) is the middle of the square.
  const auto value = [&](const glm::dvec3& to) {
    const glm::dvec3 sent = SentTo(scene, to + glm::dvec3(1, 2, 3));
    EXPECT_EQ(sent.x, sent.z);
    return sent.x;
  };
  EXPECT_NEAR(value({0.1, 5, 0.1}), 1 + 2 + 20, 1e-5);
  EXPECT_NEAR(value({-0.1, 5, -0.1}), 1 + 1 + 10, 1e-5);
  EXPECT_NEAR(value({5, 0.1, 0.1}), 1 + 3 + 20, 1e-5);   // right of the middle
  EXPECT_NEAR(value({-0.1, 0.1, 5}), 1 + 1 + 30, 1e-5);  // below the middle
  EXPECT_NEAR(value({0.1, -5, 0.1}), 1 + 3 + 30, 1e-5);  // a corner
  const Scene powerful = parse("\"float power\" 8");
  ExpectNear(powerful.lights.at(0).emission,
             glm::vec3(1, 2, 3) * float(8 / (4 * kPi * (2.5 + 15))));
  EXPECT_THROW(ParseWithImage(Image(4, 2), light), InputError);
}

// pbrt-v3 has a lat-long image, whose first row is up (y) and whose columns turn from +x to +z, and
// whose colours count.
TEST(PbrtLights, GoniometricLightsOfVersionThreeAreRead) {
  const TemporaryFolder folder;
  const int width = 128, height = 64;
  Image image(width, height);
  const auto factor = [&](double turn, double down) {
    return 1.5 + glm::dvec3(std::sin(down) * std::cos(turn), std::sin(down) * std::sin(turn),
                            std::cos(down));
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const glm::dvec3 value = factor(2 * kPi * (x + 0.5) / width, kPi * (y + 0.5) / height);
      for (int c = 0; c < 3; ++c) image.Pixel(x, y)[c] = float(value[c]);
    }
  }
  WriteImage(folder.Path("image.pfm"), image);
  const auto parse = [&](const std::string& more) {
    return ParsePbrt("WorldBegin Translate 1 2 3 LightSource \"goniometric\" " + more,
                     folder.Path("t.pbrt"), {.strict = true});
  };
  const Scene scene =
      parse("\"rgb I\" [1 2 3] \"rgb scale\" [2 2 1] \"string mapname\" \"image.pfm\"");
  ExpectNear(scene.lights.at(0).emission, {2, 4, 3});
  for (int i = 0; i < 200; ++i) {
    const double up = 1 - (i + 0.5) / 100, turn = std::fmod(i * 2.4, 2 * kPi);
    const double side = std::sqrt(1 - up * up);
    const glm::dvec3 to(side * std::cos(turn), up, side * std::sin(turn));
    const glm::dvec3 expected = factor(turn, std::acos(up));
    const glm::dvec3 sent = SentTo(scene, glm::dvec3(1, 2, 3) + to);
    // A texel of the square is 0.06 wide, over which the factor changes by a tenth at most.
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(sent[c] / expected[c], 1, 0.15) << up << " " << turn;
  }
  const std::string map = "\"string mapname\" \"image.pfm\" ";
  const Scene two = parse(map + "LightSource \"goniometric\" " + map);
  EXPECT_EQ(two.lights.at(0).form->image, two.lights.at(1).form->image);
  // A narrow image has no more texels as a square.
  WriteImage(folder.Path("image.pfm"), Image(1, 16384));
  const Scene narrow = parse(map);
  EXPECT_EQ(narrow.images.at(narrow.lights.at(0).form->image.value()).width, 128);
  // Without an image it is a point.
  const Scene plain = parse("\"rgb I\" [1 2 3]");
  EXPECT_EQ(SentTo(plain, {2, 3, 4}), glm::dvec3(1));
}

// pbrt-v3 projects the first row to the bottom, by default in a square of 45 degrees.
TEST(PbrtLights, ProjectionLightsOfVersionThreeAreRead) {
  const TemporaryFolder folder;
  Image image(1, 2);
  for (int i = 0; i < 6; ++i) image.rgb[std::size_t(i)] = float(1 + i);
  WriteImage(folder.Path("image.pfm"), image);
  const auto parse = [&](const std::string& more) {
    return ParsePbrt("WorldBegin LightSource \"projection\" " + more, folder.Path("t.pbrt"),
                     {.strict = true});
  };
  const Scene scene = parse("\"rgb I\" [2 2 2] \"string mapname\" \"image.pfm\"");
  const double half = std::tan(kPi / 8);
  EXPECT_EQ(SentTo(scene, {0.9 * half, -1.9 * half, 1}), glm::dvec3(1, 2, 3));
  EXPECT_EQ(SentTo(scene, {-0.9 * half, 1.9 * half, 1}), glm::dvec3(4, 5, 6));
  EXPECT_EQ(SentTo(scene, {1.02 * half, 0, 1}), glm::dvec3(0));
  EXPECT_EQ(SentTo(scene, {0, 2.02 * half, 1}), glm::dvec3(0));
  EXPECT_EQ(scene.images.size(), 1u);  // however many lights project it
  const Scene plain = parse("");
  EXPECT_EQ(SentTo(plain, {0.98 * half, 0.98 * half, 1}), glm::dvec3(1));
  EXPECT_EQ(SentTo(plain, {1.02 * half, 0, 1}), glm::dvec3(0));
}

// The image is upright for an eye behind the light, and `fov` is that of its shorter side.
TEST(PbrtLights, ProjectionLightsAreRead) {
  const auto parse = [](const std::string& more) {
    const auto color = [](int x, int y) { return glm::vec3(1 + x + 4 * y, 0, x + 4 * y == 7); };
    return ParseWithImage(MadeImage(4, 2, color),
                          "Translate 1 0 0 LightSource \"projection\" \"string filename\" "
                          "\"image.pfm\" \"float fov\" 60 " +
                              more);
  };
  const Scene scene = parse("\"float scale\" 2");
  EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.at(0);
  ExpectNear(scene.lights.at(0).emission, glm::vec3(2));
  const double half = std::tan(kPi / 6);
  const auto value = [&](double x, double y, double z) {
    return SentTo(scene, {1 + x * 2 * half, y * half, z});
  };
  EXPECT_EQ(value(-0.9, 0.9, 1), glm::dvec3(1, 0, 0));
  EXPECT_EQ(value(0.9, 0.9, 1), glm::dvec3(4, 0, 0));
  EXPECT_EQ(value(0.98, -0.98, 1), glm::dvec3(8, 0, 1));
  EXPECT_EQ(value(1.02, 0, 1), glm::dvec3(0));
  EXPECT_EQ(value(0, -1.02, 1), glm::dvec3(0));
  EXPECT_EQ(value(0.1, 0.1, -1), glm::dvec3(0));
  // The power is that of pbrt-v4: a sum over texels of luminance by the cosine's third power.
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    const double x = (i % 4 - 1.5) / 2 * 2 * half, y = (0.5 - i / 4) * half;
    sum += (0.2125 * (1 + i) + 0.0721 * (i == 7)) * std::pow(1 + x * x + y * y, -1.5);
  }
  ExpectNear(parse("\"float power\" 8").lights.at(0).emission,
             glm::vec3(float(8 / (sum * half * half))));
  EXPECT_THROW(parse("\"float fov\" 180"), InputError);
  // The default of version 4 is 90 degrees: the picture is as far away as it is high by halves.
  const Scene wide = ParseWithImage(MadeImage(4, 2, [](int, int) { return glm::vec3(1); }),
                                    "LightSource \"projection\" \"string filename\" \"image.pfm\"");
  EXPECT_EQ(SentTo(wide, {0, 0.98, 1}), glm::dvec3(1));
  EXPECT_EQ(SentTo(wide, {0, 1.02, 1}), glm::dvec3(0));
  EXPECT_EQ(SentTo(wide, {1.98, 0, 1}), glm::dvec3(1));
  EXPECT_EQ(SentTo(wide, {2.02, 0, 1}), glm::dvec3(0));
}

TEST(PbrtLights, DistantLightsAreRead) {
  const PunctualLight light = OnlyLight(
      "Rotate 90 1 0 0 LightSource \"distant\" \"rgb L\" [1 2 3] \"float scale\" 2 \"point3 from\" "
      "[0 0 5] \"point3 to\" [0 0 1] \"float illuminance\" 10");
  EXPECT_EQ(light.kind, LocalLightKind::kDistant);
  ExpectNear(light.emission, {20, 40, 60});
  ExpectNear(light.direction, {0, -1, 0});  // towards the light
  ExpectNear(OnlyLight("LightSource \"distant\"").direction, {0, 0, -1});
}

TEST(PbrtLights, AttributesGiveParametersToLights) {
  const Scene scene = Parse(
      std::string("AttributeBegin Attribute \"light\" \"float scale\" 3 LightSource \"point\" "
                  "LightSource \"point\" \"float scale\" 2 AreaLightSource \"diffuse\"") +
      kTriangle + "AttributeEnd LightSource \"point\"");
  EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.at(0);
  ASSERT_EQ(scene.lights.size(), 3u);
  ExpectNear(scene.lights[0].emission, glm::vec3(3));
  ExpectNear(scene.lights[1].emission, glm::vec3(2));
  ExpectNear(scene.lights[2].emission, glm::vec3(1));
  ExpectNear(scene.materials[scene.meshes.at(0).material].emission, glm::vec3(3));
}

// The side of the normals emits: that of the winding, or the opposite one if it is reversed; a
// mirror image of the shape emits on the mirror image of that side.
TEST(PbrtLights, ReverseOrientationTurnsTheShiningSide) {
  const auto side = [](const std::string& before) {
    const Scene scene = Parse(before + " AreaLightSource \"diffuse\"" + kTriangle);
    const LocalLights lights(scene, Geometry(scene, "t", 1), "t", 1, 0);
    const LocalLight& light = lights.view().lights[0];
    const glm::vec3 axis(light.axis[0], light.axis[1], light.axis[2]);
    return glm::cross(axis, glm::vec3(light.edge[0], light.edge[1], light.edge[2])).z;
  };
  EXPECT_GT(side(""), 0);
  EXPECT_LT(side("ReverseOrientation"), 0);
  EXPECT_GT(side("Scale -1 1 1"), 0);
  EXPECT_LT(side("Scale 1 1 -1"), 0);
}

TEST(PbrtLights, InstancesShine) {
  const Scene scene =
      Parse(std::string("ObjectBegin \"a\" AreaLightSource \"diffuse\"") + kTriangle +
            "ObjectEnd ObjectInstance \"a\" Translate 5 0 0 "
            "ObjectInstance \"a\"");
  const LocalLights lights(scene, Geometry(scene, "t", 1), "t", 1, 0);
  ASSERT_EQ(lights.view().count, 2u);
  EXPECT_EQ(lights.view().lights[1].position[0], 5);
}

TEST(PbrtLights, InvalidLightsAreRefusedWithTheirLine) {
  for (const auto& [text, reason] : std::initializer_list<std::pair<std::string, const char*>>{
           {"LightSource \"point\" \"rgb I\" [1 -1 1]", "negative"},
           {"LightSource \"distant\" \"float scale\" -2", "negative"},
           {"LightSource \"spot\" \"rgb I\" [1e30 1 1]", "1e18"},
           {"LightSource \"point\" \"float power\" 1e30", "power"},
           {"LightSource \"point\" \"point3 from\" [0 0 0 1 1 1]", "takes one point"},
           {"LightSource \"spot\" \"point3 to\" [0 0 0]", "no direction"},
           {"LightSource \"distant\" \"point3 from\" [0 0 1]", "no direction"},
           {"LightSource \"spot\" \"float coneangle\" 0", "cone"},
           {"LightSource \"spot\" \"float coneangle\" 181", "cone"},
           {"LightSource \"spot\" \"float conedeltaangle\" -1", "cone"},
           {"AreaLightSource \"diffuse\" \"rgb L\" [-1 1 1]", "negative"},
           {"AreaLightSource \"diffuse\" \"float power\" 1 Shape \"trianglemesh\" \"point3 P\" "
            "[0 0 0 1 0 0 2 0 0]",
            "area"}}) {
    try {
      Parse("\n" + text);
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_EQ(error.exit_code(), kExitBadInput);
      EXPECT_TRUE(std::string(error.what()).starts_with("t.pbrt:3: ")) << error.what();
      EXPECT_NE(std::string(error.what()).find(reason), std::string::npos) << error.what();
    }
  }
}

// pbrt-v3 gives a temperature and a scale.
TEST(PbrtLights, BlackBodiesHaveAScale) {
  const auto emission = [](const std::string& body) {
    return OnlyLight("LightSource \"point\" \"blackbody I\" " + body).emission;
  };
  const glm::vec3 two = emission("[5000 2]"), six = emission("[5000 6]");
  EXPECT_GT(two.b, 0);
  EXPECT_GT(two.r, two.b) << "5000 K is warmer than daylight";
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(six[c] / two[c], 3, 1e-5) << c;
}

}  // namespace
}  // namespace skywave
