#include "job/marks.h"

#include <fmt/format.h>

#include <map>
#include <set>
#include <string_view>

#include "base/error.h"
#include "base/nearest_name.h"

namespace skywave {
namespace {

template <class F>
void ForEachMesh(Scene& scene, const F& f) {
  for (Mesh& mesh : scene.meshes) f(mesh);
  for (Object& object : scene.objects) {
    for (Mesh& mesh : object.meshes) f(mesh);
  }
}

[[noreturn]] void Refuse(const std::string& option, const std::string& name, Scene& scene) {
  std::set<std::string_view> known;
  for (const Material& material : scene.materials) known.insert(material.name);
  ForEachMesh(scene, [&](const Mesh& mesh) { known.insert(mesh.name), known.insert(mesh.node); });
  known.erase("");
  throw OptionError(option, name,
                    fmt::format("no material and no mesh has this name; there are {}",
                                NearestFirst(name, {known.begin(), known.end()})));
}

}  // namespace

MaterialMark FlagOf(bool Material::*flag) {
  return {[flag](Material& material) { material.*flag = true; },
          [flag](const Material& material) { return material.*flag; }};
}

MaterialMark BitOf(std::uint32_t Material::*bits, std::uint32_t bit) {
  return {[bits, bit](Material& material) { material.*bits |= bit; },
          [bits, bit](const Material& material) { return (material.*bits & bit) != 0; }};
}

void Mark(const std::string& option, const std::vector<std::string>& names,
          const MaterialMark& mark, Scene& scene) {
  std::map<std::uint32_t, std::uint32_t> copies;  // by the material that they are of
  for (const std::string& name : names) {
    bool found = false;
    for (Material& material : scene.materials) {
      if (material.name != name) continue;
      mark.set(material);
      found = true;
    }
    ForEachMesh(scene, [&](Mesh& mesh) {
      if (mesh.name != name && mesh.node != name) return;
      found = true;
      if (mark.is_set(scene.materials[mesh.material])) return;
      const auto [copy, is_new] =
          copies.emplace(mesh.material, std::uint32_t(scene.materials.size()));
      if (is_new) {
        Material marked = scene.materials[mesh.material];
        mark.set(marked);
        scene.materials.push_back(std::move(marked));
      }
      mesh.material = copy->second;
    });
    if (!found) Refuse(option, name, scene);
  }
}

}  // namespace skywave
