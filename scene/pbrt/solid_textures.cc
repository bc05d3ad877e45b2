#include "scene/pbrt/solid_textures.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <functional>
#include <glm/gtc/constants.hpp>
#include <map>
#include <set>
#include <utility>

#include "base/error.h"
#include "scene/materials/noise.h"
#include "scene/pbrt/round_shapes.h"
#include "scene/pbrt/shapes.h"
#include "scene/shapes/curves.h"
#include "scene/shapes/mesh.h"
#include "scene/shapes/triangle_atlas.h"

namespace skywave {
namespace {

constexpr int kPatchWidth = 1024, kPatchHeight = 512;  // texels over (u, v) of a round shape
// The squares of a shape made of triangles have at most one in so many of the texels that are left
// for a scene, and its images less than twice as many.
constexpr std::size_t kTexelsPerAtlasTexel = 8;

PbrtTexture SolidTexture(PbrtSolid color, int evaluations = 1) {
  PbrtTexture texture;
  texture.solid = std::make_shared<const PbrtSolid>(std::move(color));
  texture.evaluations = evaluations;
  return texture;
}

// Returns the transform into the space of a texture, which is the one in which it is defined.
glm::dmat4 TextureFromWorld(PbrtReader& reader, const PbrtParameters& parameters) {
  if (const auto& flaw = reader.state.flaw) {
    Warn(reader, parameters,
         fmt::format("its transform is {} since the {} of {}: that of the world is used",
                     flaw->what, flaw->directive, ToString(flaw->position)));
    return glm::dmat4(1);
  }
  return glm::inverse(reader.state.to_world);
}
// Returns that of functions of the place, to which pbrt-v3 applies the transform itself where
// pbrt-v4 has its inverse.
glm::dmat4 PatternFromWorld(PbrtReader& reader, const PbrtParameters& parameters) {
  return reader.v3 ? reader.state.to_world : TextureFromWorld(reader, parameters);
}

glm::dvec3 FindVector(PbrtParameters& parameters, std::string_view name,
                      const glm::dvec3& otherwise) {
  const PbrtParameter* found = Find(parameters, {"vector", "vector3"}, name);
  if (!found) return otherwise;
  if (found->floats.size() != 3) {
    throw InputError(found->position,
                     fmt::format("{}: \"{}\" takes one vector", parameters.directive, name));
  }
  return {found->floats[0], found->floats[1], found->floats[2]};
}

// Returns the colours "tex1" and "tex2", or nothing if one of them varies; `pair` has those that
// the file does not give.
struct Pair {
  glm::vec3 first, second;
};
std::optional<Pair> ConstantPair(PbrtReader& reader, PbrtParameters& parameters,
                                 const PbrtTextures& same, Pair pair) {
  for (const auto& [name, color] : {std::pair("tex1", &pair.first), {"tex2", &pair.second}}) {
    const bool given =
        Find(parameters, {"rgb", "color", "xyz", "float", "texture", "spectrum"}, name) != nullptr;
    const auto found = FindColor(parameters, name, same, reader.warnings);
    if (given && !found) return std::nullopt;
    *color = found.value_or(*color);
  }
  return pair;
}

// Returns the (u, v) that a mapping gives to places of the texture's space. u of a sphere is its
// polar angle, v of a cylinder its height, in pbrt-v3 that of the unit sphere.
using UvOfPlace = std::function<glm::dvec2(const glm::dvec3&)>;
UvOfPlace MappingInSpace(PbrtParameters& parameters, std::string_view mapping, bool v3) {
  if (mapping == "planar") {
    const glm::dvec3 along = FindVector(parameters, "v1", {1, 0, 0});
    const glm::dvec3 across = FindVector(parameters, "v2", {0, 1, 0});
    return [=](const glm::dvec3& p) { return glm::dvec2(glm::dot(p, along), glm::dot(p, across)); };
  }
  return [v3, sphere = mapping == "spherical"](const glm::dvec3& p) {
    const double turn = std::atan2(p.y, p.x) / glm::two_pi<double>(), length = glm::length(p);
    const double height = length > 0 ? std::clamp(p.z / length, -1.0, 1.0) : 0;
    if (sphere) return glm::dvec2(std::acos(height) / glm::pi<double>(), turn - std::floor(turn));
    return glm::dvec2(0.5 + turn, v3 ? height : p.z);
  };
}

// A texel of an image on a surface.
struct SurfaceTexel {
  glm::dvec3 place, normal;  // in the world, unit
  glm::dvec3 geometric;      // the normal that textures see: of a triangle, or of a round shape
  glm::dvec3 right, up;      // axes of the image along the surface, unit, as normal maps have them
  double size;               // of the texel, in the world
};
using TexelValue = std::function<glm::vec3(const SurfaceTexel&)>;

// Evaluates texels in [begin, end) of triangle `t` whose barycentric coordinates are at least
// `least`, which may be beyond its edges. The mesh stands for a round shape, or for itself. `done`
// learns for each texel of the image that it has a value; null: nobody asks.
void BakeTriangle(const Mesh& mesh, bool round, const glm::uvec3& t, const TexelValue& value,
                  double least, const glm::ivec2& begin, const glm::ivec2& end, Image& image,
                  std::vector<bool>* done) {
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
  SurfaceTexel texel;
  texel.size = std::sqrt(glm::length(glm::cross(right, up)));
  for (int y = begin.y; y < end.y; ++y) {
    for (int x = begin.x; x < end.x; ++x) {
      const glm::dvec2 b = inverse * (glm::dvec2(x + 0.5, y + 0.5) - at[0]);
      if (!(b.x >= least && b.y >= least && 1 - b.x - b.y >= least)) continue;
      const glm::dvec3 weights(1 - b.x - b.y, b.x, b.y);
      glm::dvec3 normal(0);
      texel.place = glm::dvec3(0);
      for (int i = 0; i < 3; ++i) {
        texel.place += weights[i] * p[i];
        if (!mesh.normals.empty()) normal += weights[i] * glm::dvec3(mesh.normals[t[i]]);
      }
      texel.normal = glm::normalize(mesh.normals.empty() ? flat : normal);
      texel.geometric = round ? texel.normal : glm::normalize(flat);
      texel.right = glm::normalize(right - texel.normal * glm::dot(texel.normal, right));
      texel.up = glm::cross(texel.normal, texel.right);
      if (glm::dot(texel.up, up) < 0) texel.up = -texel.up;
      const glm::vec3 color = value(texel);
      for (int c = 0; c < 3; ++c) image.Pixel(x, y)[c] = color[c];
      if (done) (*done)[std::size_t(y) * std::size_t(image.width) + std::size_t(x)] = true;
    }
  }
}

// (u, v) of the shape cover the unit square, except for slivers at poles.
Image BakePatch(const Mesh& mesh, const TexelValue& value) {
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
    BakeTriangle(mesh, /*round=*/true, t, value, -1e-6, begin, end, image, &done);
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

Image BakeAtlas(const Mesh& mesh, const TriangleAtlas& atlas, const TexelValue& value) {
  Image image(atlas.size.x, atlas.size.y);
  tbb::parallel_for(std::size_t{0}, mesh.triangles.size(), [&](std::size_t t) {
    const AtlasSquare& square = atlas.squares[t];
    // A bilinear lookup reads texels one step beyond the slanted edge, not two.
    const double least = -1.5 / (square.side - 1);
    BakeTriangle(mesh, /*round=*/false, mesh.triangles[t], value, least, square.corner,
                 square.corner + square.side, image, nullptr);
  });
  return image;
}

// Returns the value of a texture that is not below 0 nor above 1.
TexelValue ShareAt(const PbrtSolid& solid) {
  return [&](const SurfaceTexel& texel) {
    return glm::clamp(solid(texel.place, texel.geometric), 0.0f, 1.0f);
  };
}

// Returns the slopes of heights along the axes of the image, over a texel.
TexelValue SlopeAt(const PbrtSolid& height) {
  return [&](const SurfaceTexel& texel) {
    if (!(texel.size > 0)) return glm::vec3(0);
    const auto slope = [&](const glm::dvec3& along) {
      const glm::dvec3 step = texel.size / 2 * along;
      const double rise = double(height(texel.place + step, texel.geometric).x) -
                          double(height(texel.place - step, texel.geometric).x);
      constexpr double kSteepest = 1e6;  // the texel may be nearly nothing
      return std::isfinite(rise) ? float(std::clamp(rise / texel.size, -kSteepest, kSteepest)) : 0;
    };
    return glm::vec3(slope(texel.right), slope(texel.up), 0);
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

// Gives the material the image of a parameter.
void BakeParameter(const PbrtSolidParameter& solid, const Bake& bake, Scene& scene,
                   Material& material) {
  if (solid.use == PbrtSolidUse::kHeight) {
    Image normals = bake.image(SlopeAt(*solid.value));
    material.normal_scale = NormalsOfSlopes(normals);
    material.normal_texture =
        AddSurfaceTexture(scene, std::move(normals), TextureUse::kNormals, bake.one_level);
    return;
  }
  const bool opacity = solid.use == PbrtSolidUse::kOpacity;
  const std::uint32_t texture =
      AddSurfaceTexture(scene, bake.image(ShareAt(*solid.value)),
                        opacity ? TextureUse::kOpacity : TextureUse::kColor, bake.one_level);
  if (opacity) material.opacity_texture = texture;
  if (solid.use == PbrtSolidUse::kReflectance) material.color_texture = texture;
  if (solid.use == PbrtSolidUse::kRoughness) material.roughness_texture = texture;
  if (solid.use == PbrtSolidUse::kShare) material.mixture_texture = texture;
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
// that exist, by what they are named.
std::uint32_t CopyWithSolids(PbrtReader& reader, std::uint32_t named, std::uint32_t material,
                             const std::optional<Bake>& bake,
                             std::map<std::uint32_t, std::uint32_t>& copies) {
  const auto found = reader.solid_materials.find(named);
  if (found == reader.solid_materials.end()) return material;
  if (const auto known = copies.find(named); known != copies.end()) return known->second;
  Material copy = reader.scene.materials[material];
  for (const PbrtSolidParameter& solid : found->second) {
    bake ? BakeParameter(solid, *bake, reader.scene, copy) : SetFallback(solid, copy);
  }
  if (copy.mixture) {
    for (std::uint32_t* part : {&copy.mixture->first, &copy.mixture->second}) {
      *part = CopyWithSolids(reader, *part, *part, bake, copies);
    }
  }
  reader.scene.materials.push_back(std::move(copy));
  const auto index = std::uint32_t(reader.scene.materials.size() - 1);
  copies.emplace(named, index);
  return index;
}

}  // namespace

PbrtTexture ReadSolidCheckerboard(PbrtReader& reader, PbrtParameters& parameters,
                                  const PbrtTextures& same) {
  const auto pair = ConstantPair(reader, parameters, same, {glm::vec3(1), glm::vec3(0)});
  if (!pair) return {};
  return SolidTexture([pair = *pair, to_texture = PatternFromWorld(reader, parameters)](
                          const glm::dvec3& place, const glm::dvec3&) {
    const glm::dvec3 cell = glm::floor(glm::dvec3(to_texture * glm::dvec4(place, 1)));
    return glm::mod(cell.x + cell.y + cell.z, 2.0) == 0 ? pair.first : pair.second;
  });
}

PbrtTexture ReadDirectionMix(PbrtReader& reader, PbrtParameters& parameters,
                             const PbrtTextures& same) {
  glm::dvec3 direction = FindVector(parameters, "dir", {0, 1, 0});
  direction = glm::normalize(glm::dmat3(reader.state.to_world) * direction);
  if (!std::isfinite(direction.x)) {
    throw InputError(parameters.position, parameters.directive + ": \"dir\" is no direction");
  }
  const auto pair = ConstantPair(reader, parameters, same, {glm::vec3(0), glm::vec3(1)});
  if (!pair) return {};
  return SolidTexture([pair = *pair, direction](const glm::dvec3&, const glm::dvec3& normal) {
    return glm::mix(pair.second, pair.first, float(std::abs(glm::dot(normal, direction))));
  });
}

// Sheets of stone lie across y, bent by noise; the colours along a curve are pbrt's.
PbrtTexture ReadMarble(PbrtReader& reader, PbrtParameters& parameters) {
  const int octaves = std::clamp(FindInt(parameters, "octaves").value_or(8), 0, 32);
  const double roughness = FindFloat(parameters, "roughness").value_or(0.5f);
  const double scale = FindFloat(parameters, "scale").value_or(1);
  const double variation = FindFloat(parameters, "variation").value_or(0.2f);
  return SolidTexture([=, to_texture = PatternFromWorld(reader, parameters)](
                          const glm::dvec3& place, const glm::dvec3&) {
    constexpr int kCurves = 6;
    static const glm::dvec3 kStone(0.58, 0.58, 0.6);
    static const glm::dvec3 kColors[kCurves + 3] = {
        kStone, kStone, kStone,           {0.5, 0.5, 0.5}, {0.6, 0.59, 0.58},
        kStone, kStone, {0.2, 0.2, 0.33}, kStone};
    const glm::dvec3 at = scale * glm::dvec3(to_texture * glm::dvec4(place, 1));
    const double sheet = at.y + variation * FractalNoise(at, roughness, octaves);
    const double along = (0.5 + 0.5 * std::sin(sheet)) * kCurves;
    const int curve = std::clamp(int(along), 0, kCurves - 1);
    return glm::vec3(1.5 * BezierPoint(kColors + curve, along - curve));
  });
}

PbrtTexture ReadNoise(PbrtReader& reader, PbrtParameters& parameters, const std::string& kind) {
  const bool windy = kind == "windy", wrinkled = kind == "wrinkled";
  int octaves = 8;
  double roughness = 0.5;
  if (!windy) {
    octaves = std::clamp(FindInt(parameters, "octaves").value_or(octaves), 0, 32);
    roughness = FindFloat(parameters, "roughness").value_or(0.5f);
  }
  return SolidTexture([=, to_texture = PatternFromWorld(reader, parameters)](
                          const glm::dvec3& place, const glm::dvec3&) {
    const glm::dvec3 at(to_texture * glm::dvec4(place, 1));
    if (wrinkled) return glm::vec3(float(TurbulentNoise(at, roughness, octaves)));
    if (!windy) return glm::vec3(float(FractalNoise(at, roughness, octaves)));
    // The wind is three octaves of a tenth of the frequency, and raises six of waves.
    return glm::vec3(float(std::abs(FractalNoise(0.1 * at, 0.5, 3)) * FractalNoise(at, 0.5, 6)));
  });
}

PbrtTexture CombineInSpace(PbrtReader& reader, const PbrtParameters& parameters,
                           const std::vector<PbrtTexture>& textures, const CombineTexels& combine) {
  // Only a material makes something of a single texture, which ends the chain.
  int evaluations = textures.size() > 1 ? 1 : 0;
  for (const PbrtTexture& texture : textures) {
    evaluations += texture.evaluations;
    if (texture.image) {
      Warn(reader, parameters,
           "images and textures that vary in space are not combined: its users take their default");
      return {};
    }
  }
  if (evaluations > kMaxPbrtEvaluations) {
    Warn(reader, parameters,
         fmt::format("it takes more than {} evaluations of textures that vary in space: its users "
                     "take their default",
                     kMaxPbrtEvaluations));
    return {};
  }
  return SolidTexture(
      [textures, combine](const glm::dvec3& place, const glm::dvec3& normal) {
        std::vector<glm::vec3> values;
        for (const PbrtTexture& texture : textures) {
          values.push_back(texture.solid ? (*texture.solid)(place, normal)
                                         : texture.value.value_or(glm::vec3(1)));
        }
        return combine(values);
      },
      evaluations);
}

bool IsPbrtMappingInSpace(std::string_view mapping) {
  return mapping == "planar" || mapping == "spherical" || mapping == "cylindrical";
}

PbrtTexture LayInSpace(PbrtReader& reader, PbrtParameters& parameters, std::string_view mapping,
                       const PbrtTexture& texture) {
  const UvOfPlace uv_of = MappingInSpace(parameters, mapping, reader.v3);
  if (!texture.image) return texture;
  const Texture source = reader.scene.textures[*texture.image];
  const auto image = std::make_shared<const Image>(reader.scene.images[source.image]);
  // A plane of pbrt-v3 is one of the world.
  const bool of_world = reader.v3 && mapping == "planar";
  const glm::dmat4 to_texture = of_world ? glm::dmat4(1) : TextureFromWorld(reader, parameters);
  return SolidTexture([=, factor = texture.value.value_or(glm::vec3(1))](const glm::dvec3& place,
                                                                         const glm::dvec3&) {
    const glm::dvec3 uv(uv_of(glm::dvec3(to_texture * glm::dvec4(place, 1))), 1);
    return factor * LookUpImage(*image, source, glm::dmat3x2(source.transform) * uv);
  });
}

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
  if (texels == 0 || texels > left) {
    AddWarning(
        reader.warnings, shape.position,
        "a texture that varies in space is not supported on so many triangles, together with "
        "other textures, or on so many shapes: the default of its parameter is used");
  } else {
    reader.baked_texels += texels;
    if (patch) {
      bake = {[&](const TexelValue& value) { return BakePatch(mesh, value); }, false};
    } else {
      LayOutTriangles(atlas, mesh);
      bake = {[&](const TexelValue& value) { return BakeAtlas(mesh, atlas, value); }, true};
    }
  }
  std::map<std::uint32_t, std::uint32_t> copies;
  const std::uint32_t index = CopyWithSolids(reader, named, material, bake, copies);
  if (!shape.alpha || !bake) return index;
  Material copy = reader.scene.materials[index];
  BakeParameter({.use = PbrtSolidUse::kOpacity, .value = shape.alpha}, *bake, reader.scene, copy);
  reader.scene.materials.push_back(std::move(copy));
  return std::uint32_t(reader.scene.materials.size() - 1);
}

}  // namespace skywave
