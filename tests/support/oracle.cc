#include "tests/support/oracle.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>

#include "base/clock.h"
#include "scene/geometry.h"
#include "wavefront/flush_denormals.h"

namespace skywave {
namespace {

using glm::dvec3;

constexpr std::uint32_t kFirstRouletteBounce = 3;
constexpr double kPi = std::numbers::pi;

double MaxComponent(const dvec3& v) { return std::max({v.x, v.y, v.z}); }

RTCRay EmbreeRay(const dvec3& origin, const dvec3& direction) {
  RTCRay ray = {};
  ray.org_x = float(origin.x), ray.org_y = float(origin.y), ray.org_z = float(origin.z);
  ray.dir_x = float(direction.x), ray.dir_y = float(direction.y), ray.dir_z = float(direction.z);
  ray.tfar = std::numeric_limits<float>::infinity();
  ray.mask = ~0u;
  return ray;
}

double FilterOffset(const std::vector<float>& offsets, double uniform) {
  const double at = uniform * double(offsets.size() - 1);
  const auto cell = std::size_t(at);
  return offsets[cell] + (at - double(cell)) * (double(offsets[cell + 1]) - offsets[cell]);
}

}  // namespace

Oracle::Oracle(const Scene& scene, OracleLights lights)
    : camera_(scene.camera.value()),
      has_environment_(!scene.environments.empty()),
      environment_(
          has_environment_ ? scene.environments[0] : EnvironmentLight{.scale = glm::vec3(0)},
          lights) {
  if (scene.environments.size() > 1) throw std::logic_error("the oracle knows one environment");
  for (const Material& material : scene.materials) {
    materials_.push_back(MakeOracleMaterial(material));
    has_alpha_ = has_alpha_ || !material.opaque();
  }
  scene_textures_.materials = scene.materials;
  scene_textures_.textures = scene.textures;
  scene_textures_.images = scene.images;
  for (const Mesh& mesh : scene.meshes) AddMesh(mesh);
  std::vector<OracleLocalLights::Triangle> emitters;
  for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
    Triangle& t = triangles_[i];
    const Material& material = scene.materials[t.material];
    t.light = {.corner = {t.corner[0], t.corner[1], t.corner[2]},
               .radiance = material.emission,
               .two_sided = material.emits_on_both_sides,
               .index = i};
    if (material.emission != glm::vec3(0)) emitters.push_back(t.light);
  }
  local_lights_ = OracleLocalLights(emitters, scene.lights, scene.images);
  BuildEmbreeScene();
}

Oracle::~Oracle() {
  rtcReleaseScene(scene_);
  rtcReleaseDevice(device_);
}

void Oracle::AddMesh(const Mesh& mesh) {
  for (const glm::uvec3& corners : mesh.triangles) {
    Triangle t = {.corner = {},
                  .normal = {},
                  .uv = {},
                  .material = mesh.material,
                  .smooth = false,
                  .tangent = {},
                  .light = {}};
    for (int i = 0; i < 3; ++i) {
      t.corner[i] = mesh.positions[corners[i]];
      if (!mesh.normals.empty()) t.normal[i] = mesh.normals[corners[i]];
      if (!mesh.uvs.empty()) t.uv[i] = mesh.uvs[corners[i]];
    }
    t.smooth = !mesh.normals.empty();
    t.tangent = TangentOf(t);
    // The outside is the side to which the vertex normals point.
    const glm::vec3 face = glm::cross(t.corner[1] - t.corner[0], t.corner[2] - t.corner[0]);
    if (t.smooth && glm::dot(face, t.normal[0] + t.normal[1] + t.normal[2]) < 0) {
      std::swap(t.corner[1], t.corner[2]);
      std::swap(t.normal[1], t.normal[2]);
      std::swap(t.uv[1], t.uv[2]);
    }
    triangles_.push_back(t);
  }
}

// Returns the direction in which u grows and v does not.
dvec3 Oracle::TangentOf(const Triangle& t) const {
  const Material& material = scene_textures_.materials[t.material];
  const std::string name = material.name;
  if (!HasTangent(material)) return dvec3(0);
  const dvec3 a = t.corner[1] - t.corner[0], b = t.corner[2] - t.corner[0];
  const glm::dvec2 p = t.uv[1] - t.uv[0], q = t.uv[2] - t.uv[0];
  const double area = p.x * q.y - q.x * p.y;
  if (area == 0) throw std::logic_error("the oracle needs coordinates for the grain of " + name);
  return glm::normalize((q.y * a - p.y * b) / area);
}

