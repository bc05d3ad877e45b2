// Compares the engine with the oracle in scenes of glass and of alpha.
#include <gtest/gtest.h>

#include "lights/strategies/strategy.h"
#include "scene/shapes/mesh.h"
#include "tests/support/oracle.h"
#include "tests/support/render_scenes.h"
#include "tests/support/same_as_oracle.h"
#include "tests/support/screens_scene.h"
#include "tests/support/shade_points.h"

namespace skywave {
namespace {

// In closed bodies the index ratios of the two sides cancel; here light crosses one side only, into
// the glass or out of it, before it reaches environment, floor or eye.
TEST(OraclePictures, LightThatCrossesOneSideOfAGlassAgrees) {
  for (const bool upside_down : {false, true}) {
    SCOPED_TRACE(upside_down);
    Scene scene;
    Place(scene, Quad(8), AddLambert(scene, "floor", {0.5f, 0.55f, 0.6f}), {0, -1, 0});
    Mesh sheet = Quad(1.5f);
    if (upside_down) FlipOrientation(sheet);
    Place(scene, sheet, AddGlass(scene, 1.5f), {0, 0.2f, 0});
    SetLight(scene, SkyWithSun(64, 32, 8, 0.5));
    scene.camera = LookAtCamera({0.4f, 1.9f, 4.5f}, {0, 0, 0}, {0, 1, 0}, 40, false);
    ExpectSame(scene, Request(Integrator::kPath, 6));
  }
}

TEST(OraclePictures, TheEyeWithinGlassAgrees) {
  Scene scene;
  Place(scene, Sphere(2, 8), AddGlass(scene, 1.5f), glm::vec3(0));
  SetLight(scene, SkyWithSun(64, 32, 8, 0.5));
  scene.camera = LookAtCamera({0.5f, 0.2f, 1}, {0, 0.3f, 0}, {0, 1, 0}, 70, false);
  ExpectSame(scene, Request(Integrator::kPath, 20));
}

TEST(OraclePictures, AlphaAndReliefAgree) {
  for (const Integrator integrator : {Integrator::kPath, Integrator::kDirect}) {
    JobRequest request = Request(integrator, 4);
    request.options.light_samples = 2;
    ExpectSame(ScreensScene(), request);
  }
}

// Every screen emits where it is, and so does the environment.
TEST(OraclePictures, AlphaInLightsAgrees) {
  Scene scene = ScreensScene();
  for (Material& material : scene.materials) {
    if (material.opaque()) continue;
    material.emission = {0.9f, 1.5f, 2};
    material.emits_on_both_sides = true;
  }
  for (const Integrator integrator : {Integrator::kPath, Integrator::kDirect}) {
    JobRequest request = Request(integrator, 3);
    request.options.light_samples = 2;
    ExpectSame(scene, request);
  }
}

}  // namespace
}  // namespace skywave
