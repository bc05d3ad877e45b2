// A light of one point may shine into the directions of a space of its own by a shape: a cone, an
// image on the sphere around it or an image that it projects. Scenes without such lights have no
// table of shapes.
#pragma once

#include <cstdint>

namespace skywave {

// Choices among lights, and among the texels of a shape, are made by so many steps of a uniform.
inline constexpr std::uint32_t kChoiceUnits = 1u << 24;

// A shape maps the unit square (s, t) to directions d of the light's space.
enum class LightMapping : std::uint32_t {
  kCone,    // s turns about +z, t grows by 1 - d.z from the axis to the edge
  kSphere,  // the equal-area square of Clarberg 2008: +z in the middle, +x at s = 1, +y at t = 1
  kPlane,   // the plane z = 1: +x to the right, +y up, s = t = 0 in the top left corner
};

// A shape is 32 words, read by gathers at shape * 32 + field.
// How the light of a spot falls between its two cones, with the share t of the difference of their
// cosines: 3 t^2 - 2 t^3 (pbrt-v4), t^2 (glTF's KHR_lights_punctual), or t^4 (pbrt-v3).
enum class SpotCurve : std::uint32_t { kSmoothStep, kSquare, kFourth };

struct LightShape {
  LightMapping mapping;
  // Cone: the cosine at its edge; 1 / (the cosine up to which it is full - that). Plane: half of
  // its width and of its height.
  float extent[2];
  // Row by row; the determinants are 1 or -1, so that the solid angle of d, mapped to the other
  // space, is divided by the third power of the length that the matrix gives to d.
  float light_from_world[9], world_from_light[9];
  // The square is an image of equal texels, row by row. Texel i has the factors of the light's
  // emission at first_texel + 3 i of LightShapeView::texels.
  std::uint32_t width, height, first_texel;
  // Light paths draw a row, then a column in it, by bounds as those of LightChoice, in
  // kChoiceUnits: height + 1 bounds from here on of LightShapeView::choices, then width + 1 for
  // each row. A texel without light has no width.
  std::uint32_t first_choice;
  SpotCurve curve;  // of cones
  std::uint32_t unused[6];
};
inline constexpr std::uint32_t kLogShapeWords = 5;
static_assert(sizeof(LightShape) == sizeof(std::uint32_t) << kLogShapeWords);

struct LightShapeView {
  const LightShape* shapes = nullptr;
  const float* texels = nullptr;
  const std::uint32_t* choices = nullptr;
  bool empty() const { return shapes == nullptr; }
};

}  // namespace skywave
