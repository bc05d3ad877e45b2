// A meadow of one plant: leaves about a stalk, and a flower. Its 2 * 10^9 triangles are there to
// show instances.
#include <cmath>
#include <cstdint>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <utility>

#include "scene/builtin/scene_building.h"
#include "scene/shapes/mesh.h"
#include "scene/shapes/shapes.h"
#include "scene/shapes/smooth_normals.h"

namespace skywave {
namespace {

// Returns a number in [0, 1) for each i (Weyl's sequence).
double Spread(std::uint32_t i, double step) {
  const double x = (i + 1) * step;
  return x - std::floor(x);
}

// A strip that bends from the origin outwards along +x and down again, 1 long: `along` by `across`
// quads of two triangles.
Mesh Leaf(int along, int across, double width, double rise, double fall) {
  Mesh leaf;
  for (int i = 0; i <= along; ++i) {
    const double s = double(i) / along;
    const double half = 0.5 * width * std::sin(glm::pi<double>() * std::pow(s, 0.7)) + 1e-4;
    for (int j = 0; j <= across; ++j) {
      const double t = 2.0 * j / across - 1;
      leaf.positions.emplace_back(s * (1 - 0.25 * s), rise * s - fall * s * s + 0.35 * half * t * t,
                                  half * t);
    }
  }
  for (int i = 0; i < along; ++i) {
    for (int j = 0; j < across; ++j) {
      const auto a = std::uint32_t(i * (across + 1) + j), b = a + 1;
      const auto c = a + std::uint32_t(across + 1), d = c + 1;
      leaf.triangles.emplace_back(a, b, c);
      leaf.triangles.emplace_back(b, d, c);
    }
  }
  leaf.normals = AreaWeightedNormals(leaf.positions, leaf.triangles);
  return leaf;
}

void AddPart(Object& plant, Mesh part, const glm::dmat4& to, std::uint32_t material) {
  TransformMesh(to, part);
  part.material = material;
  plant.meshes.push_back(std::move(part));
}

// About one high, 20 000 triangles: 16 leaves, 15 petals, a stalk and the middle of the flower.
Object Plant(std::uint32_t leaves, std::uint32_t petals, std::uint32_t middle) {
  Object plant = {.name = "plant", .meshes = {}};
  const auto turned = [](double degrees, double up, double scale) {
    const glm::dmat4 moved = glm::translate(glm::dmat4(1), glm::dvec3(0, up, 0));
    const glm::dmat4 turn = glm::rotate(moved, glm::radians(degrees), glm::dvec3(0, 1, 0));
    return glm::scale(turn, glm::dvec3(scale));
  };
  constexpr double kGolden = 137.50776;
  for (int i = 0; i < 16; ++i) {
    AddPart(plant, Leaf(40, 10, 0.16, 1.5 - 0.04 * i, 1.1), turned(kGolden * i, 0.01 * i, 0.5),
            leaves);
  }
  AddPart(plant, Leaf(50, 8, 0.03, 0, 0),
          glm::rotate(glm::dmat4(1), glm::half_pi<double>(), glm::dvec3(0, 0, 1)), leaves);
  for (int i = 0; i < 15; ++i) {
    AddPart(plant, Leaf(16, 10, 0.35, 0.35, 0.2), turned(24.0 * i, 0.75, 0.16), petals);
  }
  AddPart(plant, Sphere(0.05f, 9), turned(0, 0.77, 1), middle);
  return plant;
}

// Returns soil, and the plant as an object without an instance.
Scene Soil() {
  Scene scene;
  Place(scene, Quad(400), AddLambert(scene, "soil", {0.16f, 0.12f, 0.08f}), glm::vec3(0));
  const std::uint32_t leaves = AddLambert(scene, "leaf", {0.10f, 0.26f, 0.05f});
  const std::uint32_t petals = AddLambert(scene, "petal", {0.75f, 0.70f, 0.78f});
  const std::uint32_t middle = AddLambert(scene, "pollen", {0.75f, 0.50f, 0.06f});
  scene.objects.push_back(Plant(leaves, petals, middle));
  AddProceduralSky(scene);
  scene.settings = BuiltinSettings(32, 6);
  return scene;
}

}  // namespace

Scene PlantScene() {
  Scene scene = Soil();
  scene.instances.push_back({.object = 0, .meshes_before = 1});
  scene.camera = LookAtCamera({0, 1.1f, 2.0f}, {0, 0.38f, 0}, {0, 1, 0}, 32, false);
  return scene;
}

Scene MeadowScene() {
  constexpr std::uint32_t kPlants = 100'000;
  constexpr double kSide = 120;
  Scene scene = Soil();
  for (std::uint32_t i = 0; i < kPlants; ++i) {
    // Roberts' sequence fills the square evenly.
    const double x = kSide * (Spread(i, 0.7548776662466927) - 0.5);
    const double z = kSide * (Spread(i, 0.5698402909980532) - 0.5);
    const double size = 0.35 + 0.45 * Spread(i, 0.6180339887498949);
    glm::dmat4 to = glm::translate(glm::dmat4(1), glm::dvec3(x, 0, z));
    to =
        glm::rotate(to, glm::two_pi<double>() * Spread(i, 0.4142135623730951), glm::dvec3(0, 1, 0));
    to = glm::rotate(to, 0.3 * Spread(i, 0.7320508075688772), glm::dvec3(1, 0, 0));
    scene.instances.push_back({.object = 0,
                               .world_from_object = glm::dmat4x3(glm::scale(to, glm::dvec3(size))),
                               .meshes_before = 1});
  }
  scene.camera = LookAtCamera({0, 3.2f, 34}, {0, 0.2f, 18}, {0, 1, 0}, 42, false);
  return scene;
}

}  // namespace skywave
