// Local lights of a scene as the kernels read them: one record per light, and how often each is
// picked (kernels/lights/local_lights.h).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/names.h"
#include "kernels/lights/local_lights.h"
#include "scene/geometry.h"
#include "scene/light_shapes.h"
#include "scene/scene.h"

namespace skywave {

// Sums over all lights of one kind.
struct LocalLightTotal {
  std::size_t count = 0;
  double power = 0;  // luminance [radiance * sr * area]
};

// Immutable once built. Triangles without area or emission are not lights. Where an emission has a
// texture, its mean over a triangle counts towards power, as does the integral over a shape; alpha
// does not.
class LocalLights {
 public:
  LocalLights() = default;
  // `geometry` must outlive this object. `radius` is that of a sphere around the scene; distant
  // lights and the environment, of power `environment_power` (luminance), illuminate its disk.
  // Throws InputError(path) for more than kMaxLocalLights lights.
  LocalLights(const Scene& scene, const Geometry& geometry, const std::string& path, float radius,
              double environment_power);

  LocalLightView view() const;
  std::size_t bytes() const;
  const std::array<LocalLightTotal, kLocalLightKinds>& totals() const { return totals_; }
  // Returns the brightest value that a camera may see of them: their own radiance, or that of a
  // white surface lit by all their power from a distance of a hundredth of `radius`.
  float brightest() const { return brightest_; }
  // Returns the power of each light (luminance) [radiance * sr * area].
  const std::vector<double>& power() const { return power_; }

 private:
  void AddTriangles(const Scene& scene, const Geometry& geometry, const std::string& path);
  // `mean` is the mean emission, which equals the light's emission unless that has a texture or a
  // shape.
  void Add(const LocalLight& light, const glm::vec3& mean, double power_per_unit);

  std::vector<LocalLight> lights_;
  std::vector<std::uint32_t> light_of_triangle_;
  std::vector<std::uint32_t> emission_texture_;  // as in LocalLightView; empty: no light has one
  TextureView textures_ = {};                    // the textures of the geometry
  LightShapeTables shapes_;
  bool has_alpha_ = false;
  // LightChoice::first of the choices of LocalLightView.
  std::vector<std::uint32_t> alone_, shared_, alike_alone_, alike_shared_, only_, each_;
  std::array<LocalLightTotal, kLocalLightKinds> totals_ = {};
  std::vector<double> power_;
  double channel_power_ = 0;  // sum over lights in the brightest channel
  float brightest_ = 0;
};

// Returns true if anything in the scene emits light.
bool HasLocalLights(const Scene& scene);

// Returns the radius of the sphere around the bounds [world space].
float BoundingRadius(const Bounds& bounds);

// Returns the solid angle that a spot would fill with its full intensity [sr].
double SpotSolidAngle(const PunctualLight& spot);

template <>
inline constexpr auto kEnumNames<LocalLightKind> =
    std::to_array<Named<LocalLightKind>>({{LocalLightKind::kTriangle, "triangle"},
                                          {LocalLightKind::kPoint, "point"},
                                          {LocalLightKind::kSpot, "spot"},
                                          {LocalLightKind::kDistant, "distant"},
                                          {LocalLightKind::kShaped, "shaped"}});

}  // namespace skywave
