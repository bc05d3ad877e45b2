// Renders a tetrahedron of gold on a plate under a sky that is made here:
//
//   render_mesh OUTPUT.exr
#include <skywave/skywave.h>

#include <cstdint>
#include <cstdio>
#include <utility>
#include <vector>

using namespace skywave;

int main(int argc, char** argv) try {
  if (argc != 2) return std::fprintf(stderr, "usage: render_mesh OUTPUT.exr\n"), 64;
  api::Scene scene;
  const int gold = scene.AddMaterial(
      "conductor",
      {{"alpha", {0.1f}}, {"eta", {0.14f, 0.37f, 1.44f}}, {"k", {3.98f, 2.39f, 1.6f}}});

  const std::vector<float> corners = {1, 1.2f, 1, -1, -0.8f, 1, 1, -0.8f, -1, -1, 1.2f, -1};
  const std::vector<std::uint32_t> faces = {0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2};
  scene.AddMesh({.positions = corners, .triangles = faces, .material = gold});

  const std::vector<float> plate = {-4, -0.8f, 4, 4, -0.8f, 4, 4, -0.8f, -4, -4, -0.8f, -4};
  const std::vector<std::uint32_t> halves = {0, 1, 2, 0, 2, 3};
  scene.AddMesh({.positions = plate, .triangles = halves});  // grey

  std::vector<float> sky(64 * 32 * 3);
  for (int i = 0; i < 64 * 32; ++i) {
    const float height = 1 - float(i / 64) / 16;  // 1 at the zenith, -1 at the nadir
    const bool sun = i / 64 == 8 && i % 64 == 20;
    for (int c = 0; c < 3; ++c) sky[3 * i + c] = sun ? 500 : 0.5f + 0.2f * height * c;
  }
  scene.SetEnvironment({sky, 64, 32});
  scene.SetCamera({3, 2, 5}, {0, 0, 0}, {0, 1, 0}, 40);

  api::Renderer renderer(std::move(scene), {{"size", "320x240"}, {"spp", "64"}});
  renderer.Render([](double done) { return std::printf("\r%3.0f %%", 100 * done) > 0; });
  renderer.WriteExr(argv[1]);
  std::printf("\r%s", renderer.Summary().c_str());
} catch (const skywave::api::Error& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
