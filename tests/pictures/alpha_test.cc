// Tests surfaces with alpha: which rays hit, which pass, and that opaque scenes pay nothing.
#include <gtest/gtest.h>

#include <cmath>

#include "kernels/surface/opacity.h"
#include "scene/geometry.h"
#include "scene/materials/texture_tables.h"
#include "scene/shapes/mesh.h"
#include "tests/support/random_rows.h"
#include "tests/support/screens_scene.h"
#include "wavefront/render.h"
#include "wavefront/soa.h"

namespace skywave {
namespace {

Image Picture(const Scene& scene, int size, std::uint32_t samples, std::uint32_t depth = 3) {
  JobRequest request = SmallRequest(size, size, samples);
  request.max_depth = depth;
  request.filter = PixelFilter::kBox;
  const RenderJob job(scene, request);
  Film film = job.MakeFilm();
  RenderFrame(job.frame(), film);
  return film.Resolve(samples);
}

double MeanOf(const Image& image) {
  double sum = 0;
  for (const float value : image.rgb) sum += value;
  return sum / double(image.rgb.size());
}

// Returns black sheets of the given opacity that fill the film of a camera looking down on them
// from y = 2, under a constant environment of 1.
Scene Sheets(int count, float opacity) {
  Scene scene;
  const std::uint32_t black = AddLambert(scene, "black", glm::vec3(0));
  scene.materials[black].opacity = opacity;
  for (int i = 0; i < count; ++i) Place(scene, Quad(9), black, {0, -0.1f * float(i), 0});
  scene.camera = LookAtCamera({0, 2, 0}, {0, 0, 0}, {0, 0, -1}, 60, false);
  SetConstantLight(scene, 1);
  return scene;
}

// Returns five standard deviations of a mean of that many independent trials.
double Tolerance(double p, double trials) { return 5 * std::sqrt(p * (1 - p) / trials); }

TEST(Alpha, SheetsLetTheirProductPass) {
  for (const auto& [count, opacity] : {std::pair{1, 0.5f}, {1, 0.9f}, {2, 0.5f}, {3, 0.3f}}) {
    const double passes = std::pow(1.0 - opacity, count);
    EXPECT_NEAR(MeanOf(Picture(Sheets(count, opacity), 32, 64)), passes,
                Tolerance(passes, 32 * 32 * 64))
        << count << " of " << opacity;
  }
  EXPECT_EQ(MeanOf(Picture(Sheets(2, 1), 8, 4)), 0);
  EXPECT_EQ(MeanOf(Picture(Sheets(2, 0), 8, 4)), 1);
}

// The test covers every pixel, not only the mean, because sheets must not share one pattern.
TEST(Alpha, SamplesOfAPixelAreIndependent) {
  const int n = 24;
  const std::uint32_t samples = 100;
  const Image image = Picture(Sheets(2, 0.5f), n, samples);
  double squares = 0;
  for (int i = 0; i < n * n; ++i) {
    const double z = (image.rgb[3 * std::size_t(i)] - 0.25) / std::sqrt(0.25 * 0.75 / samples);
    squares += z * z;
  }
  // Chi-square with n^2 degrees of freedom has a standard deviation of sqrt(2) n.
  EXPECT_NEAR(squares / (n * n), 1, 5 * std::sqrt(2.0) / n);
}

// A white floor sees the environment through a sheet above the camera, which halves its light.
TEST(Alpha, ShadowsAreAsDeepAsTheSheet) {
  for (const bool direct : {false, true}) {
    Scene scene;
    const std::uint32_t black = AddLambert(scene, "black", glm::vec3(0));
    scene.materials[black].opacity = 0.5f;
    Place(scene, Quad(1), AddLambert(scene, "white", glm::vec3(1)), {0, 0, 0});
    // A dome blocks all light that would bypass the sheet.
    Place(scene, Sphere(5, 4), black, {0, 0, 0});
    scene.camera = LookAtCamera({0, 1, 0}, {0, 0, 0}, {0, 0, -1}, 60, false);
    SetConstantLight(scene, 1);
    JobRequest request = SmallRequest(16, 16, 64);
    request.integrator = direct ? Integrator::kDirect : Integrator::kPath;
    request.max_depth = 1;
    request.options.light_samples = direct ? 4 : 1;
    for (const bool mis : {false, true}) {
      request.options.mis = mis;
      const RenderJob job(scene, request);
      Film film = job.MakeFilm();
      RenderFrame(job.frame(), film);
      // A sample is four times the cosine of a direction on the sphere, or 0: its variance is that
      // of five coins.
      EXPECT_NEAR(MeanOf(film.Resolve(64)), 0.5, Tolerance(0.5, 16 * 16 * 64 / 5.0))
          << direct << mis;
    }
  }
}

// Squares of a mask are exact to the pixel: 2 x 2 of them, four by four pixels each.
TEST(Alpha, MasksAreExact) {
  Scene scene;
  const std::uint32_t black = AddLambert(scene, "black", glm::vec3(0));
  scene.images = {Checkers(2, 1, 0)};
  scene.textures = {{.image = 0, .use = TextureUse::kOpacity}};
  scene.materials[black].opacity_texture = 0;
  scene.materials[black].opacity_cutoff = 0.5f;
  Place(scene, Quad(1), black, {0, 0, 0});
  scene.camera = LookAtCamera({0, 1, 0}, {0, 0, 0}, {0, 0, -1}, 90, false);
  SetConstantLight(scene, 1);
  const Image image = Picture(scene, 8, 16);
  // Coordinates repeat, so edges between squares are like those of the sheet.
  int there = 0;
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) {
      const float value = image.Pixel(x, y)[0];
      ASSERT_TRUE(value == 0 || value == 1) << x << " " << y << " is " << value;
      ASSERT_EQ(value, image.Pixel(7 - x, 7 - y)[0]);
      ASSERT_EQ(value, 1 - image.Pixel(x, 7 - y)[0]);
      there += value == 0;
    }
  }
  EXPECT_EQ(there, 32);
}

