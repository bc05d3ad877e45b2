// Tests tables of names: every enum that has one is read as it was written.
#include "base/names.h"

#include <gtest/gtest.h>

#include <set>

#include "bench/measure/error_split.h"
#include "bench/measure/suite.h"
#include "lights/light_sets/light_builder.h"
#include "lights/maps/projections.h"
#include "lights/probe/export_lights.h"
#include "scene/local_lights.h"
#include "wavefront/integrator.h"
#include "wavefront/option_names.h"
#include "wavefront/rays/trace.h"

namespace skywave {
namespace {

template <class Enum>
class Names : public testing::Test {};

using NamedEnums = testing::Types<Backend, CameraKind, ClusterFrequency, ErrorMeasure, Integrator,
                                  LightFormat, LightPosition, LightSource, LocalLightKind,
                                  PhotonKernel, PictureCheck, PixelFilter, Projection>;
TYPED_TEST_SUITE(Names, NamedEnums);

TYPED_TEST(Names, BelongToOneValueEach) {
  std::set<std::string_view> names;
  int next = 0;
  for (const TypeParam value : ValuesOf<TypeParam>()) {
    EXPECT_EQ(int(value), next++);
    EXPECT_EQ(Parse<TypeParam>(ToString(value)), value);
    names.insert(ToString(value));
  }
  EXPECT_EQ(names.size(), kEnumNames<TypeParam>.size());
  EXPECT_EQ(names.count(""), 0u);
  EXPECT_FALSE(Parse<TypeParam>("nosuch"));
  EXPECT_FALSE(Parse<TypeParam>(""));
}

TEST(NameChoices, AreListedInTheOrderOfTheTable) {
  EXPECT_EQ(Choices<PixelFilter>(), "box|triangle|gaussian|blackman-harris|mitchell|sinc");
}

}  // namespace
}  // namespace skywave
