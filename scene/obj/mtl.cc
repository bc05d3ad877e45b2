#include "scene/obj/mtl.h"

#include <fmt/format.h>
#include <tiny_obj_loader.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <sstream>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/files.h"
#include "scene/materials/metals.h"
#include "scene/materials/texture_baking.h"
#include "scene/named_files.h"
#include "scene/obj/lines.h"

namespace skywave {
namespace {

// The line on which a statement of a material was last given, and whether it had a single number.
struct Statement {
  std::size_t line = 0;
  bool single = false;
};
struct Entry {
  std::string name;
  InputPosition position;  // position of newmtl
  std::map<std::string, Statement, std::less<>> statements;

  bool Has(std::string_view word) const { return statements.contains(word); }
};

InputPosition At(const Entry& entry, std::string_view word) {
  const auto found = entry.statements.find(word);
  return found == entry.statements.end()
             ? entry.position
             : InputPosition::Line(entry.position.path, found->second.line);
}

bool IsOneOf(std::string_view word, std::span<const std::string_view> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}
bool IsOneOf(std::string_view word, std::initializer_list<std::string_view> words) {
  return IsOneOf(word, std::span(words.begin(), words.size()));
}

bool IsMap(std::string_view word) {
  return word.starts_with("map_") || IsOneOf(word, {"bump", "disp", "decal", "refl", "norm"});
}

// All these statements set the one map of normals or heights.
constexpr std::array<std::string_view, 4> kReliefMaps = {"norm", "bump", "map_bump", "map_Bump"};

// Roughness, metal, sheen, coat and its roughness.
constexpr std::array<std::string_view, 5> kPhysical = {"Pr", "Pm", "Ps", "Pc", "Pcr"};

bool IsRenderedMap(std::string_view word) {
  return IsOneOf(word, {"map_Kd", "map_Ke", "map_d", "map_Pr", "map_Pm"}) ||
         IsOneOf(word, kReliefMaps);
}

// A colour has one number (grey) or three. Spectra are refused by their first word.
void CheckStatement(const ObjLines& lines, const std::vector<std::string_view>& words,
                    Warnings& warnings) {
  const std::string_view word = words[0];
  if (IsOneOf(word, {"Ka", "Kd", "Ks", "Ke", "Kt", "Tf"})) {
    const auto values = ParseObjNumbers(lines, words, 1, 3);
    if (values.size() == 2 || *std::min_element(values.begin(), values.end()) < 0) {
      throw InputError(PositionOf(lines),
                       fmt::format("'{}' takes one or three numbers that are not negative", word));
    }
    if (word == "Ke" && *std::max_element(values.begin(), values.end()) > 1e18) {
      throw InputError(PositionOf(lines), "'Ke' is brighter than 1e18");
    }
  } else if (IsOneOf(word, {"Ns", "Ni", "d", "Tr", "illum"}) || IsOneOf(word, kPhysical)) {
    const bool halo = word == "d" && words.size() > 1 && words[1] == "-halo";
    if (halo) {
      throw InputError(PositionOf(lines), "'d -halo' is not supported: give a plain number");
    }
    ParseObjNumbers(lines, words, 1, 1);
  } else if (IsMap(word) && !IsRenderedMap(word)) {
    AddWarning(warnings, PositionOf(lines),
               fmt::format("{}: textures are not supported: the plain value is used", word));
  } else if (!IsMap(word) && !IsOneOf(word, {"sharpness", "aniso", "anisor"})) {
    AddWarning(warnings, PositionOf(lines),
               fmt::format("'{}' is not a statement of MTL: ignored", word.substr(0, 40)));
  }
}

std::vector<Entry> CheckMtl(ObjLines& lines, Warnings& warnings) {
  std::vector<Entry> entries;
  std::vector<std::string_view> words;
  while (NextStatement(lines, words)) {
    if (words[0] == "newmtl") {
      if (words.size() < 2) {
        AddWarning(warnings, PositionOf(lines), "'newmtl' without a name: nothing can use it");
      }
      entries.push_back({RestOfStatement(words), PositionOf(lines), {}});
      continue;
    }
    if (entries.empty()) {
      throw InputError(PositionOf(lines),
                       fmt::format("'{}' before the first newmtl", words[0].substr(0, 40)));
    }
    CheckStatement(lines, words, warnings);
    entries.back().statements[std::string(words[0])] = {lines.line, words.size() == 2};
  }
  return entries;
}

// Expands a grey given by one number, because tinyobjloader leaves 0 in the other channels.
glm::vec3 Color(const float* values, const Entry& entry, std::string_view word) {
  const auto found = entry.statements.find(word);
  const bool grey = found != entry.statements.end() && found->second.single;
  return grey ? glm::vec3(values[0]) : glm::vec3(values[0], values[1], values[2]);
}

// Returns a reflectance, clamped to [0, 1].
glm::vec3 Fraction(const float* values, const Entry& entry, std::string_view word,
                   Warnings& warnings) {
  const glm::vec3 color = Color(values, entry, word);
  const glm::vec3 clamped = glm::clamp(color, 0.0f, 1.0f);
  if (clamped != color) {
    AddWarning(warnings, At(entry, word), fmt::format("{} is clamped to [0, 1]", word));
  }
  return clamped;
}

bool IsBlack(const glm::vec3& color) { return color == glm::vec3(0); }

bool IsGlass(const tinyobj::material_t& mtl) {
  if (mtl.illum == 6 || mtl.illum == 7) return true;
  const bool transmits =
      std::max({mtl.transmittance[0], mtl.transmittance[1], mtl.transmittance[2]}) > 0;
  return (mtl.illum == 4 || mtl.illum == 9) && (mtl.dissolve < 1 || transmits);
}

Material Glass(const tinyobj::material_t& mtl) {
  return {.bsdf = BsdfKind::kDielectric,
          .reflectance = glm::vec3(1),
          .ior = mtl.ior > 1 ? mtl.ior : 1.5f};
}

float AlphaOfExponent(float exponent) { return std::sqrt(2 / (std::max(exponent, 0.0f) + 2)); }

Material Conductor(const glm::vec3& normal_reflectance, float alpha) {
  const MetalIndex index = MetalOfReflectance(normal_reflectance);
  return {.bsdf = BsdfKind::kConductor,
          .reflectance = glm::vec3(1),
          .eta = index.eta,
          .k = index.k,
          .alpha = std::max(alpha, 1e-3f)};
}

// Returns the path of the file that the statement `word` names, or nothing.
std::optional<std::string> FindMap(const std::string& name, const Entry& entry,
                                   std::string_view word, Warnings& warnings) {
  if (name.empty()) return std::nullopt;
  const InputPosition at = At(entry, word);
  if (auto path = FindNamedOrMovedFile(at, name, warnings)) return path;
  AddMissing(warnings, at, word, InputError::NoSuchFile(at, name), "the plain value is used");
  return std::nullopt;
}

Texture MapOf(std::uint32_t image, TextureUse use, const tinyobj::texture_option_t& option) {
  Texture texture;
  texture.use = use;
  texture.image = image;
  texture.wrap_u = texture.wrap_v = option.clamp ? TextureWrap::kClamp : TextureWrap::kRepeat;
  texture.transform = UpwardTextureTransform({option.scale[0], option.scale[1]},
                                             {option.origin_offset[0], option.origin_offset[1]});
  return texture;
}

std::uint32_t AddMap(std::uint32_t image, TextureUse use, const tinyobj::texture_option_t& option,
                     TextureFiles& textures) {
  textures.scene->textures.push_back(MapOf(image, use, option));
  return static_cast<std::uint32_t>(textures.scene->textures.size() - 1);
}

// Reads an image, or warns that the statement `word` is left out because it cannot be read.
std::optional<std::uint32_t> TryImage(const std::string& path, Encoding encoding,
                                      const Entry& entry, std::string_view word,
                                      TextureFiles& textures, Warnings& warnings) {
  try {
    return AddTextureImage(textures, path, encoding);
  } catch (const InputError& error) {
    AddMissing(warnings, At(entry, word), word, error, "the plain value is used");
    return std::nullopt;
  }
}

// Returns the texture of map_Kd or map_Ke, or nothing.
std::optional<std::uint32_t> ColorMap(const std::string& name,
                                      const tinyobj::texture_option_t& option, const Entry& entry,
                                      std::string_view word, TextureFiles& textures,
                                      Warnings& warnings) {
  const auto path = FindMap(name, entry, word, warnings);
  if (!path) return std::nullopt;
  const auto image = TryImage(*path, Encoding::kSrgb, entry, word, textures, warnings);
  if (!image) return std::nullopt;
  return AddMap(*image, TextureUse::kColor, option, textures);
}

// Tests whether the image is grey, allowing for the artefacts of JPEG.
bool IsGrey(const CompactImage& image) {
  constexpr float kNoise = 0.05f;
  for (std::size_t i = 0; i < image.values(); i += 3) {
    const auto [low, high] = std::minmax({image.Value(i), image.Value(i + 1), image.Value(i + 2)});
    if (high - low > kNoise) return false;
  }
  return true;
}

// Opacity is d times map_d. `Tr 1` without d would leave nothing to see: programs that write it
// (MeshLab) mean what is opaque.
void SetOpacity(const tinyobj::material_t& mtl, const Entry& entry, TextureFiles& textures,
                Warnings& warnings, Material& material) {
  material.opacity = std::clamp(mtl.dissolve, 0.0f, 1.0f);
  if (material.opacity == 0 && entry.Has("Tr") && !entry.Has("d")) {
    AddWarning(warnings, At(entry, "Tr"), "Tr 1, which hides all, is taken for opaque");
    material.opacity = 1;
  }
  const auto path = FindMap(mtl.alpha_texname, entry, "map_d", warnings);
  if (!path) return;
  // Many exporters name a picture with an alpha channel and mean that channel.
  const auto read = [&](Encoding encoding) {
    return TryImage(*path, encoding, entry, "map_d", textures, warnings);
  };
  auto image = read(Encoding::kAlpha);
  if (image && IsWhite(textures.scene->images[*image])) image = read(Encoding::kLinear);
  if (!image || IsWhite(textures.scene->images[*image])) return;
  material.opacity_texture = AddMap(*image, TextureUse::kOpacity, mtl.alpha_texopt, textures);
}

// A coloured map holds normals, which many exporters write under all these names; a grey one holds
// heights.
void SetNormalMap(const tinyobj::material_t& mtl, const Entry& entry, TextureFiles& textures,
                  Warnings& warnings, Material& material) {
  const bool bumped = mtl.normal_texname.empty();
  const auto word = std::find_if(kReliefMaps.begin(), kReliefMaps.end(),
                                 [&](std::string_view w) { return entry.Has(w); });
  const auto path = FindMap(bumped ? mtl.bump_texname : mtl.normal_texname, entry,
                            word == kReliefMaps.end() ? "bump" : *word, warnings);
  if (!path) return;
  const tinyobj::texture_option_t& option = bumped ? mtl.bump_texopt : mtl.normal_texopt;
  const auto read = TryImage(*path, Encoding::kLinear, entry,
                             word == kReliefMaps.end() ? "bump" : *word, textures, warnings);
  if (!read) return;
  const std::uint32_t index = *read;
  const CompactImage& image = textures.scene->images[index];
  const bool heights = bumped && IsGrey(image);
  material.normal_texture =
      AddMap(index, heights ? TextureUse::kHeights : TextureUse::kNormals, option, textures);
  material.normal_scale = option.bump_multiplier;
  if (heights) {
    constexpr float kHeightOfWhite = 0.01f;  // fraction of the image's width
    material.height_in_texels = true;
    material.normal_scale *= kHeightOfWhite * float(image.width);
  }
}

bool IsPhysical(const Entry& entry) {
  const auto has = [&](std::string_view word) { return entry.Has(word); };
  return std::any_of(kPhysical.begin(), kPhysical.end(), has) || has("map_Pr") || has("map_Pm");
}

// Returns the image of map_Pr in green and that of map_Pm in blue, as Material::roughness_texture
// has them. One file for both is taken for one of glTF, which has them in these channels.
std::optional<std::uint32_t> PhysicalMap(const tinyobj::material_t& mtl, const Entry& entry,
                                         TextureFiles& textures, Warnings& warnings,
                                         Material& material) {
  const auto read = [&](const std::string& name, const tinyobj::texture_option_t& option,
                        std::string_view word) -> std::optional<Texture> {
    const auto path = FindMap(name, entry, word, warnings);
    if (!path) return std::nullopt;
    const auto image = TryImage(*path, Encoding::kLinear, entry, word, textures, warnings);
    if (!image) return std::nullopt;
    return MapOf(*image, TextureUse::kColor, option);
  };
  const auto rough = read(mtl.roughness_texname, mtl.roughness_texopt, "map_Pr");
  const auto metal = read(mtl.metallic_texname, mtl.metallic_texopt, "map_Pm");
  if (!rough && !metal) return std::nullopt;
  const bool packed = rough && metal && rough->image == metal->image;
  const auto combine = [&](std::span<const glm::vec3> values) {
    const auto grey = [](const glm::vec3& v) { return (v.x + v.y + v.z) / 3; };
    return packed ? glm::vec3(0, values[0].y, values[1].z)
                  : glm::vec3(0, grey(values[0]), grey(values[1]));
  };
  // A map stands in the place of its number.
  const TextureOperand operands[] = {
      {glm::vec3(rough ? 1 : std::sqrt(material.alpha)), rough ? &*rough : nullptr},
      {glm::vec3(metal ? 1 : material.metallic), metal ? &*metal : nullptr}};
  const auto baked = BakeTexture(operands, combine, *textures.scene);
  if (!baked) {
    AddWarning(warnings, At(entry, "map_Pr"),
               "map_Pr and map_Pm lie differently: the plain values are used");
    return std::nullopt;
  }
  const CompactImage& image = textures.scene->images[baked->image];
  textures.baked_texels += std::size_t(image.width) * std::size_t(image.height);
  if (textures.baked_texels > kMaxBakedTexels) {
    throw InputError(At(entry, rough ? "map_Pr" : "map_Pm"),
                     fmt::format("the maps of roughness and metal have more than {} texels from "
                                 "here on",
                                 kMaxBakedTexels));
  }
  material.alpha = material.metallic = 1;
  textures.scene->textures.push_back(*baked);
  return std::uint32_t(textures.scene->textures.size() - 1);
}

// Returns the layers of the physically based statements, without their colour.
Material PhysicalLayers(const tinyobj::material_t& mtl, const Entry& entry, TextureFiles& textures,
                        Warnings& warnings) {
  const auto share = [](float number) { return std::clamp(number, 0.0f, 1.0f); };
  const auto alpha = [&](float roughness) { return share(roughness) * share(roughness); };
  constexpr float kPlainRoughness = 0.5f;  // where neither Pr nor Ns is given; and of the sheen
  Material material = {.bsdf = BsdfKind::kMetallicRoughness};
  material.alpha = entry.Has("Pr")   ? alpha(mtl.roughness)
                   : entry.Has("Ns") ? AlphaOfExponent(mtl.shininess)
                                     : alpha(kPlainRoughness);
  material.metallic = share(mtl.metallic);
  if (mtl.ior > 1) material.ior = mtl.ior;
  material.roughness_texture = PhysicalMap(mtl, entry, textures, warnings, material);
  material.coat = share(mtl.clearcoat_thickness);
  material.coat_alpha = alpha(mtl.clearcoat_roughness);
  material.sheen = glm::vec3(share(mtl.sheen));
  material.sheen_alpha = alpha(kPlainRoughness);
  if (material.coat > 0 || !IsBlack(material.sheen)) {
    material.bsdf = BsdfKind::kCoatedMetallicRoughness;
  }
  if (mtl.anisotropy != 0) {
    AddWarning(warnings, At(entry, "aniso"), "aniso is not rendered: highlights are round");
  }
  return material;
}

Material ToMaterial(const tinyobj::material_t& mtl, const Entry& entry, TextureFiles& textures,
                    Warnings& warnings) {
  const glm::vec3 diffuse = Fraction(mtl.diffuse, entry, "Kd", warnings);
  const glm::vec3 specular = Fraction(mtl.specular, entry, "Ks", warnings);
  if (IsGlass(mtl)) return Glass(mtl);
  const auto map =
      ColorMap(mtl.diffuse_texname, mtl.diffuse_texopt, entry, "map_Kd", textures, warnings);
  const bool physical = IsPhysical(entry);
  if (!physical && !map && IsBlack(diffuse) && !IsBlack(specular)) {
    if (mtl.illum == 3 || mtl.illum == 5) {
      return {.bsdf = BsdfKind::kMirror, .reflectance = specular};
    }
    return Conductor(specular, AlphaOfExponent(mtl.shininess));
  }
  Material material;
  if (physical) {
    material = PhysicalLayers(mtl, entry, textures, warnings);
    if (!IsBlack(specular)) AddNote(warnings, At(entry, "Ks"), "Ks has no effect beside Pr and Pm");
  } else if (!IsBlack(specular)) {
    AddWarning(warnings, At(entry, "Ks"),
               "Ks over a diffuse colour is approximated by a coat of index 1.5");
    material.bsdf = BsdfKind::kMetallicRoughness;
    material.alpha = AlphaOfExponent(mtl.shininess);
  }
  material.color_texture = map;
  // Blender, Mitsuba and tinyobjloader use different defaults if Kd is missing.
  material.reflectance = diffuse;
  if (!entry.Has("Kd")) material.reflectance = glm::vec3(entry.Has("map_Kd") ? 0.6f : 0.5f);
  // Exporters write black to mean that the map alone counts.
  if (map && (!entry.Has("Kd") || IsBlack(diffuse))) material.reflectance = glm::vec3(1);
  return material;
}

void SetEmission(const tinyobj::material_t& mtl, const Entry& entry, TextureFiles& textures,
                 Warnings& warnings, Material& material) {
  material.emits_on_both_sides = true;
  material.emission = Color(mtl.emission, entry, "Ke");
  if (entry.Has("Ke") && IsBlack(material.emission)) return;
  material.emission_texture =
      ColorMap(mtl.emissive_texname, mtl.emissive_texopt, entry, "map_Ke", textures, warnings);
  if (material.emission_texture && !entry.Has("Ke")) material.emission = glm::vec3(1);
}

}  // namespace

std::vector<Material> ParseMtl(std::string text, const std::string& path, TextureFiles& textures,
                               Warnings& warnings) {
  ObjLines lines = MakeObjLines(std::move(text), path);
  const std::vector<Entry> entries = CheckMtl(lines, warnings);
  std::vector<Material> materials;
  if (entries.empty()) return materials;

  std::map<std::string, int> by_name;
  std::vector<tinyobj::material_t> read;
  std::string notes, errors;
  std::istringstream stream(std::move(lines.text));
  tinyobj::LoadMtl(&by_name, &read, &stream, &notes, &errors);
  if (read.size() != entries.size() || !errors.empty()) {
    throw InputError(InputPosition::File(path),
                     fmt::format("tinyobjloader reads {} materials of {}: {}", read.size(),
                                 entries.size(), errors));
  }
  for (std::size_t i = 0; i < read.size(); ++i) {
    materials.push_back(ToMaterial(read[i], entries[i], textures, warnings));
    if (!IsGlass(read[i])) {
      SetOpacity(read[i], entries[i], textures, warnings, materials.back());
      SetNormalMap(read[i], entries[i], textures, warnings, materials.back());
    }
    SetEmission(read[i], entries[i], textures, warnings, materials.back());
    materials.back().name = entries[i].name;
  }
  return materials;
}

std::vector<Material> ReadMtl(const std::string& path, TextureFiles& textures, Warnings& warnings) {
  return ParseMtl(ReadFile(path), path, textures, warnings);
}

}  // namespace skywave
