// pbrt's textures: constant, imagemap (8-bit, EXR, HDR or PFM), and scale of one image by colours.
// Others are known by name only: what uses them takes its default, with a warning.
#include <fmt/format.h>

#include "base/error.h"
#include "scene/pbrt_state.h"

namespace skywave {
namespace {

void Warn(PbrtReader& reader, const PbrtParameters& parameters, const std::string& text) {
  AddWarning(reader.warnings, parameters.position, parameters.directive + ": " + text);
}

PbrtTexture Constant(PbrtReader& reader, PbrtParameters& parameters) {
  const auto value = FindColor(parameters, "value", reader.textures, reader.warnings);
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

// Of 8-bit files: sRGB unless the file says otherwise, in the words of version 3 or 4.
Encoding EncodingOf(PbrtReader& reader, PbrtParameters& parameters) {
  if (!FindBool(parameters, "gamma").value_or(true)) return Encoding::kLinear;
  const std::string encoding = FindString(parameters, "encoding").value_or("sRGB");
  if (encoding == "linear") return Encoding::kLinear;
  if (encoding != "sRGB") {
    Warn(reader, parameters,
         fmt::format("the encoding \"{}\" is not supported: read as sRGB", encoding));
  }
  return Encoding::kSrgb;
}

PbrtTexture ImageMap(PbrtReader& reader, PbrtParameters& parameters) {
  const auto filename = FindString(parameters, "filename");
  if (!filename) {
    throw InputError(parameters.position, parameters.directive + " needs a \"string filename\"");
  }
  if (const std::string mapping = FindString(parameters, "mapping").value_or("uv");
      mapping != "uv") {
    Warn(reader, parameters, fmt::format("the mapping \"{}\" is not supported: left out", mapping));
    return {};
  }
  if (FindBool(parameters, "invert").value_or(false)) {
    Warn(reader, parameters, "\"invert\" is not supported: left out");
    return {};
  }
  // How pbrt filters: here the pyramid is always used.
  FindString(parameters, "filter");
  FindFloat(parameters, "maxanisotropy");
  FindBool(parameters, "trilinear");

  Texture texture;
  texture.wrap_u = texture.wrap_v = Wrap(reader, parameters);
  const auto number = [&](const char* name, float otherwise) {
    return FindFloat(parameters, name).value_or(otherwise);
  };
  texture.transform = UpwardTextureTransform({number("uscale", 1), number("vscale", 1)},
                                             {number("udelta", 0), number("vdelta", 0)});
  const float scale = number("scale", 1);
  const std::string path = ResolvePbrtPath(reader, *filename, parameters.position);
  texture.image = AddTextureImage(reader.texture_files, path, EncodingOf(reader, parameters));
  reader.scene.textures.push_back(texture);
  return {.value = glm::vec3(scale),
          .image = static_cast<std::uint32_t>(reader.scene.textures.size() - 1)};
}

// The product of two, tex1 and tex2 (version 3) or tex and scale (version 4), one image at most.
PbrtTexture Scale(PbrtReader& reader, PbrtParameters& parameters) {
  PbrtTexture product{.value = glm::vec3(1), .image = {}};
  for (const char* name : {"tex", "scale", "tex1", "tex2"}) {
    PbrtTexture factor{.value = glm::vec3(1), .image = {}};
    if (const auto image = FindImageTexture(parameters, name, reader.textures)) {
      factor = *image;
    } else if (const auto color = FindColor(parameters, name, reader.textures, reader.warnings)) {
      factor.value = color;
    }
    if (product.image && factor.image) {
      Warn(reader, parameters, "the product of two images is not supported: left out");
      return {};
    }
    product.value = *product.value * factor.value.value_or(glm::vec3(1));
    if (factor.image) product.image = factor.image;
  }
  return product;
}

}  // namespace

void ReadPbrtTexture(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const InputPosition position = PositionOf(source, word);
  const std::string name = ExpectString(source, "the name of a texture");
  ExpectString(source, "the type of a texture");
  const std::string kind = ExpectString(source, "the class of a texture");
  PbrtParameters parameters =
      ReadParameters(source, position, fmt::format("Texture \"{}\" \"{}\"", name, kind));
  if (kind == "constant") {
    reader.textures[name] = Constant(reader, parameters);
  } else if (kind == "scale") {
    reader.textures[name] = Scale(reader, parameters);
  } else if (kind == "imagemap") {
    reader.textures[name] = ImageMap(reader, parameters);
  } else {
    reader.textures[name] = {};
    AddWarning(reader.warnings, position,
               parameters.directive + " is not supported: its users take their default");
    return;
  }
  ReportUnused(parameters, reader.warnings);
}

}  // namespace skywave
