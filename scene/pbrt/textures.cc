// Reads pbrt's textures: constant, imagemap (8-bit, EXR, HDR or PFM), bilerp, dots, and scale, mix
// and checkerboard, which become images (texture_baking.h) unless all their operands are constant;
// those that vary in space are in solid_textures.h.
// Others are known by name only: parameters that use them take their default, with a warning.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "base/error.h"
#include "image/srgb.h"
#include "scene/materials/noise.h"
#include "scene/materials/texture_baking.h"
#include "scene/pbrt/solid_textures.h"
#include "scene/pbrt/state.h"

namespace skywave {
namespace {

// Returns whether an operand of a texture has an image.
bool HasImageOperand(PbrtParameters& parameters, const PbrtTextures& textures) {
  return std::any_of(parameters.list.begin(), parameters.list.end(), [&](const auto& parameter) {
    const auto found = parameter.type == "texture" && parameter.strings.size() == 1
                           ? textures.find(parameter.strings[0])
                           : textures.end();
    return found != textures.end() && found->second.image;
  });
}

PbrtTexture Constant(PbrtReader& reader, PbrtParameters& parameters, const PbrtTextures& same) {
  const auto value = FindColor(parameters, "value", same, reader.warnings);
  return {.value = value.value_or(glm::vec3(1)), .image = {}};
}

TextureWrap Wrap(PbrtReader& reader, PbrtParameters& parameters) {
  const std::string wrap = FindString(parameters, "wrap").value_or("repeat");
  if (wrap == "repeat") return TextureWrap::kRepeat;
  if (wrap != "clamp") {
    Warn(reader, parameters, fmt::format("the wrap \"{}\" is not supported: clamped", wrap));
  }
  return TextureWrap::kClamp;
}

// The encoding of 8-bit files, as versions 3 and 4 name it.
struct TexelEncoding {
  Encoding encoding = Encoding::kSrgb;
  float gamma = 1;  // numbers are raised to this power, after `encoding`
};
TexelEncoding EncodingOf(PbrtReader& reader, PbrtParameters& parameters, const std::string& path) {
  if (!FindBool(parameters, "gamma").value_or(true)) return {Encoding::kLinear};
  const std::string encoding = FindString(parameters, "encoding").value_or("sRGB");
  if (encoding == "linear") return {Encoding::kLinear};
  constexpr std::string_view kGamma = "gamma ";
  if (encoding.starts_with(kGamma)) {
    const char *begin = encoding.data() + kGamma.size(), *end = encoding.data() + encoding.size();
    float gamma = 0;
    const auto [stop, error] = std::from_chars(begin, end, gamma);
    if (error != std::errc() || stop != end || !(gamma > 0 && gamma < 100)) {
      throw InputError(parameters.position, fmt::format("{}: the encoding \"{}\" has no exponent",
                                                        parameters.directive, encoding));
    }
    return {Encoding::kLinear, IsOfScreen(path) ? gamma : 1};
  }
  if (encoding != "sRGB") {
    Warn(reader, parameters,
         fmt::format("the encoding \"{}\" is not supported: read as sRGB", encoding));
  }
  return {};
}

std::string MappingName(PbrtParameters& parameters) {
  return FindString(parameters, "mapping").value_or("uv");
}

// The mapping of (u, v), or of what a mapping in space has in their place; nothing, with a warning,
// for mappings that are not known.
struct UvMapping {
  glm::vec2 scale{1, 1}, offset{0, 0};
};
std::optional<UvMapping> MappingOf(PbrtReader& reader, PbrtParameters& parameters) {
  const std::string name = MappingName(parameters);
  if (name != "uv" && !IsPbrtMappingInSpace(name)) {
    Warn(reader, parameters,
         fmt::format("the mapping \"{}\" is unknown: its users take their default", name));
    return std::nullopt;
  }
  const auto number = [&](const char* parameter, float otherwise) {
    return FindFloat(parameters, parameter).value_or(otherwise);
  };
  UvMapping mapping;
  if (name == "uv") mapping.scale = {number("uscale", 1), number("vscale", 1)};
  if (name == "uv" || name == "planar") mapping.offset = {number("udelta", 0), number("vdelta", 0)};
  return mapping;
}

PbrtTexture AddTexture(PbrtReader& reader, const Texture& texture, const glm::vec3& factor) {
  reader.scene.textures.push_back(texture);
  return {.value = factor, .image = static_cast<std::uint32_t>(reader.scene.textures.size() - 1)};
}

// Applies `combine` to textures. A combination of constants stays constant; images are baked.
PbrtTexture Combine(PbrtReader& reader, const PbrtParameters& parameters,
                    const std::vector<PbrtTexture>& textures, const CombineTexels& combine) {
  if (std::any_of(textures.begin(), textures.end(), [](auto& t) { return t.solid != nullptr; })) {
    return CombineInSpace(reader, parameters, textures, combine);
  }
  std::vector<TextureOperand> operands;
  std::vector<glm::vec3> values;
  for (const PbrtTexture& texture : textures) {
    values.push_back(texture.value.value_or(glm::vec3(1)));
    operands.push_back(
        {values.back(), texture.image ? &reader.scene.textures[*texture.image] : nullptr});
  }
  const bool constant = std::none_of(operands.begin(), operands.end(),
                                     [](const TextureOperand& o) { return o.texture != nullptr; });
  if (constant) return {.value = combine(values), .image = {}};
  const std::optional<Texture> baked = BakeTexture(operands, combine, reader.scene);
  if (!baked) {
    Warn(reader, parameters,
         "its images lie differently and do not all repeat a whole number of times in the unit "
         "square: its users take their default");
    return {};
  }
  const CompactImage& image = reader.scene.images[baked->image];
  reader.baked_texels += std::size_t(image.width) * std::size_t(image.height);
  if (reader.baked_texels > kMaxBakedTexels) {
    throw InputError(parameters.position,
                     fmt::format("{}: textures that are computed have more than {} texels from "
                                 "here on",
                                 parameters.directive, kMaxBakedTexels));
  }
  return AddTexture(reader, *baked, glm::vec3(1));
}

// Returns the index of the image of a texture of floats. pbrt takes the alpha channel of files of
// red to alpha, or else the mean of the channels, and without a filter always the first one.
std::uint32_t FloatImage(PbrtReader& reader, const std::string& path, Encoding encoding,
                         bool unfiltered) {
  const auto [known, is_new] = reader.float_images.try_emplace({path, encoding, unfiltered}, 0);
  if (!is_new) return known->second;
  const bool alpha = !unfiltered && IsRgba(path);
  Image image = ReadTexture(path, alpha ? Encoding::kAlpha : encoding, kTextureLimits);
  const bool encoded = alpha && encoding == Encoding::kSrgb && IsOfScreen(path);
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    float* const rgb = &image.rgb[i];
    float value = alpha || unfiltered ? rgb[0] : (rgb[0] + rgb[1] + rgb[2]) / 3;
    if (rgb[0] == rgb[1] && rgb[1] == rgb[2]) value = rgb[0];
    std::fill_n(rgb, 3, encoded ? float(LinearFromSrgb(value)) : value);
  }
  known->second = AddTextureImage(reader.scene, std::move(image));
  return known->second;
}

// pbrt clamps colours at the image, too.
PbrtTexture ImageMap(PbrtReader& reader, PbrtParameters& parameters, bool color) {
  const auto filename = FindString(parameters, "filename");
  if (!filename) {
    throw InputError(parameters.position, parameters.directive + " needs a \"string filename\"");
  }
  // The pyramid is used for all filters of pbrt but that without one.
  const bool unfiltered = FindString(parameters, "filter") == "point";
  FindFloat(parameters, "maxanisotropy");
  FindBool(parameters, "trilinear");

  const auto mapping = MappingOf(reader, parameters);
  if (!mapping) return {};
  Texture texture;
  texture.wrap_u = texture.wrap_v = Wrap(reader, parameters);
  texture.transform = UpwardTextureTransform(mapping->scale, mapping->offset);
  const glm::vec3 scale(FindFloat(parameters, "scale").value_or(1));
  const bool invert = FindBool(parameters, "invert").value_or(false);
  const auto left_out = [&](const InputError& error) {
    AddMissing(reader.warnings, parameters.position, "Texture \"imagemap\"", error,
               "its users take their default");
    return PbrtTexture{};
  };
  std::string path;
  try {
    path = ResolvePbrtPath(reader, *filename, parameters.position);
  } catch (const InputError& error) {
    return left_out(error);
  }
  const TexelEncoding encoding = EncodingOf(reader, parameters, path);
  try {
    texture.image = color ? AddTextureImage(reader.texture_files, path, encoding.encoding)
                          : FloatImage(reader, path, encoding.encoding, unfiltered);
  } catch (const InputError& error) {
    return left_out(error);
  }
  if (unfiltered) {
    texture.image = reader.unfiltered_images.Of(
        texture.image, reader.baked_texels, reader.scene,
        [&](const std::string& text) { Warn(reader, parameters, text); });
  }
  const PbrtTexture plain = AddTexture(reader, texture, scale);
  if (encoding.gamma == 1 && !invert) {
    return color ? ClampedPbrtTexture(reader, plain) : plain;
  }
  return Combine(reader, parameters, {{.value = glm::vec3(1), .image = plain.image}},
                 [&](std::span<const glm::vec3> values) {
                   const glm::vec3 decoded = scale * glm::pow(values[0], glm::vec3(encoding.gamma));
                   return invert ? glm::max(1.0f - decoded, glm::vec3(0)) : decoded;
                 });
}

// Returns the operand of a texture: another one of `textures`, or a colour.
PbrtTexture Operand(PbrtReader& reader, PbrtParameters& parameters, const PbrtTextures& textures,
                    std::string_view name, float otherwise) {
  if (const auto image = FindImageTexture(parameters, name, textures)) return *image;
  if (const auto solid = FindSolidTexture(parameters, name, textures)) return *solid;
  const auto color = FindColor(parameters, name, textures, reader.warnings);
  return {.value = color.value_or(glm::vec3(otherwise)), .image = {}};
}

// Version 3 has tex1 and tex2, version 4 has tex and scale, a float.
PbrtTexture Scale(PbrtReader& reader, PbrtParameters& parameters, const PbrtTextures& same) {
  const bool v3 = Find(parameters, {"rgb", "color", "xyz", "float", "texture", "spectrum"}, "tex1");
  const PbrtTexture a = Operand(reader, parameters, same, v3 ? "tex1" : "tex", 1),
                    b = v3 ? Operand(reader, parameters, same, "tex2", 1)
                           : Operand(reader, parameters, reader.float_textures, "scale", 1);
  const glm::vec3 factor = a.value.value_or(glm::vec3(1)) * b.value.value_or(glm::vec3(1));
  // With a single image, a factor suffices and no copy is needed.
  const bool solid = a.solid || b.solid;
  if (!solid && (!a.image || !b.image))
    return {.value = factor, .image = a.image ? a.image : b.image};
  return Combine(reader, parameters, {a, b},
                 [](std::span<const glm::vec3> values) { return values[0] * values[1]; });
}

glm::vec3 MixTexels(std::span<const glm::vec3> values) {
  return glm::mix(values[0], values[1], values[2]);
}

PbrtTexture Mix(PbrtReader& reader, PbrtParameters& parameters, const PbrtTextures& same) {
  return Combine(
      reader, parameters,
      {Operand(reader, parameters, same, "tex1", 0), Operand(reader, parameters, same, "tex2", 1),
       Operand(reader, parameters, reader.float_textures, "amount", 0.5f)},
      MixTexels);
}

PbrtTexture Checkerboard(PbrtReader& reader, PbrtParameters& parameters, const PbrtTextures& same) {
  FindString(parameters, "aamode");  // pbrt-v3's filter
  const int dimension = FindInt(parameters, "dimension").value_or(2);
  if (dimension != 2 && dimension != 3) {
    Warn(reader, parameters,
         fmt::format("dimension {} is not supported: its users take their default", dimension));
    return {};
  }
  const PbrtTexture tex1 = Operand(reader, parameters, same, "tex1", 1),
                    tex2 = Operand(reader, parameters, same, "tex2", 0);
  if (dimension == 3) {
    return Combine(reader, parameters, {tex1, tex2, ReadSolidChecks(reader, parameters)},
                   MixTexels);
  }
  const auto mapping = MappingOf(reader, parameters);
  if (!mapping) return {};
  if (!reader.checker_image) {
    reader.checker_image = AddTextureImage(reader.scene, CheckerSelector());
  }
  Texture selector{.image = *reader.checker_image};
  selector.transform = UpwardTextureTransform(0.5f * mapping->scale, 0.5f * mapping->offset);
  return Combine(reader, parameters, {tex1, tex2, AddTexture(reader, selector, glm::vec3(1))},
                 MixTexels);
}

// The first texture is seen where surfaces face the direction.
PbrtTexture DirectionMix(PbrtReader& reader, PbrtParameters& parameters, const PbrtTextures& same) {
  return Combine(reader, parameters,
                 {Operand(reader, parameters, same, "tex2", 1),
                  Operand(reader, parameters, same, "tex1", 0), ReadDirection(reader, parameters)},
                 MixTexels);
}

// Returns an image over the unit square of (u, v), 1 in dots.
Image DotSelector(const UvMapping& mapping) {
  const auto side = [](float scale) {
    return int(std::clamp(std::ceil(std::abs(scale)) * kCheckTexels, float(kCheckTexels),
                          float(kMaxBakedSide)));
  };
  Image image(side(mapping.scale.x), side(mapping.scale.y));
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const glm::dvec2 uv((x + 0.5) / image.width, 1 - (y + 0.5) / image.height);
      const bool inside = IsInDot(uv * glm::dvec2(mapping.scale) + glm::dvec2(mapping.offset));
      std::fill_n(image.Pixel(x, y), 3, inside ? 1.0f : 0.0f);
    }
  }
  return image;
}

