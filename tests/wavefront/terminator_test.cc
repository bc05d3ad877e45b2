// Tests that coarse meshes with smooth normals are lit like the round surfaces that they stand for.
#include <gtest/gtest.h>

#include <algorithm>

#include "base/error.h"
#include "tests/support/film_layers.h"
#include "tests/support/render_scenes.h"
#include "wavefront/stages/terminator.h"

namespace skywave {
namespace {

constexpr double kInvPi = 0.31830988618379067;

// Returns a ball of 20 frequency^2 triangles with the normals of a sphere under a low sun.
Scene Ball(int frequency, bool as_instance = false) {
  Scene scene;
  const std::uint32_t chalk = AddLambert(scene, "chalk", glm::vec3(0.8f));
  if (as_instance) {
    scene.objects.push_back({.name = "ball", .meshes = {Sphere(1, frequency)}});
    scene.objects[0].meshes[0].material = chalk;
    glm::dmat4 turned(0.0);
    turned[0][2] = turned[1][1] = turned[2][0] = turned[3][3] = 1;  // mirrored, too
    scene.instances.push_back({.object = 0, .world_from_object = glm::dmat4x3(turned)});
  } else {
    Place(scene, Sphere(1, frequency), chalk, glm::vec3(0));
  }
  scene.lights.push_back({.kind = LocalLightKind::kDistant,
                          .emission = glm::vec3(3),
                          .direction = glm::normalize(glm::vec3(1, 0.35f, 0.1f))});
  scene.camera = LookAtCamera({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 30, false);
  return scene;
}

JobRequest Request(ShadowTerminator terminator) {
  JobRequest request = SmallRequest(48, 48, 16);
  request.integrator = Integrator::kDirect;
  request.options.of<TerminatorOptions>().terminator = terminator;
  return request;
}

Image Picture(const Scene& scene, const JobRequest& request) {
  const RenderJob job(scene, request);
  return Render(job).Resolve(job.options().samples_per_pixel);
}

// Returns the mean squared difference from what a matt surface of the shading normals reflects.
double Error(const Scene& scene, ShadowTerminator terminator) {
  const RenderJob job = MakeJob(scene, Request(terminator), "shading-normal");
  const Film film = Render(job);
  const Image picture = film.Resolve(job.options().samples_per_pixel);
  const Layers layers = ByName(film.ResolveAovs(job.options().samples_per_pixel));
  double sum = 0;
  for (int y = 14; y < 34; ++y) {
    for (int x = 14; x < 34; ++x) {  // away from the silhouette
      const auto pixel = std::size_t(48 * y + x);
      const glm::vec3 normal(layers.at("shading-normal.X")[pixel],
                             layers.at("shading-normal.Y")[pixel],
                             layers.at("shading-normal.Z")[pixel]);
      const double cosine = std::max(glm::dot(normal, scene.lights[0].direction), 0.0f);
      const double off = double(picture.Pixel(x, y)[0]) - 0.8 * kInvPi * 3 * cosine;
      sum += off * off;
    }
  }
  return sum / (20 * 20);
}

TEST(ShadowTerminator, OfACoarseBallIsThatOfItsNormals) {
  EXPECT_GT(Error(Ball(2), ShadowTerminator::kFacets), 1e-4);
  EXPECT_LT(Error(Ball(2), ShadowTerminator::kSmooth), 1e-5);
}

TEST(ShadowTerminator, IsSmoothOnMirroredInstances) {
  EXPECT_GT(Error(Ball(2, true), ShadowTerminator::kFacets), 1e-4);
  EXPECT_LT(Error(Ball(2, true), ShadowTerminator::kSmooth), 1e-5);
}

// Surfaces without normals, and glass, have nothing that could be rounded.
TEST(ShadowTerminator, LeavesFlatTrianglesAndGlass) {
  Scene scene = Ball(3);
  scene.meshes[0] = Facetted(scene.meshes[0]);
  EXPECT_EQ(Picture(scene, Request(ShadowTerminator::kSmooth)).rgb,
            Picture(scene, Request(ShadowTerminator::kFacets)).rgb);
  Scene glass = Ball(3);
  glass.materials.back().bsdf = BsdfKind::kDielectric;
  SetConstantLight(glass, 1);
  EXPECT_EQ(Picture(glass, Request(ShadowTerminator::kSmooth)).rgb,
            Picture(glass, Request(ShadowTerminator::kFacets)).rgb);
}

// A white ball under white light from everywhere gives back what it gets, up to what its coarse
// silhouette and its normals lose.
TEST(ShadowTerminator, KeepsTheLightOfAFurnace) {
  Scene scene = Ball(3);
  scene.lights.clear();
  scene.materials.back().reflectance = glm::vec3(1);
  SetConstantLight(scene, 1);
  JobRequest request = Request(ShadowTerminator::kSmooth);
  request.integrator = Integrator::kPath;
  request.max_depth = 32;
  const Image picture = Picture(scene, request);
  double sum = 0;
  for (int y = 12; y < 36; ++y) {
    for (int x = 12; x < 36; ++x) sum += double(picture.Pixel(x, y)[0]);
  }
  EXPECT_NEAR(sum / (24 * 24), 1, 0.004);
}

// Layers of the first surfaces are of the triangles.
TEST(ShadowTerminator, DoesNotChangeLayers) {
  const auto layers = [](ShadowTerminator terminator) {
    return Resolve(MakeJob(Ball(3), Request(terminator), "position,normal,shading-normal,depth"));
  };
  EXPECT_EQ(layers(ShadowTerminator::kSmooth), layers(ShadowTerminator::kFacets));
}

// Light paths bring flux by area of the triangles, not of what is round.
TEST(ShadowTerminator, IsOfPathsFromTheCamera) {
  JobRequest request = Request(ShadowTerminator::kSmooth);
  request.integrator = Integrator::kBdpt;
  EXPECT_THROW(Picture(Ball(3), request), OptionError);
}

}  // namespace
}  // namespace skywave
