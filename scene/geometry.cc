#include "scene/geometry.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "base/error.h"
#include "kernels/conductor_tables.h"
#include "kernels/surface.h"

namespace skywave {
namespace {

bool Finite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Embree does not look at its input; whoever reads a file must have, and this is the last gate.
void CheckMesh(const Mesh& mesh, std::size_t materials, const std::string& path) {
  const auto fail = [&](const std::string& reason) {
    throw InputError(InputPosition::File(path), fmt::format("mesh '{}': {}", mesh.name, reason));
  };
  if (mesh.material >= materials) fail("its material does not exist");
  if (!mesh.normals.empty() && mesh.normals.size() != mesh.positions.size()) {
    fail(fmt::format("{} normals for {} positions", mesh.normals.size(), mesh.positions.size()));
  }
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::vec3& p = mesh.positions[i];
    // Embree's limit; beyond it the arithmetic of boxes overflows.
    if (!Finite(p) || glm::length(p) > 1e18f) {
      fail(fmt::format("vertex {} is at ({}, {}, {})", i, p.x, p.y, p.z));
    }
  }
  if (!mesh.uvs.empty() && mesh.uvs.size() != mesh.positions.size()) {
    fail(fmt::format("{} uvs for {} positions", mesh.uvs.size(), mesh.positions.size()));
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int corner = 0; corner < 3; ++corner) {
      if (mesh.triangles[i][corner] >= mesh.positions.size()) {
        fail(fmt::format("triangle {} names vertex {} of {}", i, mesh.triangles[i][corner],
                         mesh.positions.size()));
      }
    }
  }
}

std::uint32_t PackNormal(const glm::vec3& n) { return EncodeNormal(n.x, n.y, n.z); }

// Appends one triangle: positions already in the vertex table from `first_vertex` on. Returns its
// corners in the order of the record.
glm::uvec3 AppendTriangle(const Mesh& mesh, BsdfKind bsdf, glm::uvec3 corners,
                          std::uint32_t first_vertex, std::vector<std::uint32_t>& indices,
                          std::vector<TriangleRecord>& records) {
  const glm::vec3 &a = mesh.positions[corners.x], &b = mesh.positions[corners.y],
                  &c = mesh.positions[corners.z];
  const glm::vec3 face = glm::cross(b - a, c - a);
  TriangleRecord record = {.normal = {}, .tag = mesh.material | std::uint32_t(bsdf) << kKindShift};
  bool smooth = !mesh.normals.empty();
  if (smooth) {
    glm::vec3 normals[3], sum(0);
    for (int i = 0; i < 3; ++i) {
      normals[i] = mesh.normals[corners[i]];
      const float length = glm::length(normals[i]);
      smooth = smooth && std::isfinite(length) && length > 0;
      sum += normals[i];
    }
    if (smooth && glm::dot(sum, face) < 0) {
      std::swap(corners.y, corners.z);
      std::swap(normals[1], normals[2]);
    }
    for (int i = 0; smooth && i < 3; ++i) record.normal[i] = PackNormal(normals[i]);
  }
  if (!smooth) record.tag |= kFlatTriangle;
  for (int i = 0; i < 3; ++i) indices.push_back(first_vertex + corners[i]);
  records.push_back(record);
  return corners;
}

constexpr float kSteepest = 1e6f;  // what is more is a wall all the same

// Nothing where no material has a normal map.
std::vector<NormalMapRecord> PackNormalMaps(const Scene& scene, const TextureTables& textures) {
  std::vector<NormalMapRecord> records;
  bool any = false;
  for (const Material& material : scene.materials) {
    NormalMapRecord record = {};
    if (material.normal_texture) {
      any = true;
      const bool heights = scene.textures[*material.normal_texture].use == TextureUse::kHeights;
      record.texture = *material.normal_texture + 1;
      const float scale = material.normal_scale * textures.slopes[*material.normal_texture];
      record.scale = std::isnan(scale) ? 0 : std::clamp(scale, -kSteepest, kSteepest);
      record.per_texel = heights && !material.height_in_texels;
    }
    records.push_back(record);
  }
  if (!any) records.clear();
  return records;
}

// Meshes in their order, those whose material is opaque first.
std::vector<const Mesh*> OpaqueFirst(const Scene& scene) {
  std::vector<const Mesh*> meshes;
  for (const Mesh& mesh : scene.meshes) meshes.push_back(&mesh);
  std::stable_partition(meshes.begin(), meshes.end(),
                        [&](const Mesh* mesh) { return scene.materials[mesh->material].opaque(); });
  return meshes;
}

