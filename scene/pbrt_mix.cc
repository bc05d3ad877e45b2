// pbrt's material "mix". A blend of two Lambert surfaces is one; of others the one with the larger
// share is rendered, with a warning, because a surface has one BSDF.
#include <fmt/format.h>

#include "base/error.h"
#include "scene/pbrt_state.h"

namespace skywave {
namespace {

// The names, in the words of version 4 or 3.
std::pair<std::string, std::string> NamesOf(PbrtParameters& parameters, bool& v4) {
  const PbrtParameter* pair = Find(parameters, {"string"}, "materials");
  v4 = pair != nullptr;
  if (pair && pair->strings.size() == 2) return {pair->strings[0], pair->strings[1]};
  const auto first = FindString(parameters, "namedmaterial1"),
             second = FindString(parameters, "namedmaterial2");
  if (pair || !first || !second) {
    throw InputError(parameters.position,
                     parameters.directive + " needs the names of two materials");
  }
  return {*first, *second};
}

std::optional<std::uint32_t> Named(const PbrtReader& reader, const PbrtParameters& parameters,
                                   const std::string& name) {
  const auto found = reader.named_materials.find(name);
  if (found == reader.named_materials.end()) {
    throw InputError(parameters.position,
                     fmt::format("{}: there is no material \"{}\"", parameters.directive, name));
  }
  return found->second;
}

bool IsPlainLambert(const Material& material) {
  return material.bsdf == BsdfKind::kLambert && !material.color_texture;
}

}  // namespace

std::optional<std::uint32_t> MixPbrtMaterials(PbrtReader& reader, const std::string& name,
                                              PbrtParameters& parameters) {
  bool v4 = false;
  const auto names = NamesOf(parameters, v4);
  const auto first = Named(reader, parameters, names.first),
             second = Named(reader, parameters, names.second);
  glm::vec3 share =
      FindColor(parameters, "amount", reader.textures, reader.warnings).value_or(glm::vec3(0.5f));
  if (!v4) share = 1.0f - share;  // version 3 gives that of the first
  share = glm::clamp(share, 0.0f, 1.0f);
  ReportUnused(parameters, reader.warnings);

  std::vector<Material>& materials = reader.scene.materials;
  if (first && second && IsPlainLambert(materials[*first]) && IsPlainLambert(materials[*second])) {
    Material blend = materials[*first];
    blend.name = name;
    blend.reflectance =
        glm::mix(materials[*first].reflectance, materials[*second].reflectance, share);
    materials.push_back(std::move(blend));
    return static_cast<std::uint32_t>(materials.size() - 1);
  }
  if (share == glm::vec3(0)) return first;
  if (share == glm::vec3(1)) return second;
  const bool is_second = share.x + share.y + share.z > 1.5f;
  AddWarning(reader.warnings, parameters.position,
             fmt::format("{}: a mix is not supported: rendered as \"{}\"", parameters.directive,
                         is_second ? names.second : names.first));
  return is_second ? second : first;
}

}  // namespace skywave
