#include "scene/geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <iterator>
#include <numeric>

#include "base/error.h"
#include "kernels/bsdf/conductor_tables.h"
#include "kernels/bsdf/pack.h"
#include "kernels/surface/surface.h"

namespace skywave {
namespace {

constexpr std::size_t kMaxRecords = std::size_t{1} << 29;  // kernels index them by 31 bits of words
constexpr std::size_t kMaxVariants = 128;                  // records a triangle, in the mean

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
      fail(fmt::format("vertex {} is at ({}, {}, {}); the world ends at 1e18", i, p.x, p.y, p.z));
    }
  }
  if (!mesh.uvs.empty() && mesh.uvs.size() != mesh.positions.size()) {
    fail(fmt::format("{} uvs for {} positions", mesh.uvs.size(), mesh.positions.size()));
  }
  if (!mesh.colors.empty() && mesh.colors.size() != mesh.positions.size()) {
    fail(fmt::format("{} colours for {} positions", mesh.colors.size(), mesh.positions.size()));
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
glm::uvec3 AppendTriangle(const Mesh& mesh, glm::uvec3 corners, std::uint32_t first_vertex,
                          std::vector<std::uint32_t>& indices,
                          std::vector<TriangleRecord>& records) {
  const glm::vec3 &a = mesh.positions[corners.x], &b = mesh.positions[corners.y],
                  &c = mesh.positions[corners.z];
  const glm::vec3 face = glm::cross(b - a, c - a);
  TriangleRecord record = {.normal = {}, .tag = mesh.material};
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

// Indices of meshes in their order, those whose material is opaque first.
std::vector<std::uint32_t> OpaqueFirst(const Scene& scene) {
  std::vector<std::uint32_t> meshes(scene.meshes.size());
  std::iota(meshes.begin(), meshes.end(), 0u);
  std::stable_partition(meshes.begin(), meshes.end(), [&](std::uint32_t mesh) {
    return scene.materials[scene.meshes[mesh].material].opaque();
  });
  return meshes;
}

void CheckMaterial(const Scene& scene, std::size_t index, const std::string& path) {
  const Material& material = scene.materials[index];
  const auto fail = [&](const std::string& reason) {
    throw InputError(InputPosition::File(path),
                     fmt::format("material '{}': {}", material.name, reason));
  };
  for (const auto& texture :
       {material.color_texture, material.roughness_texture, material.opacity_texture,
        material.normal_texture, material.emission_texture}) {
    if (texture && (*texture >= scene.textures.size() ||
                    scene.textures[*texture].image >= scene.images.size())) {
      fail("its texture does not exist");
    }
  }
  if (const auto& mixture = material.mixture) {
    if (mixture->first >= index || mixture->second >= index) fail("it is mixed of later materials");
  } else if (Bsdfs()[std::size_t(material.bsdf)].tables.measured &&
             (material.measured >= scene.measured.size() ||
              scene.measured[material.measured].rgb.size() != kMeasuredFloats)) {
    fail("its measured BRDF does not exist");
  }
}

// The direction in which u grows over a triangle; the world's +y where it has no uvs.
std::uint32_t PackTangent(const Mesh& mesh, const glm::uvec3& corners) {
  glm::dvec3 tangent(0, 1, 0);
  if (!mesh.uvs.empty()) {
    const glm::dvec3 a(mesh.positions[corners.x]), b(mesh.positions[corners.y]),
        c(mesh.positions[corners.z]);
    const glm::dvec2 s(mesh.uvs[corners.x]), t(mesh.uvs[corners.y]), w(mesh.uvs[corners.z]);
    const glm::dvec2 along = t - s, across = w - s;
    const double area = along.x * across.y - along.y * across.x;
    const glm::dvec3 u = (across.y * (b - a) - along.y * (c - a)) * (area < 0 ? -1.0 : 1.0);
    const double length = glm::length(u);
    if (std::isfinite(length) && length > 0) tangent = u / length;
  }
  return EncodeNormal(float(tangent.x), float(tangent.y), float(tangent.z));
}

}  // namespace

Geometry::Geometry(const Scene& scene, const std::string& path, int threads,
                   const std::string& embree_config, bool keep_uvs) {
  std::size_t vertex_count = 0, triangle_count = 0;
  for (const Mesh& mesh : scene.meshes) {
    CheckMesh(mesh, scene.materials.size(), path);
    vertex_count += mesh.positions.size();
    triangle_count += mesh.triangles.size();
  }
  if (triangle_count == 0) {
    throw InputError(InputPosition::File(path), "there is no triangle to render");
  }
  if (scene.materials.size() > kMaterialMask || triangle_count >= kMaxRecords) {
    throw InputError(InputPosition::File(path),
                     fmt::format("{} materials and {} triangles are more than a scene can hold",
                                 scene.materials.size(), triangle_count));
  }
  bool textured = false;
  bool tangents = false;
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    CheckMaterial(scene, i, path);
    const Material& material = scene.materials[i];
    textured = textured || material.color_texture || material.roughness_texture ||
               material.opacity_texture || material.normal_texture || material.emission_texture;
    tangents = tangents || Bsdfs()[std::size_t(material.bsdf)].varying == Varying::kTangent;
  }
  if (textured) {
    textures_ = MakeTextureTables(scene, path);
    normal_maps_ = PackNormalMaps(scene, textures_);
  }
  keep_uvs = keep_uvs || textured;
  const bool colored = std::any_of(scene.meshes.begin(), scene.meshes.end(),
                                   [](const Mesh& mesh) { return !mesh.colors.empty(); });
  if (keep_uvs) textures_.uvs.reserve(triangle_count);
  vertices_.reserve(vertex_count * 3 + 1);
  indices_.reserve(triangle_count * 3);
  triangles_.reserve(triangle_count);
  for (const std::uint32_t index : OpaqueFirst(scene)) {
    const Mesh& mesh = scene.meshes[index];
    const auto first_vertex = std::uint32_t(vertices_.size() / 3);
    for (const glm::vec3& p : mesh.positions) vertices_.insert(vertices_.end(), {p.x, p.y, p.z});
    meshes_.push_back({index, std::uint32_t(triangles_.size()), first_vertex});
    for (const glm::uvec3& triangle : mesh.triangles) {
      const glm::uvec3 corners = AppendTriangle(mesh, triangle, first_vertex, indices_, triangles_);
      if (keep_uvs) textures_.uvs.push_back(MakeTriangleUvs(mesh, corners));
      if (tangents) tangents_.push_back(PackTangent(mesh, corners));
      for (int i = 0; colored && i < 3; ++i) {
        const glm::vec3 color = mesh.colors.empty() ? glm::vec3(1) : mesh.colors[corners[i]];
        vertex_colors_.push_back(PackTexel(&color.x));
      }
    }
    if (scene.materials[mesh.material].opaque()) {
      first_with_alpha_ = std::uint32_t(triangles_.size());
    }
  }
  // Variants come behind all triangles, variants of variants behind those.
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    AppendVariants(scene, i);
    // Mixtures of mixtures double with every level.
    if (triangles_.size() > kMaxVariants * triangle_count || triangles_.size() >= kMaxRecords) {
      throw InputError(InputPosition::File(path),
                       "the mixtures of materials have more variants than a scene can hold");
    }
  }
  if (!normal_maps_.empty()) MakeMapAxes(scene);
  vertices_.push_back(0);  // Embree reads vertices four floats at a time
  for (const Material& material : scene.materials) {
    materials_.push_back(PackMaterial(material, scene.measured));
    absorbs_ = absorbs_ || material.absorption != glm::vec3(0);
    // Tens of milliseconds, so only for those who need them.
    const BsdfTables& tables = Bsdfs()[std::size_t(material.bsdf)].tables;
    if (tables.ggx) conductor_tables_ = &GgxTables();
    if (tables.sheen) sheen_tables_ = &GetSheenTables();
  }
  for (const MeasuredBrdf& brdf : scene.measured) {
    measured_.insert(measured_.end(), brdf.rgb.begin(), brdf.rgb.end());
  }
  if (has_alpha()) {
    opacity_ = MakeOpacityRecords(scene.materials);
    alpha_filter_ = {.opacity = {.triangles = triangles_.data(),
                                 .records = opacity_.data(),
                                 .textures = textures_.view()},
                     .first = first_with_alpha_};
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
    if (holes) SetAlphaFilter(geometry, alpha_filter_);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene_.get(), geometry, id);
    rtcReleaseGeometry(geometry);
  };
  attach(0, 0, first_with_alpha_, false);
  attach(1, first_with_alpha_, triangle_count - first_with_alpha_, true);
  rtcCommitScene(scene_.get());
  if (const RTCError error = rtcGetDeviceError(device_.get()); error != RTC_ERROR_NONE) {
    throw InputError(InputPosition::File(path),
                     fmt::format("Embree cannot build the scene (error {})", int(error)));
  }
  build_seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Gives triangle `i` the BSDF of its material, or two more records where that is a mixture.
