#include "scene/pbrt/solid_baking.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "scene/pbrt/round_shapes.h"
#include "scene/shapes/mesh.h"
#include "scene/shapes/triangle_atlas.h"

namespace skywave {
namespace {

constexpr int kPatchWidth = 1024, kPatchHeight = 512;  // texels over (u, v) of a round shape
// The squares of a shape made of triangles have at most one in so many of the texels that are left
// for a scene, and its images less than twice as many.
constexpr std::size_t kTexelsPerAtlasTexel = 8;

// A texel of an image on a surface.
struct SurfaceTexel {
  PbrtPoint point;       // its normal is that of the triangle, or of a round shape
  glm::dvec3 right, up;  // axes of the image along the surface, unit, as normal maps have them
  glm::dmat2 turn;       // how far (u, v) of the shape go in a unit of length along them
  double size;           // of the texel, in the world
};
using TexelValue = std::function<glm::vec3(const SurfaceTexel&)>;

// A mesh with an image over its (u, v), and the (u, v) of the shape that it is of, which are other
// ones where the image is an atlas.
struct BakedMesh {
  const Mesh& mesh;
  bool round;                          // it stands for a round shape, or else for itself
  glm::dvec3 origin;                   // the place in the file's world of (0, 0, 0) of the mesh
  std::span<const glm::vec2> own_uvs;  // empty: those of pbrt's triangles without any
};

std::array<glm::dvec2, 3> OwnUvs(const BakedMesh& baked, const glm::uvec3& t) {
  const std::span<const glm::vec2> uvs = baked.own_uvs;
  if (uvs.empty()) return {glm::dvec2(0, 0), glm::dvec2(1, 0), glm::dvec2(1, 1)};
  return {uvs[t.x], uvs[t.y], uvs[t.z]};
}

// Evaluates texels in [begin, end) of triangle `t` whose barycentric coordinates are at least
// `least`, which may be beyond its edges. `done` learns for each texel of the image that it has a
// value; null: nobody asks.
void BakeTriangle(const BakedMesh& baked, const glm::uvec3& t, const TexelValue& value,
                  double least, const glm::ivec2& begin, const glm::ivec2& end, Image& image,
                  std::vector<bool>* done) {
  const Mesh& mesh = baked.mesh;
  const glm::dvec2 size(image.width, image.height);
  std::array<glm::dvec2, 3> at;
  for (int i = 0; i < 3; ++i) {
    const glm::vec2& uv = mesh.uvs[t[i]];
    at[std::size_t(i)] = glm::dvec2(uv.x, 1 - double(uv.y)) * size;
  }
  const glm::dmat2 edges(at[1] - at[0], at[2] - at[0]);
  if (!(std::abs(glm::determinant(edges)) > 0)) return;
  const glm::dmat2 inverse = glm::inverse(edges);
  const glm::dvec3 p[3] = {mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]};
  const glm::dvec3 flat = glm::cross(p[1] - p[0], p[2] - p[0]);
  // One texel to the right, and one up.
  const glm::dvec3 right = inverse[0][0] * (p[1] - p[0]) + inverse[0][1] * (p[2] - p[0]);
  const glm::dvec3 up = -inverse[1][0] * (p[1] - p[0]) - inverse[1][1] * (p[2] - p[0]);
  const auto own = OwnUvs(baked, t);
  const glm::dmat2 own_edges(own[1] - own[0], own[2] - own[0]);
  // (u, v) one texel to the right, and one up.
  const glm::dvec2 own_right = own_edges * inverse[0], own_up = -(own_edges * inverse[1]);
  SurfaceTexel texel;
  texel.size = std::sqrt(glm::length(glm::cross(right, up)));
  for (int y = begin.y; y < end.y; ++y) {
    for (int x = begin.x; x < end.x; ++x) {
      const glm::dvec2 b = inverse * (glm::dvec2(x + 0.5, y + 0.5) - at[0]);
      if (!(b.x >= least && b.y >= least && 1 - b.x - b.y >= least)) continue;
      const glm::dvec3 weights(1 - b.x - b.y, b.x, b.y);
      glm::dvec3 normal(0);
      texel.point = {};
      texel.point.place = baked.origin;
      for (int i = 0; i < 3; ++i) {
        texel.point.place += weights[i] * p[i];
        texel.point.uv += weights[i] * own[std::size_t(i)];
        if (!mesh.normals.empty()) normal += weights[i] * glm::dvec3(mesh.normals[t[i]]);
      }
      const glm::dvec3 shading = glm::normalize(mesh.normals.empty() ? flat : normal);
      texel.point.normal = baked.round ? shading : glm::normalize(flat);
      texel.right = glm::normalize(right - shading * glm::dot(shading, right));
      texel.up = glm::cross(shading, texel.right);
      if (glm::dot(texel.up, up) < 0) texel.up = -texel.up;
      // The axes of the image need not be at right angles, those of a normal map are.
      const double along = glm::dot(right, texel.right), across = glm::dot(up, texel.right);
      texel.turn[0] = own_right / along;
      texel.turn[1] = (own_up - across * texel.turn[0]) / glm::dot(up, texel.up);
      const glm::vec3 color = value(texel);
      for (int c = 0; c < 3; ++c) image.Pixel(x, y)[c] = color[c];
      if (done) (*done)[std::size_t(y) * std::size_t(image.width) + std::size_t(x)] = true;
    }
  }
}

// (u, v) of the shape cover the unit square, except for slivers at poles.
Image BakePatch(const BakedMesh& baked, const TexelValue& value) {
  const Mesh& mesh = baked.mesh;
  Image image(kPatchWidth, kPatchHeight);
  std::vector<bool> done(std::size_t(image.width) * std::size_t(image.height));
  const glm::ivec2 size(image.width, image.height);
  for (const glm::uvec3& t : mesh.triangles) {
    glm::dvec2 low(1), high(0);
    for (int i = 0; i < 3; ++i) {
      const glm::dvec2 at(mesh.uvs[t[i]].x, 1 - double(mesh.uvs[t[i]].y));
      low = glm::min(low, at), high = glm::max(high, at);
    }
    const glm::ivec2 begin = glm::max(glm::ivec2(glm::floor(low * glm::dvec2(size))) - 1, 0);
    const glm::ivec2 end = glm::min(glm::ivec2(glm::ceil(high * glm::dvec2(size))) + 1, size);
    BakeTriangle(baked, t, value, -1e-6, begin, end, image, &done);
  }
  // A texel that no triangle has gets the value of the one before it in its row.
  for (int y = 0; y < image.height; ++y) {
    for (int step = 1; step < 2 * image.width; ++step) {
      const int x = step % image.width, before = (x + image.width - 1) % image.width;
      const auto row = std::size_t(y) * std::size_t(image.width);
      if (done[row + std::size_t(x)] || !done[row + std::size_t(before)]) continue;
      std::copy_n(image.Pixel(before, y), 3, image.Pixel(x, y));
      done[row + std::size_t(x)] = true;
    }
  }
  return image;
}

// Returns (u, v) of the corners of all triangles, in their order, which is that of the vertices
// once the mesh is laid out in an atlas.
std::vector<glm::vec2> UvsOfCorners(const Mesh& mesh) {
  std::vector<glm::vec2> uvs;
  if (mesh.uvs.empty()) return uvs;
  uvs.reserve(3 * mesh.triangles.size());
  for (const glm::uvec3& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) uvs.push_back(mesh.uvs[t[i]]);
  }
  return uvs;
}

