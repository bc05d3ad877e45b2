// The options that a caller gives to the scene readers.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "base/names.h"

namespace skywave {

// How to store an object that is in a scene more than once.
enum class InstanceUse {
  kAuto,  // copied, unless that would take more memory than it is worth
  kCopy,  // its triangles are copied for every instance
  kShare  // all instances share its triangles
};
template <>
inline constexpr auto kEnumNames<InstanceUse> = std::to_array<Named<InstanceUse>>(
    {{InstanceUse::kAuto, "auto"}, {InstanceUse::kCopy, "copy"}, {InstanceUse::kShare, "share"}});

// What becomes of a scene that names a file which is not there or cannot be read.
enum class MissingFiles {
  kSkip,   // what needs it is left out, with a warning
  kRefuse  // the scene is refused
};
template <>
inline constexpr auto kEnumNames<MissingFiles> = std::to_array<Named<MissingFiles>>(
    {{MissingFiles::kSkip, "skip"}, {MissingFiles::kRefuse, "refuse"}});

// Whether colours of vertices count, as factors of the reflectance and of the opacity.
enum class VertexColors { kOn, kOff };
template <>
inline constexpr auto kEnumNames<VertexColors> =
    std::to_array<Named<VertexColors>>({{VertexColors::kOn, "on"}, {VertexColors::kOff, "off"}});

inline constexpr std::size_t kMaxInstances = std::size_t{1} << 24;

struct ReadOptions {
  // Turns every omission or approximation into an InputError instead of a warning.
  bool strict = false;
  MissingFiles missing = MissingFiles::kSkip;
  VertexColors vertex_colors = VertexColors::kOn;
  // Files that grow beyond this by instances or subdivision are refused, so that a small file
  // cannot exhaust the memory. [triangles] 2^27 triangles are about 5 GB of positions and indices.
  std::size_t max_triangles = std::size_t{1} << 27;
  InstanceUse instances = InstanceUse::kAuto;
  std::size_t max_instances = kMaxInstances;  // files with more are refused
  // Diameter of the spheres and tubes that stand for points and lines, in units of their mesh.
  // Unset: they are left out.
  std::optional<float> point_size;
  // The moment at which an animated scene is read, frame / fps [s]. Unset: nodes are where the file
  // puts them without its animations.
  std::optional<double> frame;
  std::optional<double> fps;   // [1/s]; unset: kDefaultFps
  std::string animation = {};  // the only animation that moves something; empty: all do
  // One of the scenes of a file and of the variants of its materials, by name; a scene also by its
  // place in the file. Empty: the file's defaults.
  std::string scene, variant;
  // The place of the file's world that becomes Scene::origin. ReadScene chooses it.
  glm::dvec3 origin{0.0};
};

inline constexpr double kDefaultFps = 24;

// Returns the moment in seconds, or nothing where no frame is asked for.
inline std::optional<double> TimeOf(const ReadOptions& options) {
  if (!options.frame) return std::nullopt;
  return *options.frame / options.fps.value_or(kDefaultFps);
}

}  // namespace skywave
