// What the red, green and blue of a file are: the chromaticities of its primaries and of its white.
#pragma once

#include <glm/glm.hpp>

#include <optional>
#include <string_view>

#include "image/image.h"

namespace skywave {

struct RgbPrimaries {
  glm::dvec2 red, green, blue, white;  // CIE 1931 x, y
};
inline constexpr glm::dvec2 kWhiteD65(0.3127, 0.329);
inline constexpr RgbPrimaries kRec709 = {{0.64, 0.33}, {0.3, 0.6}, {0.15, 0.06}, kWhiteD65};

// Returns whether the chromaticities make a space: none is 0 below, and no colour is of the others.
bool IsRgbSpace(const RgbPrimaries& primaries);

// Returns the XYZ of the colours of a space, whose white has Y = 1.
glm::dmat3 XyzFromRgb(const RgbPrimaries& primaries);
// Returns the XYZ under D65 of what has some XYZ under another white (Bradford's method, Lam 1985).
glm::dmat3 AdaptToD65(const glm::dvec2& white);

const RgbPrimaries& PrimariesOf(RgbSpace space);
// Returns the space of the primaries, which may be 0.001 off.
std::optional<RgbSpace> SpaceOf(const RgbPrimaries& primaries);
// Returns the name of the space's linear colours by the ASWF Color Interop Forum.
std::string_view InteropId(RgbSpace space);
// Returns what makes colours of the space of those of Rec. 709: white stays white, and what is not
// negative stays so.
glm::dmat3 FromRec709(RgbSpace space);

// Converts a picture of such colours to linear Rec. 709, where its white stays white; but numbers
// that are X, Y and Z themselves keep their chromaticities. Does nothing if it is in that space
// already, to 0.001.
void ConvertToRec709(const RgbPrimaries& primaries, Image& image);
// A picture of a space as one of Rec. 709: the picture itself, which has to outlive this, or a
// copy.
class InRec709 {
 public:
  InRec709(const Image& image, RgbSpace space) : image_(&image) {
    if (space == RgbSpace::kRec709) return;
    ConvertToRec709(PrimariesOf(space), converted_.emplace(image));
  }
  operator const Image&() const { return converted_ ? *converted_ : *image_; }

 private:
  const Image* image_;
  std::optional<Image> converted_;
};

// Applies a matrix, unless it is the identity, to every pixel.
void ConvertColors(const glm::dmat3& matrix, Image& image);

}  // namespace skywave