Image BakeAtlas(const BakedMesh& baked, const TriangleAtlas& atlas, const TexelValue& value) {
  Image image(atlas.size.x, atlas.size.y);
  tbb::parallel_for(std::size_t{0}, baked.mesh.triangles.size(), [&](std::size_t t) {
    const AtlasSquare& square = atlas.squares[t];
    // A bilinear lookup reads texels one step beyond the slanted edge, not two.
    const double least = -1.5 / (square.side - 1);
    BakeTriangle(baked, baked.mesh.triangles[t], value, least, square.corner,
                 square.corner + square.side, image, nullptr);
  });
  return image;
}

// Returns the value of a texture that is not below 0 nor above 1; `exceeds` becomes true if one is
// above.
TexelValue ShareAt(const PbrtSolid& solid, std::atomic<bool>& exceeds) {
  return [&](const SurfaceTexel& texel) {
    const glm::vec3 value = solid(texel.point);
    if (glm::any(glm::greaterThan(value, glm::vec3(1)))) exceeds = true;
    return glm::clamp(value, 0.0f, 1.0f);
  };
}

// Returns the slopes of heights along the axes of the image, over a texel.
TexelValue SlopeAt(const PbrtSolid& height) {
  return [&](const SurfaceTexel& texel) {
    if (!(texel.size > 0)) return glm::vec3(0);
    const auto height_at = [&](const glm::dvec3& along, const glm::dvec2& uv_along, double step) {
      return double(height({texel.point.place + step * along, texel.point.normal,
                            texel.point.uv + step * uv_along})
                        .x);
    };
    const auto slope = [&](const glm::dvec3& along, const glm::dvec2& uv_along) {
      const double rise =
          height_at(along, uv_along, texel.size / 2) - height_at(along, uv_along, -texel.size / 2);
      constexpr double kSteepest = 1e6;  // the texel may be nearly nothing
      return std::isfinite(rise) ? float(std::clamp(rise / texel.size, -kSteepest, kSteepest)) : 0;
    };
    return glm::vec3(slope(texel.right, texel.turn[0]), slope(texel.up, texel.turn[1]), 0);
  };
}

