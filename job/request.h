// What a user asks for: a scene, its light and camera, and how they are rendered. Each field is an
// option (job/options.h).
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/names.h"
#include "image/rgb_space.h"
#include "job/denoise/denoiser.h"
#include "lights/maps/environment_map.h"
#include "scene/read_options.h"
#include "scene/scene.h"
#include "wavefront/film/film_area.h"
#include "wavefront/film/sky_patches.h"
#include "wavefront/frame.h"

namespace skywave {

// An illumination map in a file or in memory, and how it lies in the world.
struct EnvironmentRequest {
  std::string path;                      // a file or a sequence (MapFile); empty, and no image:
                                         // the scene's own lights
  std::shared_ptr<const Image> image;    // in place of a file; notes and errors call it "map"
  std::uint64_t image_hash = 0;          // of its bits; other images have others
  std::optional<Projection> projection;  // unset: by the picture's shape, see DetectProjection
  float rotation_degrees = 0;            // counter-clockwise about the up axis, seen from above
  float intensity = 1;
  std::optional<char> up_axis;  // unset: the scene's
  ReadLimits limits;

  // Whether there is a map in place of the scene's own lights.
  bool has_map() const { return !path.empty() || image != nullptr; }
};

// Changes of the camera. Unset values are those of the scene's camera or of the automatic one.
struct CameraRequest {
  std::string from;              // a file of cameras, see job/camera_file.h; empty: the scene's
  std::string name;              // one of its cameras; empty: the first one
  std::optional<Camera> placed;  // in place of the scene's first one; of the file, if there is one
  glm::dvec3 placed_at{0.0};     // its place, which scenes far from (0, 0, 0) need whole
  std::optional<CameraKind> kind;
  std::optional<glm::dvec3> eye,
      target;                   // target: the middle of the scene if only the eye is given
  std::optional<glm::vec3> up;  // unset: the axis that is up in the scene
  std::optional<float> fov_degrees;
  std::optional<float> lens_radius;     // world space
  std::optional<float> focal_distance;  // world space; unset: the middle of the scene is sharp
  // A turn of the whole camera about the up axis, through the target or the middle of the scene;
  // counter-clockwise, seen from above.
  std::optional<float> orbit_degrees;
  float orbit_step = 0;               // from each frame of a turntable to the next [degrees]
  std::optional<float> roll_degrees;  // a turn about the view, clockwise as the camera looks
};

// What is behind the scene where the camera sees past it.
enum class Background {
  kMap,         // the map and other light from infinitely far away
  kTransparent  // nothing: the picture has alpha
};
template <>
inline constexpr auto kEnumNames<Background> = std::to_array<Named<Background>>(
    {{Background::kMap, "map"}, {Background::kTransparent, "transparent"}});

// What gives catchers their colours: they themselves, the backplate, or the map on the dome.
enum class Projected { kNone, kCamera, kDome };
template <>
inline constexpr auto kEnumNames<Projected> = std::to_array<Named<Projected>>(
    {{Projected::kNone, "none"}, {Projected::kCamera, "camera"}, {Projected::kDome, "dome"}});

// A map that was taken over the ground, inside a sphere (kernels/lights/projection.h). Lengths are
// those of the world.
struct DomeRequest {
  float height = 1;
  float radius = std::numeric_limits<float>::infinity();  // > height
  friend bool operator==(const DomeRequest&, const DomeRequest&) = default;
};

// A plane under the scene, which a photograph may show already.
enum class Ground { kNone, kGrey, kCatcher };

// Unset values come from the scene file, and where that has none from RenderOptions
// (ResolveRequest).
struct JobRequest {
  std::string scene;  // file or built-in scene
  Ground ground = Ground::kNone;
  ReadOptions read;
  std::vector<std::string> materials;            // changes, see job/material_changes.h
  std::vector<std::string> catchers;             // names of materials and meshes, see job/marks.h
  std::vector<std::string> holdouts;             // likewise
  std::vector<std::string> links, shadow_links;  // see job/links.h
  // Unset: transparent where there are catchers, holdouts, a backplate or a dome, else the map.
  std::optional<Background> background;
  std::string backplate;                         // a file, see job/backplate.h; empty: none
  std::optional<DomeRequest> dome;               // behind the scene where there is no backplate
  std::optional<Projected> project;              // unset: the dome, where there is one
  SkyDivision sky_patches = SkyDivision::kNone;  // into which the groups of lights part the map
  // If false, rough conductors and glass lose the light that their facets would scatter more than
  // once.
  bool energy_compensation = true;
  EnvironmentRequest environment;
  CameraRequest camera;
  std::string strategy;               // empty: the scene's, or importance
  std::vector<std::string> portals;   // see job/portals.h
  std::string continuation_strategy;  // where paths split; empty: the same
  std::string embree_config;
  std::optional<int> width, height;
  std::optional<CropWindow> crop;
  std::optional<Integrator> integrator;
  std::optional<std::uint32_t> samples_per_pixel, max_depth;
  std::optional<PixelFilter> filter;
  RgbSpace working_space = RgbSpace::kRec709;  // of all colours, and of the EXR
  Denoiser denoise = Denoiser::kNone;          // the film keeps what it reads
  bool coherent_noise = false;                 // the frame does not change the seed
  RenderOptions options;                       // everything that a scene file cannot set
};

// Deepest path: the pairs of dimensions of its random numbers fit in a block (kernels/sampler.h).
inline constexpr std::uint32_t kMaxDepth = 16384;

// The settings of a scene file, for what a request leaves to it.
struct SceneDefaults {
  const RenderSettings& settings;
  const std::string& scene;  // its name, for errors
};

}  // namespace skywave