void Geometry::AppendVariants(const Scene& scene, std::size_t i) {
  const std::uint32_t material = triangles_[i].tag & kMaterialMask;
  const auto& mixture = scene.materials[material].mixture;
  if (!mixture) {
    const auto bsdf = std::uint32_t(scene.materials[material].bsdf);
    triangles_[i].tag |= bsdf << kKindShift;
    bsdfs_ |= BsdfSet{1} << bsdf;
    return;
  }
  has_mixtures_ = true;
  const auto first = std::uint32_t(triangles_.size());
  for (const std::uint32_t variant : {mixture->first, mixture->second}) {
    TriangleRecord record = triangles_[i];
    record.tag = (record.tag & ~kMaterialMask) | variant;
    triangles_.push_back(record);
    mixed_.push_back(std::uint32_t(i));
    if (!textures_.uvs.empty()) textures_.uvs.push_back(TriangleUvs(textures_.uvs[i]));
    if (!tangents_.empty()) tangents_.push_back(std::uint32_t(tangents_[i]));
    for (std::size_t c = 0; !vertex_colors_.empty() && c < 3; ++c) {
      vertex_colors_.push_back(std::uint32_t(vertex_colors_[3 * i + c]));
    }
  }
  triangles_[i] = {.normal = {first, std::bit_cast<std::uint32_t>(mixture->share), material},
                   .tag = kMixedTriangle};
}