// Turns slopes into a normal map, steepened or flattened so that the steepest slope is 1, and
// returns what that was.
float NormalsOfSlopes(Image& image) {
  float steepest = 0;
  for (std::size_t i = 0; i < image.rgb.size(); ++i) {
    steepest = std::max(steepest, std::abs(image.rgb[i]));
  }
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    glm::vec3 normal(0, 0, 1);
    if (steepest > 0) normal = {-image.rgb[i] / steepest, -image.rgb[i + 1] / steepest, 1};
    normal = 0.5f * glm::normalize(normal) + 0.5f;
    for (int c = 0; c < 3; ++c) image.rgb[i + std::size_t(c)] = normal[c];
  }
  return steepest;
}

// How textures are evaluated for one shape, over the unit square of its (u, v).
struct Bake {
  std::function<Image(const TexelValue&)> image;
  bool one_level;  // Texture::one_level of these images
};

std::uint32_t AddSurfaceTexture(Scene& scene, Image image, TextureUse use, bool one_level) {
  Texture texture;
  texture.image = AddTextureImage(scene, std::move(image));
  texture.wrap_u = texture.wrap_v = TextureWrap::kClamp;
  texture.transform = UpwardTextureTransform({1, 1}, {0, 0});
  texture.use = use;
  texture.one_level = one_level;
  scene.textures.push_back(texture);
  return std::uint32_t(scene.textures.size() - 1);
}

// Gives the material the image of a parameter; returns whether values above 1 were cut.
bool BakeParameter(const PbrtSolidParameter& solid, const Bake& bake, Scene& scene,
                   Material& material) {
  if (solid.use == PbrtSolidUse::kHeight) {
    Image normals = bake.image(SlopeAt(*solid.value));
    material.normal_scale = NormalsOfSlopes(normals);
    material.normal_texture =
        AddSurfaceTexture(scene, std::move(normals), TextureUse::kNormals, bake.one_level);
    return false;
  }
  std::atomic<bool> exceeds = false;
  const bool opacity = solid.use == PbrtSolidUse::kOpacity;
  const std::uint32_t texture =
      AddSurfaceTexture(scene, bake.image(ShareAt(*solid.value, exceeds)),
                        opacity ? TextureUse::kOpacity : TextureUse::kColor, bake.one_level);
  if (opacity) material.opacity_texture = texture;
  if (solid.use == PbrtSolidUse::kReflectance) material.color_texture = texture;
  if (solid.use == PbrtSolidUse::kRoughness) material.roughness_texture = texture;
  if (solid.use == PbrtSolidUse::kShare) material.mixture_texture = texture;
  return exceeds;
}

void SetFallback(const PbrtSolidParameter& solid, Material& material) {
  if (solid.use == PbrtSolidUse::kReflectance) material.reflectance *= solid.fallback;
  if (solid.use == PbrtSolidUse::kRoughness) {
    material.alpha = material.coat_alpha = solid.fallback;
    if (material.alpha_across) material.alpha_across = solid.fallback;
  }
  if (solid.use == PbrtSolidUse::kShare) material.mixture->share = solid.fallback;
}

// Returns how many images the material and those that it is mixed of need. A mixture may have one
// material many times, as mixtures of mixtures do; `counted` has those that need no more.
std::size_t CountSolids(const PbrtReader& reader, std::uint32_t named,
                        std::set<std::uint32_t>& counted) {
  const auto found = reader.solid_materials.find(named);
  if (found == reader.solid_materials.end() || !counted.insert(named).second) return 0;
  std::size_t count = found->second.size();
  if (const auto& mixture = reader.scene.materials[named].mixture) {
    count += CountSolids(reader, mixture->first, counted);
    count += CountSolids(reader, mixture->second, counted);
  }
  return count;
}

