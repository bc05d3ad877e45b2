#include "scene/light_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/constants.hpp>
#include <numeric>
#include <optional>
#include <span>

#include "kernels/bsdf/bsdf.h"

namespace skywave {
namespace {

constexpr int kBuckets = 12;
constexpr std::uint32_t kMostLevels = 32;              // LightTreeView::way has a bit for each
constexpr double kHalfSphere = 2 * glm::pi<double>();  // [sr]

struct Box {
  glm::dvec3 low{HUGE_VAL}, high{-HUGE_VAL};
  void Hold(const glm::dvec3& point) { low = glm::min(low, point), high = glm::max(high, point); }
  void Hold(const Box& other) { Hold(other.low), Hold(other.high); }
  double diagonal2() const {
    const glm::dvec3 size = high - low;
    return low.x <= high.x ? glm::dot(size, size) : 0;
  }
};

// A light as the tree knows it.
struct Item {
  Box box;
  glm::dvec3 axis{0, 0, 1};  // its normal; distant: towards it
  double cos_cone = 1;       // -1: it shines all around
  double cos_spread = 0;
  double intensity = 0;
  bool two_sided = false, distant = false;
  glm::dvec3 middle() const { return 0.5 * (box.low + box.high); }
};

glm::dvec3 Of(const float (&v)[3]) { return {v[0], v[1], v[2]}; }

// `power` is that of LocalLights::power.
Item MakeItem(const LocalLight& light, double power) {
  Item item;
  const glm::dvec3 position = Of(light.position);
  item.box.Hold(position);
  item.intensity = power / (2 * kHalfSphere);
  switch (light.kind) {
    case LocalLightKind::kTriangle: {
      const glm::dvec3 axis = Of(light.axis), edge = Of(light.edge);
      item.box.Hold(position + axis), item.box.Hold(position + edge);
      item.axis = glm::normalize(glm::cross(axis, edge));
      item.two_sided = light.two_sided != 0;
      item.intensity = power / (0.5 * kHalfSphere * (item.two_sided ? 2 : 1));
      break;
    }
    case LocalLightKind::kSpot:
      item.axis = Of(light.axis);
      item.cos_spread = double(light.cone.cos_dark);
      break;
    case LocalLightKind::kDistant:
      item.axis = Of(light.axis);
      item.distant = true;
      break;
    case LocalLightKind::kPoint:
    case LocalLightKind::kShaped:
      item.cos_cone = -1;
      break;
  }
  if (light.kind == LocalLightKind::kSpot || light.kind == LocalLightKind::kDistant) {
    item.intensity = glm::dot(Of(light.emission), Of(kLuminance));
  }
  return item;
}

// Sums over lights, by which a division is judged.
struct Group {
  Box box;
  glm::dvec3 axes{0};
  double intensity = 0;
  std::size_t count = 0;

  void Add(const Item& item) {
    box.Hold(item.box);
    if (item.cos_cone > 0 && !item.two_sided) axes += item.axis;
    intensity += item.intensity;
    ++count;
  }
  void Add(const Group& other) {
    box.Hold(other.box);
    axes += other.axes, intensity += other.intensity, count += other.count;
  }
  // The measure of the directions into which lights with normals of this spread shine is pi if they
  // have one normal and 4 pi if they look everywhere; between these it follows the length of the
  // normals' mean.
  double Cost() const {
    if (count == 0) return 0;
    return intensity * (4 - 3 * glm::length(axes) / double(count)) * box.diagonal2();
  }
};

class Builder {
 public:
  Builder(std::vector<Item> items, double total)
      : items_(std::move(items)), total_(total), order_(items_.size()), way_(items_.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    nodes_.resize(1);
    Build(0, order_, 0, 0);
  }
  std::vector<LightNode> nodes() && { return std::move(nodes_); }
  std::vector<std::uint32_t> way() && { return std::move(way_); }

 private:
  using Lights = std::span<std::uint32_t>;

  // Makes node `at`, which `way` leads to, of lights.
  void Build(std::size_t at, Lights lights, std::uint32_t way, std::uint32_t depth) {
    nodes_[at] = Node(lights);
    if (lights.size() == 1) {
      nodes_[at].first = lights[0];
      way_[lights[0]] = way;
      return;
    }
    const std::size_t middle = Divide(lights, depth), children = nodes_.size();
    nodes_[at].first = std::uint32_t(children);
    nodes_.resize(children + 2);
    Build(children, lights.first(middle), way, depth + 1);
    Build(children + 1, lights.subspan(middle), way | 1u << depth, depth + 1);
  }

