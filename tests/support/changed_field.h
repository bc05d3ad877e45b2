// Materials that differ in one field, for tests of functions that read every field.
#pragma once

#include <cstdint>
#include <optional>

#include "kernels/bsdf/material.h"

namespace skywave {

// Returns a material that has every part, so that each of its fields counts.
inline Material MaterialOfAllParts(BsdfKind bsdf) {
  return {.name = "all",
          .bsdf = bsdf,
          .eta = {0.2f, 0.4f, 1.4f},
          .k = {3.9f, 2.4f, 1.6f},
          .alpha = 0.3f,
          .alpha_across = 0.4f,
          .metallic = 0.25f,
          .second_color = {0.1f, 0.2f, 0.3f},
          .coat = 0.5f,
          .coat_alpha = 0.2f,
          .coat_thickness = 0.5f,
          .sheen = {0.3f, 0.2f, 0.1f},
          .sheen_alpha = 0.25f,
          .anisotropy = 0.5f,
          .anisotropy_turn = 0.3f,
          .film = 0.5f,
          .reflection = glm::vec3(0.75f, 0.5f, 0.25f),
          .absorption = {1, 2, 3},
          .color_texture = 1,
          .roughness_texture = 2,
          .second_color_texture = 7,
          .sheen_texture = 8,
          .sheen_alpha_texture = 9,
          .coat_alpha_texture = 10,
          .specular_texture = 11,
          .specular_color_texture = 12,
          .anisotropy_texture = 13,
          .film_texture = 14,
          .film_thickness_texture = 15,
          .opacity = 0.5f,
          .opacity_cutoff = 0.25f,
          .opacity_texture = 3,
          .normal_texture = 4,
          .normal_scale = 2,
          .own_base_normals = true,
          .base_normal_texture = 16,
          .mixture = Mixture{1, 2, 0.5f},
          .mixture_texture = 6,
          .emission = {3, 2, 1},
          .emission_texture = 5};
}

// These give a field another value, which no clamp undoes.
inline void ChangeField(float& field) { field += 0.125f; }
inline void ChangeField(bool& field) { field = !field; }
inline void ChangeField(std::uint32_t& field) { ++field; }
inline void ChangeField(glm::vec3& field) { field.y += 0.125f; }
inline void ChangeField(Mixture& field) { field.share += 0.125f; }
inline void ChangeField(BsdfKind& field) {
  field = BsdfKind((std::uint32_t(field) + 1) % kBsdfKinds);
}
template <class T>
void ChangeField(std::optional<T>& field) {
  ChangeField(*field);
}

}  // namespace skywave