// Variants of one triangle may have different maps.
void Geometry::MakeMapAxes(const Scene& scene) {
  map_axes_.resize(record_count());
  for (std::uint32_t record = 0; record < record_count(); ++record) {
    const std::uint32_t tag = triangles_[record].tag;
    const auto& texture = scene.materials[tag & kMaterialMask].normal_texture;
    if ((tag & kMixedTriangle) != 0 || !texture) continue;
    const std::uint32_t triangle = TriangleOf(record);
    const MeshPlace& place = PlaceOf(triangle);
    const std::uint32_t* const corners = &indices_[3 * std::size_t{triangle}];
    map_axes_[record] =
        MakeTriangleTangents(scene.meshes[place.mesh],
                             glm::uvec3(corners[0], corners[1], corners[2]) - place.first_vertex,
                             scene.textures[*texture]);
  }
}

std::string DefaultEmbreeConfig() {
  return __builtin_cpu_supports("avx2") ? "isa=avx2" : "verbose=0";
}

MaterialView Geometry::materials() const {
  return {.records = materials_.data(),
          .conductor = conductor_tables_,
          .sheen = sheen_tables_,
          .measured = measured_.data()};
}

glm::vec3 Geometry::Corner(std::size_t triangle, int corner) const {
  const float* p = &vertices_[3 * std::size_t{indices_[3 * triangle + std::size_t(corner)]}];
  return {p[0], p[1], p[2]};
}

TextureView Geometry::textures() const { return textures_.view(); }

NormalMapView Geometry::normal_maps() const {
  if (normal_maps_.empty()) return {};
  return {.records = normal_maps_.data(), .tangents = map_axes_.data()};
}

std::uint32_t Geometry::TriangleOf(std::uint32_t record) const {
  while (record >= triangle_count()) record = mixed_[record - triangle_count()];
  return record;
}

const MeshPlace& Geometry::PlaceOf(std::uint32_t triangle) const {
  const auto next = std::upper_bound(
      meshes_.begin(), meshes_.end(), triangle,
      [](std::uint32_t t, const MeshPlace& place) { return t < place.first_triangle; });
  return *std::prev(next);
}

std::size_t Geometry::bytes() const {
  return vertices_.size() * sizeof(float) + indices_.size() * sizeof(std::uint32_t) +
         triangles_.size() * sizeof(TriangleRecord) + materials_.size() * sizeof(MaterialRecord) +
         (tangents_.size() + vertex_colors_.size() + mixed_.size() + measured_.size()) *
             sizeof(float) +
         textures_.bytes() + normal_maps_.size() * sizeof(NormalMapRecord) +
         map_axes_.size() * sizeof(TriangleTangents) + opacity_.size() * sizeof(OpacityRecord);
}

}  // namespace skywave