MaterialRecord PackMaterial(const Material& material) {
  MaterialRecord record = {};
  const float alpha = std::clamp(material.alpha, 1e-3f, 1.0f);
  for (int c = 0; c < 3; ++c) {
    record.color[c] = material.reflectance[c];
    record.eta[c] = material.eta[c];
    record.k[c] = material.k[c];
    if (material.bsdf == BsdfKind::kConductor) {
      record.multiscatter[c] =
          ConductorMultiscatter(GgxTables(), alpha, material.eta[c], material.k[c]);
    }
  }
  record.alpha = alpha;
  record.ior = material.ior;
  if (material.bsdf == BsdfKind::kMetallicRoughness) record.eta[0] = material.metallic;
  if (material.color_texture) record.color_texture = *material.color_texture + 1;
  if (material.roughness_texture) record.roughness_texture = *material.roughness_texture + 1;
  return record;
}

}  // namespace

Geometry::Geometry(const Scene& scene, const std::string& path, int threads,
                   const std::string& embree_config) {
  std::size_t vertex_count = 0, triangle_count = 0;
  for (const Mesh& mesh : scene.meshes) {
    CheckMesh(mesh, scene.materials.size(), path);
    vertex_count += mesh.positions.size();
    triangle_count += mesh.triangles.size();
  }
  if (triangle_count == 0) {
    throw InputError(InputPosition::File(path), "there is no triangle to render");
  }
  if (scene.materials.size() > kMaterialMask || triangle_count >= (std::size_t{1} << 29)) {
    throw InputError(InputPosition::File(path),
                     fmt::format("{} materials and {} triangles are more than a scene can hold",
                                 scene.materials.size(), triangle_count));
  }
  bool textured = false;
  for (const Material& material : scene.materials) {
    for (const auto& texture : {material.color_texture, material.roughness_texture,
                                material.opacity_texture, material.normal_texture}) {
      if (!texture) continue;
      textured = true;
      if (*texture >= scene.textures.size()) {
        throw InputError(InputPosition::File(path),
                         fmt::format("material '{}': its texture does not exist", material.name));
      }
    }
  }
  if (textured) {
    textures_ = MakeTextureTables(scene, path);
    textures_.uvs.reserve(triangle_count);
    normal_maps_ = PackNormalMaps(scene, textures_);
  }
  vertices_.reserve(vertex_count * 3 + 1);
  indices_.reserve(triangle_count * 3);
  triangles_.reserve(triangle_count);
  if (!normal_maps_.empty()) tangents_.reserve(triangle_count);
  for (const Mesh* const from : OpaqueFirst(scene)) {
    const Mesh& mesh = *from;
    const Material& material = scene.materials[mesh.material];
    const auto first_vertex = std::uint32_t(vertices_.size() / 3);
    for (const glm::vec3& p : mesh.positions) vertices_.insert(vertices_.end(), {p.x, p.y, p.z});
    for (const glm::uvec3& triangle : mesh.triangles) {
      const glm::uvec3 corners =
          AppendTriangle(mesh, material.bsdf, triangle, first_vertex, indices_, triangles_);
      if (textured) textures_.uvs.push_back(MakeTriangleUvs(mesh, corners));
      if (normal_maps_.empty()) continue;
      tangents_.push_back(
          material.normal_texture
              ? MakeTriangleTangents(mesh, corners, scene.textures[*material.normal_texture])
              : TriangleTangents{});
    }
    if (material.opaque()) first_with_holes_ = std::uint32_t(triangles_.size());
  }
  vertices_.push_back(0);  // Embree reads vertices four floats at a time
  for (const Material& material : scene.materials) {
    materials_.push_back(PackMaterial(material));
    // Tens of milliseconds, so only for those who need them.
    if (material.bsdf == BsdfKind::kConductor || material.bsdf == BsdfKind::kMetallicRoughness) {
      conductor_tables_ = &GgxTables();
    }
  }
  if (has_holes()) {
    opacity_ = MakeOpacityRecords(scene.materials);
    hole_filter_ = {.opacity = {.triangles = triangles_.data(),
                                .records = opacity_.data(),
                                .textures = textures_.view()},
                    .first = first_with_holes_};
  }

  const auto start = std::chrono::steady_clock::now();
  const std::string config =
      fmt::format("threads={},set_affinity=0,{}", threads,
                  embree_config.empty() ? DefaultEmbreeConfig() : embree_config);
  device_.reset(rtcNewDevice(config.c_str()));
  if (!device_) {
    throw InputError(InputPosition::File(path), "Embree does not start with: " + config);
  }
  rtcSetDeviceMemoryMonitorFunction(
      device_.get(),
      [](void* sum, ssize_t bytes, bool) {
        *static_cast<std::atomic<std::int64_t>*>(sum) += bytes;
        return true;
      },
      &embree_bytes_);
  scene_.reset(rtcNewScene(device_.get()));
  rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_HIGH);
  const auto attach = [&](unsigned id, std::size_t first, std::size_t count, bool holes) {
    if (count == 0) return;
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               vertices_.data(), 0, 3 * sizeof(float), vertex_count);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               &indices_[3 * first], 0, 3 * sizeof(std::uint32_t), count);
    if (holes) SetHoleFilter(geometry, hole_filter_);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene_.get(), geometry, id);
    rtcReleaseGeometry(geometry);
  };
  attach(0, 0, first_with_holes_, false);
  attach(1, first_with_holes_, triangle_count - first_with_holes_, true);
  rtcCommitScene(scene_.get());
  if (const RTCError error = rtcGetDeviceError(device_.get()); error != RTC_ERROR_NONE) {
    throw InputError(InputPosition::File(path),
                     fmt::format("Embree cannot build the scene (error {})", int(error)));
  }
  build_seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::string DefaultEmbreeConfig() {
  return __builtin_cpu_supports("avx2") ? "isa=avx2" : "verbose=0";
}

