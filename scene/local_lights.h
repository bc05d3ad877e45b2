// The lights of a scene that are somewhere in it, as kernels read them: one record a light, and how
// often each is picked (kernels/lights/local_lights.h).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/names.h"
#include "kernels/lights/local_lights.h"
#include "scene/geometry.h"
#include "scene/scene.h"

namespace skywave {

inline constexpr std::size_t kMaxLocalLights = std::size_t{1} << 22;

// All lights of one kind.
struct LocalLightTotal {
  std::size_t count = 0;
  double power = 0;  // luminance [radiance * sr * area]
};

// Immutable once built. Triangles without area or emission are no lights. Where an emission has a
// texture, its mean over a triangle counts for power. Holes do not.
class LocalLights {
 public:
  LocalLights() = default;
  // `geometry` must outlive it. `radius`: of a sphere around the scene, on whose disk distant
  // lights and the map shine, the map with `environment_power` (luminance). Throws InputError(path)
  // for more lights than kMaxLocalLights.
  LocalLights(const Scene& scene, const Geometry& geometry, const std::string& path, float radius,
              double environment_power);

  LocalLightView view() const;
  std::size_t bytes() const;
  const std::array<LocalLightTotal, kLocalLightKinds>& totals() const { return totals_; }
  // The brightest that eye or film may see of them: their own radiance, or that of a white surface
  // which all their power lights from a hundredth of `radius` away.
  float brightest() const { return brightest_; }

 private:
  void AddTriangles(const Scene& scene, const Geometry& geometry, const std::string& path);
  // `mean`: of the emission, which is that of the light unless it has a texture.
  void Add(const LocalLight& light, const glm::vec3& mean, double power_a_unit);

  std::vector<LocalLight> lights_;
  std::vector<std::uint32_t> light_of_triangle_;
  std::vector<std::uint32_t> emission_texture_;  // LocalLightView's; empty: none has one
  TextureView textures_ = {};                    // of the geometry
  bool holes_ = false;
  std::vector<std::uint32_t> alone_, shared_;  // LightChoice::first
  std::array<LocalLightTotal, kLocalLightKinds> totals_ = {};
  std::vector<double> power_;  // of each light, luminance
  double channel_power_ = 0;   // the brightest channel of all
  float brightest_ = 0;
};

// Whether anything in the scene shines.
bool HasLocalLights(const Scene& scene);

// Radius of the sphere around the bounds [world space].
float BoundingRadius(const Bounds& bounds);

// Solid angle of a spot's light as if it were all of full intensity [sr].
double SpotSolidAngle(float cos_full, float cos_dark);

template <>
inline constexpr auto kEnumNames<LocalLightKind> =
    std::to_array<Named<LocalLightKind>>({{LocalLightKind::kTriangle, "triangle"},
                                          {LocalLightKind::kPoint, "point"},
                                          {LocalLightKind::kSpot, "spot"},
                                          {LocalLightKind::kDistant, "distant"}});

}  // namespace skywave
