#include "scene/geometry_tables.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <map>
#include <span>
#include <utility>

#include "base/error.h"
#include "kernels/bsdf/conductor_tables.h"
#include "kernels/bsdf/pack.h"
#include "kernels/partition.h"
#include "kernels/surface/surface.h"
#include "scene/geometry_checks.h"
#include "scene/materials/opacity.h"

namespace skywave {
namespace {

constexpr std::size_t kMaxVariants = 128;  // mean number of records per triangle

const BsdfKernels& BsdfOf(const Material& material) { return Bsdfs()[std::size_t(material.bsdf)]; }

// ---- Triangles ----

// The columns of a triangle that only some scenes have.
struct TriangleColumns {
  bool uvs, tangents, colors, alphas;
};

TriangleColumns ColumnsOf(const Scene& scene, std::span<const Mesh* const> meshes, bool uvs) {
  const auto& materials = scene.materials;
  return {.uvs = uvs,
          .tangents = std::any_of(materials.begin(), materials.end(), HasTangent),
          .colors = std::any_of(meshes.begin(), meshes.end(),
                                [](const Mesh* mesh) { return !mesh->colors.empty(); }),
          .alphas = std::any_of(meshes.begin(), meshes.end(),
                                [](const Mesh* mesh) { return !mesh->alphas.empty(); })};
}

// Returns all meshes in the order in which MeshPlace counts them.
std::vector<const Mesh*> AllMeshes(const Scene& scene) {
  std::vector<const Mesh*> meshes;
  for (const Mesh& mesh : scene.meshes) meshes.push_back(&mesh);
  for (const Object& object : scene.objects) {
    for (const Mesh& mesh : object.meshes) meshes.push_back(&mesh);
  }
  return meshes;
}

// Makes the record of a triangle, and turns `corners` so that its vertex normals are on its outer
// side. A triangle whose normals are no directions is flat.
TriangleRecord MakeRecord(const Mesh& mesh, bool one_sided, glm::uvec3& corners) {
  const glm::vec3 &a = mesh.positions[corners.x], &b = mesh.positions[corners.y],
                  &c = mesh.positions[corners.z];
  const glm::vec3 face = glm::cross(b - a, c - a);
  TriangleRecord record = {.normal = {}, .tag = mesh.material};
  if (one_sided) record.tag |= kOneSidedTriangle;
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
      if (one_sided) record.tag |= kTurnedTriangle;
    }
    for (int i = 0; smooth && i < 3; ++i) {
      record.normal[i] = EncodeNormal(normals[i].x, normals[i].y, normals[i].z);
    }
  }
  if (!smooth) record.tag |= kFlatTriangle;
  return record;
}

// Returns the mean of the mesh's tangents over a triangle or, where it has none of them, the
// direction in which u grows, or the world's +y where it has no uvs; with kMirroredTangent.
std::uint32_t PackTangent(const Mesh& mesh, const glm::uvec3& corners) {
  glm::dvec3 tangent(0, 1, 0), mean(0);
  for (int i = 0; i < 3 && !mesh.tangents.empty(); ++i) {
    mean += glm::dvec3(mesh.tangents[corners[i]]);
  }
  if (const double size = glm::length(mean); std::isfinite(size) && size > 1e-6) {
    tangent = mean / size;
  } else if (!mesh.uvs.empty()) {
    const glm::dvec3 a(mesh.positions[corners.x]), b(mesh.positions[corners.y]),
        c(mesh.positions[corners.z]);
    const glm::dvec2 s(mesh.uvs[corners.x]), t(mesh.uvs[corners.y]), w(mesh.uvs[corners.z]);
    const glm::dvec2 along = t - s, across = w - s;
    const double area = along.x * across.y - along.y * across.x;
    const glm::dvec3 u = (across.y * (b - a) - along.y * (c - a)) * (area < 0 ? -1.0 : 1.0);
    const double length = glm::length(u);
    if (std::isfinite(length) && length > 0) tangent = u / length;
  }
  const bool mirrored = MakeTriangleTangents(mesh, corners, Texture()).side < 0;
  const std::uint32_t packed = EncodeNormal(float(tangent.x), float(tangent.y), float(tangent.z));
  return (packed & ~kMirroredTangent) | (mirrored ? kMirroredTangent : 0);
}

