// Tests instances: an object that is shared looks as its copies do.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <string>

#include "base/error.h"
#include "scene/geometry.h"
#include "scene/instances.h"
#include "scene/shapes/mesh.h"
#include "tests/support/render_scenes.h"
#include "tests/support/screens_scene.h"
#include "wavefront/records/photon_map.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

Scene Resolved(Scene scene, InstanceUse use) {
  ReadOptions options;
  options.instances = use;
  ResolveInstances(options, "test", scene);
  return scene;
}

Mesh Moved(Mesh mesh, const glm::dmat4& to, std::uint32_t material) {
  TransformMesh(to, mesh);
  mesh.material = material;
  return mesh;
}

glm::dmat4 At(double x, double y, double z) {
  return glm::translate(glm::dmat4(1), glm::dvec3(x, y, z));
}

void AddInstance(Scene& scene, std::uint32_t object, const glm::dmat4& to) {
  scene.instances.push_back({.object = object,
                             .world_from_object = glm::dmat4x3(to),
                             .meshes_before = std::uint32_t(scene.meshes.size())});
}

// Objects of surfaces whose shading depends on something in their space: a texture, a normal map,
// colours of vertices, a tangent, and a lamp. They stand turned, stretched, mirrored, small, large
// and far from the origin.
Scene Figures() {
  Scene scene;
  Image relief(2, 1);
  const glm::vec3 left = NormalColor({0.5f, 0, 1}), right = NormalColor({-0.2f, 0.4f, 1});
  for (int c = 0; c < 3; ++c) relief.Pixel(0, 0)[c] = left[c], relief.Pixel(1, 0)[c] = right[c];
  Image squares(64, 64);
  for (int i = 0; i < 64 * 64; ++i) {
    std::fill_n(squares.Pixel(i % 64, i / 64), 3, (i / 512 + i % 64 / 8) % 2 == 0 ? 0.1f : 0.9f);
  }
  scene.images = {squares, relief};
  scene.textures = {{.image = 0}, {.image = 1, .use = TextureUse::kNormals}};
  const std::uint32_t floor = AddLambert(scene, "floor", glm::vec3(0.6f));
  const std::uint32_t fine = AddLambert(scene, "fine", glm::vec3(1));
  scene.materials[fine].color_texture = 0;
  const std::uint32_t rough = AddLambert(scene, "rough", {0.8f, 0.5f, 0.3f});
  scene.materials[rough].normal_texture = 1;
  const std::uint32_t tinted = AddLambert(scene, "tinted", glm::vec3(0.9f));
  const std::uint32_t lamp = AddLambert(scene, "lamp", glm::vec3(0.5f));
  scene.materials[lamp].emission = {6, 4, 2};
  scene.materials[lamp].emits_on_both_sides = true;
  const auto brushed = std::uint32_t(scene.materials.size());
  scene.materials.push_back({.name = "brushed",
                             .bsdf = BsdfKind::kAnisotropicConductor,
                             .reflectance = {0.9f, 0.8f, 0.6f},
                             .alpha = 0.05f,
                             .alpha_across = 0.5f});
  Mesh colored = Sphere(0.3f, 4);
  for (const glm::vec3& p : colored.positions) colored.colors.push_back(0.5f + p);

  Object figure = {.name = "figure", .meshes = {}};
  figure.meshes = {Moved(Quad(0.7f), At(0, 0.05, 0), fine), Moved(colored, At(0.8, 0.5, 0), tinted),
                   Moved(Sphere(0.35f, 8), At(-0.8, 0.5, 0), brushed),
                   Moved(Quad(0.15f), At(0.3, 1.2, -0.2), lamp)};
  Object tile = {.name = "tile", .meshes = {Moved(Quad(0.4f), glm::dmat4(1), rough)}};
  scene.objects = {figure, tile};

  Place(scene, Quad(30), floor, {100, 0, 50});
  const auto stand = [](double x, double z, double turn, const glm::dvec3& scale) {
    const glm::dmat4 turned =
        glm::rotate(At(100 + x, 0.2, 50 + z), turn, glm::normalize(glm::dvec3(0.1, 1, 0.2)));
    return glm::scale(turned, scale);
  };
  AddInstance(scene, 0, stand(-1.5, -1, 0.4, {1, 1, 1}));
  AddInstance(scene, 0, stand(1.5, -1, 2.2, {1.2, 0.5, 0.8}));
  AddInstance(scene, 0, stand(-1.5, 1.5, 4, {-0.8, 1, 1}));
  AddInstance(scene, 1, stand(0, 0, 1, {0.5, 0.5, 1}));
  AddInstance(scene, 0, stand(0.3, 1.4, 1, {0.3, 0.3, 0.3}));
  AddInstance(scene, 0, stand(3.5, 2.5, 1, {3, 3, 3}));
  AddInstance(scene, 1, stand(1.2, 2.2, 3, {-1, 1, 1}));
  scene.camera = LookAtCamera({100, 5, 56}, {100.3f, 0.5f, 50.5f}, {0, 1, 0}, 38, false);
  SetLight(scene, SkyWithSun(64, 32, 40, 0.1));
  return scene;
}

