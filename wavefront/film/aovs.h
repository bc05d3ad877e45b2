// Arbitrary output variables: what a picture can say beside its radiance, for compositing, for
// denoising and to look into a render. Each is one line of a table; a layer of the EXR has its
// name.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "kernels/camera.h"
#include "kernels/columns.h"
#include "scene/geometry.h"

namespace skywave {

// How the samples of a pixel become one value. What the camera rays meet (the first two) is read at
// the first surface, through no mirror and no glass.
enum class AovSum {
  kMeanOfHits,   // over the samples whose camera ray hit something
  kNearestHit,   // of the sample nearest to the pixel's centre, where a mean would mean nothing
  kCoverage,     // share of the samples whose camera ray hit something
  kSampleCount,  // the same in every pixel
  kVariance,     // of one sample of the beauty, unbiased if samples are independent
  kDirect,       // radiance of light that met at most one surface
  kIndirect,     // the rest of the beauty
  kLightGroups,  // the beauty by groups of lights, a layer each (wavefront/film/light_groups.h)
};

// What a mean can hold without being clamped: decides the unit of its sums.
enum class AovRange { kUnit, kColor, kWorld };

// Surfaces [0, count) that the camera rays of a wave hit.
struct FirstSurfaces {
  const Geometry& geometry;
  const CameraView& camera;
  SurfaceColumns surfaces;
  std::uint32_t count;
};

inline constexpr std::uint32_t kMaxAovChannels = 3;
using AovColumns = float* [kMaxAovChannels];

struct Aov {
  std::string_view name;      // of the flag's word and of the layer
  std::string_view channels;  // a letter each; the channel of the file is name.letter
  AovSum sum;
  std::string_view help;
  // First hits only.
  void (*read)(const FirstSurfaces& first, const AovColumns& out) = nullptr;  // writes `count` rows
  AovRange range = AovRange::kUnit;
  float background = 0;  // where nothing was hit
};

// All there are, in the order of help texts.
std::span<const Aov> Aovs();

// Lines of the table: bit i is Aovs()[i].
using AovSet = std::uint32_t;

// All lines of the table.
AovSet AllAovs();
// From names divided by commas, or "all".
std::optional<AovSet> ParseAovs(std::string_view names);
// The names, divided by commas.
std::string ToString(AovSet aovs);
// Whether some line of `aovs` sums in that way.
bool Sums(AovSet aovs, AovSum sum);
// Whether it needs texture coordinates of scenes without textures.
bool NeedsUvs(AovSet aovs);
// Whether some line is read at first hits.
bool ReadsHits(AovSet aovs);

}  // namespace skywave