void AppendTriangle(const Mesh& mesh, bool one_sided, glm::uvec3 corners,
                    std::uint32_t first_vertex, const TriangleColumns& columns,
                    GeometryTables& tables) {
  tables.triangles.push_back(MakeRecord(mesh, one_sided, corners));
  for (int i = 0; i < 3; ++i) tables.corners.push_back(first_vertex + corners[i]);
  if (columns.uvs) tables.textures.uvs.push_back(MakeTriangleUvs(mesh, UvSet::kFirst, corners));
  if (columns.tangents) tables.tangents.push_back(PackTangent(mesh, corners));
  for (int i = 0; columns.colors && i < 3; ++i) {
    const glm::vec3 color = mesh.colors.empty() ? glm::vec3(1) : mesh.colors[corners[i]];
    tables.vertex_colors.push_back(PackTexel(&color.x));
  }
  for (int i = 0; columns.alphas && i < 3; ++i) {
    tables.vertex_alphas.push_back(mesh.alphas.empty() ? 1 : mesh.alphas[corners[i]]);
  }
}

void AddMesh(const Mesh& mesh, bool one_sided, std::uint32_t index, const TriangleColumns& columns,
             GeometryTables& tables) {
  const auto first_vertex = std::uint32_t(tables.vertices.size() / 3);
  for (const glm::vec3& p : mesh.positions) {
    tables.vertices.insert(tables.vertices.end(), {p.x, p.y, p.z});
  }
  tables.meshes.push_back({index, std::uint32_t(tables.triangles.size()), first_vertex});
  for (const glm::uvec3& triangle : mesh.triangles) {
    AppendTriangle(mesh, one_sided, triangle, first_vertex, columns, tables);
  }
}

// Adds meshes [first, first + count), those of the world or of an object: first the opaque ones,
// then the others.
void AddSpan(const Scene& scene, std::span<const Mesh* const> meshes, std::size_t first,
             std::size_t count, const TriangleColumns& columns, GeometryTables& tables) {
  TriangleSpan span = {.first = std::uint32_t(tables.triangles.size())};
  for (const bool opaque : {true, false}) {
    for (std::size_t i = first; i < first + count; ++i) {
      const Material& material = scene.materials[meshes[i]->material];
      if ((material.opaque() && meshes[i]->alphas.empty()) != opaque) continue;
      AddMesh(*meshes[i], material.one_sided, std::uint32_t(i), columns, tables);
      tables.one_sided = tables.one_sided || material.one_sided;
    }
    if (opaque) span.first_with_alpha = std::uint32_t(tables.triangles.size());
  }
  span.end = std::uint32_t(tables.triangles.size());
  tables.spans.push_back(span);
}

void AddMeshes(const Scene& scene, std::span<const Mesh* const> meshes,
               const TriangleColumns& columns, GeometryTables& tables) {
  std::size_t vertices = 0, triangles = 0;
  for (const Mesh* const mesh : meshes) {
    vertices += mesh->positions.size(), triangles += mesh->triangles.size();
  }
  if (columns.uvs) tables.textures.uvs.reserve(triangles);
  tables.vertices.reserve(vertices * 3 + 1);
  tables.corners.reserve(triangles * 3 + 1);
  tables.triangles.reserve(triangles);
  std::size_t first = scene.meshes.size();
  AddSpan(scene, meshes, 0, first, columns, tables);
  tables.meshes_in_world = std::uint32_t(first);
  for (const Object& object : scene.objects) {
    AddSpan(scene, meshes, first, object.meshes.size(), columns, tables);
    first += object.meshes.size();
  }
  tables.vertices.push_back(0);  // Embree reads vertices four floats at a time, as kernels do
}

// ---- Instances ----

// Returns the largest sum of a row of absolute values times `v`.
double LargestRow(const glm::dmat3& m, const glm::dvec3& v) {
  double largest = 0;
  for (int row = 0; row < 3; ++row) {
    const double sum =
        std::abs(m[0][row]) * v.x + std::abs(m[1][row]) * v.y + std::abs(m[2][row]) * v.z;
    largest = std::max(largest, sum);
  }
  return largest;
}

