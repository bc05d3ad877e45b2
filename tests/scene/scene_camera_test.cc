// Tests cameras, films, filters and other options of scenes, and conversions between kinds of
// cameras.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "base/error.h"
#include "scene/pbrt/reader.h"
#include "scene/scene.h"
#include "tests/support/expect_near.h"

namespace skywave {
namespace {

Scene Parse(const std::string& text) { return ParsePbrt(text, "t.pbrt"); }

// Returns the camera of a scene that must not give any warning.
Camera OnlyCamera(const std::string& text) {
  const Scene scene = Parse(text);
  EXPECT_EQ(scene.warnings, std::vector<std::string>{}) << text;
  return scene.camera.value();
}

TEST(PbrtCamera, ThinLensesAreRead) {
  const Camera camera = OnlyCamera(
      "Camera \"perspective\" \"float fov\" 40 \"float lensradius\" .5 \"float focaldistance\" 7");
  EXPECT_EQ(camera.kind, CameraKind::kPerspective);
  EXPECT_EQ(camera.lens_radius, 0.5f);
  EXPECT_EQ(camera.focal_distance, 7);
  EXPECT_FALSE(camera.window);
  const Camera pinhole = OnlyCamera("Camera \"perspective\"");
  EXPECT_EQ(pinhole.lens_radius, 0);
  EXPECT_EQ(pinhole.focal_distance, 1e6f);  // pbrt's default
}

TEST(PbrtCamera, OrthographicCamerasAndScreenWindowsAreRead) {
  const Camera camera = OnlyCamera(
      "Camera \"orthographic\" \"float screenwindow\" [-2 3 -1 4] \"float lensradius\" .1");
  EXPECT_EQ(camera.kind, CameraKind::kOrthographic);
  EXPECT_EQ(camera.lens_radius, 0.1f);
  ASSERT_TRUE(camera.window);
  EXPECT_EQ(camera.window->left, -2);
  EXPECT_EQ(camera.window->right, 3);
  EXPECT_EQ(camera.window->bottom, -1);
  EXPECT_EQ(camera.window->top, 4);
  // The window is [-1, 1] on the shorter side.
  const ScreenWindow wide =
      OnlyCamera("Camera \"perspective\" \"float frameaspectratio\" 2").window.value();
  EXPECT_EQ(wide.right, 2);
  EXPECT_EQ(wide.top, 1);
  const ScreenWindow tall =
      OnlyCamera("Camera \"perspective\" \"float frameaspectratio\" .5").window.value();
  EXPECT_EQ(tall.right, 1);
  EXPECT_EQ(tall.bottom, -2);
}

TEST(PbrtCamera, SphericalCamerasAreOrientedAsInPbrt) {
  // pbrt's direction is (sin theta cos phi, cos theta, sin theta sin phi) at phi = 2 pi u. The
  // middle of the picture looks along -x, three quarters along -z, the top along +y.
  for (const char* text :
       {"Camera \"environment\"", "Camera \"spherical\" \"string mapping\" \"equirectangular\""}) {
    const Camera camera = OnlyCamera(std::string("Translate -1 -2 -3 ") + text);
    EXPECT_EQ(camera.kind, CameraKind::kLatLong);
    ExpectNear(camera.world_from_camera[2], {-1, 0, 0});
    ExpectNear(camera.world_from_camera[0], {0, 0, -1});
    ExpectNear(camera.world_from_camera[1], {0, 1, 0});
    ExpectNear(camera.world_from_camera[3], {1, 2, 3});
  }
  const Camera square = OnlyCamera("Camera \"spherical\"");
  EXPECT_EQ(square.kind, CameraKind::kEqualArea);
  EXPECT_EQ(square.world_from_camera, glm::mat4(1));
  EXPECT_EQ(Parse("Camera \"spherical\" \"string mapping\" \"fisheye\"").warnings.size(), 1u);
  EXPECT_EQ(Parse("Camera \"realistic\" \"string lensfile\" \"a.dat\"").warnings.size(), 1u);
}

TEST(PbrtFilm, CropWindowsAreRead) {
  const auto crop = Parse("Film \"rgb\" \"float cropwindow\" [.25 .5 0 1]").settings.crop;
  ASSERT_TRUE(crop);
  EXPECT_EQ(crop->left, 0.25f);
  EXPECT_EQ(crop->right, 0.5f);
  EXPECT_EQ(crop->top, 0);
  EXPECT_EQ(crop->bottom, 1);
  EXPECT_FALSE(Parse("Film \"rgb\"").settings.crop);
  // The ends are put in order, and what is beyond the film is cut off.
  const auto swapped = Parse("Film \"rgb\" \"float cropwindow\" [.5 .25 3 -1]").settings.crop;
  ASSERT_TRUE(swapped);
  EXPECT_EQ(swapped->left, 0.25f);
  EXPECT_EQ(swapped->right, 0.5f);
  EXPECT_EQ(swapped->top, 0);
  EXPECT_EQ(swapped->bottom, 1);
}

TEST(PbrtFilm, PixelBoundsEndWithTheFilm) {
  for (const std::string bounds : {"[-3 5 2 99]", "[5 -3 99 2]"}) {
    const auto crop = Parse(
                          "Film \"rgb\" \"integer xresolution\" 10 \"integer yresolution\" 8 "
                          "\"integer pixelbounds\" " +
                          bounds)
                          .settings.crop;
    ASSERT_TRUE(crop);
    EXPECT_EQ(crop->left, 0);
    EXPECT_EQ(std::ceil(double(crop->right) * 10), 5);
    EXPECT_EQ(std::ceil(double(crop->top) * 8), 2);
    EXPECT_EQ(std::ceil(double(crop->bottom) * 8), 8);
  }
}

TEST(PbrtFilm, PixelBoundsAreKeptExactly) {
  // Crops are rounded up to pixels (job/job.cc).
  for (int right = 2; right <= 700; ++right) {
    const auto crop = Parse(
                          "Film \"rgb\" \"integer xresolution\" 700 \"integer yresolution\" 33 "
                          "\"integer pixelbounds\" [" +
                          std::to_string(right - 1) + " " + std::to_string(right) + " 0 33]")
                          .settings.crop;
    ASSERT_TRUE(crop);
    EXPECT_EQ(std::ceil(double(crop->left) * 700), right - 1);
    EXPECT_EQ(std::ceil(double(crop->right) * 700), right);
    EXPECT_EQ(std::ceil(double(crop->top) * 33), 0);
    EXPECT_EQ(std::ceil(double(crop->bottom) * 33), 33);
  }
}

TEST(PbrtCamera, InvalidCamerasAreRefused) {
  const std::pair<const char*, const char*> cases[] = {
      {"\nCamera \"perspective\" \"float lensradius\" -1", "t.pbrt:2: "},
      {"Camera \"orthographic\" \"float focaldistance\" 0", "t.pbrt:1: "},
      {"Camera \"perspective\" \"float screenwindow\" [0 1 0]", "t.pbrt:1: "},
      {"Camera \"perspective\" \"float screenwindow\" [1 0 0 1]", "t.pbrt:1: "},
      {"Camera \"perspective\" \"float frameaspectratio\" 0", "t.pbrt:1: "},
      {"\nFilm \"rgb\" \"float cropwindow\" [1 2 0 1]", "t.pbrt:2: "},
      {"Film \"rgb\" \"float cropwindow\" [.5 .5 0 1]", "t.pbrt:1: "},
      {"Film \"rgb\" \"float cropwindow\" [0 1]", "t.pbrt:1: "},
  };
  for (const auto& [text, place] : cases) {
    try {
      Parse(text);
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with(place)) << text << " -> " << error.what();
    }
  }
}

TEST(CameraKinds, OrthographicShowsTheMiddleAtTheSameSize) {
  const Bounds bounds{{-1, -1, -1}, {1, 1, 1}};
  const Camera before = LookAtCamera({0, 0, 8}, {0, 0, 0}, {0, 1, 0}, 30, false);
  const Camera after = WithKind(before, CameraKind::kOrthographic, bounds, 'y', false);
  EXPECT_EQ(after.kind, CameraKind::kOrthographic);
  const float half = 8 * std::tan(glm::radians(15.0f));
  EXPECT_NEAR(glm::length(glm::vec3(after.world_from_camera[0])), half, 1e-5f);
  EXPECT_NEAR(glm::length(glm::vec3(after.world_from_camera[1])), half, 1e-5f);
  ExpectNear(after.world_from_camera[2], {0, 0, -1});
}

// The middle may lie beside the axis, and a lens keeps its size in the world.
TEST(CameraKinds, OrthographicKeepsDepthAndLens) {
  const Bounds bounds{{-1, -1, -1}, {1, 1, 1}};
  Camera before = LookAtCamera({3, 0, 8}, {3, 0, 0}, {0, 1, 0}, 30, false);
  before.lens_radius = 0.25f, before.focal_distance = 6;
  const Camera after = WithKind(before, CameraKind::kOrthographic, bounds, 'y', false);
  const float side = glm::length(glm::vec3(after.world_from_camera[0]));
  EXPECT_NEAR(side, 8 * std::tan(glm::radians(15.0f)), 1e-5f);
  EXPECT_NEAR(after.lens_radius * side, 0.25f, 1e-6f);
  EXPECT_NEAR(after.focal_distance * glm::length(glm::vec3(after.world_from_camera[2])), 6, 1e-5f);
}

TEST(CameraKinds, SphericalCamerasStandUpright) {
  const Bounds bounds{{-1, -1, -1}, {1, 1, 1}};
  for (const bool left_handed : {false, true}) {
    const Camera before = FrameBounds(bounds, 'z', left_handed);
    const Camera after = WithKind(before, CameraKind::kLatLong, bounds, 'z', left_handed);
    ExpectNear(after.world_from_camera[1], {0, 0, 1});
    EXPECT_NEAR(after.world_from_camera[2].z, 0, 1e-6f);
    EXPECT_EQ(after.world_from_camera[3], before.world_from_camera[3]);
    ExpectNear(after.world_from_camera[0], before.world_from_camera[0]);
  }
}

TEST(Camera, IsTheInverseOfTheTransform) {
  const Scene scene = Parse("LookAt 1 2 3  1 2 10  0 1 0 Camera \"perspective\" \"float fov\" 35");
  ASSERT_TRUE(scene.camera);
  EXPECT_TRUE(scene.left_handed);
  EXPECT_FLOAT_EQ(scene.camera->fov_degrees, 35);
  const glm::mat4& m = scene.camera->world_from_camera;
  ExpectNear(m[0], {1, 0, 0});
  ExpectNear(m[1], {0, 1, 0});
  ExpectNear(m[2], {0, 0, 1});
  ExpectNear(m[3], {1, 2, 3});
  EXPECT_FLOAT_EQ(Parse("Camera \"perspective\"").camera->fov_degrees, 90);
  EXPECT_FLOAT_EQ(Parse("Camera \"perspective\" \"float halffov\" 20").camera->fov_degrees, 40);
}

TEST(Camera, FrameIsRightHandedSeenInItsWorld) {
  for (const bool left_handed : {false, true}) {
    const Camera camera = LookAtCamera({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 40, left_handed);
    // Looking along -z with y up, right is +x if the axes are right-handed.
    ExpectNear(camera.world_from_camera[0], {left_handed ? -1.0f : 1.0f, 0, 0});
    ExpectNear(camera.world_from_camera[1], {0, 1, 0});
    ExpectNear(camera.world_from_camera[2], {0, 0, -1});
  }
}

TEST(Camera, FramesBounds) {
  const Bounds bounds{{-3, 10, -1}, {5, 12, 2}};
  for (const char up : {'x', 'y', 'z'}) {
    for (const bool left_handed : {false, true}) {
      for (const float aspect : {1.0f, 2.5f, 0.4f}) {
        const Camera camera = FrameBounds(bounds, up, left_handed, aspect);
        const float wide = std::max(aspect, 1.0f), tall = std::max(1 / aspect, 1.0f);
        const glm::mat4 to_camera = glm::inverse(camera.world_from_camera);
        const float slope = std::tan(glm::radians(0.5f * camera.fov_degrees));
        float widest = 0;
        for (int corner = 0; corner < 8; ++corner) {
          const glm::vec3 p(to_camera * glm::vec4(corner & 1 ? bounds.high.x : bounds.low.x,
                                                  corner & 2 ? bounds.high.y : bounds.low.y,
                                                  corner & 4 ? bounds.high.z : bounds.low.z, 1));
          ASSERT_GT(p.z, 0);
          widest = std::max({widest, std::abs(p.x / p.z) / wide, std::abs(p.y / p.z) / tall});
        }
        EXPECT_LT(widest, slope);
        EXPECT_GT(widest, 0.8f * slope);  // not smaller than necessary either
        // The view is from above: the eye is higher than the centre.
        const int axis = up - 'x';
        EXPECT_GT(camera.world_from_camera[3][axis], 0.5f * (bounds.low + bounds.high)[axis]);
      }
    }
  }
}

// Three sides of a box are seen, and a sheet across any axis is not a line.
TEST(Camera, FramesBoundsFromTheFrontTheRightAndAbove) {
  for (const char up : {'x', 'y', 'z'}) {
    for (const bool left_handed : {false, true}) {
      const Camera camera = FrameBounds({{-1, -1, -1}, {1, 1, 1}}, up, left_handed);
      const glm::mat3 axes = EnvironmentFrame(up, left_handed, 0);  // right, forward, up
      const glm::vec3 eye = glm::transpose(axes) * glm::vec3(camera.world_from_camera[3]);
      EXPECT_GT(eye.x, 1.5f);
      EXPECT_LT(eye.y, -1.5f);
      EXPECT_GT(eye.z, 0.5f);
      EXPECT_GT(-eye.y, eye.x);  // more of the front than of the side
    }
  }
}

TEST(EnvironmentFrame, IsNeverMirroredAndTurnsCounterClockwise) {
  for (const char up : {'x', 'y', 'z'}) {
    for (const bool left_handed : {false, true}) {
      for (const float degrees : {0.0f, 30.0f, 200.0f}) {
        const glm::mat3 f = EnvironmentFrame(up, left_handed, degrees);
        const glm::vec3 cross = glm::cross(f[1], f[2]);
        ExpectNear(f[0], left_handed ? -cross : cross);
      }
      // A quarter turn to the left moves forward to the former left.
      const glm::mat3 still = EnvironmentFrame(up, left_handed, 0);
      const glm::mat3 turned = EnvironmentFrame(up, left_handed, 90);
      ExpectNear(turned[1], -still[0]);
      ExpectNear(turned[2], still[2]);
    }
  }
  ExpectNear(EnvironmentFrame('y', false, 0)[1], {0, 0, -1});
  ExpectNear(EnvironmentFrame('z', false, 0)[1], {0, 1, 0});
  ExpectNear(EnvironmentFrame('x', false, 0)[1], {0, 1, 0});
  ExpectNear(EnvironmentFrame('y', true, 0)[1], {0, 0, 1});
  ExpectNear(EnvironmentFrame('x', true, 0)[0], {0, 0, -1});
}

TEST(PbrtOptions, FillTheSettings) {
  const RenderSettings v3 =
      Parse(
          "Film \"image\" \"integer xresolution\" [320] \"integer yresolution\" [200]\n"
          "Sampler \"halton\" \"integer pixelsamples\" 48\n"
          "Integrator \"directlighting\" \"integer maxdepth\" [3]\n"
          "PixelFilter \"gaussian\" \"float xwidth\" [2] \"float ywidth\" [2]\n")
          .settings;
  EXPECT_EQ(v3.width, 320);
  EXPECT_EQ(v3.height, 200);
  EXPECT_EQ(v3.samples_per_pixel, 48);
  EXPECT_EQ(v3.integrator, "direct");
  EXPECT_EQ(v3.max_depth, 3);
  EXPECT_EQ(v3.filter, PixelFilter::kGaussian);
  // Version 3's standard deviation is a half by itself. Ours is a third of the radius.
  EXPECT_EQ(v3.filter_radius, 1.5f);
  const RenderSettings v4 = Parse(
                                "Integrator \"volpath\" PixelFilter \"triangle\" "
                                "\"float xradius\" 1.5 \"float yradius\" 1.5 Sampler "
                                "\"stratified\" \"integer xsamples\" 4 \"integer ysamples\" 3")
                                .settings;
  EXPECT_EQ(v4.integrator, "path");
  EXPECT_FALSE(v4.photons_each_sample);
  EXPECT_EQ(v4.filter, PixelFilter::kTriangle);
  EXPECT_EQ(v4.filter_radius, 1.5f);
  EXPECT_EQ(v4.samples_per_pixel, 12);
  EXPECT_EQ(Parse("PixelFilter \"box\"").settings.filter, PixelFilter::kBox);
  EXPECT_EQ(Parse("PixelFilter \"triangle\"").settings.filter_radius, 2);
  // What a file leaves out is pbrt's default, which the two versions do not share.
  const RenderSettings bare4 = Parse("WorldBegin").settings;
  EXPECT_EQ(bare4.width, 1280);
  EXPECT_EQ(bare4.height, 720);
  EXPECT_EQ(bare4.filter, PixelFilter::kGaussian);
  const RenderSettings bare3 = Parse("WorldBegin WorldEnd").settings;
  EXPECT_EQ(bare3.width, 1280);
  EXPECT_EQ(bare3.height, 720);
  EXPECT_EQ(bare3.filter, PixelFilter::kBox);
  // The last filter counts, and has nothing of those before it.
  EXPECT_FALSE(Parse("PixelFilter \"triangle\" PixelFilter \"box\"").settings.filter_radius);
}

TEST(PbrtOptions, GaussiansHaveTheirDeviationsWhereTheyEndLate) {
  const auto radius = [](const std::string& text) {
    return Parse("PixelFilter \"gaussian\" " + text).settings.filter_radius.value();
  };
  EXPECT_FLOAT_EQ(radius(""), 1.5f);
  EXPECT_FLOAT_EQ(radius("\"float sigma\" .25"), 0.75f);
  EXPECT_FLOAT_EQ(radius("\"float xradius\" 4 \"float yradius\" 4 \"float sigma\" 1"), 3.0f);
  EXPECT_FLOAT_EQ(radius("\"float xradius\" 2 \"float yradius\" 2 \"float sigma\" 1"), 2.0f);
  // exp(-8 x^2) has a standard deviation of a quarter.
  EXPECT_FLOAT_EQ(radius("\"float alpha\" 8 WorldBegin WorldEnd"), 0.75f);
  EXPECT_FLOAT_EQ(radius("WorldBegin WorldEnd"), 1.5f);
}

// Files of version 4 may have the word in comments and strings.
TEST(PbrtOptions, OnlyTheDirectiveWorldEndMakesAFileOneOfVersion3) {
  const auto filter = [](const std::string& text) { return Parse(text).settings.filter; };
  for (const char* const text : {"WorldBegin # WorldEnd",
                                 "WorldBegin\nMakeNamedMaterial \"WorldEnd\" \"string type\" "
                                 "\"diffuse\"\n# a \"WorldEnd\"\n",
                                 "# WorldEnd\r\nWorldBegin"}) {
    EXPECT_EQ(filter(text), PixelFilter::kGaussian) << text;
  }
  for (const char* const text : {"WorldBegin WorldEnd", "WorldBegin\nWorldEnd # WorldEnd",
                                 "WorldBegin # \"\nWorldEnd", "WorldBegin\n# a\r  WorldEnd\n#"}) {
    EXPECT_EQ(filter(text), PixelFilter::kBox) << text;
  }
}

// The names of version 4 have no type, and a value is one word or string.
TEST(PbrtOptions, AreReadAndChangeNothingButWhatIsSaid) {
  const Scene scene = Parse(
      "Option \"seed\" 5 Option \"disablepixeljitter\" true Option \"render_coord_sys\" \"world\" "
      "Option \"forcediffuse\" false WorldBegin");
  ReadOptions strict;
  strict.strict = true;
  EXPECT_NO_THROW(ParsePbrt("Option \"Seed\" 5 WorldBegin", "t.pbrt", strict));
  EXPECT_THROW(ParsePbrt("Option \"forcediffuse\" true WorldBegin", "t.pbrt", strict), InputError);
  EXPECT_NO_THROW(ParsePbrt("Option \"displacementedgescale\" 1 WorldBegin", "t.pbrt", strict));
  for (const std::string name : {"displacementedgescale", "nonsense", "renderingspace"}) {
    EXPECT_THROW(ParsePbrt("Option \"" + name + "\" 2 WorldBegin", "t.pbrt", strict), InputError)
        << name;
  }
  EXPECT_THROW(Parse("Option \"seed\" [5] WorldBegin"), InputError);
  EXPECT_THROW(Parse("Option seed 5 WorldBegin"), InputError);
}

TEST(PbrtOptions, LimitsOfSamplesAreThoseOfTheirVersion) {
  const auto settings_of = [](const std::string& film, const std::string& end) {
    return Parse("Film " + film + " WorldBegin Shape \"sphere\" " + end).settings;
  };
  const RenderSettings v4 =
      settings_of("\"rgb\" \"float iso\" 200 \"float maxcomponentvalue\" 4", "");
  EXPECT_EQ(v4.largest_of_sample, 4.0f);
  EXPECT_FALSE(v4.luminance_of_sample);
  const RenderSettings v3 =
      settings_of("\"image\" \"float maxsampleluminance\" 4 \"float scale\" 2", "WorldEnd");
  EXPECT_EQ(v3.luminance_of_sample, 8.0f);
  EXPECT_FALSE(v3.largest_of_sample);
  EXPECT_FALSE(
      Parse("Film \"rgb\" \"float maxcomponentvalue\" 1e30 WorldBegin").settings.largest_of_sample);
  EXPECT_THROW(Parse("Film \"rgb\" \"float maxcomponentvalue\" 0"), InputError);
}

TEST(PbrtOptions, NameTheIntegrator) {
  EXPECT_EQ(Parse("Integrator \"bdpt\"").settings.integrator, "bdpt");
  EXPECT_EQ(Parse("Integrator \"lightpath\"").settings.integrator, "light");
  EXPECT_EQ(Parse("Integrator \"mlt\"").settings.integrator, "path");
  const RenderSettings sppm =
      Parse("Integrator \"sppm\" \"integer numiterations\" 24 \"float radius\" 0.25").settings;
  EXPECT_EQ(sppm.integrator, "photon");
  EXPECT_EQ(sppm.samples_per_pixel, 24);
  EXPECT_TRUE(sppm.photons_each_sample);
  EXPECT_EQ(sppm.photon_distance, 0.25f);
  EXPECT_THROW(Parse("Integrator \"sppm\" \"float radius\" 0"), InputError);
}

}  // namespace
}  // namespace skywave
