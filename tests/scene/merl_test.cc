// Tests measured BRDFs of the MERL format: reading, refusals and the fitted sampling lobe.

#include "scene/materials/merl.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "base/error.h"
#include "tests/support/bsdf_cases.h"

namespace skywave {
namespace {

constexpr std::size_t kBins = kMeasuredFloats / 3;
constexpr double kScale[3] = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};

// Returns the synthetic table as a file.
std::string MerlFile() {
  const std::vector<float> table = SyntheticMeasuredTable();
  const std::int32_t dims[3] = {90, 90, 180};
  std::string bytes(sizeof dims + 3 * kBins * sizeof(double), 0);
  std::memcpy(bytes.data(), dims, sizeof dims);
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      const double value = double(table[3 * bin + c]) / kScale[c];
      std::memcpy(bytes.data() + sizeof dims + (c * kBins + bin) * sizeof value, &value,
                  sizeof value);
    }
  }
  return bytes;
}
void SetValue(std::string& bytes, std::size_t index, double value) {
  std::memcpy(bytes.data() + 12 + index * sizeof value, &value, sizeof value);
}
std::string ErrorOf(const std::string& bytes) {
  try {
    ParseMerl(bytes, "x.binary");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Merl, ReadsWhatWasWritten) {
  std::string bytes = MerlFile();
  SetValue(bytes, 7, -1);  // not measured
  const MeasuredBrdf brdf = ParseMerl(bytes, "x.binary");
  const std::vector<float> table = SyntheticMeasuredTable();
  ASSERT_EQ(brdf.rgb.size(), table.size());
  EXPECT_EQ(brdf.rgb[3 * 7], 0);
  for (std::size_t i = 3 * 8; i < table.size(); i += 97) {
    ASSERT_NEAR(brdf.rgb[i], table[i], 1e-6 * table[i]) << i;
  }
}

// The gloss of the synthetic table is GGX of width 0.3.
TEST(Merl, FindsTheWidthOfTheGloss) {
  const MeasuredBrdf brdf = ParseMerl(MerlFile(), "x.binary");
  EXPECT_NEAR(brdf.alpha, 0.3, 0.06);
  EXPECT_GT(brdf.specular_share, 0.1);
  EXPECT_LT(brdf.specular_share, 0.6);
}

TEST(Merl, InvalidTablesAreRefused) {
  const std::string good = MerlFile();
  ASSERT_EQ(ErrorOf(good), "");
  EXPECT_NE(ErrorOf(""), "");
  EXPECT_NE(ErrorOf(good.substr(0, 11)), "");
  EXPECT_NE(ErrorOf(good.substr(0, good.size() - 1)), "");
  EXPECT_NE(ErrorOf(good + "x"), "");
  std::string bad = good;
  bad[0] = 91;
  EXPECT_NE(ErrorOf(bad).find("91 x 90 x 180"), std::string::npos);
  for (const double value : {std::nan(""), std::numeric_limits<double>::infinity(), -1e300}) {
    bad = good;
    SetValue(bad, 1000, value);
    EXPECT_NE(ErrorOf(bad).find("not finite"), std::string::npos);
  }
}

}  // namespace
}  // namespace skywave