// `reach` has the largest coordinates of the object's vertices on each axis.
InstanceRecord MakeInstanceRecord(const glm::dmat4x3& to, const glm::dvec3& reach) {
  const glm::dmat3 linear(to[0], to[1], to[2]);
  InstanceRecord record = {};
  for (int row = 0; row < 3; ++row) {
    for (int c = 0; c < 3; ++c) record.linear[3 * row + c] = float(linear[c][row]);
    record.translation[row] = float(to[3][row]);
  }
  const glm::dvec3 offset = glm::abs(to[3]);
  const double extent = LargestRow(linear, reach) + std::max({offset.x, offset.y, offset.z});
  record.extent = float(4 * extent);
  const double scale = LargestRow(linear, glm::dvec3(1));
  record.scale = float(scale);
  record.cofactors = float((glm::determinant(linear) < 0 ? -1 : 1) / (scale * scale));
  return record;
}

glm::dvec3 ReachOf(const Object& object) {
  glm::dvec3 reach(0);
  for (const Mesh& mesh : object.meshes) {
    for (const glm::vec3& p : mesh.positions) reach = glm::max(reach, glm::dvec3(glm::abs(p)));
  }
  return reach;
}

void AddInstances(const Scene& scene, GeometryTables& tables) {
  if (scene.instances.empty()) return;
  std::vector<glm::dvec3> reach;
  for (const Object& object : scene.objects) reach.push_back(ReachOf(object));
  const auto add = [&](const TriangleSpan& span, const InstanceRecord& record) {
    tables.places.first.push_back({{span.first, span.first_with_alpha}});
    tables.instance_records.push_back(record);
  };
  add(tables.spans.front(), MakeInstanceRecord(glm::dmat4x3(1), glm::dvec3(0)));
  for (const Instance& instance : scene.instances) {
    EmbreeInstance& placed = tables.instances.emplace_back();
    placed.object = instance.object;
    const glm::mat4x3 to(instance.world_from_object);
    std::copy_n(&to[0].x, 12, placed.world_from_object);
    add(tables.spans[1 + instance.object],
        MakeInstanceRecord(instance.world_from_object, reach[instance.object]));
  }
}

// ---- Variants ----

// Appends a copy of record `i` with another material.
void AppendVariant(std::uint32_t i, std::uint32_t material, GeometryTables& tables) {
  TriangleRecord record = tables.triangles[i];
  record.tag = (record.tag & ~kMaterialMask) | material;
  tables.triangles.push_back(record);
  tables.mixed.push_back(i);
  const auto repeat = [&](auto& column, std::size_t from) {
    column.push_back(std::decay_t<decltype(column[0])>(column[from]));
  };
  for (std::size_t c = 0; c < 3; ++c) repeat(tables.corners, 3 * std::size_t{i} + c);
  if (!tables.textures.uvs.empty()) repeat(tables.textures.uvs, i);
  if (!tables.tangents.empty()) repeat(tables.tangents, i);
  for (std::size_t c = 0; !tables.vertex_colors.empty() && c < 3; ++c) {
    repeat(tables.vertex_colors, 3 * std::size_t{i} + c);
  }
}

// Gives record `i` the BSDF of its material, or two more records where that is a mixture.
void ResolveMaterial(const Scene& scene, std::uint32_t i, GeometryTables& tables) {
  const std::uint32_t material = tables.triangles[i].tag & kMaterialMask;
  const auto& mixture = scene.materials[material].mixture;
  if (!mixture) {
    const auto bsdf = std::uint32_t(scene.materials[material].bsdf);
    tables.triangles[i].tag |= bsdf << kKindShift;
    tables.bsdfs |= BsdfSet{1} << bsdf;
    return;
  }
  const std::uint32_t sides = tables.triangles[i].tag & (kOneSidedTriangle | kTurnedTriangle);
  const auto first = std::uint32_t(tables.triangles.size());
  AppendVariant(i, mixture->first, tables);
  AppendVariant(i, mixture->second, tables);
  const auto& texture = scene.materials[material].mixture_texture;
  const std::uint32_t share =
      texture ? kShareOfTexture | *texture
              : std::bit_cast<std::uint32_t>(std::abs(mixture->share));  // -0 has the texture's bit
  tables.triangles[i] = {.normal = {first, share, material}, .tag = kMixedTriangle | sides};
}

