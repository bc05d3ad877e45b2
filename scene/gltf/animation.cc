#include "scene/gltf/animation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "base/error.h"
#include "scene/gltf/buffers.h"
#include "scene/gltf/names.h"

namespace skywave {
namespace {

enum class Interpolation { kLinear, kStep, kCubicSpline };

// The keys of a sampler: times [s] that do not decrease, and `components` numbers of each value. A
// key of a cubic spline has three values: the tangent before it, its own, and the tangent after it.
struct Keys {
  Interpolation interpolation = Interpolation::kLinear;
  std::vector<float> times, values;
  int components = 3;

  glm::dvec4 Value(std::size_t index) const {
    glm::dvec4 value(0);
    for (int c = 0; c < components; ++c) {
      value[c] = values[index * std::size_t(components) + std::size_t(c)];
    }
    return value;
  }
  std::size_t values_of_key() const { return interpolation == Interpolation::kCubicSpline ? 3 : 1; }
  glm::dvec4 ValueOfKey(std::size_t key) const {
    return Value(key * values_of_key() + values_of_key() / 2);
  }
};

// A channel, and what errors call it.
struct ChannelPlace {
  const tinygltf::Model& model;
  const tinygltf::Animation& animation;
  std::size_t index;
  const std::string &name, &path;