// The alpha of vertices grows from 0 at the left to 1 at the right; a cutoff makes an edge of it.
TEST(Alpha, VerticesHaveTheirOwn) {
  constexpr int kSize = 16;
  Scene scene;
  const std::uint32_t black = AddLambert(scene, "black", glm::vec3(0));
  Mesh quad = Quad(1);
  for (const glm::vec3& p : quad.positions) quad.alphas.push_back((p.x + 1) / 2);
  Place(scene, quad, black, {0, 0, 0});
  scene.camera = LookAtCamera({0, 1, 0}, {0, 0, 0}, {0, 0, -1}, 90, false);
  SetConstantLight(scene, 1);
  for (const float factor : {1.0f, 0.5f}) {
    scene.materials[black].opacity = factor;
    const Image image = Picture(scene, kSize, 256);
    for (int x = 0; x < kSize; ++x) {
      double column = 0;
      for (int y = 0; y < kSize; ++y) column += image.Pixel(x, y)[0];
      const double passes = 1 - factor * (x + 0.5) / kSize;
      EXPECT_NEAR(column / kSize, passes, Tolerance(passes, kSize * 256)) << x;
    }
  }
  scene.materials[black].opacity_cutoff = 0.25f;  // of 1/2 times the alpha
  const Image cut = Picture(scene, kSize, 4);
  for (int x = 0; x < kSize; ++x) EXPECT_EQ(cut.Pixel(x, 5)[0], x < kSize / 2 ? 1 : 0) << x;
}

TEST(Alpha, ScalarLookupsHaveTheBitsOfVectors) {
  Random random(71);
  Scene scene;
  Image image(7, 5);
  for (float& value : image.rgb) value = random.Float();
  for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = image.rgb[i / 3 * 3];
  scene.images = {image};
  for (std::uint32_t i = 0; i < 9; ++i) {
    Texture texture = {.wrap_u = TextureWrap(i % 3), .wrap_v = TextureWrap(i / 3)};
    for (int k = 0; k < 6; ++k) texture.transform[k / 2][k % 2] = float(random.Between(-3, 3));
    scene.textures.push_back(texture);
  }
  TextureTables tables = MakeTextureTables(scene, "test");
  tables.uvs.resize(1);
  for (auto& corner : tables.uvs[0].uv) corner[0] = float(random.Between(-2, 2)), corner[1] = 0.5f;
  std::vector<MaterialRecord> materials(9);
  for (std::uint32_t i = 0; i < 9; ++i) materials[i].color_texture = i + 1;
  const soa::Table<SurfaceColumns> table(512);
  const SurfaceColumns& s = table;
  for (std::uint32_t i = 0; i < 512; ++i) {
    s.u[i] = float(random.Float()), s.v[i] = float(random.Float()) * (1 - s.u[i]);
    s.material[i] = i % 9, s.color_r[i] = 1;
  }
  TextureColors(tables.view(), materials.data(), 0, 512, s);
  for (std::uint32_t i = 0; i < 512; ++i) {
    ASSERT_EQ(FirstChannel(tables.view(), i % 9, 0, s.u[i], s.v[i]), s.color_r[i]) << i;
  }
}

TEST(Alpha, AnswersDependOnKeyAndTriangleAlone) {
  const std::vector<TriangleRecord> triangles(50);
  const OpacityRecord records[] = {{.factor = 0.3f, .cutoff = -1}};
  const OpacityView view = {.triangles = triangles.data(), .records = records, .textures = {}};
  int met = 0, both = 0;
  for (std::uint32_t key = 0; key < 4000; ++key) {
    for (std::uint32_t t = 0; t + 1 < 50; t += 2) {
      const bool first = StopsRay(view, key * 2654435761u, t, 0.2f, 0.3f);
      ASSERT_EQ(first, StopsRay(view, key * 2654435761u, t, 0.6f, 0.1f));
      met += first;
      both += first && StopsRay(view, key * 2654435761u, t + 1, 0, 0);
    }
  }
  const double n = 4000 * 25;
  EXPECT_NEAR(met / n, 0.3, Tolerance(0.3, n));
  EXPECT_NEAR(both / n, 0.09, Tolerance(0.09, n));
}

