// Tests the methods by which one job renders its scene beside its own, as comparisons do.
#include <gtest/gtest.h>

#include <string>

#include "base/error.h"
#include "job/job.h"
#include "tests/support/temporary_folder.h"
#include "wavefront/integrator.h"

namespace skywave {
namespace {

class RenderMethods : public testing::Test {
 protected:
  // The job renders by `direct`: nothing of its own is made for light paths.
  RenderMethods() {
    folder_.Write("sky.pfm", "PF\n2 1\n-1.0\n" + std::string(12, '\x3f') + std::string(12, '\x42'));
    request_.scene = "spheres";
    request_.environment.path = folder_.Path("sky.pfm");
    request_.options.integrator = Integrator::kDirect;
    request_.options.width = 8, request_.options.height = 6;
  }

  TemporaryFolder folder_;
  JobRequest request_;
};

// MIS compensation leaves directions to BSDF samples, and product draws for a surface: light paths
// that started with either would miss light.
TEST_F(RenderMethods, LightPathsStartWithAStrategyThatCanEmit) {
  const RenderJob job(request_);
  ASSERT_FALSE(CanEmit(job.strategy()));
  for (const Integrator integrator : ValuesOf<Integrator>()) {
    const IntegratorDescriptor& described = Describe(integrator);
    for (const std::string specification : {"importance", "product", "warp", "hybrid:lights=8"}) {
      SCOPED_TRACE(std::string(ToString(integrator)) + " " + specification);
      if (described.light_paths == LightPaths::kStrategy && specification != "importance" &&
          specification != "warp") {
        EXPECT_THROW(job.MakeMethod(specification, integrator), InputError);
        continue;
      }
      const RenderMethod method = job.MakeMethod(specification, integrator);
      const FrameView frame = job.frame(method);
      EXPECT_EQ(frame.options.integrator, integrator);
      EXPECT_EQ(frame.strategy, method.strategy.get());
      if (described.has_light_paths()) {
        EXPECT_TRUE(CanEmit(*frame.emitter));
        EXPECT_EQ(frame.emitter == frame.strategy, CanEmit(*frame.strategy));
      }
    }
  }
}

}  // namespace
}  // namespace skywave
