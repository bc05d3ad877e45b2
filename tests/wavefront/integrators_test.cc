// What integrators say of themselves goes together, and their workers have the tables.
#include "wavefront/integrator.h"

#include <gtest/gtest.h>

#include "wavefront/worker.h"

namespace skywave {
namespace {

TEST(Integrators, DescribeThemselvesWithoutContradiction) {
  for (const Integrator integrator : ValuesOf<Integrator>()) {
    SCOPED_TRACE(ToString(integrator));
    const IntegratorDescriptor& described = Describe(integrator);
    EXPECT_FALSE(described.help.empty());
    EXPECT_NE(described.render_wave, nullptr);
    EXPECT_EQ(described.stores != StoredLight::kNothing, described.for_each_pass != nullptr);
    EXPECT_LE(described.pass_each_sample, described.has_photons());
    EXPECT_LE(described.has_photons(), described.has_light_paths());
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
    EXPECT_EQ(worker->light.has_value(), described.has_light_paths());
    EXPECT_EQ(worker->photon.has_value(), described.stores == StoredLight::kPhotons);
    EXPECT_EQ(worker->merging.has_value(), described.stores == StoredLight::kVertices);
    EXPECT_EQ(worker->virtual_lights.has_value(), described.stores == StoredLight::kLights);
    EXPECT_EQ(worker->irradiance.has_value(), described.stores == StoredLight::kIrradiance);
    EXPECT_EQ(worker->continuations, nullptr);
    if (!described.splits) continue;
    options.split = 2;
    EXPECT_NE(MakeWorker(options)->continuations, nullptr);
  }
}

}  // namespace
}  // namespace skywave