// A floor is lit by an emitting sheet only: the sheet contributes in proportion to its opacity,
// whether its light is found by light samples or by chance.
TEST(Alpha, LightsEmitInProportionToIt) {
  const auto floor = [](float opacity, bool squares, bool mis, Integrator integrator) {
    Scene scene;
    const std::uint32_t lamp = AddLambert(scene, "lamp", glm::vec3(0));
    scene.materials[lamp].emission = glm::vec3(8);
    scene.materials[lamp].emits_on_both_sides = true;
    scene.materials[lamp].opacity = opacity;
    if (squares) {
      scene.images = {Checkers(8, 1, 0)};
      scene.textures = {{.image = 0, .use = TextureUse::kOpacity}};
      scene.materials[lamp].opacity_texture = 0;
      scene.materials[lamp].opacity_cutoff = 0.5f;
    }
    // The lamp precedes the floor, so that the order of the meshes differs from that of the
    // triangles.
    Place(scene, Quad(0.5f), lamp, {0, 1, 0});
    Place(scene, Quad(1), AddLambert(scene, "white", glm::vec3(0.8f)), {0, 0, 0});
    scene.camera = LookAtCamera({0, 0.9f, 0}, {0, 0, 0}, {0, 0, -1}, 60, false);
    JobRequest request = SmallRequest(16, 16, 256);
    request.integrator = integrator;
    request.max_depth = 1;
    request.options.mis = mis;
    const RenderJob job(scene, request);
    Film film = job.MakeFilm();
    RenderFrame(job.frame(), film);
    return MeanOf(film.Resolve(256));
  };
  const double whole = floor(1, false, true, Integrator::kPath);
  ASSERT_GT(whole, 0.5);
  for (const Integrator integrator : {Integrator::kPath, Integrator::kDirect}) {
    for (const bool mis : {false, true}) {
      // The relative error of a sample is below 1.5, that of the mean of 65536 below 0.6 percent.
      EXPECT_NEAR(floor(0.4f, false, mis, integrator) / whole, 0.4, 0.4 * 5 * 0.006) << mis;
      EXPECT_NEAR(floor(1, true, mis, integrator) / whole, 0.5, 0.5 * 5 * 0.006) << mis;
    }
  }
}

// Opacity comes from the mixture, everything else from its parts; tables have a row for every
// variant.
TEST(Alpha, MixturesHaveIt) {
  Scene scene;
  const std::uint32_t black = AddLambert(scene, "black", glm::vec3(0));
  scene.images = {Plain(NormalColor({0.3f, 0, 1}))};
  scene.textures = {{.image = 0, .use = TextureUse::kNormals}};
  scene.materials[black].normal_texture = 0;
  AddLambert(scene, "also black", glm::vec3(0));
  scene.materials.push_back({.name = "mixture", .opacity = 0.5f, .mixture = Mixture{0, 1, 0.4f}});
  Place(scene, Quad(9), 2, {0, 0, 0});
  Place(scene, Quad(0.01f), black, {0, -5, 0});
  scene.camera = LookAtCamera({0, 2, 0}, {0, 0, 0}, {0, 0, -1}, 60, false);
  SetConstantLight(scene, 1);
  EXPECT_NEAR(MeanOf(Picture(scene, 32, 64)), 0.5, Tolerance(0.5, 32 * 32 * 64));

  const Geometry geometry(scene, "test");
  ASSERT_EQ(geometry.triangle_count(), 4u);
  ASSERT_EQ(geometry.record_count(), 8u);
  EXPECT_EQ(geometry.first_with_alpha(), 2u);
  for (std::uint32_t record = 0; record < 8; ++record) {
    EXPECT_EQ(geometry.MeshOf(record), record < 2 ? 1u : 0u) << record;
    const std::uint32_t tag = geometry.triangles()[record].tag;
    const bool mapped = (tag & kMixedTriangle) == 0 && (tag & kMaterialMask) == black;
    EXPECT_EQ(geometry.normal_maps().tangents[record].side != 0, mapped) << record;
  }
}

TEST(Alpha, OpaqueScenesHaveOneGeometryAndNoKeys) {
  Scene scene = Sheets(2, 1);
  const Geometry opaque(scene, "test");
  EXPECT_FALSE(opaque.has_alpha());
  const RenderJob job(scene, SmallRequest(4, 4, 1));
  EXPECT_FALSE(job.frame().tracer.first_with_alpha);
  AddLambert(scene, "alpha", glm::vec3(1));
  scene.materials[1].opacity = 0.5f;
  Place(scene, Quad(1), 1, {0, 1, 0});
  std::swap(scene.meshes.front(), scene.meshes.back());
  const Geometry mixed(scene, "test");
  ASSERT_EQ(mixed.first_with_alpha(), 4u);
  for (std::uint32_t t = 0; t < 6; ++t) {
    EXPECT_EQ(mixed.triangles()[t].tag & kMaterialMask, t < 4 ? 0u : 1u);
    EXPECT_EQ(mixed.MeshOf(t), t < 2 ? 1u : t < 4 ? 2u : 0u);
  }
}

}  // namespace
}  // namespace skywave