// Variants come after all triangles, and variants of variants after those.
void AddVariants(const Scene& scene, const std::string& path, GeometryTables& tables) {
  for (std::size_t i = 0; i < tables.triangles.size(); ++i) {
    ResolveMaterial(scene, std::uint32_t(i), tables);
    // Mixtures of mixtures double with every level.
    const std::size_t records = tables.triangles.size();
    if (records > kMaxVariants * tables.triangle_count() || records >= kMaxRecords) {
      throw InputError(InputPosition::File(path),
                       "the mixtures of materials have more variants than a scene can hold");
    }
  }
}

// ---- Materials ----

RecordCorners CornersOf(std::span<const Mesh* const> meshes, std::uint32_t record,
                        const GeometryTables& tables) {
  const std::uint32_t triangle = tables.TriangleOf(record);
  const MeshPlace& place = tables.PlaceOf(triangle);
  const std::uint32_t* const corners = &tables.corners[3 * std::size_t{triangle}];
  return {*meshes[place.mesh], glm::uvec3(corners[0], corners[1], corners[2]) - place.first_vertex};
}

// Adds the second texture coordinates of meshes, where textures use them.
void AddSecondUvs(const Scene& scene, std::span<const Mesh* const> meshes, GeometryTables& tables) {
  if (std::none_of(scene.textures.begin(), scene.textures.end(),
                   [](const Texture& texture) { return texture.uv_set == UvSet::kSecond; })) {
    return;
  }
  std::vector<TriangleUvs> uvs;
  for (std::uint32_t record = 0; record < tables.triangles.size(); ++record) {
    const auto [mesh, corners] = CornersOf(meshes, record, tables);
    uvs.push_back(MakeTriangleUvs(mesh, UvSet::kSecond, corners));
  }
  AppendSecondUvs(uvs, scene.textures, tables.textures);
}

// Returns whether MaterialView::varied is true for a scene with this material.
bool IsVaried(const Material& material) {
  return material.metal_of_color || material.second_color_texture ||
         (material.roughness_texture &&
          (BsdfOf(material).varying == Varying::kAlpha ||
           BsdfOf(material).varying == Varying::kCoatWidths || BsdfOf(material).across));
}

// Adds the records of materials and the tables that their BSDFs read. Materials with equal coats,
// or equal glass, share a table.
void AddMaterials(const Scene& scene, GeometryTables& tables) {
  std::map<CoatKey, std::uint32_t> coats;
  std::map<std::array<float, 3>, std::uint32_t> dielectrics;
  for (const Material& material : scene.materials) {
    tables.materials.push_back(PackMaterial(material, scene.measured));
    if (BsdfOf(material).tables.coat) {
      const auto [coat, is_new] =
          coats.emplace(CoatKeyOf(material), std::uint32_t(tables.coats.size()));
      if (is_new && material.roughness_texture) {
        const std::vector<CoatTable> by_width = MakeCoatTables(material);
        tables.coats.insert(tables.coats.end(), by_width.begin(), by_width.end());
      } else if (is_new) {
        tables.coats.push_back(MakeCoatTable(material));
      }
      PutField(tables.materials.back(), MaterialField::kCoatTable, coat->second);
    }
    // One table serves all widths that a texture may give; for two widths there is none.
    const bool varies = material.roughness_texture.has_value();
    if (BsdfOf(material).tables.dielectric && material.energy_compensation &&
        !(varies && material.alpha_across)) {
      const float alpha = varies ? 0 : MicrofacetWidth(material.alpha);
      const float across =
          varies || !material.alpha_across ? 0 : MicrofacetWidth(*material.alpha_across);
      const auto [glass, is_new] = dielectrics.emplace(std::array{material.ior, alpha, across},
                                                       std::uint32_t(tables.dielectrics.size()));
      if (is_new) {
        tables.dielectrics.push_back(varies ? MakeDielectricTable(material.ior)
                                     : across != 0
                                         ? MakeDielectricTable(alpha, across, material.ior)
                                         : MakeDielectricTable(alpha, material.ior));
      }
      PutField(tables.materials.back(), MaterialField::kDielectricTable, glass->second + 1);
    }
    tables.varied = tables.varied || IsVaried(material);
    tables.two_widths = tables.two_widths || (BsdfOf(material).two_widths && material.alpha_across);
    tables.glass_layers =
        tables.glass_layers || (BsdfOf(material).glass_layers && !material.reflects_plainly());
    tables.absorbs = tables.absorbs || material.has(MaterialPart::kAbsorption);
    // These take up to 0.3 s, so only scenes that need them compute them.
    if (BsdfOf(material).tables.ggx) tables.ggx = &GgxTables();
    if (BsdfOf(material).tables.anisotropic && material.energy_compensation &&
        HasTangent(material)) {
      tables.anisotropic = &GetAnisotropicTables();
    }
    if (BsdfOf(material).tables.sheen) tables.sheen = &GetSheenTables();
  }
  if (HasCatchers(scene)) {
    for (const Material& material : scene.materials) tables.catchers.push_back(material.catcher);
  }
  if (HasHoldouts(scene)) {
    for (const Material& material : scene.materials) tables.holdouts.push_back(material.holdout);
  }
  tables.has_unshadowed =
      std::any_of(scene.materials.begin(), scene.materials.end(),
                  [](const Material& material) { return material.unshadowed != 0; });
  for (const MeasuredBrdf& brdf : scene.measured) {
    tables.measured.insert(tables.measured.end(), brdf.rgb.begin(), brdf.rgb.end());
  }
  if (tables.has_alpha()) tables.opacity = MakeOpacityRecords(scene.materials);
}