  LightNode Node(Lights lights) const {
    Box box;
    glm::dvec3 axes{0};
    double intensity = 0, cos_spread = 1;
    bool two_sided = false, all_distant = true, all_around = false;
    for (const std::uint32_t i : lights) {
      const Item& item = items_[i];
      box.Hold(item.box);
      // Normals that may be turned are turned to where the others look.
      axes += item.two_sided && glm::dot(axes, item.axis) < 0 ? -item.axis : item.axis;
      intensity += item.intensity;
      cos_spread = std::min(cos_spread, item.cos_spread);
      two_sided = two_sided || item.two_sided;
      all_distant = all_distant && item.distant;
      all_around = all_around || item.cos_cone < 0;
    }
    const double length = glm::length(axes);
    const glm::dvec3 axis = length > 0 ? axes / length : glm::dvec3(0, 0, 1);
    double cos_cone = all_around ? -1 : 1;
    for (const std::uint32_t i : lights) {
      const double cosine = glm::dot(axis, items_[i].axis);
      cos_cone = std::min(cos_cone, items_[i].two_sided ? std::abs(cosine) : cosine);
    }
    // Floats must not make the cone, or the sphere, smaller than it is.
    if (lights.size() > 1) cos_cone = std::max(cos_cone - 1e-6, -1.0);
    const glm::dvec3 center = 0.5 * (box.low + box.high);
    const double farthest = glm::length(glm::max(glm::abs(box.low), glm::abs(box.high)));
    LightNode node = {};
    for (int i = 0; i < 3; ++i) {
      node.center[i] = float(center[i]);
      node.axis[i] = float(axis[i]);
    }
    node.radius = lights.size() == 1 && box.diagonal2() == 0
                      ? 0
                      : float(0.5 * std::sqrt(box.diagonal2()) + 0x1p-22 * farthest);
    node.cos_cone = float(cos_cone);
    node.cos_spread = float(cos_spread - 1e-6);
    node.intensity = float(intensity / total_);
    node.count = std::uint32_t(lights.size()) | (two_sided ? kTwoSidedNode : 0) |
                 (all_distant ? kDistantNode : 0);
    return node;
  }

  // Brings lights into the order of two groups and returns the size of the first one.
  std::size_t Divide(Lights lights, std::uint32_t depth) {
    const auto is_distant = [&](std::uint32_t i) { return items_[i].distant; };
    const auto local = std::stable_partition(lights.begin(), lights.end(),
                                             [&](std::uint32_t i) { return !is_distant(i); });
    const auto locals = std::size_t(local - lights.begin());
    if (locals > 0 && locals < lights.size()) return locals;
    // Halves need no more levels than there are left.
    const auto levels = std::uint32_t(std::bit_width(lights.size() - 1));
    const bool has_room = depth + levels + 1 < kMostLevels;
    const std::optional<Plane> plane = has_room && locals > 0 ? BestPlane(lights) : std::nullopt;
    if (!plane) return lights.size() / 2;
    const auto second = std::stable_partition(lights.begin(), lights.end(), [&](std::uint32_t i) {
      return BucketOf(*plane, items_[i]) <= plane->last;
    });
    return std::size_t(second - lights.begin());
  }

  // Lights are divided by the bucket of their middle along an axis.
  struct Plane {
    int axis = 0;
    double low = 0, size = 0;
    int last = 0;  // bucket of the first group
  };

  static int BucketOf(const Plane& plane, const Item& item) {
    const double place = (item.middle()[plane.axis] - plane.low) / plane.size;
    return std::clamp(int(place * kBuckets), 0, kBuckets - 1);
  }

  // Returns the division of least cost; none where all middles are one point.
  std::optional<Plane> BestPlane(Lights lights) const {
    Box middles;
    for (const std::uint32_t i : lights) middles.Hold(items_[i].middle());
    const glm::dvec3 size = middles.high - middles.low;
    const double longest = std::max({size.x, size.y, size.z});
    std::optional<Plane> best;
    double least = HUGE_VAL;
    for (int axis = 0; axis < 3; ++axis) {
      if (!(size[axis] > 0)) continue;
      Plane plane = {.axis = axis, .low = middles.low[axis], .size = size[axis]};
      std::array<Group, kBuckets> groups;
      for (const std::uint32_t i : lights) {
        groups[std::size_t(BucketOf(plane, items_[i]))].Add(items_[i]);
      }
      std::array<Group, kBuckets> after;  // what lies in later buckets
      for (int b = kBuckets - 1; b-- > 0;) {
        after[std::size_t(b)] = after[std::size_t(b) + 1];
        after[std::size_t(b)].Add(groups[std::size_t(b) + 1]);
      }
      Group before;
      for (plane.last = 0; plane.last < kBuckets - 1; ++plane.last) {
        before.Add(groups[std::size_t(plane.last)]);
        const Group& rest = after[std::size_t(plane.last)];
        if (before.count == 0 || rest.count == 0) continue;
        const double cost = longest / size[axis] * (before.Cost() + rest.Cost());
        if (cost < least) least = cost, best = plane;
      }
    }
    return best;
  }

  std::vector<Item> items_;
  double total_;
  std::vector<std::uint32_t> order_;
  std::vector<LightNode> nodes_;
  std::vector<std::uint32_t> way_;
};

}  // namespace

LightTree::LightTree(const LocalLights& lights, const Scene& scene) {
  const LocalLightView view = lights.view();
  std::vector<Item> items;
  double total = 0;
  for (std::uint32_t i = 0; i < view.count; ++i) {
    items.push_back(MakeItem(view.lights[i], lights.power()[i]));
    total += items.back().intensity;
  }
  Builder builder(std::move(items), total);
  way_ = std::move(builder).way();
  nodes_ = std::move(builder).nodes();
  for (const Material& material : scene.materials) {
    lit_behind_.push_back(Bsdfs()[std::size_t(material.bsdf)].transmits ? 1 : 0);
  }
}

}  // namespace skywave