void Oracle::BuildEmbreeScene() {
  device_ = rtcNewDevice(DefaultEmbreeConfig().c_str());
  scene_ = rtcNewScene(device_);
  rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
  RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<glm::vec3*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                              sizeof(glm::vec3), 3 * triangles_.size()));
  auto* indices = static_cast<glm::uvec3*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(glm::uvec3), triangles_.size()));
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    std::copy_n(triangles_[i].corner, 3, vertices + 3 * i);
    indices[i] = glm::uvec3(3 * i, 3 * i + 1, 3 * i + 2);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene_);
}

// Returns true if the triangle stops a ray at that point.
bool Oracle::IsThere(std::uint32_t triangle, double u, double v, OracleRandom& random) const {
  const Triangle& t = triangles_[triangle];
  const Material& material = scene_textures_.materials[t.material];
  if (material.opaque()) return true;
  const glm::dvec2 uv =
      (1 - u - v) * glm::dvec2(t.uv[0]) + u * glm::dvec2(t.uv[1]) + v * glm::dvec2(t.uv[2]);
  return random() < OracleOpacity(scene_textures_, material, uv);
}

// Returns the emission of a triangle at that point.
dvec3 Oracle::Emission(std::uint32_t triangle, double u, double v) const {
  const Triangle& t = triangles_[triangle];
  const Material& material = scene_textures_.materials[t.material];
  if (!material.emission_texture) return t.light.radiance;
  const glm::dvec2 uv =
      (1 - u - v) * glm::dvec2(t.uv[0]) + u * glm::dvec2(t.uv[1]) + v * glm::dvec2(t.uv[2]);
  return t.light.radiance * LookUpTexture(scene_textures_, *material.emission_texture, uv);
}