PbrtTexture Dots(PbrtReader& reader, PbrtParameters& parameters, const PbrtTextures& same) {
  const auto mapping = MappingOf(reader, parameters);
  if (!mapping) return {};
  Texture selector{.image = AddTextureImage(reader.scene, DotSelector(*mapping))};
  selector.transform = UpwardTextureTransform({1, 1}, {0, 0});
  // All versions of pbrt paint the ground with "inside" and the dots with "outside".
  const PbrtTexture ground = Operand(reader, parameters, same, "inside", 1),
                    dots = Operand(reader, parameters, same, "outside", 0);
  return Combine(reader, parameters, {ground, dots, AddTexture(reader, selector, glm::vec3(1))},
                 MixTexels);
}

// The four colours are texels, and (u, v) from 0 to 1 goes from centre to centre. pbrt goes on in a
// straight line beyond.
PbrtTexture Bilerp(PbrtReader& reader, PbrtParameters& parameters, const PbrtTextures& same) {
  const auto mapping = MappingOf(reader, parameters);
  if (!mapping) return {};
  Image corners(2, 2);
  for (const auto& [name, x, y, otherwise] : {std::tuple("v00", 0, 1, 0.0f),
                                              {"v01", 0, 0, 1.0f},
                                              {"v10", 1, 1, 0.0f},
                                              {"v11", 1, 0, 1.0f}}) {
    const glm::vec3 color =
        FindColor(parameters, name, same, reader.warnings).value_or(glm::vec3(otherwise));
    for (int c = 0; c < 3; ++c) corners.Pixel(x, y)[c] = color[c];
  }
  Texture texture;
  texture.image = AddTextureImage(reader.scene, std::move(corners));
  texture.wrap_u = texture.wrap_v = TextureWrap::kClamp;
  texture.transform = UpwardTextureTransform(0.5f * mapping->scale, 0.5f * mapping->offset + 0.25f);
  return AddTexture(reader, texture, glm::vec3(1));
}

