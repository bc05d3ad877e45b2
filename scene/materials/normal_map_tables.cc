#include "scene/materials/normal_map_tables.h"

#include <algorithm>
#include <cmath>

namespace skywave {
namespace {

constexpr float kSteepest = 1e6f;  // scale of a normal map; steeper ones are walls, too

NormalMapRecord MakeMapRecord(const NormalMap& map, const Scene& scene,
                              const TextureTables& textures) {
  NormalMapRecord record = {.of_base = map.of_base};
  if (!map.texture) return record;
  const bool heights = scene.textures[*map.texture].use == TextureUse::kHeights;
  const float scale = map.scale * textures.slopes[*map.texture];
  record.texture = *map.texture + 1;
  record.scale = std::isnan(scale) ? 0 : std::clamp(scale, -kSteepest, kSteepest);
  record.per_texel = heights && !map.in_texels;
  return record;
}

}  // namespace

NormalMap MapOf(const Material& material) {
  return {material.normal_texture, material.normal_scale, material.height_in_texels};
}
NormalMap BaseMapOf(const Material& material) {
  if (!material.own_base_normals) return {};
  return {material.base_normal_texture, material.base_normal_scale, false, true};
}

NormalMapView NormalMapTables::view() const {
  if (records.empty()) return {};
  return {.records = records.data(),
          .tangents = axes.data(),
          .slopes = slopes.empty() ? nullptr : slopes.data()};
}

std::size_t NormalMapTables::bytes() const {
  return records.size() * sizeof(NormalMapRecord) + axes.size() * sizeof(TriangleTangents) +
         slopes.size() * sizeof(TriangleSlopes);
}

NormalMapTables MakeNormalMaps(
    const Scene& scene, NormalMap map_of(const Material&), const TextureTables& textures,
    std::span<const TriangleRecord> triangles,
    const std::function<RecordCorners(std::uint32_t record)>& corners_of) {
  NormalMapTables maps;
  bool any = false, lengths = false;
  for (const Material& material : scene.materials) {
    const NormalMap map = map_of(material);
    maps.records.push_back(MakeMapRecord(map, scene, textures));
    any = any || map.texture || map.of_base;
    lengths = lengths || maps.records.back().per_texel != 0;
  }
  if (!any) return {};
  maps.axes.resize(triangles.size());
  if (lengths) maps.slopes.resize(triangles.size());
  for (std::uint32_t record = 0; record < triangles.size(); ++record) {
    const std::uint32_t tag = triangles[record].tag, material = tag & kMaterialMask;
    const auto texture = map_of(scene.materials[material]).texture;
    if ((tag & kMixedTriangle) != 0 || !texture) continue;
    const auto [mesh, corners] = corners_of(record);
    const Texture& map = scene.textures[*texture];
    maps.axes[record] = MakeTriangleTangents(mesh, corners, map);
    if (maps.records[material].per_texel != 0) {
      const CompactImage& image = scene.images[map.image];
      maps.slopes[record] = MakeTriangleSlopes(mesh, corners, map, image.width, image.height);
    }
  }
  return maps;
}

}  // namespace skywave
