// Renders scenes of which each pixel is known exactly unless rays start or end wrongly: on the far
// side of the surface that they leave, beyond the next one, or before an occluder.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "base/error.h"
#include "scene/geometry.h"
#include "scene/instances.h"
#include "scene/shapes/mesh.h"
#include "tests/support/random_rows.h"
#include "tests/support/render_scenes.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

// Each light sample of a matt surface in constant light brings the same, so pixels have no noise.
Image Picture(const Scene& scene, int size = 16, std::uint32_t depth = 2) {
  JobRequest request = SmallRequest(size, size, 16);
  request.strategy = "cosine";
  request.max_depth = depth;
  const RenderJob job(scene, request);
  Film film = job.MakeFilm();
  RenderFrame(job.frame(), film);
  return film.Resolve(16);
}

double Mean(const Image& image) {
  double sum = 0;
  for (const float value : image.rgb) sum += value;
  return sum / double(image.rgb.size());
}

double Darkest(const Image& image) { return *std::min_element(image.rgb.begin(), image.rgb.end()); }

// Returns two triangles around the origin, with corners of no round numbers. Their angles are near
// `aspect`.
Mesh Floor(float size, float aspect) {
  Mesh mesh;
  const glm::mat4 turn = glm::rotate(glm::mat4(1), 0.3f, glm::vec3(1, 2, 3));
  for (const glm::vec2 corner :
       {glm::vec2(-1, -.7f), glm::vec2(1, -.9f), glm::vec2(1.1f, 1), glm::vec2(-.8f, 1)}) {
    mesh.positions.emplace_back(turn * glm::vec4(size * corner.x, 0, size / aspect * corner.y, 1));
  }
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}};
  return mesh;
}

Scene LitScene() {
  Scene scene;
  AddLambert(scene, "matt", glm::vec3(0.5f));
  SetConstantLight(scene, 1);
  scene.camera = LookAtCamera({3, 4, 1}, {0, 0, 0}, {0, 1, 0}, 5, false);
  return scene;
}

// Embree cannot tell how far a ray begins from the plane of a triangle better than to some 2^-24 of
// its size: of floors of 10^4 a twentieth of the light was lost as long as only the ray's own
// coordinates counted.
TEST(RayOrigins, FloorsOfAnySizeDoNotShadowThemselves) {
  for (const float aspect : {1.0f, 20.0f}) {
    for (const float size : {10.0f, 1e3f, 1e4f, 1e5f, 1e6f}) {
      Scene scene = LitScene();
      Place(scene, Floor(size, aspect), 0, glm::vec3(0));
      EXPECT_NEAR(Darkest(Picture(scene)), 0.5, 1e-5) << "floor of " << size << " by 1/" << aspect;
    }
  }
}

TEST(RayOrigins, InstancesDoNotShadowThemselves) {
  for (const float scale : {1e-3f, 1.0f, 1e3f}) {
    Scene scene = LitScene();
    Object& object = scene.objects.emplace_back();
    object.meshes.push_back(Floor(1e3f / scale, 1));
    const glm::mat4 to = glm::scale(glm::translate(glm::mat4(1), glm::vec3(0, -.5f, 0)),
                                    glm::vec3(scale, 2 * scale, -scale));
    scene.instances.push_back({.object = 0, .world_from_object = glm::dmat4x3(to)});
    EXPECT_NEAR(Darkest(Picture(scene)), 0.5, 1e-5) << "instance of " << scale;
  }
}

// A matt sheet under one that lets everything through, nearer than a hundred-thousandth of their
// size. A ray that begins beyond the upper one would be lost.
TEST(RayOrigins, SheetsCloseTogetherAreToldApart) {
  for (const float gap : {1e-5f, 1e-4f, 1e-2f}) {
    Scene scene = LitScene();
    const std::uint32_t clear = AddLambert(scene, "clear", glm::vec3(1));
    scene.materials[clear].bsdf = BsdfKind::kDielectric;
    scene.materials[clear].ior = 1;
    Place(scene, Quad(1), 0, glm::vec3(0));
    Place(scene, Quad(1), clear, glm::vec3(0, 2 * gap, 0));
    scene.camera = LookAtCamera({0, 4, 1}, {0, 0, 0}, {0, 1, 0}, 5, false);
    EXPECT_NEAR(Mean(Picture(scene, 16, 8)), 0.5, 0.01) << "gap of " << gap;
  }
}

// The picture is the same at every scale that is rendered, and no other is.
TEST(RayOrigins, PicturesAreTheSameAtAnyScale) {
  const auto mean_at = [](float scale) {
    Scene scene = LitScene();
    Place(scene, Quad(2 * scale), 0, glm::vec3(0));
    Place(scene, Sphere(0.5f * scale, 8), 0, glm::vec3(0, 0.5f * scale, 0));
    scene.camera = LookAtCamera(scale * glm::vec3(3, 4, 1), glm::vec3(0), {0, 1, 0}, 30, false);
    return Mean(Picture(scene, 32));
  };
  const double mean = mean_at(1);
  for (const float scale : {1e-6f, 1e-3f, 1e3f, 1e6f, 1e8f}) {
    EXPECT_NEAR(mean_at(scale), mean, 1e-3) << "scale " << scale;
  }
  for (const float scale : {1e-15f, 1e-9f, 1e-7f, 1e10f, 1e20f}) {
    EXPECT_THROW(mean_at(scale), InputError) << "scale " << scale;
  }
}