struct Layers {
  Image picture;
  std::map<std::string, std::vector<float>> by_name;
};

Layers Render(
    const Scene& scene, std::uint32_t samples,
    const std::function<void(JobRequest&)>& change = [](JobRequest&) {}) {
  JobRequest request = SmallRequest(96, 64, samples);
  request.filter = PixelFilter::kBox;
  request.options.aovs = *ParseAovs("albedo,normal,position,uv");
  change(request);
  const RenderJob job(scene, request);
  Film film = job.MakeFilm();
  RenderFrame(job.frame(), film);
  Layers layers = {.picture = film.Resolve(samples), .by_name = {}};
  for (NamedChannel& channel : film.ResolveAovs(samples)) {
    layers.by_name[channel.name] = std::move(channel.values);
  }
  return layers;
}

// Few pixels may differ: those of edges, where rounding decides what is hit.
TEST(Instances, LookLikeTheirCopies) {
  const Scene copied = Resolved(Figures(), InstanceUse::kCopy);
  const Scene shared = Resolved(Figures(), InstanceUse::kShare);
  ASSERT_TRUE(copied.instances.empty());
  ASSERT_EQ(shared.instances.size(), 6u);  // the mirrored tile has a normal map, and is copied
  const Layers a = Render(copied, 1), b = Render(shared, 1);
  ASSERT_EQ(a.by_name.size(), 12u);
  for (const auto& [name, values] : a.by_name) {
    const std::vector<float>& others = b.by_name.at(name);
    int differ = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const float tolerance = name.starts_with("position") ? 2e-4f : 2e-3f;
      differ += !(std::abs(values[i] - others[i]) <= tolerance);
    }
    EXPECT_LE(differ, int(values.size() / 200)) << name;
  }
}

TEST(Instances, ReflectLikeTheirCopies) {
  const Layers a = Render(Resolved(Figures(), InstanceUse::kCopy), 64);
  const Layers b = Render(Resolved(Figures(), InstanceUse::kShare), 64);
  constexpr int kBlock = 8;
  for (int y = 0; y < a.picture.height; y += kBlock) {
    for (int x = 0; x < a.picture.width; x += kBlock) {
      double sums[2] = {};
      for (int i = 0; i < kBlock * kBlock; ++i) {
        const int column = x + i % kBlock, row = y + i / kBlock;
        sums[0] += a.picture.Pixel(column, row)[1], sums[1] += b.picture.Pixel(column, row)[1];
      }
      EXPECT_NEAR(sums[1] / sums[0], 1, 0.07) << x << " " << y;
    }
  }
}

// Disks of photons are cut where the surface bends, by the normals of what their rays hit.
TEST(Instances, GatherThePhotonsOfTheirCopies) {
  Scene scene;
  const std::uint32_t white = AddLambert(scene, "white", glm::vec3(0.7f));
  scene.objects = {{.name = "wall", .meshes = {Moved(Quad(1), glm::dmat4(1), white)}}};
  for (const double turn : {90.0, 30.0, 0.0}) {
    AddInstance(scene, 0,
                glm::rotate(glm::dmat4(1), glm::radians(turn), glm::dvec3(0, 0, 1)) *
                    At(turn == 30 ? 0.5 : 0, -0.6, 0));
  }
  scene.lights.push_back(
      {.kind = LocalLightKind::kPoint, .emission = glm::vec3(2), .position = {0, 0.5f, 0.3f}});
  scene.camera = LookAtCamera({-1, 1, 3}, {0, 0, 0}, {0, 1, 0}, 50, false);
  const auto photons = [](JobRequest& request) {
    request.integrator = Integrator::kPhoton;
    request.options.of<PhotonOptions>().indirect = 3000;
    request.options.of<PhotonOptions>().gather = 0;
  };
  const Layers a = Render(Resolved(scene, InstanceUse::kCopy), 4, photons);
  const Layers b = Render(Resolved(scene, InstanceUse::kShare), 4, photons);
  // The cells of a disk are turned by the bits of its place, so that single pixels differ.
  double copied = 0, shared = 0;
  for (const float value : a.picture.rgb) copied += value;
  for (const float value : b.picture.rgb) shared += value;
  EXPECT_NEAR(shared / copied, 1, 3e-3);
}