// Finds the nearest triangle up to `reach` that stops the ray, by trying one after another.
bool Oracle::FindHit(const Ray& ray, double reach, OracleRandom& random, RTCRayHit& query) const {
  EmbreeQuery embree(scene_, /*coherent=*/false);
  query.ray = EmbreeRay(ray.origin, ray.direction);
  query.ray.tfar = float(reach);
  while (true) {
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    Intersect1(embree, query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    if (IsThere(query.hit.primID, query.hit.u, query.hit.v, random)) return true;
    // The step exceeds the rounding of distances; otherwise Embree would find the same hit forever.
    query.ray.tnear = query.ray.tfar * (1 + 0x1p-20f) + 1e-20f;
    query.ray.tfar = float(reach);
    if (!(query.ray.tnear < query.ray.tfar)) return false;
  }
}

bool Oracle::Intersect(const Ray& ray, OracleRandom& random, Hit& hit) const {
  RTCRayHit query = {};
  if (!FindHit(ray, std::numeric_limits<double>::infinity(), random, query)) return false;

  const Triangle& t = triangles_[query.hit.primID];
  const double u = query.hit.u, v = query.hit.v, w = 1 - u - v;
  const dvec3 a(t.corner[0]), b(t.corner[1]), c(t.corner[2]);
  const dvec3 wo = -ray.direction;
  dvec3 ng = glm::normalize(glm::cross(b - a, c - a)), ns = ng;
  if (t.smooth) {
    ns = glm::normalize(w * dvec3(t.normal[0]) + u * dvec3(t.normal[1]) + v * dvec3(t.normal[2]));
  }
  const bool back = glm::dot(ng, wo) < 0;
  if (back) ng = -ng, ns = -ns;
  // Smooth normals that face away from the eye cannot shade.
  if (!(glm::dot(ns, wo) > 1e-4)) ns = ng;
  const Material& material = scene_textures_.materials[t.material];
  if (material.normal_texture) {
    const glm::dvec2 uv =
        w * glm::dvec2(t.uv[0]) + u * glm::dvec2(t.uv[1]) + v * glm::dvec2(t.uv[2]);
    const double side = back ? -1 : 1;
    ns = side * OracleBend(scene_textures_, material, t.corner, t.uv, uv, side * ns);
    // Normals that face away are turned towards the eye, in the plane of both.
    ns = glm::normalize(ns + wo * std::max(0.0, 1.0 / 128 - glm::dot(ns, wo)));
  }
  hit.distance = query.ray.tfar;
  hit.light = t.light.radiance == dvec3(0) ? nullptr : &t.light;
  hit.emission = Emission(query.hit.primID, u, v);
  hit.light_cosine = (back ? -1 : 1) * glm::dot(ng, wo);
  if (t.light.two_sided) hit.light_cosine = std::abs(hit.light_cosine);
  hit.surface = {&materials_[t.material], wo, ng, ns, back, t.tangent};
  ApplyTextures(t, {w, u, v}, hit);
  hit.point = w * a + u * b + v * c;
  const double longest = std::max(glm::length(b - a), glm::length(c - a));
  const double slimness = longest * longest / glm::length(glm::cross(b - a, c - a));
  hit.lift = MaxComponent(glm::abs(hit.point)) * 0x1p-20 + longest * slimness * 0x1p-21;
  return true;
}

void Oracle::ApplyTextures(const Triangle& triangle, const dvec3& weights, Hit& hit) const {
  const Material& material = scene_textures_.materials[triangle.material];
  if (!material.color_texture && !material.roughness_texture) return;
  hit.textured = *hit.surface.material;
  hit.surface.material = &hit.textured;
  const glm::dvec2 uv = weights.x * glm::dvec2(triangle.uv[0]) +
                        weights.y * glm::dvec2(triangle.uv[1]) +
                        weights.z * glm::dvec2(triangle.uv[2]);
  if (material.color_texture) {
    hit.textured.reflectance *= LookUpTexture(scene_textures_, *material.color_texture, uv);
  }
  if (material.roughness_texture) {
    const dvec3 seen = LookUpTexture(scene_textures_, *material.roughness_texture, uv);
    hit.textured.alpha = std::clamp(hit.textured.alpha * seen.y * seen.y, 1e-3, 1.0);
    hit.textured.metallic *= seen.z;
  }
}

bool Oracle::Occluded(const Ray& ray, double distance, OracleRandom& random) const {
  const double reach = distance * (1 - 1e-4);
  if (has_alpha_) {
    RTCRayHit hit = {};
    return FindHit(ray, reach, random, hit);
  }
  EmbreeQuery embree(scene_, /*coherent=*/false);
  RTCRay query = EmbreeRay(ray.origin, ray.direction);
  query.tfar = float(reach);
  Occluded1(embree, query);
  return query.tfar < 0;
}

Oracle::Ray Oracle::LeaveFrom(const Hit& hit, const dvec3& direction) const {
  const dvec3& ng = hit.surface.ng;
  const double side = glm::dot(ng, direction) < 0 ? -1 : 1;
  return {hit.point + side * hit.lift * ng, direction};
}

// Returns the radiance for a ray that left the scene. `pdf` is the BSDF sampling density of its
// direction, or 0 if it had none, so that no light sample could have found the same light.
dvec3 Oracle::LightFromEnvironment(const dvec3& direction, double pdf,
                                   const RenderOptions& options) const {
  if (pdf == 0) return environment_.Seen(direction);
  if (!options.mis) return dvec3(0);
  const OracleEnvironment::Lit lit = environment_.AsLight(direction);
  const double samples = options.integrator == Integrator::kDirect ? options.light_samples : 1;
  const double light_pdf = samples * lit.pdf * (1 - LocalShare());
  return lit.radiance * (pdf * pdf / (pdf * pdf + light_pdf * light_pdf));
}

// Light samples are divided evenly between the environment and the local lights.
double Oracle::LocalShare() const { return local_lights_.empty() ? 0 : has_environment_ ? 0.5 : 1; }

// Returns the radiance of an emitting triangle at the end of a ray; `pdf` as above.
dvec3 Oracle::LightFromHit(const Hit& hit, double pdf, const RenderOptions& options) const {
  if (!hit.light || !(hit.light_cosine > 0)) return dvec3(0);
  if (pdf == 0) return hit.emission;
  if (!options.mis) return dvec3(0);
  const double samples = options.integrator == Integrator::kDirect ? options.light_samples : 1;
  const double light_pdf =
      samples * LocalShare() * local_lights_.Pdf(*hit.light, hit.distance, hit.light_cosine);
  return hit.emission * (pdf * pdf / (pdf * pdf + light_pdf * light_pdf));
}

// Returns one light sample, not yet divided by the number of samples.
dvec3 Oracle::LightFromSample(const Hit& hit, const RenderOptions& options,
                              OracleRandom& random) const {
  OracleLocalLights::LightSample light;
  if (!local_lights_.empty() && random() < LocalShare()) {
    const auto local = local_lights_.Sample(LeaveFrom(hit, hit.surface.ng).origin, random);
    if (!local) return dvec3(0);
    light = *local;
    if (light.triangle) light.radiance = Emission(*light.triangle, light.u, light.v);
    light.pdf *= LocalShare();
    if (light.pdf == 0) light.radiance /= LocalShare();
  } else {
    const OracleEnvironment::LightSample far = environment_.Sample(random);
    light = {far.direction, far.radiance, far.pdf * (1 - LocalShare()),
             std::numeric_limits<double>::infinity()};
  }
  const OracleValue bsdf = EvaluateBsdf(hit.surface, light.direction);
  if (!(MaxComponent(bsdf.value * light.radiance) > 0)) return dvec3(0);
  // Shadow rays end just before the light, so its alpha is tested here.
  if (light.triangle && !IsThere(*light.triangle, light.u, light.v, random)) return dvec3(0);
  if (Occluded(LeaveFrom(hit, light.direction), light.distance, random)) return dvec3(0);
  if (light.pdf == 0) return bsdf.value * light.radiance;
  double weight = 1;
  if (options.mis) {
    const double samples = options.integrator == Integrator::kDirect ? options.light_samples : 1;
    const double light_pdf = samples * light.pdf;
    weight = light_pdf * light_pdf / (light_pdf * light_pdf + bsdf.pdf * bsdf.pdf);
  }
  return bsdf.value * light.radiance * (weight / light.pdf);
}

dvec3 Oracle::Radiance(Ray ray, const RenderOptions& options, OracleRandom& random) const {
  const bool direct = options.integrator == Integrator::kDirect;
  dvec3 radiance(0), throughput(1);
  double pdf = 0;
  for (std::uint32_t bounce = 0;; ++bounce) {
    Hit hit;
    // After the last surface, and after the BSDF sample of `direct`, only emission counts.
    const bool last = bounce == options.max_depth || (direct && pdf > 0);
    if (!Intersect(ray, random, hit)) {
      return radiance + throughput * LightFromEnvironment(ray.direction, pdf, options);
    }
    radiance += throughput * LightFromHit(hit, pdf, options);
    if (last) return radiance;

    if (!hit.surface.material->delta()) {
      const std::uint32_t samples = direct ? options.light_samples : 1;
      for (std::uint32_t i = 0; i < samples; ++i) {
        radiance += throughput * LightFromSample(hit, options, random) / double(samples);
      }
      if (direct && !options.mis) return radiance;
    }
    const OracleScatter scattered = ScatterBsdf(hit.surface, random);
    if (!scattered.alive) return radiance;
    throughput *= scattered.weight;
    if (bounce >= kFirstRouletteBounce) {
      const double survival = std::min(1.0, MaxComponent(throughput));
      if (!(random() < survival)) return radiance;
      throughput /= survival;
    }
    pdf = scattered.pdf;
    ray = LeaveFrom(hit, scattered.wi);
  }
}

// Directions of the square are those of Clarberg 2008, "Fast Equal-Area Mapping of the
// (Hemi)Sphere", whose pole is up in camera space.
dvec3 EqualAreaDirection(double x, double y) {
  // Beyond a side of the square, the same side follows in reverse.
  if (x < 0 || x > 1) x = x < 0 ? -x : 2 - x, y = 1 - y;
  if (y < 0 || y > 1) y = y < 0 ? -y : 2 - y, x = 1 - x;
  const double a = 2 * x - 1, b = 2 * y - 1, inside = 1 - std::abs(a) - std::abs(b);
  const double r = 1 - std::abs(inside);
  const double turn = kPi / 4 * (r == 0 ? 1 : (std::abs(b) - std::abs(a)) / r + 1);
  const double side = r * std::sqrt(2 - r * r);
  return {std::copysign(std::cos(turn), a) * side, std::copysign(1 - r * r, inside),
          std::copysign(std::sin(turn), b) * side};
}

std::optional<Oracle::Ray> Oracle::CameraRay(const glm::dvec2& film, const RenderOptions& options,
                                             OracleRandom& random) const {
  const double width = options.width, height = options.height, shorter = std::min(width, height);
  const double fov = glm::radians(double(camera_.fov_degrees));
  dvec3 origin(0), direction(0, 0, 1);
  // Camera space has x to the right, y up and z ahead.
  glm::dvec2 screen = {(2 * film.x - width) / shorter, (height - 2 * film.y) / shorter};
  if (const std::optional<ScreenWindow>& w = camera_.window) {
    screen = {w->left + (double(w->right) - w->left) * film.x / width,
              w->top - (double(w->top) - w->bottom) * film.y / height};
  }
  switch (camera_.kind) {
    case CameraKind::kPerspective:
      direction = {screen * std::tan(fov / 2), 1};
      break;
    case CameraKind::kOrthographic:
      origin = {screen, 0};
      break;
    case CameraKind::kLatLong: {
      const double polar = kPi * film.y / height, turn = 2 * kPi * (film.x / width - 0.5);
      direction = {std::sin(polar) * std::sin(turn), std::cos(polar),
                   std::sin(polar) * std::cos(turn)};
      break;
    }
    case CameraKind::kEqualArea:
      direction = EqualAreaDirection(film.x / width, film.y / height);
      break;
    case CameraKind::kFisheye: {
      const glm::dvec2 off = {film.x - width / 2, height / 2 - film.y};
      const double radius = glm::length(off), angle = fov * radius / shorter;
      if (angle > fov / 2) return std::nullopt;
      if (radius > 0) direction = {off * (std::sin(angle) / radius), std::cos(angle)};
      break;
    }
    case CameraKind::kRealistic:  // lens_system_test.cc follows its rays
      return std::nullopt;
  }
  if (camera_.lens_radius > 0) {
    const dvec3 sharp = origin + direction * double(camera_.focal_distance);
    const double radius = camera_.lens_radius * std::sqrt(random()), turn = 2 * kPi * random();
    origin += dvec3(radius * std::cos(turn), radius * std::sin(turn), 0);
    direction = sharp - origin;
  }
  const glm::dmat4 world(camera_.world_from_camera);
  return Ray{dvec3(world * glm::dvec4(origin, 1)),
             glm::normalize(dvec3(world * glm::dvec4(direction, 0)))};
}

void Oracle::RenderRow(int y, const RenderOptions& options, const std::vector<float>& filter,
                       OraclePicture& picture) const {
  const double n = options.samples_per_pixel;
  for (int x = 0; x < options.width; ++x) {
    OracleRandom random(std::uint64_t{options.seed} << 32 | options.first_sample,
                        std::uint64_t(y) * options.width + x);
    dvec3 mean(0), squares(0);
    for (std::uint32_t i = 0; i < options.samples_per_pixel; ++i) {
      const double film_x = x + 0.5 + FilterOffset(filter, random());
      const double film_y = y + 0.5 + FilterOffset(filter, random());
      const std::optional<Ray> ray = CameraRay({film_x, film_y}, options, random);
      const dvec3 value = ray ? Radiance(*ray, options, random) : dvec3(0);
      const dvec3 difference = value - mean;
      mean += difference / double(i + 1);
      squares += difference * (value - mean);
    }
    for (int c = 0; c < 3; ++c) {
      picture.mean.Pixel(x, y)[c] = float(mean[c]);
      picture.variance[(std::size_t(y) * options.width + x) * 3 + c] =
          n > 1 ? squares[c] / (n - 1) / n : 0;
    }
  }
}

OraclePicture Oracle::Render(const RenderOptions& options) const {
  if (options.integrator != Integrator::kPath && options.integrator != Integrator::kDirect) {
    throw std::logic_error("the oracle knows the integrators path and direct");
  }
  if (options.crop_x != 0 || options.crop_y != 0)
    throw std::logic_error("the oracle crops nothing");
  OraclePicture picture;
  picture.mean = Image(options.width, options.height);
  picture.variance.resize(picture.mean.rgb.size());
  const std::vector<float> filter = FilterOffsets(options.filter, options.filter_radius);
  std::atomic<int> next_row = 0;
  const auto start = Clock::now();
  const auto work = [&] {
    const FlushDenormals flush;
    for (int y = next_row++; y < options.height; y = next_row++) {
      RenderRow(y, options, filter, picture);
    }
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < std::max(options.threads, 1); ++i) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  picture.seconds = SecondsSince(start);
  return picture;
}

}  // namespace skywave
