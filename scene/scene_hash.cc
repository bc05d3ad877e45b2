#include "scene/scene_hash.h"

#include <xxhash.h>

#include <memory>
#include <optional>
#include <string_view>

#include "kernels/bsdf/bsdf.h"
#include "scene/lens_system.h"

namespace skywave {
namespace {

class Hash {
 public:
  Hash() { XXH64_reset(state_.get(), 0); }
  Hash(const Hash& other) { XXH64_copyState(state_.get(), other.state_.get()); }
  Hash& operator=(const Hash&) = delete;
  std::uint64_t value() const { return XXH64_digest(state_.get()); }

  template <class T>
  void Add(const T& value) {
    XXH64_update(state_.get(), &value, sizeof value);
  }
  template <class T>
  void AddAll(const T& values) {
    Add(std::uint64_t{values.size()});
    AddArray(values.data(), values.size());
  }
  template <class T>
  void AddArray(const T* values, std::size_t count) {
    XXH64_update(state_.get(), values, count * sizeof values[0]);
  }

 private:
  struct Free {
    void operator()(XXH64_state_t* state) const { XXH64_freeState(state); }
  };
  std::unique_ptr<XXH64_state_t, Free> state_{XXH64_createState()};
};

// These add a field of a material. A BSDF goes by its name, so that new ones change no hash; an
// optional field that is unset and no part of its own goes by a value that it cannot have.
template <class T>
void AddField(const T& field, Hash& hash) {
  hash.Add(field);
}
void AddField(BsdfKind bsdf, Hash& hash) { hash.AddAll(Bsdfs()[std::size_t(bsdf)].name); }
void AddField(const std::optional<float>& field, Hash& hash) { hash.Add(field.value_or(-1)); }
void AddField(const std::optional<std::uint32_t>& field, Hash& hash) {
  hash.Add(field.value_or(~0u));
}
void AddField(const std::optional<glm::vec3>& field, Hash& hash) { hash.Add(field.value()); }
void AddField(const std::optional<Mixture>& field, Hash& hash) { hash.Add(field.value()); }
static_assert(sizeof(Mixture) == 3 * sizeof(std::uint32_t), "padding has no value to hash");

void AddMaterial(const Material& material, Hash& hash) {
  Material::ForEachField(material, [&](std::string_view, MaterialPart part, const auto& field) {
    if (!material.has(part)) return;
    // Later parts say which they are: another one may look like them.
    if (part >= MaterialPart::kCatcher) hash.Add(std::uint32_t(part));
    AddField(field, hash);
  });
}

void AddMesh(const Mesh& mesh, Hash& hash) {
  hash.AddAll(mesh.positions), hash.AddAll(mesh.normals), hash.AddAll(mesh.uvs);
  hash.AddAll(mesh.triangles);
  hash.Add(mesh.material);
  if (!mesh.second_uvs.empty()) hash.AddAll(mesh.second_uvs);
  if (!mesh.tangents.empty()) hash.AddAll(mesh.tangents);
  if (!mesh.colors.empty()) hash.AddAll(mesh.colors);
  if (!mesh.alphas.empty()) hash.AddAll(mesh.alphas);
}

void AddTexture(const Texture& texture, Hash& hash) {
  hash.Add(texture.image), hash.Add(texture.wrap_u), hash.Add(texture.wrap_v);
  hash.Add(texture.transform);
  if (texture.use != TextureUse::kColor) hash.Add(texture.use);
  if (texture.one_level) hash.Add(texture.one_level);
  if (texture.uv_set != UvSet::kFirst) hash.Add(texture.uv_set);
}

void AddImage(const Image& image, Hash& hash) {
  hash.Add(image.width), hash.Add(image.height), hash.AddAll(image.rgb);
}

// Adds the floats, whichever form they have.
void AddImage(const CompactImage& image, Hash& hash) {
  hash.Add(image.width), hash.Add(image.height), hash.Add(std::uint64_t{image.values()});
  std::vector<float> decoded;
  for (int y = 0; y < image.height; ++y) {
    hash.AddArray(image.Row(y, decoded), 3 * std::size_t(image.width));
  }
}

void AddCamera(const Camera& camera, Hash& hash) {
  hash.Add(camera.kind), hash.Add(camera.world_from_camera), hash.Add(camera.fov_degrees);
  if (camera.window) hash.Add(*camera.window);
  if (camera.square_pixels) hash.Add(camera.square_pixels);
  if (camera.film_width > 0) hash.Add(camera.film_width), hash.Add(camera.film_height);
  hash.Add(camera.lens_radius), hash.Add(camera.focal_distance);
  if (camera.realistic) hash.AddAll(camera.realistic->columns);
}

void AddEnvironment(const EnvironmentLight& light, const glm::mat3& world_from_map, Hash& hash) {
  if (light.map) AddImage(*light.map, hash);
  hash.Add(light.scale), hash.Add(world_from_map);
}

void AddLight(const PunctualLight& light, Hash& hash) {
  hash.Add(light.kind), hash.Add(light.emission), hash.Add(light.position);
  hash.Add(light.direction), hash.Add(light.cos_full), hash.Add(light.cos_dark);
  if (light.curve != SpotCurve::kSmoothStep) hash.Add(light.curve);
  if (!light.form) return;
  hash.Add(light.form->mapping), hash.Add(light.form->world_from_light);
  AddField(light.form->image, hash), hash.Add(light.form->half_size);
}

}  // namespace

SceneHashContent::SceneHashContent(const Scene& scene) {
  const auto hash = std::make_shared<Hash>();
  if (scene.origin != glm::dvec3(0)) hash->Add(scene.origin);
  for (const Mesh& mesh : scene.meshes) AddMesh(mesh, *hash);
  for (const Object& object : scene.objects) {
    hash->Add(std::uint64_t{object.meshes.size()});
    for (const Mesh& mesh : object.meshes) AddMesh(mesh, *hash);
  }
  for (const Instance& instance : scene.instances) {
    hash->Add(instance.object), hash->Add(instance.world_from_object);
  }
  for (const Material& material : scene.materials) AddMaterial(material, *hash);
  for (const MeasuredBrdf& brdf : scene.measured) hash->AddAll(brdf.rgb);
  for (const Texture& texture : scene.textures) AddTexture(texture, *hash);
  for (const CompactImage& image : scene.images) AddImage(image, *hash);
  state_ = hash;
}

std::uint64_t SceneHashContent::WithView(const Camera& camera, const EnvironmentLight& light,
                                         const glm::mat3& world_from_map,
                                         std::span<const PunctualLight> lights) const {
  Hash hash = *static_cast<const Hash*>(state_.get());
  AddCamera(camera, hash);
  AddEnvironment(light, world_from_map, hash);
  for (const PunctualLight& punctual : lights) AddLight(punctual, hash);
  return hash.value();
}

std::uint64_t SceneHash(const Scene& scene) {
  Hash hash = *static_cast<const Hash*>(SceneHashContent(scene).state_.get());
  if (scene.camera) AddCamera(*scene.camera, hash);
  for (const EnvironmentLight& light : scene.environments) {
    AddEnvironment(light, light.world_from_map, hash);
  }
  for (const PunctualLight& light : scene.lights) AddLight(light, hash);
  return hash.value();
}

std::uint64_t MapHash(const Image& map) {
  Hash hash;
  AddImage(map, hash);
  return hash.value();
}

}  // namespace skywave
