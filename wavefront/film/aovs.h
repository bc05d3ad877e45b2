// Arbitrary output variables are what a picture can hold in addition to its radiance, for
// compositing, for denoising and to look into a render. Each is one line of a table; a layer of the
// EXR has its name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "kernels/camera.h"
#include "kernels/columns.h"
#include "scene/geometry.h"
#include "wavefront/film/flow.h"
#include "wavefront/film/hidden_objects.h"
#include "wavefront/film/light_parts.h"
#include "wavefront/film/mattes.h"

namespace skywave {

// The samples of a pixel become one value by one of these sums. The first two are read at the first
// surfaces that camera rays hit, through no mirror and no glass.
enum class AovSum {
  kMeanOfHits,    // over the samples whose camera ray hit something
  kNearestHit,    // of the sample nearest to the pixel's centre, where a mean is meaningless
  kCoverage,      // share of the samples whose camera ray hit something
  kSampleCount,   // of the pixel
  kVariance,      // of one sample of the beauty, unbiased if samples are independent
  kHalf,          // the beauty of the second halves of the samples, and their number
  kHalfVariance,  // of one sample of them
  kDirect,        // radiance of light that hit at most one surface
  kIndirect,      // the rest of the beauty
  kLightGroups,   // the beauty by groups of lights, one layer each (wavefront/film/light_groups.h)
  kAlpha,         // share of what is behind the scene that it hides
  // Those of catchers (wavefront/stages/place.h).
  kShadow,      // light of catchers with the objects over that without them
  kDifference,  // the same, subtracted
  kForeground,  // the beauty without what is behind it
  kBackdrop,    // what is behind it: a map on the ground and on a dome (LightPart::kBackdrop)
  kPart,        // a part of the light, and the share of the pixel where it is seen
  kMatte        // ids of first surfaces and their shares (wavefront/film/mattes.h)
};

// The range that a mean can hold without being clamped decides the unit of its sums.
enum class AovRange { kUnit, kColor, kWorld };

// The camera rays of a wave have hit surfaces [0, count).
struct FirstSurfaces {
  const Geometry& geometry;
  const CameraView& camera;
  SurfaceColumns surfaces;
  std::uint32_t count;
  const Tracer* tracer = nullptr;       // for layers of what is behind them
  const FrameMotion* motion = nullptr;  // for layers of it
  const bool* nearest = nullptr;        // rows that layers of kNearestHit keep
};

inline constexpr std::uint32_t kMaxAovChannels = kHiddenObjects;  // of a layer of first hits
using AovColumns = float* [kMaxAovChannels];

struct Aov {
  std::string_view name;      // word of the flag and name of the layer
  std::string_view channels;  // one letter each; the channel of the file is name.letter
  AovSum sum;
  std::string_view help;
  // This is for layers of first hits only.
  void (*read)(const FirstSurfaces& first, const AovColumns& out) = nullptr;  // writes `count` rows
  AovRange range = AovRange::kUnit;
  float background = 0;        // value where nothing was hit
  bool of_composites = false;  // kept for catchers and transparent backgrounds, and not in "all"
  std::optional<LightPart> part = std::nullopt;  // whose sum it is; none: that of the beauty
  MatteOf matte = MatteOf::kObjects;  // what a matte is of; mattes are not in "all" either
  bool of_motion = false;             // needs the frames beside that of the picture; not in "all"
  bool traces = false;                // rays of its own; not in "all"
};

// Returns all of them, in the order of help texts.
std::span<const Aov> Aovs();

// A set of lines of the table has bit i for Aovs()[i].
using AovSet = std::uint64_t;

// Returns all lines of the table but mattes and those of composites, of motion and of more rays.
AovSet AllAovs();
// Returns the lines that sum the beauty like that.
AovSet AovsOf(AovSum sum);
// Returns those that pictures with catchers have, alpha among them.
AovSet CatcherAovs();
// Returns those of the parts of their light, and of the noise of these.
AovSet PartAovs();
// Parses names separated by commas. "all" is all of them, "denoiser" those that a denoiser reads.
std::optional<AovSet> ParseAovs(std::string_view names);
// Returns the names, separated by commas.
std::string ToString(AovSet aovs);
// Returns the name of a layer of the EXR; `group` is the name of its group of lights, or the number
// of a layer of a matte.
std::string LayerName(const Aov& aov, std::string_view group);
// Calls f(aov, group, channel) for each channel of the layers `aovs`, in their order. The layer of
// light groups is there once for each of `light_groups` groups, and a matte has kMatteLayers; the
// others have group 0.
template <class F>
void ForEachChannel(AovSet aovs, std::size_t light_groups, F f) {
  for (std::size_t k = 0; k < Aovs().size(); ++k) {
    if ((aovs >> k & 1) == 0) continue;
    const Aov& aov = Aovs()[k];
    const std::size_t groups = aov.sum == AovSum::kLightGroups ? light_groups
                               : aov.sum == AovSum::kMatte     ? kMatteLayers
                                                               : 1;
    for (std::size_t group = 0; group < groups; ++group) {
      for (std::size_t c = 0; c < aov.channels.size(); ++c) f(aov, group, c);
    }
  }
}
// Returns how many channels these layers have.
std::size_t ChannelCount(AovSet aovs, std::size_t light_groups);
// True if any line of `aovs` sums the beauty like that.
bool Sums(AovSet aovs, AovSum sum);
// True if any line needs the frames beside that of the picture.
bool NeedsMotion(AovSet aovs);
// True if any line needs texture coordinates in scenes without textures.
bool NeedsUvs(AovSet aovs);
// True if any line is read at first hits.
bool ReadsHits(AovSet aovs);

}  // namespace skywave