  const tinygltf::AnimationChannel& channel() const { return animation.channels[index]; }
  [[noreturn]] void Fail(const std::string& reason) const {
    FailGltf(path, fmt::format("animation '{}', channel {}: {}", name, index, reason));
  }
  const tinygltf::AnimationSampler& sampler() const {
    const int sampler = channel().sampler;
    if (sampler < 0 || std::size_t(sampler) >= animation.samplers.size()) {
      Fail(fmt::format("there is no sampler {}", sampler));
    }
    return animation.samplers[std::size_t(sampler)];
  }
};

std::vector<float> ReadTimes(const ChannelPlace& place) {
  const int input = place.sampler().input;
  std::vector<float> times = ReadGltfNumbers(place.model, input, 1, place.path);
  if (place.model.accessors[std::size_t(input)].componentType != TINYGLTF_COMPONENT_TYPE_FLOAT) {
    place.Fail("its times are no floats");
  }
  // Times have to increase. Two keys at the same time do no harm, and there are files with them.
  if (!std::is_sorted(times.begin(), times.end())) place.Fail("its times decrease");
  return times;
}

Interpolation InterpolationOf(const ChannelPlace& place) {
  const std::string& name = place.sampler().interpolation;
  if (name.empty() || name == "LINEAR") return Interpolation::kLinear;
  if (name == "STEP") return Interpolation::kStep;
  if (name == "CUBICSPLINE") return Interpolation::kCubicSpline;
  place.Fail(fmt::format("there is no interpolation '{}'", name));
}

// Rotations and weights may be stored as normalized integers, translations and scales only as
// floats.
void CheckValueType(const ChannelPlace& place, bool normalizable) {
  const tinygltf::Accessor& accessor = place.model.accessors[std::size_t(place.sampler().output)];
  const int type = accessor.componentType;
  const bool integer =
      normalizable && accessor.normalized &&
      (type == TINYGLTF_COMPONENT_TYPE_BYTE || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
       type == TINYGLTF_COMPONENT_TYPE_SHORT || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT);
  if (type != TINYGLTF_COMPONENT_TYPE_FLOAT && !integer) {
    place.Fail(normalizable ? "its values are neither floats nor normalized integers"
                            : "its values are no floats");
  }
}

Keys ReadKeys(const ChannelPlace& place, bool rotation) {
  Keys keys;
  keys.interpolation = InterpolationOf(place);
  keys.times = ReadTimes(place);
  keys.components = rotation ? 4 : 3;
  keys.values = ReadGltfNumbers(place.model, place.sampler().output, keys.components, place.path);
  CheckValueType(place, rotation);
  const std::size_t wanted = keys.times.size() * keys.values_of_key();
  if (keys.values.size() != wanted * std::size_t(keys.components)) {
    place.Fail(fmt::format("its {} keys need {} values, not {}", keys.times.size(), wanted,
                           keys.values.size() / std::size_t(keys.components)));
  }
  for (std::size_t key = 0; rotation && key < keys.times.size(); ++key) {
    if (!(glm::length(keys.ValueOfKey(key)) > 0)) {
      place.Fail(fmt::format("the rotation of key {} has length zero", key));
    }
  }
  return keys;
}

// Returns the keys of each of the weights, which a file stores one after the other for every key.
std::vector<Keys> ReadWeightKeys(const ChannelPlace& place) {
  Keys keys;
  keys.interpolation = InterpolationOf(place);
  keys.times = ReadTimes(place);
  keys.components = 1;
  const std::vector<float> values =
      ReadGltfNumbers(place.model, place.sampler().output, 1, place.path);
  CheckValueType(place, true);
  const std::size_t rows = keys.times.size() * keys.values_of_key();
  if (rows == 0 || values.size() % rows != 0) {
    place.Fail(fmt::format("its {} keys cannot have {} weights", keys.times.size(), values.size()));
  }
  const std::size_t weights = values.size() / rows;
  std::vector<Keys> list(weights, keys);
  for (std::size_t i = 0; i < values.size(); ++i) list[i % weights].values.push_back(values[i]);
  return list;
}

glm::dquat Quaternion(const glm::dvec4& xyzw) { return glm::dquat(xyzw.w, xyzw.x, xyzw.y, xyzw.z); }
glm::dvec4 Vector(const glm::dquat& q) { return {q.x, q.y, q.z, q.w}; }

// Follows the shorter one of the two arcs.
glm::dvec4 Slerp(const glm::dvec4& from, const glm::dvec4& to, double share) {
  return Vector(
      glm::slerp(glm::normalize(Quaternion(from)), glm::normalize(Quaternion(to)), share));
}

// The cubic Hermite spline of glTF 2.0, appendix C.5.
glm::dvec4 Spline(const Keys& keys, std::size_t key, double share, double seconds) {
  const double t = share, t2 = t * t, t3 = t2 * t;
  const glm::dvec4 start = keys.Value(3 * key + 1), tangent_out = keys.Value(3 * key + 2);
  const glm::dvec4 tangent_in = keys.Value(3 * key + 3), end = keys.Value(3 * key + 4);
  return (2 * t3 - 3 * t2 + 1) * start + seconds * (t3 - 2 * t2 + t) * tangent_out +
         (3 * t2 - 2 * t3) * end + seconds * (t3 - t2) * tangent_in;
}

// Returns the value at `time` [s]; rotations need normalising.
glm::dvec4 ValueAt(const Keys& keys, double time) {
  // Files keep times as floats. A frame that is rounded as they are meets the key of its own time.
  const float rounded = float(time);
  const auto after = std::upper_bound(keys.times.begin(), keys.times.end(), rounded);
  if (after == keys.times.begin()) return keys.ValueOfKey(0);
  const auto key = std::size_t(after - keys.times.begin()) - 1;
  if (after == keys.times.end() || keys.interpolation == Interpolation::kStep) {
    return keys.ValueOfKey(key);
  }
  const double start = keys.times[key], seconds = double(*after) - start;
  const double share = std::clamp((time - start) / seconds, 0.0, 1.0);
  if (keys.interpolation == Interpolation::kCubicSpline) return Spline(keys, key, share, seconds);
  const glm::dvec4 from = keys.ValueOfKey(key), to = keys.ValueOfKey(key + 1);
  return keys.components == 4 ? Slerp(from, to, share) : glm::mix(from, to, share);
}

void PoseNode(const ChannelPlace& place, double time, GltfPose& pose) {
  const std::string& property = place.channel().target_path;
  if (property == "weights") {
    pose.weights.emplace();
    for (const Keys& keys : ReadWeightKeys(place)) {
      pose.weights->push_back(ValueAt(keys, time).x);
    }
    return;
  }
  const bool rotation = property == "rotation";
  const glm::dvec4 value = ValueAt(ReadKeys(place, rotation), time);
  if (property == "translation") {
    pose.translation = glm::dvec3(value);
  } else if (property == "scale") {
    pose.scale = glm::dvec3(value);
  } else {
    // A spline may pass through zero between its keys.
    const double length = glm::length(value);
    if (!(length > 0) || !std::isfinite(length)) {
      place.Fail(fmt::format("its rotation at {} s has length {}", time, length));
    }
    pose.rotation = Quaternion(value / length);
  }
}

// Returns whether the channel moves a node, and warns where it moves something else.
bool MovesNode(const ChannelPlace& place, Warnings& warnings) {
  const tinygltf::AnimationChannel& channel = place.channel();
  const std::string& property = channel.target_path;
  if (property != "translation" && property != "rotation" && property != "scale" &&
      property != "weights") {
    AddWarning(
        warnings, InputPosition::File(place.path),
        fmt::format("animations of '{}' are not supported: left at rest", property.substr(0, 60)));
    return false;
  }
  if (channel.target_node == -1) {
    AddWarning(warnings, InputPosition::File(place.path),
               "animations of things that are no nodes are not supported: left at rest");
    return false;
  }
  if (channel.target_node < 0 || std::size_t(channel.target_node) >= place.model.nodes.size()) {
    place.Fail(fmt::format("there is no node {}", channel.target_node));
  }
  if (property != "weights" &&
      !place.model.nodes[std::size_t(channel.target_node)].matrix.empty()) {
    place.Fail(fmt::format("node {} has a matrix, which cannot be animated", channel.target_node));
  }
  return true;
}

std::vector<std::string> AnimationNames(const tinygltf::Model& model) {
  std::set<std::string> taken;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < model.animations.size(); ++i) {
    names.push_back(NameOnce(model.animations[i].name, i, taken));
  }
  return names;
}

}  // namespace

