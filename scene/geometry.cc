#include "scene/geometry.h"

<<<<<<< HEAD
#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <numeric>

#include "base/clock.h"
#include "base/error.h"
#include "kernels/bsdf/conductor_tables.h"
#include "kernels/surface/surface.h"

=======
>>>>>>> materials
namespace skywave {

Geometry::Geometry(const Scene& scene, const std::string& path, int threads,
<<<<<<< HEAD
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
    materials_.push_back(PackMaterial(material, scene));
    absorbs_ = absorbs_ || material.absorption != glm::vec3(0);
    // Tens of milliseconds, so only for those who need them.
    if (ReadsGgxTables(material.bsdf)) conductor_tables_ = &GgxTables();
    if (material.bsdf == BsdfKind::kCoatedMetallicRoughness) sheen_tables_ = &GetSheenTables();
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

  const auto start = Clock::now();
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
  build_seconds_ = SecondsSince(start);
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
=======
                   const std::string& embree_config, bool keep_uvs)
    : tables_(MakeGeometryTables(scene, path, keep_uvs)),
      opacity_(tables_.opacity_view()),
      embree_({.vertices = tables_.vertices.data(),
               .vertex_count = tables_.vertex_count(),
               .indices = tables_.indices.data(),
               .triangle_count = std::uint32_t(tables_.triangle_count()),
               .first_with_alpha = tables_.first_with_alpha,
               .opacity = opacity_},
              path, threads, embree_config) {}
>>>>>>> materials

MaterialView Geometry::materials() const {
  return {.records = tables_.materials.data(),
          .conductor = tables_.ggx,
          .sheen = tables_.sheen,
          .measured = tables_.measured.data()};
}

NormalMapView Geometry::normal_maps() const {
  if (tables_.normal_maps.empty()) return {};
  return {.records = tables_.normal_maps.data(), .tangents = tables_.map_axes.data()};
}

glm::vec3 Geometry::Corner(std::size_t triangle, int corner) const {
  const std::uint32_t vertex = tables_.indices[3 * triangle + std::size_t(corner)];
  const float* const p = &tables_.vertices[3 * std::size_t{vertex}];
  return {p[0], p[1], p[2]};
}

}  // namespace skywave