// Red is what u exceeds a whole number by, green the same of v: pbrt-v3's picture of coordinates.
PbrtTexture Coordinates(PbrtReader& reader, PbrtParameters& parameters) {
  constexpr int kSide = 512;
  const auto mapping = MappingOf(reader, parameters);
  if (!mapping) return {};
  Image image(kSide, kSide);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      float* const rgb = image.Pixel(x, y);
      rgb[0] = (float(x) + 0.5f) / kSide, rgb[1] = 1 - (float(y) + 0.5f) / kSide, rgb[2] = 0;
    }
  }
  Texture texture{.image = AddTextureImage(reader.scene, std::move(image))};
  texture.transform = UpwardTextureTransform(mapping->scale, mapping->offset);
  return AddTexture(reader, texture, glm::vec3(1));
}

}  // namespace

PbrtTexture ClampedPbrtTexture(PbrtReader& reader, const PbrtTexture& texture) {
  if (!texture.image) return texture;
  const glm::vec3 factor = texture.value.value_or(glm::vec3(1));
  const Texture source = reader.scene.textures[*texture.image];
  const CompactImage& image = reader.scene.images[source.image];
  bool exceeds = false;
  for (std::size_t i = 0; i < image.values(); ++i) {
    exceeds = exceeds || factor[int(i % 3)] * image.Value(i) > 1;
  }
  if (!exceeds) return texture;
  const auto key = std::tuple(*texture.image, factor.x, factor.y, factor.z);
  const auto [known, is_new] = reader.clamped_textures.try_emplace(key, 0);
  if (is_new) {
    Image clamped = image.Floats();
    for (std::size_t i = 0; i < clamped.rgb.size(); ++i) {
      clamped.rgb[i] = std::min(factor[int(i % 3)] * clamped.rgb[i], 1.0f);
    }
    Texture copy = source;
    copy.image = AddTextureImage(reader.scene, std::move(clamped));
    known->second = *AddTexture(reader, copy, glm::vec3(1)).image;
  }
  return {.value = glm::vec3(1), .image = known->second};
}