// Returns a copy of `material`, which is `named` or a copy of that, with the images that `bake`
// makes, or else with its defaults, and likewise of those that it is mixed of. `copies` has those
// that exist, by what they are named; `exceeds` becomes true if a reflectance is above 1.
std::uint32_t CopyWithSolids(PbrtReader& reader, std::uint32_t named, std::uint32_t material,
                             const std::optional<Bake>& bake,
                             std::map<std::uint32_t, std::uint32_t>& copies, bool& exceeds) {
  const auto found = reader.solid_materials.find(named);
  if (found == reader.solid_materials.end()) return material;
  if (const auto known = copies.find(named); known != copies.end()) return known->second;
  Material copy = reader.scene.materials[material];
  for (const PbrtSolidParameter& solid : found->second) {
    if (!bake) {
      SetFallback(solid, copy);
    } else if (BakeParameter(solid, *bake, reader.scene, copy)) {
      exceeds = exceeds || solid.use == PbrtSolidUse::kReflectance;
    }
  }
  if (copy.mixture) {
    for (std::uint32_t* part : {&copy.mixture->first, &copy.mixture->second}) {
      *part = CopyWithSolids(reader, *part, *part, bake, copies, exceeds);
    }
  }
  reader.scene.materials.push_back(std::move(copy));
  const auto index = std::uint32_t(reader.scene.materials.size() - 1);
  copies.emplace(named, index);
  return index;
}

}  // namespace

std::uint32_t MaterialWithSolids(PbrtReader& reader, std::uint32_t named, std::uint32_t material,
                                 const PbrtSolidShape& shape, Mesh& mesh) {
  const bool patch = IsRoundPbrtShape(shape.type);
  std::set<std::uint32_t> counted;
  const std::size_t images = CountSolids(reader, named, counted) + (shape.alpha ? 1 : 0);
  assert(images > 0);  // only shapes on which something varies in space get here
  const std::size_t left = kMaxBakedTexels - std::min(kMaxBakedTexels, reader.baked_texels);
  TriangleAtlas atlas;
  if (!patch && !shape.fixed_uvs) {
    atlas = MakeTriangleAtlas(mesh, left / kTexelsPerAtlasTexel / images);
  }
  const glm::ivec2 size = patch ? glm::ivec2(kPatchWidth, kPatchHeight) : atlas.size;
  const std::size_t texels = images * std::size_t(size.x) * std::size_t(size.y);
  std::optional<Bake> bake;
  const std::vector<glm::vec2> own_uvs = patch ? mesh.uvs : UvsOfCorners(mesh);
  const BakedMesh baked = {.mesh = mesh,
                           .round = patch,
                           .origin = reader.in_object ? glm::dvec3(0) : reader.options.origin,
                           .own_uvs = own_uvs};
  if (texels == 0 || texels > left) {
    AddWarning(
        reader.warnings, shape.position,
        "a texture that varies in space is not supported on so many triangles, together with "
        "other textures, or on so many shapes: the default of its parameter is used");
  } else {
    reader.baked_texels += texels;
    if (patch) {
      bake = {[&](const TexelValue& value) { return BakePatch(baked, value); }, false};
    } else {
      LayOutTriangles(atlas, mesh);
      bake = {[&](const TexelValue& value) { return BakeAtlas(baked, atlas, value); }, true};
    }
  }
  std::map<std::uint32_t, std::uint32_t> copies;
  bool exceeds = false;
  const std::uint32_t index = CopyWithSolids(reader, named, material, bake, copies, exceeds);
  if (exceeds && reader.v3) {
    AddWarning(reader.warnings, shape.position,
               "a texture in space reflects more than it gets, as pbrt-v3 lets it: cut at 1");
  }
  if (!shape.alpha || !bake) return index;
  Material copy = reader.scene.materials[index];
  BakeParameter({.use = PbrtSolidUse::kOpacity, .value = shape.alpha}, *bake, reader.scene, copy);
  reader.scene.materials.push_back(std::move(copy));
  return std::uint32_t(reader.scene.materials.size() - 1);
}

}  // namespace skywave
