#include "scene/instances.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>
#include <vector>

#include "base/error.h"
#include "scene/shapes/mesh.h"

namespace skywave {
namespace {

// A copy takes these bytes while the BVH is built, and an instance the last of them
// (docs/decisions/2026-11-23-share-instances.md).
constexpr double kBytesOfTriangle = 150, kBytesOfVertex = 32, kBytesOfMesh = 300,
                 kBytesOfInstance = 1100;
// Rays through a shared object take up to twice as long as rays through copies, so an object is
// copied as long as its copies take less memory than this.
constexpr double kWorthOfCopies = 256e6;

// Returns the number of triangles, or that for which there are vertices if it is larger: meshes of
// few triangles may name few of their vertices.
std::size_t Triangles(const std::vector<Mesh>& meshes) {
  std::size_t triangles = 0;
  for (const Mesh& mesh : meshes) {
    triangles += std::max(mesh.triangles.size(), mesh.positions.size() / 3);
  }
  return triangles;
}

double BytesOfCopy(const std::vector<Mesh>& meshes) {
  double bytes = 0;
  for (const Mesh& mesh : meshes) {
    bytes += kBytesOfMesh + kBytesOfTriangle * double(mesh.triangles.size()) +
             kBytesOfVertex * double(mesh.positions.size());
  }
  return bytes;
}

bool Shines(const Scene& scene, const Mesh& mesh) {
  return mesh.material < scene.materials.size() &&
         scene.materials[mesh.material].emission != glm::vec3(0);
}

// `seen` has materials that were asked before, without a map: mixtures may have one many times.
bool HasNormalMap(const Scene& scene, std::uint32_t material, std::set<std::uint32_t>& seen) {
  if (material >= scene.materials.size() || !seen.insert(material).second) return false;
  const Material& of = scene.materials[material];
  if (of.normal_texture || of.base_normal_texture) return true;
  return of.mixture && (HasNormalMap(scene, of.mixture->first, seen) ||
                        HasNormalMap(scene, of.mixture->second, seen));
}

bool IsShared(InstanceUse use, const std::vector<Mesh>& meshes, std::size_t instances,
              std::size_t max_triangles) {
  if (use != InstanceUse::kAuto) return use == InstanceUse::kShare;
  const double count = double(instances);
  if (double(Triangles(meshes)) * count > double(max_triangles)) return true;
  return (count - 1) * BytesOfCopy(meshes) - count * kBytesOfInstance > kWorthOfCopies;
}

// Returns whether Embree can send rays into the object and back without losing their precision.
bool HasInverse(const glm::dmat3& linear) {
  const double lengths = glm::length(linear[0]) * glm::length(linear[1]) * glm::length(linear[2]);
  const double volume = std::abs(glm::determinant(linear));
  return std::isfinite(lengths) && volume > 1e-6 * lengths && std::isnormal(float(volume)) &&
         std::isnormal(float(1 / volume));
}

bool HasToBeCopied(const glm::dmat3& linear, bool has_normal_map) {
  return !HasInverse(linear) || (has_normal_map && glm::determinant(linear) < 0);
}

// An object as it is used.
struct Use {
  std::size_t instances = 0;
  bool shared = false, has_normal_map = false;
  std::vector<Mesh> shining;  // meshes of a shared object that are copied nevertheless
};

std::vector<Use> UsesOf(const ReadOptions& options, Scene& scene) {
  std::vector<Use> uses(scene.objects.size());
  for (const Instance& instance : scene.instances) ++uses.at(instance.object).instances;
  for (std::size_t i = 0; i < uses.size(); ++i) {
    std::vector<Mesh>& meshes = scene.objects[i].meshes;
    Use& use = uses[i];
    if (!IsShared(options.instances, meshes, use.instances, options.max_triangles)) continue;
    use.shared = true;
    const auto first_shining = std::stable_partition(
        meshes.begin(), meshes.end(), [&](const Mesh& mesh) { return !Shines(scene, mesh); });
    use.shining.assign(std::move_iterator(first_shining), std::move_iterator(meshes.end()));
    meshes.erase(first_shining, meshes.end());
    std::set<std::uint32_t> seen;
    use.has_normal_map = std::any_of(meshes.begin(), meshes.end(), [&](const Mesh& mesh) {
      return HasNormalMap(scene, mesh.material, seen);
    });
  }
  return uses;
}

// Appends copies to `meshes` until there are too many triangles.
class Copier {
 public:
  Copier(const ReadOptions& options, const std::string& path, std::size_t triangles)
      : most_(options.max_triangles), path_(path), triangles_(triangles) {
    Check();
  }
  void Append(const glm::dmat4& to, const std::string& node, const std::vector<Mesh>& from,
              std::vector<Mesh>& meshes) {
    triangles_ += Triangles(from);
    Check();
    for (Mesh mesh : from) {
      TransformMesh(to, mesh);
      mesh.node = node;
      meshes.push_back(std::move(mesh));
    }
  }

