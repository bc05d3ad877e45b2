// The correctness reference and the speed floor of the engine: a plain depth-first path tracer. It
// traces one path at a time with single rays of Embree and shades in double, with its own BSDFs,
// environment, light samples, camera and random numbers. It shares with the engine only the meaning
// of the scene (the conventions of kernels/bsdf/bsdf.h, kernels/lights/environment.h and
// wavefront/integrators/{path,direct}.cc) and tables: FilterOffsets(), GgxTables(), and those of
// sheen and coats, which tests of their own hold to quadrature and to random walks in the layers.
// What it does not know it refuses.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "image/image.h"
#include "tests/support/oracle_bsdf.h"
#include "tests/support/oracle_environment.h"
#include "tests/support/oracle_lights.h"
#include "tests/support/oracle_relief.h"
#include "tests/support/oracle_texture.h"
#include "wavefront/frame.h"
#include "wavefront/rays/embree_rays.h"

namespace skywave {

struct OraclePicture {
  Image mean;
  std::vector<double> variance;  // variance of the mean, three per pixel; 0 for a single sample
  double seconds = 0;            // wall clock
};

class Oracle {
 public:
  // The scene needs a camera; its only environment is used, with its map in memory. Throws
  // std::logic_error for what the oracle does not know.
  explicit Oracle(const Scene& scene, OracleLights lights = OracleLights::kImportance);
  ~Oracle();
  Oracle(const Oracle&) = delete;
  Oracle& operator=(const Oracle&) = delete;

  // Uses film, integrator, samples, depth, filter (its radius set), seed and threads of `options`
  // and ignores wave and backend. The bits are the same for any number of threads.
  OraclePicture Render(const RenderOptions& options) const;

 private:
  struct Triangle {
    glm::vec3 corner[3], normal[3];
    glm::vec2 uv[3];
    std::uint32_t material;
    bool smooth;
    glm::dvec3 tangent;                 // 0 unless the BSDF is anisotropic
    OracleLocalLights::Triangle light;  // radiance 0: no light
  };
  struct Ray {
    glm::dvec3 origin, direction;
  };
  struct Hit {
    OracleSurface surface;
    OracleMaterial textured;  // surface.material, if textures change it
    glm::dvec3 point;
    double lift;  // distance between the point and the origins of rays that leave it
    double distance;
    const OracleLocalLights::Triangle* light;
    glm::dvec3 emission;
    double light_cosine;  // <= 0: seen from its dark side
  };

  void AddMesh(const Mesh& mesh);
  glm::dvec3 TangentOf(const Triangle& triangle) const;
  void BuildEmbreeScene();
  bool FindHit(const Ray& ray, double reach, OracleRandom& random, RTCRayHit& query) const;
  bool Intersect(const Ray& ray, OracleRandom& random, Hit& hit) const;
  void ApplyTextures(const Triangle& triangle, const glm::dvec3& weights, Hit& hit) const;
  bool Occluded(const Ray& ray, double distance, OracleRandom& random) const;
  bool IsThere(std::uint32_t triangle, double u, double v, OracleRandom& random) const;
  glm::dvec3 Emission(std::uint32_t triangle, double u, double v) const;
  Ray LeaveFrom(const Hit& hit, const glm::dvec3& direction) const;
  glm::dvec3 LightFromEnvironment(const glm::dvec3& direction, double pdf,
                                  const RenderOptions& options) const;
  glm::dvec3 LightFromHit(const Hit& hit, double pdf, const RenderOptions& options) const;
  glm::dvec3 LightFromSample(const Hit& hit, const RenderOptions& options,
                             OracleRandom& random) const;
  double LocalShare() const;
  glm::dvec3 Radiance(Ray ray, const RenderOptions& options, OracleRandom& random) const;
  // Returns the ray that a point of the film [pixels] sees along, or nothing outside of a fisheye.
  std::optional<Ray> CameraRay(const glm::dvec2& film, const RenderOptions& options,
                               OracleRandom& random) const;
  void RenderRow(int y, const RenderOptions& options, const std::vector<float>& filter,
                 OraclePicture& picture) const;

  Camera camera_;
  bool has_environment_;
  OracleEnvironment environment_;
  OracleLocalLights local_lights_;
  std::vector<OracleMaterial> materials_;
  bool has_alpha_ = false;
  Scene scene_textures_;  // materials, textures and images only
  std::vector<Triangle> triangles_;
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
};

}  // namespace skywave