std::uint32_t PbrtShareTexture(PbrtReader& reader, const PbrtTexture& texture, bool inverted) {
  const glm::vec3 factor = texture.value.value_or(glm::vec3(1));
  Texture copy = reader.scene.textures[*texture.image];
  Image shares = reader.scene.images[copy.image].Floats();
  for (std::size_t i = 0; i < shares.rgb.size(); i += 3) {
    float* const rgb = &shares.rgb[i];
    const float mean = (factor.x * rgb[0] + factor.y * rgb[1] + factor.z * rgb[2]) / 3;
    const float share = std::clamp(mean, 0.0f, 1.0f);
    std::fill_n(rgb, 3, inverted ? 1 - share : share);
  }
  copy.image = AddTextureImage(reader.scene, std::move(shares));
  return *AddTexture(reader, copy, glm::vec3(1)).image;
}

PbrtTexture PbrtAlphaTexture(PbrtReader& reader, const PbrtParameters& parameters,
                             const std::vector<PbrtTexture>& roughness,
                             const std::function<float(float)>& alpha_of, const PackAlphas& pack) {
  // Textures that serve twice are evaluated once.
  std::vector<PbrtTexture> distinct;
  std::vector<std::size_t> at;
  for (const PbrtTexture& texture : roughness) {
    const auto same = std::find_if(distinct.begin(), distinct.end(),
                                   [&](auto& other) { return SamePbrtTexture(other, texture); });
    at.push_back(std::size_t(same - distinct.begin()));
    if (same == distinct.end()) distinct.push_back(texture);
  }
  return Combine(reader, parameters, distinct,
                 [alpha_of, pack, at](std::span<const glm::vec3> values) {
                   std::vector<float> alphas;
                   for (const std::size_t i : at) {
                     const glm::vec3& value = values[i];
                     const float mean = std::max((value.x + value.y + value.z) / 3, 0.0f);
                     alphas.push_back(std::clamp(alpha_of(mean), 1e-3f, 1.0f));
                   }
                   return pack(alphas);
                 });
}

