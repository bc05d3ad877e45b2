// What integrators say of themselves goes together, and their workers have the tables.
#include "wavefront/integrator.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "wavefront/integrators/path.h"
#include "wavefront/policies/control_pilot.h"
#include "wavefront/policies/emission_pilot.h"
#include "wavefront/records/photon_map.h"
#include "wavefront/render_option.h"
#include "wavefront/stages/light_stages.h"
#include "wavefront/stages/path_stages.h"
#include "wavefront/worker.h"

namespace skywave {
namespace {

TEST(Integrators, DescribeThemselvesWithoutContradiction) {
  for (const Integrator integrator : ValuesOf<Integrator>()) {
    SCOPED_TRACE(ToString(integrator));
    const IntegratorDescriptor& described = Describe(integrator);
    EXPECT_FALSE(described.help.empty());
    EXPECT_NE(described.render_wave, nullptr);
    EXPECT_LE(described.describe_passes != nullptr, described.for_each_pass != nullptr);
    EXPECT_LE(described.pass_each_sample, described.for_each_pass != nullptr);
    EXPECT_LE(described.has_splats, described.has_light_paths());
    // Where nothing else brings direct light, light paths have to.
    EXPECT_TRUE(described.light_samples != LightSamples::kNone || described.has_splats);
  }
}

TEST(Integrators, GiveWorkersWhatTheyNeed) {
  for (const Integrator integrator : ValuesOf<Integrator>()) {
    SCOPED_TRACE(ToString(integrator));
    const IntegratorDescriptor& described = Describe(integrator);
    RenderOptions options;
    options.integrator = integrator;
    options.wave = 16;
    const std::unique_ptr<Worker> worker = MakeWorker(options);
    EXPECT_EQ(worker->tables.find<LightPathTables>() != nullptr, described.has_light_paths());
    EXPECT_EQ(worker->tables.find<Continuations>(), nullptr);
    EXPECT_EQ(worker->tables.find<ControlTables>(), nullptr);
    if (!Takes(integrator, "split")) continue;
    options.bsdf_samples = 2;
    options.of<ControlOptions>().control = ControlVariate::kIrradiance;
    const std::unique_ptr<Worker> splitting = MakeWorker(options);
    EXPECT_NE(splitting->tables.find<ControlTables>(), nullptr);
    const auto* const continuations = splitting->tables.find<Continuations>();
    ASSERT_NE(continuations, nullptr);
    EXPECT_NE(continuations->wave.tables.find<ControlTables>(), nullptr);
  }
}

// Copies of options share what neither changes, and nothing else.
TEST(RenderOptions, OfIntegratorsAreCopiedWithTheOthers) {
  RenderOptions options;
  EXPECT_EQ(options.of<PhotonOptions>().gather, PhotonOptions().gather);
  options.of<PhotonOptions>().gather = 3;
  options.of<GuideOptions>().guide = true;
  RenderOptions copy = options;
  copy.of<PhotonOptions>().gather = 5;
  EXPECT_EQ(options.of<PhotonOptions>().gather, 3u);
  EXPECT_EQ(copy.of<PhotonOptions>().gather, 5u);
  EXPECT_TRUE(copy.of<GuideOptions>().guide);
}

TEST(RenderOptions, OfIntegratorsHaveOneLineEach) {
  const std::vector<RenderOption>& table = RenderOptionTable();
  for (const RenderOption& option : table) {
    SCOPED_TRACE(option.name);
    EXPECT_EQ(std::count_if(table.begin(), table.end(),
                            [&](const RenderOption& other) { return other.name == option.name; }),
              1);
    EXPECT_FALSE(IntegratorsOf(option).empty());
  }
  EXPECT_TRUE(Takes(Integrator::kVcm, "photons"));
  EXPECT_FALSE(Takes(Integrator::kVcm, "gather"));
  EXPECT_FALSE(Takes(Integrator::kDirect, "photons"));
}

}  // namespace
}  // namespace skywave