// The long highlight of a brushed plate and the slope of a relief turn with the instance.
TEST(Instances, RotateTheirHighlightsAndReliefs) {
  for (const bool brushed : {true, false}) {
    Scene scene;
    scene.images = {Plain(NormalColor({0.6f, 0.1f, 1}))};
    scene.textures = {{.image = 0, .use = TextureUse::kNormals}};
    const std::uint32_t material = AddLambert(scene, "plate", glm::vec3(0.9f));
    if (brushed) {
      scene.materials[material].bsdf = BsdfKind::kAnisotropicConductor;
      scene.materials[material].alpha = 0.05f, scene.materials[material].alpha_across = 0.5f;
    } else {
      scene.materials[material].normal_texture = 0;
    }
    scene.objects = {{.name = "plate", .meshes = {Moved(Quad(1), glm::dmat4(1), material)}}};
    const glm::dmat4 turn = glm::rotate(glm::dmat4(1), glm::radians(70.0), glm::dvec3(0, 1, 0));
    AddInstance(scene, 0, glm::scale(turn, glm::dvec3(1.5, 1, 1)));
    scene.camera = LookAtCamera({0, 2, 2}, {0, 0, 0}, {0, 1, 0}, 40, false);
    SetLight(scene, SkyWithSun(64, 32, 100, 0.2));
    const Layers a = Render(Resolved(scene, InstanceUse::kCopy), 64);
    const Layers b = Render(Resolved(scene, InstanceUse::kShare), 64);
    double difference = 0, sum = 0;
    for (std::size_t i = 0; i < a.picture.rgb.size(); ++i) {
      difference += std::abs(a.picture.rgb[i] - b.picture.rgb[i]), sum += a.picture.rgb[i];
    }
    EXPECT_LT(difference, 1e-2 * sum) << brushed;
  }
}

// Rays that leave a surface must not meet it again, however an instance is stretched, however far
// it is moved, and wherever its object lies in its own space.
TEST(Instances, NormalsGoToTheWorldByTheInverseTranspose) {
  const glm::dmat4 turned = glm::rotate(At(3, 4, 5), 0.7, glm::normalize(glm::dvec3(1, 2, 3)));
  for (const glm::dvec3 factors : {glm::dvec3(1, 2, 3), {-1, 1, 1}, {-0.01, -20, -3}}) {
    const glm::dmat4 place = glm::scale(turned, factors);
    Scene scene;
    const std::uint32_t white = AddLambert(scene, "white", glm::vec3(1));
    scene.objects = {{.name = "ball", .meshes = {Moved(Sphere(1, 4), glm::dmat4(1), white)}}};
    AddInstance(scene, 0, place);
    const Geometry geometry(Resolved(scene, InstanceUse::kShare), "scene");
    ASSERT_EQ(geometry.instance_count(), 1u);
    const glm::dvec3 normal = glm::normalize(glm::dvec3(0.3, -0.5, 0.8));
    const auto [x, y, z] =
        NormalInWorld(geometry.instances()[1], float(normal.x), float(normal.y), float(normal.z));
    const glm::dvec3 expected = glm::transpose(glm::inverse(glm::dmat3(place))) * normal;
    const glm::dvec3 found = glm::normalize(glm::dvec3(x, y, z));
    EXPECT_LT(glm::distance(found, glm::normalize(expected)), 1e-5) << factors.x;
  }
}