bool IsTextured(const Scene& scene) {
  bool textured = false;
  for (const Material& material : scene.materials) {
    ForEachTexture(material, [&](std::uint32_t) { textured = true; });
  }
  return textured;
}

}  // namespace

GeometryTables MakeGeometryTables(const Scene& scene, const std::string& path, bool keep_uvs) {
  CheckMeshes(scene, path);
  CheckMaterials(scene, path);
  const bool textured = IsTextured(scene);
  GeometryTables tables;
  if (textured) tables.textures = MakeTextureTables(scene, path);
  const std::vector<const Mesh*> meshes = AllMeshes(scene);
  AddMeshes(scene, meshes, ColumnsOf(scene, meshes, keep_uvs || textured), tables);
  AddInstances(scene, tables);
  AddVariants(scene, path, tables);
  tables.corners.push_back(0);  // kernels read them four words at a time
  if (textured) AddSecondUvs(scene, meshes, tables);
  const auto corners = [&](std::uint32_t record) { return CornersOf(meshes, record, tables); };
  tables.normal_maps = MakeNormalMaps(scene, MapOf, tables.textures, tables.triangles, corners);
  tables.base_normal_maps =
      MakeNormalMaps(scene, BaseMapOf, tables.textures, tables.triangles, corners);
  AddMaterials(scene, tables);
  return tables;
}

std::uint32_t GeometryTables::TriangleOf(std::uint32_t record) const {
  while (record >= triangle_count()) record = mixed[record - triangle_count()];
  return record;
}

const MeshPlace& GeometryTables::PlaceOf(std::uint32_t triangle) const {
  const auto next = std::upper_bound(
      meshes.begin(), meshes.end(), triangle,
      [](std::uint32_t t, const MeshPlace& place) { return t < place.first_triangle; });
  return *std::prev(next);
}

bool GeometryTables::has_alpha() const {
  return std::any_of(spans.begin(), spans.end(),
                     [](const TriangleSpan& span) { return span.has_alpha(); });
}

OpacityView GeometryTables::opacity_view() const {
  if (!has_alpha()) return {};
  return {.triangles = triangles.data(),
          .records = opacity.data(),
          .textures = textures.view(),
          .of_corners = vertex_alphas.empty() ? nullptr : vertex_alphas.data()};
}

std::size_t GeometryTables::bytes() const {
  const auto bytes_of = [](const auto&... table) {
    return (... + (table.size() * sizeof table[0]));
  };
  return bytes_of(vertices, corners, triangles, materials, tangents, vertex_colors, vertex_alphas,
                  mixed, measured, coats, dielectrics, opacity, instances, instance_records,
                  places.first) +
         normal_maps.bytes() + base_normal_maps.bytes() + textures.bytes();
}

}  // namespace skywave