std::vector<GltfPose> PoseGltfNodes(const tinygltf::Model& model, const ReadOptions& options,
                                    const std::string& path, Warnings& warnings) {
  std::vector<GltfPose> poses(model.nodes.size());
  const std::optional<double> time = TimeOf(options);
  if (!time) return poses;
  const std::vector<std::string> names = AnimationNames(model);
  std::map<std::pair<int, std::string>, std::size_t> movers;  // animations by node and property
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!options.animation.empty() && options.animation != names[i]) continue;
    for (std::size_t c = 0; c < model.animations[i].channels.size(); ++c) {
      const ChannelPlace place{model, model.animations[i], c, names[i], path};
      if (!MovesNode(place, warnings)) continue;
      const tinygltf::AnimationChannel& channel = place.channel();
      const auto [mover, is_new] =
          movers.try_emplace({channel.target_node, channel.target_path}, i);
      if (!is_new && mover->second == i) {
        place.Fail(fmt::format("moves the {} of node {} a second time", channel.target_path,
                               channel.target_node));
      }
      if (!is_new) {
        AddWarning(warnings, InputPosition::File(path),
                   "several animations move the same node: the first one of them counts, unless "
                   "one is chosen by its name");
        continue;
      }
      PoseNode(place, *time, poses[std::size_t(channel.target_node)]);
    }
  }
  return poses;
}

std::vector<AnimationInfo> ListGltfAnimations(const tinygltf::Model& model, const std::string& path,
                                              Warnings& warnings) {
  const std::vector<std::string> names = AnimationNames(model);
  std::vector<AnimationInfo> list;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const tinygltf::Animation& animation = model.animations[i];
    AnimationInfo info = {.name = names[i], .seconds = 0, .channels = animation.channels.size()};
    std::set<int> inputs;  // channels share their times as a rule
    try {
      for (std::size_t c = 0; c < animation.channels.size(); ++c) {
        const ChannelPlace place{model, animation, c, names[i], path};
        if (!inputs.insert(place.sampler().input).second) continue;
        info.seconds = std::max(info.seconds, double(ReadTimes(place).back()));
      }
    } catch (const InputError& error) {
      AddNote(warnings, InputPosition::File(path),
              "an animation cannot be read: " + error.reason());
    }
    list.push_back(std::move(info));
  }
  return list;
}

}  // namespace skywave