TEST(Instances, HaveNoShadowsOfTheirOwnRounding) {
  const glm::dmat4 places[] = {
      At(3000, 500, -2000),
      glm::rotate(At(3000, 0, 0), 0.7, glm::normalize(glm::dvec3(1, 2, 3))) *
          glm::scale(glm::dmat4(1), glm::dvec3(1, 0.002, 1)) *
          glm::rotate(glm::dmat4(1), 0.5, glm::normalize(glm::dvec3(3, 1, -2))),
      glm::rotate(glm::dmat4(1), 1.1, glm::normalize(glm::dvec3(1, 1, 0))) *
          glm::scale(glm::dmat4(1), glm::dvec3(0.001, 1, 0.001)),
      At(-5000, 0, 0)};
  for (int i = 0; i < 4; ++i) {
    Scene scene;
    const std::uint32_t white = AddLambert(scene, "white", glm::vec3(1));
    const double away = i == 3 ? 5000 : 0;
    scene.objects = {
        {.name = "ball", .meshes = {Moved(Facetted(Sphere(1, 16)), At(away, 0, 0), white)}}};
    AddInstance(scene, 0, places[i]);
    scene = Resolved(scene, InstanceUse::kShare);
    ASSERT_EQ(scene.instances.size(), 1u) << i;
    SetConstantLight(scene, 1);
    // Light samples by the cosine alone are exactly 1, and 0 where something is in their way.
    const Layers layers = Render(scene, 16, [](JobRequest& request) {
      request.strategy = "cosine", request.options.mis = false, request.max_depth = 1;
    });
    double most = 0;
    for (const float value : layers.picture.rgb) most = std::max(most, double(std::abs(value - 1)));
    EXPECT_LT(most, 2e-3) << i;
  }
}

// Two sheets of one triangle pair would stop the same rays if their alpha had the same numbers.
TEST(Instances, PassRaysIndependently) {
  Scene scene;
  const std::uint32_t black = AddLambert(scene, "black", glm::vec3(0));
  scene.materials[black].opacity = 0.5f;
  scene.objects = {{.name = "sheet", .meshes = {Moved(Quad(9), glm::dmat4(1), black)}}};
  AddInstance(scene, 0, At(0, 0, 0)), AddInstance(scene, 0, At(0, -0.5, 0));
  scene.camera = LookAtCamera({0, 2, 0}, {0, 0, 0}, {0, 0, -1}, 60, false);
  SetConstantLight(scene, 1);
  const Layers layers = Render(Resolved(scene, InstanceUse::kShare), 16);
  double sum = 0;
  for (const float value : layers.picture.rgb) sum += value;
  const double trials = 96 * 64 * 16;
  EXPECT_NEAR(sum / double(layers.picture.rgb.size()), 0.25, 5 * std::sqrt(0.25 * 0.75 / trials));
}

// All calls of Embree number hits alike.
TEST(Instances, AreTheSameForAllBackends) {
  const Scene scene = Resolved(Figures(), InstanceUse::kShare);
  const Layers first = Render(scene, 4);
  for (const Backend backend : kBackends) {
    const Layers other =
        Render(scene, 4, [&](JobRequest& request) { request.options.backend = backend; });
    EXPECT_EQ(other.picture.rgb, first.picture.rgb) << ToString(backend);
  }
}

TEST(Instances, AreSharedWhereCopiesCostMore) {
  Scene scene;
  AddLambert(scene, "grey", glm::vec3(0.5f));
  scene.objects = {{.name = "ball", .meshes = {Sphere(1, 16)}},  // 5120 triangles
                   {.name = "tile", .meshes = {Quad(1)}}};
  for (int i = 0; i < 1000; ++i) AddInstance(scene, 0, At(3 * i, 0, 0));
  for (int i = 0; i < 1000; ++i) AddInstance(scene, 1, At(3 * i, 2, 0));
  const Scene resolved = Resolved(scene, InstanceUse::kAuto);
  EXPECT_EQ(resolved.instances.size(), 1000u);
  EXPECT_EQ(resolved.objects.size(), 1u);
  EXPECT_EQ(resolved.meshes.size(), 1000u);
  scene.instances.erase(scene.instances.begin(), scene.instances.begin() + 990);
  EXPECT_TRUE(Resolved(scene, InstanceUse::kAuto).instances.empty());
}

// Copies stand where the file has their instance, since the order of meshes decides bits.
TEST(Instances, AreCopiedInTheOrderOfTheFile) {
  Scene scene;
  AddLambert(scene, "grey", glm::vec3(0.5f));
  const auto place = [&](const char* name) {
    scene.meshes.push_back(Quad(1));
    scene.meshes.back().name = name;
  };
  scene.objects = {{.name = "tile", .meshes = {Quad(1)}}};
  scene.objects[0].meshes[0].name = "copy";
  place("first"), AddInstance(scene, 0, At(0, 1, 0)), place("second"), place("third");
  AddInstance(scene, 0, At(0, 2, 0));
  std::string names;
  const Scene resolved = Resolved(scene, InstanceUse::kCopy);
  for (const Mesh& mesh : resolved.meshes) names += mesh.name + " ";
  EXPECT_EQ(names, "first copy second third copy ");
  EXPECT_EQ(resolved.meshes[4].positions[0].y, 2);
}

