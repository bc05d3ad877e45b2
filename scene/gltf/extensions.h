// The extensions of glTF's materials: their names, and what their values become.
#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <optional>

#include "kernels/bsdf/material.h"
#include "scene/gltf/textures.h"

namespace skywave {

namespace khr {
inline constexpr const char* kAnisotropy = "KHR_materials_anisotropy";
inline constexpr const char* kClearcoat = "KHR_materials_clearcoat";
inline constexpr const char* kDiffuseTransmission = "KHR_materials_diffuse_transmission";
inline constexpr const char* kIridescence = "KHR_materials_iridescence";
inline constexpr const char* kSheen = "KHR_materials_sheen";
inline constexpr const char* kSpecular = "KHR_materials_specular";
inline constexpr const char* kTransmission = "KHR_materials_transmission";
inline constexpr const char* kUnlit = "KHR_materials_unlit";
inline constexpr const char* kVariants = "KHR_materials_variants";
inline constexpr const char* kVolume = "KHR_materials_volume";
}  // namespace khr

// Returns a value clamped to [0, 1], with a warning if it was beyond.
float GltfFraction(GltfTextures& context, const char* name, double value);
// Returns the number of an extension that should be a fraction.
float GltfFractionOf(GltfTextures& context, const tinygltf::Value& extension, const char* name,
                     double otherwise);
// Returns a factor that an extension allows to be any number from 0 on.
float GltfPositive(GltfTextures& context, const tinygltf::Value& extension, const char* name,
                   double otherwise);

// Returns the texture of an extension; kAlpha reads its alpha channel.
std::optional<std::uint32_t> GltfTextureOf(GltfTextures& context, const tinygltf::Value& extension,
                                           const char* name, Encoding encoding);

// Returns the mixture of two materials, which it adds to the scene.
Material GltfMixture(GltfTextures& context, Material first, Material second,
                     const GltfShare& share);
// Returns a copy for a part of a mixture.
Material NamedPart(const Material& base, const char* part);

}  // namespace skywave