MaterialView Geometry::materials() const {
  return {.records = materials_.data(), .conductor = conductor_tables_};
}

TextureView Geometry::textures() const { return textures_.view(); }

NormalMapView Geometry::normal_maps() const {
  if (normal_maps_.empty()) return {};
  return {.records = normal_maps_.data(), .tangents = tangents_.data()};
}

std::size_t Geometry::bytes() const {
  return vertices_.size() * sizeof(float) + indices_.size() * sizeof(std::uint32_t) +
         triangles_.size() * sizeof(TriangleRecord) + materials_.size() * sizeof(MaterialRecord) +
         textures_.bytes() + normal_maps_.size() * sizeof(NormalMapRecord) +
         tangents_.size() * sizeof(TriangleTangents) + opacity_.size() * sizeof(OpacityRecord);
}

std::uint64_t SceneHash(const Scene& scene) {
  XXH64_state_t* state = XXH64_createState();
  XXH64_reset(state, 0);
  const auto add = [&](const auto& value) { XXH64_update(state, &value, sizeof value); };
  const auto add_all = [&](const auto& values) {
    add(std::uint64_t{values.size()});
    XXH64_update(state, values.data(), values.size() * sizeof values[0]);
  };
  for (const Mesh& mesh : scene.meshes) {
    add_all(mesh.positions), add_all(mesh.normals), add_all(mesh.uvs), add_all(mesh.triangles);
    add(mesh.material);
    if (!mesh.tangents.empty()) add_all(mesh.tangents);
  }
  for (const Material& m : scene.materials) {
    add(m.bsdf), add(m.reflectance), add(m.eta), add(m.k), add(m.alpha), add(m.ior);
    add(m.metallic), add(m.color_texture.value_or(~0u)), add(m.roughness_texture.value_or(~0u));
    if (!m.opaque()) {
      add(m.opacity), add(m.opacity_cutoff.value_or(-1)), add(m.opacity_texture.value_or(~0u));
    }
    if (m.normal_texture) {
      add(*m.normal_texture), add(m.normal_scale), add(m.height_in_texels);
    }
  }
  for (const Texture& t : scene.textures) {
    add(t.image), add(t.wrap_u), add(t.wrap_v), add(t.transform);
    if (t.use != TextureUse::kColor) add(t.use);
  }
  for (const Image& image : scene.images) {
    add(image.width), add(image.height), add_all(image.rgb);
  }
  if (scene.camera) {
    const Camera& camera = *scene.camera;
    add(camera.kind), add(camera.world_from_camera), add(camera.fov_degrees);
    if (camera.window) add(*camera.window);
    add(camera.lens_radius), add(camera.focal_distance);
  }
  for (const EnvironmentLight& light : scene.environments) {
    if (light.map) add(light.map->width), add(light.map->height), add_all(light.map->rgb);
    add(light.scale), add(light.world_from_map);
  }
  const std::uint64_t hash = XXH64_digest(state);
  XXH64_freeState(state);
  return hash;
}

}  // namespace skywave
