#include "job/environment.h"

#include <fmt/format.h>
#include <utility>

#include "base/error.h"
#include "image/primaries.h"
#include "job/map_sequence.h"
#include "lights/maps/projections.h"
#include "lights/maps/resample.h"
#include "lights/maps/sum_maps.h"
#include "scene/local_lights.h"

namespace skywave {
namespace {

// The light of the request, or else those of the scene.
std::vector<EnvironmentLight> ChooseLights(const Scene& scene, const JobRequest& request) {
  const EnvironmentRequest& environment = request.environment;
  if (environment.has_map()) {
    EnvironmentLight light;
    light.map_path = MapFile(request);
    light.world_from_map =
        EnvironmentFrame(scene.up_axis, scene.left_handed, environment.rotation_degrees);
    return {light};
  }
  if (scene.environments.empty() && HasLocalLights(scene)) return {{.scale = glm::vec3(0)}};
  if (scene.environments.empty()) {
    throw InputError(InputPosition::File(request.scene),
                     "has no light; give an illumination map with --env MAP");
  }
  std::vector<EnvironmentLight> lights = scene.environments;
  const glm::mat3 turn =
      EnvironmentTurn(scene.up_axis, scene.left_handed, environment.rotation_degrees);
  for (EnvironmentLight& light : lights) light.world_from_map = turn * light.world_from_map;
  return lights;
}

// Reads the map of `light` if it is in a file, or makes one pixel of a constant light; repairs it,
// and converts it to the space.
// A map of the scene may be any picture, as in pbrt; one that is asked for has radiance.
void LoadMap(EnvironmentLight& light, const EnvironmentRequest& request, RgbSpace space,
             std::vector<std::string>& notes) {
  if (!light.map && light.map_path.empty() && !request.image) {
    light.map = Image(1, 1);
    light.map->rgb = {1, 1, 1};
  }
  const std::string name = request.image ? "map" : light.map_path;
  if (!light.map) {
    Image image = request.image          ? *request.image
                  : request.path.empty() ? ReadTexture(name, Encoding::kSrgb, request.limits)
                                         : ReadImage(name, request.limits);
    const bool equal_area = light.equal_area_square && image.width == image.height;
    const Projection projection = request.projection ? *request.projection
                                  : equal_area       ? Projection::kOctahedral
                                                     : DetectProjection(image, name);
    notes.push_back(fmt::format("{}: {} x {}, {} {}", name, image.width, image.height,
                                request.projection ? "read as" : "taken for",
                                ToString(projection)));
    const BadPixels bad = RepairRadiance(image);
    if (bad.total() > 0) {
      notes.push_back(fmt::format("{}: {}", name, Describe(bad)));
    }
    light.map = ToLatLong(std::move(image), projection);
  }
  const glm::vec3 factor = light.scale * request.intensity;
  light.scale = glm::vec3(1);
  if (factor != glm::vec3(1)) {
    for (std::size_t i = 0; i < light.map->rgb.size(); i += 3) {
      for (int c = 0; c < 3; ++c) light.map->rgb[i + std::size_t(c)] *= factor[c];
    }
  }
  ConvertColors(FromRec709(space), *light.map);
  if (const BadPixels bad = RepairRadiance(*light.map); bad.total() > 0) {
    notes.push_back(fmt::format("{}: {} pixels exceed all bounds at this intensity and are limited",
                                name, bad.total()));
  }
}

EnvironmentLight Sum(const std::vector<EnvironmentLight>& lights) {
  std::vector<OrientedMap> maps;
  for (const EnvironmentLight& light : lights) {
    OrientedMap map = {*light.map, {}};
    for (int column = 0; column < 3; ++column) {
      for (int row = 0; row < 3; ++row) {
        map.world_from_map[std::size_t(column)][std::size_t(row)] =
            light.world_from_map[column][row];
      }
    }
    maps.push_back(std::move(map));
  }
  OrientedMap sum = SumMaps(std::move(maps));
  EnvironmentLight light;
  light.map = std::move(sum.latlong);
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      light.world_from_map[column][row] = sum.world_from_map[std::size_t(column)][std::size_t(row)];
    }
  }
  return light;
}

// Repeats a single pixel over a small map. Light samples hold each channel of a texel with nine
// bits of the brightest (lights/tables/texels.h), and what one texel loses its neighbours take up.
void SpreadSinglePixel(Image& map) {
  if (map.width * map.height > 1) return;
  Image spread(32, 16);
  for (std::size_t i = 0; i < spread.rgb.size(); ++i) spread.rgb[i] = map.rgb[i % 3];
  map = std::move(spread);
}

}  // namespace

EnvironmentLight LoadEnvironment(const Scene& scene, const JobRequest& request,
                                 std::vector<std::string>& notes) {
  std::vector<EnvironmentLight> lights = ChooseLights(scene, request);
  for (EnvironmentLight& light : lights) {
    LoadMap(light, request.environment, request.working_space, notes);
  }
  if (lights.size() == 1) {
    SpreadSinglePixel(*lights.front().map);
    return std::move(lights.front());
  }
  EnvironmentLight sum = Sum(lights);
  notes.push_back(fmt::format("{}: {} infinite lights are summed into a map of {} x {}",
                              request.scene, scene.environments.size(), sum.map->width,
                              sum.map->height));
  return sum;
}

}  // namespace skywave