void ReadPbrtTexture(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const InputPosition position = PositionOf(source, word);
  const std::string name = ExpectString(source, "the name of a texture");
  const std::string type = ExpectString(source, "the type of a texture");
  const std::string kind = ExpectString(source, "the class of a texture");
  PbrtParameters parameters = ReadParametersAndAttributes(
      reader, source, position, "texture", fmt::format("Texture \"{}\" \"{}\"", name, kind));
  if (type != "float" && type != "spectrum" && type != "color") {
    throw InputError(position, fmt::format("{}: the types are float and spectrum, not \"{}\"",
                                           parameters.directive, type));
  }
  PbrtTextures& textures = type == "float" ? reader.float_textures : reader.color_textures;
  const std::string mapping = MappingName(parameters);
  const bool in_space = IsPbrtMappingInSpace(mapping);
  // Operands lie over (u, v), whatever the checks do.
  if (in_space && HasImageOperand(parameters, textures)) {
    textures[name] = {};
    AddWarning(reader.warnings, position,
               fmt::format("{}: the mapping \"{}\" is not supported for textures of textures: its "
                           "users take their default",
                           parameters.directive, mapping));
    return;
  }
  PbrtTexture texture;
  if (kind == "constant") {
    texture = Constant(reader, parameters, textures);
  } else if (kind == "scale") {
    texture = Scale(reader, parameters, textures);
  } else if (kind == "imagemap") {
    texture = ImageMap(reader, parameters, type != "float");
  } else if (kind == "mix") {
    texture = Mix(reader, parameters, textures);
  } else if (kind == "checkerboard") {
    texture = Checkerboard(reader, parameters, textures);
  } else if (kind == "bilerp") {
    texture = Bilerp(reader, parameters, textures);
  } else if (kind == "dots" && !in_space) {
    texture = Dots(reader, parameters, textures);
  } else if (kind == "fbm" || kind == "windy" || kind == "wrinkled") {
    texture = ReadNoise(reader, parameters, kind);
  } else if (kind == "uv" && type != "float") {
    texture = Coordinates(reader, parameters);
  } else if (kind == "directionmix") {
    texture = DirectionMix(reader, parameters, textures);
  } else if (kind == "marble" && type != "float") {
    texture = ReadMarble(reader, parameters);
  } else {
    textures[name] = {};
    AddWarning(reader.warnings, position,
               parameters.directive + " is not supported: its users take their default");
    return;
  }
  textures[name] = in_space ? LayInSpace(reader, parameters, mapping, texture) : texture;
  ReportUnused(parameters, reader.warnings);
}

}  // namespace skywave
