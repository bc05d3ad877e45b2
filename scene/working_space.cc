#include "scene/working_space.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "image/primaries.h"
#include "scene/materials/texture_files.h"

namespace skywave {
namespace {

class Converter {
 public:
  explicit Converter(RgbSpace space) : matrix_(FromRec709(space)) {}

  void Convert(glm::vec3& color) const { color = glm::vec3(matrix_ * glm::dvec3(color)); }
  void Convert(Image& image) const { ConvertColors(matrix_, image); }

  // Converts what metals reflect at normal incidence (Born and Wolf, 14.2), by k where that can be.
  void ConvertIndex(glm::vec3& eta, glm::vec3& k) const {
    if (eta == glm::vec3(0) && k == glm::vec3(0)) return;  // all of the light
    const auto square = [](double x) { return x * x; };
    glm::dvec3 reflected;
    for (int c = 0; c < 3; ++c) {
      const double n = eta[c], absorbed = square(k[c]);
      reflected[c] = (square(n - 1) + absorbed) / (square(n + 1) + absorbed);
    }
    reflected = matrix_ * reflected;
    for (int c = 0; c < 3; ++c) {
      const double r = std::clamp(reflected[c], 0.0, 0.9999), n = eta[c];
      const double absorbed = (r * square(n + 1) - square(n - 1)) / (1 - r);
      if (absorbed >= 0) {
        k[c] = float(std::sqrt(absorbed));
      } else {
        eta[c] = float((1 + std::sqrt(r)) / (1 - std::sqrt(r))), k[c] = 0;
      }
    }
  }

  // Converts what is left of white light after the mean free path.
  void ConvertAbsorption(glm::vec3& absorption) const {
    const double mean = (double(absorption.x) + absorption.y + absorption.z) / 3;
    if (!(mean > 0)) return;
    const glm::dvec3 left = matrix_ * glm::exp(-glm::dvec3(absorption) / mean);
    absorption = glm::vec3(-glm::log(glm::max(left, 1e-30)) * mean);
  }

 private:
  const glm::dmat3 matrix_;
};

void ConvertMaterial(const Converter& converter, Material& material) {
  for (glm::vec3* const color :
       {&material.reflectance, &material.second_color, &material.coat_albedo, &material.sheen,
        &material.specular_color, &material.emission}) {
    converter.Convert(*color);
  }
  if (material.reflection) converter.Convert(*material.reflection);
  converter.ConvertIndex(material.eta, material.k);
  converter.ConvertAbsorption(material.absorption);
}

// Calls f(texture) for the textures of a material that are colours.
template <class M, class F>
void ForEachColorTexture(M& material, const F& f) {
  for (auto* const texture :
       {&material.color_texture, &material.second_color_texture, &material.sheen_texture,
        &material.specular_color_texture, &material.emission_texture}) {
    if (*texture) f(**texture);
  }
}

// Converts the images of colours. One that is numbers as well gets a copy, and so do the textures
// that see it as colours.
void ConvertImages(const Converter& converter, Scene& scene) {
  std::set<std::uint32_t> of_colors;  // textures
  for (const Material& material : scene.materials) {
    ForEachColorTexture(material, [&](std::uint32_t texture) { of_colors.insert(texture); });
  }
  std::set<std::uint32_t> of_numbers;  // images
  for (const Material& material : scene.materials) {
    std::multiset<std::uint32_t> textures;
    ForEachTexture(material, [&](std::uint32_t texture) { textures.insert(texture); });
    ForEachColorTexture(material,
                        [&](std::uint32_t texture) { textures.erase(textures.find(texture)); });
    for (const std::uint32_t texture : textures) {
      of_numbers.insert(scene.textures[texture].image);
    }
  }
  std::map<std::uint32_t, std::uint32_t> converted;  // image -> its colours
  const auto colors_of = [&](std::uint32_t image) {
    const auto [known, is_new] = converted.try_emplace(image, image);
    if (!is_new) return known->second;
    if (of_numbers.contains(image)) known->second = AddTextureImage(scene, scene.images[image]);
    Image colors = scene.images[known->second].Floats();
    converter.Convert(colors);
    scene.images[known->second] = std::move(colors);
    return known->second;
  };
  std::map<std::uint32_t, std::uint32_t> copies;  // texture -> that of the colours
  for (const std::uint32_t texture : of_colors) {
    Texture copy = scene.textures[texture];
    copy.image = colors_of(copy.image);
    if (copy.image == scene.textures[texture].image) continue;
    copies[texture] = std::uint32_t(scene.textures.size());
    scene.textures.push_back(copy);
  }
  for (Material& material : scene.materials) {
    ForEachColorTexture(material, [&](std::uint32_t& texture) {
      if (const auto copy = copies.find(texture); copy != copies.end()) texture = copy->second;
    });
  }
  for (PunctualLight& light : scene.lights) {
    if (light.form && light.form->image) light.form->image = colors_of(*light.form->image);
  }
}

void ConvertMeshes(const Converter& converter, std::vector<Mesh>& meshes) {
  for (Mesh& mesh : meshes) {
    for (glm::vec3& color : mesh.colors) converter.Convert(color);
  }
}

}  // namespace

void ConvertScene(RgbSpace space, Scene& scene) {
  if (space == RgbSpace::kRec709) return;
  const Converter converter(space);
  for (Material& material : scene.materials) ConvertMaterial(converter, material);
  ConvertImages(converter, scene);
  ConvertMeshes(converter, scene.meshes);
  for (Object& object : scene.objects) ConvertMeshes(converter, object.meshes);
  for (PunctualLight& light : scene.lights) converter.Convert(light.emission);
  for (MeasuredBrdf& brdf : scene.measured) {
    for (std::size_t i = 0; i + 2 < brdf.rgb.size(); i += 3) {
      glm::vec3 color(brdf.rgb[i], brdf.rgb[i + 1], brdf.rgb[i + 2]);
      converter.Convert(color);
      for (int c = 0; c < 3; ++c) brdf.rgb[i + std::size_t(c)] = color[c];
    }
  }
}

}  // namespace skywave