TEST(Instances, AreCopiedWhereTheyCannotBeShared) {
  Scene scene = Figures();
  scene.instances.clear();
  AddInstance(scene, 0, glm::scale(At(1, 1, 1), glm::dvec3(1, 0, 1)));  // has no inverse
  AddInstance(scene, 0, At(2, 2, 2));
  const Scene resolved = Resolved(scene, InstanceUse::kShare);
  EXPECT_EQ(resolved.instances.size(), 1u);
  // The floor, the flat figure whole, and the lamp of the other one.
  ASSERT_EQ(resolved.meshes.size(), 1u + 4 + 1);
  EXPECT_NE(resolved.materials[resolved.meshes.back().material].emission, glm::vec3(0));
  ASSERT_EQ(resolved.objects.size(), 1u);
  EXPECT_EQ(resolved.objects[0].meshes.size(), 3u);
}

// Vertices count too: an object may have many for one triangle.
TEST(Instances, AreSharedWhereTheirVerticesCostMore) {
  Scene scene;
  AddLambert(scene, "grey", glm::vec3(0.5f));
  Mesh mesh = Quad(1);
  mesh.normals.clear(), mesh.uvs.clear();
  mesh.positions.resize(100'000);
  scene.objects = {{.name = "points", .meshes = {mesh}}};
  for (int i = 0; i < 1000; ++i) AddInstance(scene, 0, At(i, 0, 0));
  ReadOptions options;
  options.max_triangles = 1'000'000, options.instances = InstanceUse::kCopy;
  Scene copied = scene;
  EXPECT_THROW(ResolveInstances(options, "test", copied), InputError);
  EXPECT_EQ(Resolved(scene, InstanceUse::kAuto).instances.size(), 1000u);
}

// A material that a job makes shine lights the scene, also where its object is shared.
TEST(Instances, ShineByTheMaterialsOfAJob) {
  Scene scene;
  AddLambert(scene, "white", glm::vec3(0.5f));
  const std::uint32_t glow = AddLambert(scene, "glow", glm::vec3(0.5f));
  Place(scene, Quad(4), 0, {0, -1, 0});
  scene.objects = {{.name = "plate", .meshes = {Moved(Quad(1), glm::dmat4(1), glow)}}};
  AddInstance(scene, 0, glm::rotate(At(0, 1, 0), M_PI, glm::dvec3(1, 0, 0)));
  AddInstance(scene, 0, At(0, -0.5, 0));
  scene.camera = LookAtCamera({0, 0.5f, 5}, {0, 0, 0}, {0, 1, 0}, 50, false);
  SetConstantLight(scene, 0.1f);
  double mean[2] = {};
  for (const InstanceUse use : {InstanceUse::kCopy, InstanceUse::kShare}) {
    const Layers layers = Render(Resolved(scene, use), 16, [](JobRequest& request) {
      request.materials = {"glow=:emission=5"};
    });
    for (const float value : layers.picture.rgb) mean[use == InstanceUse::kShare] += value;
  }
  EXPECT_GT(mean[0], 0.3 * 96 * 64 * 3);  // without the lamps it is below 0.1
  EXPECT_NEAR(mean[1] / mean[0], 1, 1e-3);
}

TEST(Instances, AreRefusedBeyondTheLimit) {
  Scene scene;
  AddLambert(scene, "grey", glm::vec3(0.5f));
  scene.objects = {{.name = "tile", .meshes = {Quad(1)}}};
  for (int i = 0; i < 100; ++i) AddInstance(scene, 0, At(i, 0, 0));
  ReadOptions options;
  options.max_triangles = 50, options.instances = InstanceUse::kCopy;
  Scene copied = scene;
  EXPECT_THROW(ResolveInstances(options, "test", copied), InputError);
  options.instances = InstanceUse::kAuto;
  ResolveInstances(options, "test", scene);
  EXPECT_EQ(scene.instances.size(), 100u);
  options.max_instances = 99;
  EXPECT_THROW(ResolveInstances(options, "test", scene), InputError);
}

}  // namespace
}  // namespace skywave
