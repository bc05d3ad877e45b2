// Tests files of light sets: what is read is what was written, and bad files are named.
#include "lights/light_sets/light_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "base/error.h"
#include "base/files.h"
#include "lights/light_sets/light_builder.h"
#include "lights/light_sets/probe_lights.h"
#include "lights/light_sets/voronoi.h"
#include "tests/support/light_test_maps.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

class LightFile : public testing::Test {
 protected:
  LightSet Read(const std::string& text, const SphereMap& map) {
    WriteFileAtomically(path_, text);
    return ReadLightFile(path_, map);
  }
  // Returns the reason for which a file is refused, with its place.
  std::string Refused(const std::string& text) {
    try {
      Read(text, map_);
    } catch (const InputError& error) {
      EXPECT_EQ(error.exit_code(), kExitBadInput);
      return error.what();
    }
    return "";
  }

  TemporaryFolder folder_;
  std::string path_ = folder_.Path("set.json");
  Image image_ = test::SunMap(64, 32, 200);
  SphereMap map_ = MakeSphereMap(image_);
};

void ExpectSame(const LightSet& a, const LightSet& b) {
  ASSERT_EQ(a.lights.size(), b.lights.size());
  for (std::size_t i = 0; i < a.lights.size(); ++i) {
    EXPECT_EQ(a.lights[i].direction, b.lights[i].direction);
    // Sums of the same texels, in whatever runs.
    EXPECT_NEAR(a.lights[i].energy, b.lights[i].energy, 1e-12 * b.lights[i].energy);
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(a.lights[i].irradiance[c], b.lights[i].irradiance[c],
                  1e-12 * b.lights[i].irradiance[c]);
    }
  }
  EXPECT_EQ(a.cell_of_texel, b.cell_of_texel);
}

TEST_F(LightFile, HoldsTheLightsThatWereWritten) {
  for (const Named<LightSource>& source : kEnumNames<LightSource>) {
    SCOPED_TRACE(source.name);
    for (const bool bright : {false, true}) {
      LightRequest request = {.lights = {.source = source.value, .lights = 20}, .strata = {}};
      if (bright) request.strata = StrataRequest{};
      const LightSet set = MakeProbeLights(map_, request).set;
      ExpectSame(Read(LightFileText(set, 64, 32, {}), map_), set);
    }
  }
}

TEST_F(LightFile, ServesTheMapAtAnyExposure) {
  const LightSet set = BuildLights(map_, {.lights = 20});
  Image twice = image_;
  for (float& value : twice.rgb) value *= 2;
  const LightSet read = Read(LightFileText(set, 64, 32, {}), MakeSphereMap(twice));
  for (std::size_t i = 0; i < set.lights.size(); ++i) {
    EXPECT_NEAR(read.lights[i].energy, 2 * set.lights[i].energy, 1e-9 * set.lights[i].energy);
  }
}

// A file of another program may hold nothing but directions, or places in the map.
TEST_F(LightFile, WithoutCellsThoseOfVoronoiAreMade) {
  const std::vector<Vector3> samples = {DirectionOfUv(0.3, 0.25), DirectionOfUv(0.75, 0.5)};
  const LightSet expected = VoronoiLights(map_, samples, LightPosition::kSample);
  ExpectSame(Read(R"({"samples": [{"uv": [0.3, 0.25]}, {"uv": [0.75, 0.5]}]})", map_), expected);
  nlohmann::json json;
  for (const Vector3& s : samples) json["samples"].push_back({{"direction", {s.x, s.y, s.z}}});
  ExpectSame(Read(json.dump(), map_), expected);
}

// A set of a map of any size is where that of the next one begins.
TEST_F(LightFile, IsFollowedByTheLightsOfAnotherMap) {
  const LightSet set =
      MakeProbeLights(map_, {.lights = {.source = LightSource::kPenrose, .lights = 20}}).set;
  WriteFileAtomically(path_, LightFileText(set, 64, 32, {}));
  const std::vector<Vector3> directions = ReadLightDirections(path_);
  ASSERT_EQ(directions.size(), set.lights.size());
  for (std::size_t i = 0; i < directions.size(); ++i) {
    EXPECT_EQ(directions[i], set.lights[i].direction);
  }
  const Image other = test::SunMap(32, 16, 100);
  const SphereMap next = MakeSphereMap(other);
  const LightRequest request = {
      .lights = {.source = LightSource::kKMeans, .lights = 3}, .strata = {}, .follow = path_};
  const LightSet following = MakeProbeLights(next, request).set;
  EXPECT_EQ(following.lights.size(), set.lights.size());
  LightRequest nowhere = request;
  nowhere.follow = folder_.Path("none.json");
  EXPECT_THROW(MakeProbeLights(next, nowhere), InputError);
}

TEST_F(LightFile, BadFilesAreNamedWithTheirFault) {
  const std::string cells =
      R"({"width": 64, "height": 32, "samples": [{"uv": [0.5, 0.5]}], "cells": )";
  const auto rows = [&](const std::string& first) {
    std::string text = cells + "[" + first;
    for (int y = 1; y < 32; ++y) text += ", [[0, 64]]";
    return text + "]}";
  };
  EXPECT_EQ(Refused(rows("[[0, 64]]")), "");
  const std::pair<std::string, std::string> faults[] = {
      {"{", "set.json (byte 2): is not JSON"},
      {"{}", "is no light set"},
      {R"({"samples": []})", "there are no samples"},
      {R"({"samples": [{"uv": [0.5, 0.5]}, {}]})", "sample 1 has neither a direction nor uv"},
      {R"({"samples": [{"uv": [0.5, 1.5]}]})", "sample 0 has uv outside [0, 1]"},
      {R"({"samples": [{"direction": [0, 0, 2]}]})",
       "sample 0 has a direction that is not of length 1"},
      {R"({"samples": [{"direction": [0, 0]}]})", "is no light set"},
      {R"({"width": 32, "height": 32, "samples": [{"uv": [0.5, 0.5]}], "cells": []})",
       "has cells of a map of 32x32, and this one is 64x32"},
      {rows("[[0, 63]]"), "row 0 of the cells is not 64 texels long"},
      {rows("[[0, 65]]"), "row 0 of the cells is not 64 texels long"},
      {rows("[[0, 1000000000000000]]"), "row 0 of the cells is not 64 texels long"},
      {rows("[[0, 0], [0, 64]]"), "row 0 of the cells is not 64 texels long"},
      {rows("[[1, 64]]"), "cell 1 has no sample: there are 1"},
      {rows("[[-2, 64]]"), "cell -2 has no sample"},
      {rows("[[0, 64]], [[0, 64]]"), "there are cells of 33 rows, the map has 32"}};
  for (const auto& [text, fault] : faults) {
    const std::string refused = Refused(text);
    EXPECT_NE(refused.find(fault), std::string::npos) << fault << "\n" << refused;
    EXPECT_NE(refused.find("set.json"), std::string::npos) << refused;
  }
}

}  // namespace
}  // namespace skywave
