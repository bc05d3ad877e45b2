#include "job/environment.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"
#include "lights/maps/projections.h"
#include "scene/local_lights.h"

namespace skywave {
namespace {

// As the request or else the scene has them.
std::vector<EnvironmentLight> ChooseLights(const Scene& scene, const JobRequest& request) {
  const EnvironmentRequest& wish = request.environment;
  if (!wish.path.empty()) {
    EnvironmentLight light;
    light.map_path = wish.path;
    light.world_from_map =
        EnvironmentFrame(scene.up_axis, scene.left_handed, wish.rotation_degrees);
    return {light};
  }
  if (scene.environments.empty() && HasLocalLights(scene)) return {{.scale = glm::vec3(0)}};
  if (scene.environments.empty()) {
    throw InputError(InputPosition::File(request.scene),
                     "has no light; give an illumination map with --env MAP");
  }
  std::vector<EnvironmentLight> lights = scene.environments;
  const glm::mat3 turn = EnvironmentTurn(scene.up_axis, scene.left_handed, wish.rotation_degrees);
  for (EnvironmentLight& light : lights) light.world_from_map = turn * light.world_from_map;
  return lights;
}

// Reads the map of `light` if it is in a file, or makes one pixel of a constant light; repairs it.
void LoadMap(EnvironmentLight& light, const EnvironmentRequest& wish,
             std::vector<std::string>& notes) {
  if (!light.map && light.map_path.empty()) {
    light.map = Image(1, 1);
    light.map->rgb = {1, 1, 1};
  }
  if (!light.map) {
    Image image = ReadImage(light.map_path, wish.limits);
    const bool equal_area = light.equal_area_square && image.width == image.height;
    const Projection projection = wish.projection ? *wish.projection
                                  : equal_area    ? Projection::kOctahedral
                                                  : DetectProjection(image, light.map_path);
    notes.push_back(fmt::format("{}: {} x {}, {} {}", light.map_path, image.width, image.height,
                                wish.projection ? "read as" : "taken for", ToString(projection)));
    const BadPixels bad = RepairRadiance(image);
    if (bad.total() > 0) {
      notes.push_back(fmt::format("{}: {} NaN, {} infinite and {} negative pixels set to 0",
                                  light.map_path, bad.nan, bad.infinite, bad.negative));
    }
    light.map = ToLatLong(std::move(image), projection);
  }
  for (std::size_t i = 0; i < light.map->rgb.size(); ++i) {
    light.map->rgb[i] *= light.scale[int(i % 3)] * wish.intensity;
  }
  light.scale = glm::vec3(1);
  if (const BadPixels bad = RepairRadiance(*light.map); bad.total() > 0) {
    notes.push_back(
        fmt::format("{}: {} pixels exceed all bounds at this intensity and are set to 0",
                    light.map_path, bad.total()));
  }
}

// A lat-long map between the centres of its pixels, across its seam; rows end at the poles.
glm::dvec3 Interpolate(const Image& map, const ImagePoint& at) {
  const double x = at.u * map.width - 0.5, y = at.v * map.height - 0.5;
  const int column = int(std::floor(x)), row = int(std::floor(y));
  glm::dvec3 sum(0);
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      const double weight = std::abs(1 - i - (x - column)) * std::abs(1 - j - (y - row));
      const float* rgb =
          map.Pixel((column + i + map.width) % map.width, std::clamp(row + j, 0, map.height - 1));
      sum += weight * glm::dvec3(rgb[0], rgb[1], rgb[2]);
    }
  }
  return sum;
}

// `light` on the grid and in the frame of `grid`, every texel the mean of 2 x 2 points. In the end
// each channel is scaled so that the sphere's mean is that of `light`.
Image OnGridOf(const EnvironmentLight& grid, const EnvironmentLight& light) {
  Image image(grid.map->width, grid.map->height);
  const glm::dmat3 turn =
      glm::transpose(glm::dmat3(light.world_from_map)) * glm::dmat3(grid.world_from_map);
  tbb::parallel_for(0, image.height, [&](int y) {
    for (int x = 0; x < image.width; ++x) {
      glm::dvec3 sum(0);
      for (int point = 0; point < 4; ++point) {
        const ImagePoint at = {(x + 0.25 + 0.5 * (point % 2)) / image.width,
                               (y + 0.25 + 0.5 * (point / 2)) / image.height};
        const Vector3 d = *DirectionOfPoint(Projection::kLatLong, at);
        const glm::dvec3 to = turn * glm::dvec3(d.x, d.y, d.z);
        sum += Interpolate(*light.map, PointOfDirection(Projection::kLatLong, {to.x, to.y, to.z}));
      }
      for (int c = 0; c < 3; ++c) image.Pixel(x, y)[c] = float(sum[c] / 4);
    }
  });
  const std::array<double, 3> wanted = SphereMean(*light.map), found = SphereMean(image);
  for (std::size_t i = 0; i < image.rgb.size(); ++i) {
    if (found[i % 3] > 0) image.rgb[i] *= float(wanted[i % 3] / found[i % 3]);
  }
  return image;
}

std::size_t Texels(const EnvironmentLight& light) { return light.map->rgb.size(); }

EnvironmentLight Sum(std::vector<EnvironmentLight> lights) {
  // The first of the finest.
  const auto finest =
      std::max_element(lights.begin(), lights.end(),
                       [](const auto& a, const auto& b) { return Texels(a) < Texels(b); });
  EnvironmentLight sum = *finest;
  for (auto light = lights.begin(); light != lights.end(); ++light) {
    if (light == finest) continue;
    const bool same = Texels(*light) == Texels(sum) && light->map->width == sum.map->width &&
                      light->world_from_map == sum.world_from_map;
    const bool constant = Texels(*light) == 3;
    const Image image = same || constant ? *light->map : OnGridOf(sum, *light);
    const std::size_t period = image.rgb.size();
    for (std::size_t i = 0; i < sum.map->rgb.size(); ++i) {
      float& value = sum.map->rgb[i];
      value = std::min(value + image.rgb[i % period], std::numeric_limits<float>::max());
    }
  }
  return sum;
}

}  // namespace

EnvironmentLight LoadEnvironment(const Scene& scene, const JobRequest& request,
                                 std::vector<std::string>& notes) {
  std::vector<EnvironmentLight> lights = ChooseLights(scene, request);
  for (EnvironmentLight& light : lights) LoadMap(light, request.environment, notes);
  if (lights.size() == 1) return std::move(lights.front());
  EnvironmentLight sum = Sum(std::move(lights));
  notes.push_back(fmt::format("{}: {} infinite lights are summed into a map of {} x {}",
                              request.scene, scene.environments.size(), sum.map->width,
                              sum.map->height));
  return sum;
}

}  // namespace skywave