// So it is for maps of every radiance that is rendered.
TEST(RayOrigins, PicturesAreTheSameForAnyRadiance) {
  const auto mean_of = [](float radiance) {
    Scene scene = LitScene();
    Place(scene, Quad(2), 0, glm::vec3(0));
    Place(scene, Sphere(0.5f, 8), 0, glm::vec3(0, 0.5f, 0));
    SetConstantLight(scene, radiance);
    scene.camera = LookAtCamera({3, 4, 1}, glm::vec3(0), {0, 1, 0}, 30, false);
    return Mean(Picture(scene, 32, 8)) / radiance;
  };
  const double mean = mean_of(1);
  for (const float radiance : {1e-19f, 1e-15f, 1e-10f, 1e-7f, 1e-4f, 1e5f, 1e15f, 1e30f}) {
    EXPECT_NEAR(mean_of(radiance), mean, 1e-3 * mean) << "radiance " << radiance;
  }
  EXPECT_THROW(mean_of(1e-21f), InputError);
}

// Both materials of a mixture have records of their own, with the corners of its triangle.
TEST(RayOrigins, MixturesAreWhereTheirTrianglesAre) {
  Scene scene = LitScene();
  AddLambert(scene, "white", glm::vec3(1));
  scene.materials.push_back({.name = "mixture", .mixture = Mixture{0, 1, 0.4f}});
  Place(scene, Quad(1), 0, glm::vec3(0));
  Place(scene, Quad(2), 2, glm::vec3(0, 1, 0));
  const Geometry geometry(scene, "scene");
  ASSERT_EQ(geometry.triangle_count(), 4u);
  ASSERT_EQ(geometry.record_count(), 8u);
  const std::uint32_t* const corners = geometry.triangle_tables().corners;
  for (std::uint32_t record = 0; record < geometry.record_count(); ++record) {
    const std::uint32_t triangle = geometry.TriangleOf(record);
    EXPECT_TRUE(std::equal(corners + 3 * record, corners + 3 * record + 3, corners + 3 * triangle))
        << "record " << record;
  }
}

// Returns a closed box around the origin whose walls are cells with shared corners, at random
// places but for those of the rims.
Mesh BoxOfCells(int cells) {
  Mesh box;
  Random random(5);
  const glm::vec3 corners[6] = {{-1, -1, -1}, {-1, -1, 1},  {-1, -1, -1},
                                {1, -1, -1},  {-1, -1, -1}, {-1, 1, -1}};
  const glm::vec3 x(2, 0, 0), y(0, 2, 0), z(0, 0, 2);
  const glm::vec3 sides[6][2] = {{x, y}, {x, y}, {y, z}, {y, z}, {x, z}, {x, z}};
  const auto jitter = [&] { return float(random.Between(-0.3, 0.3)) / float(cells); };
  for (int wall = 0; wall < 6; ++wall) {
    const auto first = std::uint32_t(box.positions.size());
    for (int j = 0; j <= cells; ++j) {
      for (int i = 0; i <= cells; ++i) {
        const bool inside = i > 0 && i < cells && j > 0 && j < cells;
        const float a = float(i) / float(cells) + (inside ? jitter() : 0);
        const float b = float(j) / float(cells) + (inside ? jitter() : 0);
        box.positions.push_back(corners[wall] + a * sides[wall][0] + b * sides[wall][1]);
      }
    }
    const auto line = std::uint32_t(cells + 1);
    for (std::uint32_t j = 0; j + 1 < line; ++j) {
      for (std::uint32_t i = 0; i + 1 < line; ++i) {
        const std::uint32_t at = first + j * line + i;
        box.triangles.push_back({at, at + 1, at + line + 1});
        box.triangles.push_back({at, at + line + 1, at + line});
      }
    }
  }
  return box;
}

// Embree tests the triangles on both sides of an edge by products that round differently, so four
// rays of a million slip through.
TEST(RayOrigins, NoLightComesIntoClosedRooms) {
  Scene scene;
  AddLambert(scene, "matt", glm::vec3(0.5f));
  SetConstantLight(scene, 1);
  Place(scene, BoxOfCells(60), 0, glm::vec3(0));
  scene.camera = LookAtCamera({0.1f, 0.05f, 0.02f}, {1, 0.3f, 0.2f}, {0, 1, 0}, 100, false);
  JobRequest request = SmallRequest(128, 128, 128);
  request.max_depth = 3;
  const RenderJob job(scene, request);
  Film film = job.MakeFilm();
  RenderFrame(job.frame(), film);
  const Image image = film.Resolve(128);
  EXPECT_EQ(*std::max_element(image.rgb.begin(), image.rgb.end()), 0);
}

// Small sheets a little above a floor hide a part of the light, however far the camera is.
TEST(RayOrigins, OrthographicCamerasSeeTheSameFromAnyDistance) {
  const auto mean_from = [](float distance) {
    Scene scene = LitScene();
    Place(scene, Quad(4), 0, glm::vec3(0));
    for (int i = 0; i < 64; ++i) {
      const glm::vec3 at(float(i % 8) * 0.7f - 2.4f, 0.02f, float(i / 8) * 0.7f - 2.4f);
      Place(scene, Quad(0.1f), 0, at);
    }
    scene.camera =
        LookAtCamera(distance * glm::vec3(0, 0.9f, 0.436f), glm::vec3(0), {0, 1, 0}, 45, false);
    scene.camera->kind = CameraKind::kOrthographic;
    scene.camera->window = ScreenWindow{-3, 3, -3, 3};
    return Mean(Picture(scene, 64));
  };
  const double near = mean_from(10);
  EXPECT_LT(near, 0.495);
  for (const float distance : {1e2f, 1e3f, 1e4f, 1e5f, 1e6f}) {
    EXPECT_NEAR(mean_from(distance), near, 5e-4) << "from " << distance;
  }
}

}  // namespace
}  // namespace skywave