 private:
  void Check() const {
    if (triangles_ <= most_) return;
    throw InputError(
        InputPosition::File(path_),
        fmt::format("the scene has more than {} triangles, copies of instances included (`max-"
                    "triangles`); with `instances` share, objects are not copied",
                    most_));
  }
  std::size_t most_;
  const std::string& path_;
  std::size_t triangles_;
};

// Drops objects without an instance and those without a mesh, with their instances.
void DropUnused(Scene& scene) {
  std::vector<bool> used(scene.objects.size());
  for (const Instance& instance : scene.instances) used[instance.object] = true;
  std::vector<std::uint32_t> number(scene.objects.size());
  std::vector<Object> kept;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    used[i] = used[i] && !scene.objects[i].meshes.empty();
    number[i] = std::uint32_t(kept.size());
    if (used[i]) kept.push_back(std::move(scene.objects[i]));
  }
  std::erase_if(scene.instances, [&](const Instance& instance) { return !used[instance.object]; });
  for (Instance& instance : scene.instances) instance.object = number[instance.object];
  scene.objects = std::move(kept);
}

}  // namespace

void ResolveInstances(const ReadOptions& options, const std::string& path, Scene& scene) {
  if (scene.instances.size() > options.max_instances) {
    throw InputError(InputPosition::File(path),
                     fmt::format("the scene has {} instances, and {} are the most",
                                 scene.instances.size(), options.max_instances));
  }
  const std::vector<Use> uses = UsesOf(options, scene);
  std::size_t triangles = Triangles(scene.meshes);
  for (std::size_t i = 0; i < uses.size(); ++i) {
    if (uses[i].shared && uses[i].instances > 0) triangles += Triangles(scene.objects[i].meshes);
  }
  Copier copier(options, path, triangles);
  std::vector<Mesh> own = std::move(scene.meshes), meshes;
  std::vector<Instance> shared;
  std::size_t taken = 0;
  const auto take_until = [&](std::size_t end) {
    for (; taken < end; ++taken) meshes.push_back(std::move(own[taken]));
  };
  for (const Instance& instance : scene.instances) {
    const Use& use = uses[instance.object];
    const glm::dmat4 to(instance.world_from_object);
    const std::string node = instance.node == kNoNode ? "" : scene.nodes[instance.node];
    take_until(std::min<std::size_t>(instance.meshes_before, own.size()));
    const bool copied = !use.shared || HasToBeCopied(glm::dmat3(to), use.has_normal_map);
    if (copied) copier.Append(to, node, scene.objects[instance.object].meshes, meshes);
    copier.Append(to, node, use.shining, meshes);
    if (copied) continue;
    shared.push_back(instance);
    shared.back().meshes_before = std::uint32_t(meshes.size());
  }
  take_until(own.size());
  scene.meshes = std::move(meshes);
  scene.instances = std::move(shared);
  DropUnused(scene);
}

}  // namespace skywave
