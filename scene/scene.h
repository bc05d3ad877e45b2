// What is rendered, as plain data: what every reader and built-in scene produces and what
// Geometry (geometry.h) turns into Embree's and the kernels' tables.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "image/image.h"
#include "kernels/camera.h"
#include "kernels/columns.h"
#include "kernels/lights/local_lights.h"

namespace skywave {

struct Mixture {
  std::uint32_t first, second;  // indices into Scene::materials, of materials before this one
  float share;                  // of the second one, in [0, 1]
};

struct Material {
  std::string name;
  BsdfKind bsdf = BsdfKind::kLambert;
  // Lambert: albedo; mirror, conductor: factor of Fresnel; metallic-roughness: base colour. Linear
  // RGB.
  glm::vec3 reflectance{0.5f};
  glm::vec3 eta{0.0f};  // conductors: real part of the index per channel; eta = k = 0: F = 1
  glm::vec3 k{0.0f};    // conductors: imaginary part of the index per channel
  // Width of microfacets in [0.001, 1]; Oren-Nayar: roughness in [0, 1]; Phong, Blinn: the exponent
  // is 2 / alpha^2 - 2.
  float alpha = 0.1f;
  // Anisotropic conductors, Ward: the width across the tangent; not given: alpha.
  std::optional<float> alpha_across;
  float ior = 1.5f;    // dielectric: index inside (where the normal points away) / outside
  float metallic = 0;  // metallic-roughness: share of metal
  // Diffuse transmission: what passes through; Phong: the gloss.
  glm::vec3 second_color{0.0f};
  // Coated conductor (strength 1; `ior` is the coat's), coated metallic-roughness (index 1.5).
  float coat = 1, coat_alpha = 1e-3f;
  glm::vec3 sheen{0.0f};  // coated metallic-roughness: colour and width
  float sheen_alpha = 0.1f;
  std::uint32_t measured = 0;  // measured: index into Scene::measured
  // Dielectric, smooth or rough: what light loses inside, by Beer and Lambert [1/length].
  glm::vec3 absorption{0.0f};
  // Indices into Scene::textures: factors of the reflectance; of the square root of alpha (green)
  // and of metallic (blue).
  std::optional<std::uint32_t> color_texture, roughness_texture;
  // Share of the surface that is there: this times the texture. With a cutoff the surface is there
  // where that reaches it, and not at all elsewhere.
  float opacity = 1;
  std::optional<float> opacity_cutoff;
  std::optional<std::uint32_t> opacity_texture;
  // Bends the shading normal. The scale is that of the tilt; of heights, what 1 is in the world
  // or, for a height in texels, on the image.
  std::optional<std::uint32_t> normal_texture;
  float normal_scale = 1;
  bool height_in_texels = false;
  // Two other materials, one of which a hit has: nothing else but opacity and emission counts then.
  std::optional<Mixture> mixture;
  // Radiance of the surface itself, on the side of its normals or on both; the texture is a factor.
  glm::vec3 emission{0.0f};
  bool emits_on_both_sides = false;
  std::optional<std::uint32_t> emission_texture;

  // False: rays may pass through.
  bool opaque() const { return opacity >= 1 && !opacity_texture; }
};

// A BRDF as it was measured (scene/materials/merl.h).
struct MeasuredBrdf {
  std::vector<float> rgb;  // kMeasuredFloats [1/sr], in the order that columns.h gives
  // The lobe that sampling takes for it: GGX width and probability, the rest is drawn by the
  // cosine.
  float alpha = 1, specular_share = 0;
};

// What the texels of a texture stand for. Normals: x right in the image, y up and z off the
// surface, [0, 1] stands for [-1, 1]. Opacity and heights: the mean of the channels.
enum class TextureUse : std::uint32_t { kColor, kOpacity, kNormals, kHeights };

// An image as a material uses it. uv (0, 0) is the top left corner of the image, (1, 1) the bottom
// right one, after `transform` (columns: what u, v and 1 are multiplied with).
struct Texture {
  std::uint32_t image = 0;  // index into Scene::images
  TextureWrap wrap_u = TextureWrap::kRepeat, wrap_v = TextureWrap::kRepeat;
  glm::mat3x2 transform{1, 0, 0, 1, 0, 0};
  TextureUse use = TextureUse::kColor;
};

// Triangles. (p1 - p0) x (p2 - p0) is on the side that the normals point to, in left-handed worlds
// too: counter-clockwise seen from there, once the axes are drawn right-handed.
struct Mesh {
  std::string name;
  std::vector<glm::vec3> positions;  // world space
  std::vector<glm::vec3> normals;    // empty (flat shading) or one a position, unit length
  std::vector<glm::vec2> uvs;        // empty or one a position
  // Empty or one a position: where u grows, and the side on which v does (+-1, of normal x
  // tangent), as glTF has it. Unset: triangle by triangle from uvs.
  std::vector<glm::vec4> tangents;
  std::vector<glm::vec3> colors;  // empty or one a position: factor of the reflectance, linear RGB
  std::vector<glm::uvec3> triangles;  // indices into positions
  std::uint32_t material = 0;         // index into Scene::materials
};

// The rectangle of the plane z = 1 (perspective, in units of tan(fov / 2)) or z = 0 (orthographic)
// that the film shows.
struct ScreenWindow {
  float left = -1, right = 1, bottom = -1, top = 1;
};

// Camera space: x right, y up, looking along +z; in a right-handed world the matrix mirrors. A
// scene file's camera may be scaled: directions need normalising after the matrix.
struct Camera {
  CameraKind kind = CameraKind::kPerspective;
  glm::mat4 world_from_camera{1.0f};
  float fov_degrees = 45.0f;           // of a screen window's [-1, 1], of a fisheye's circle
  std::optional<ScreenWindow> window;  // unset: [-1, 1] on the shorter side of the film
  // Of perspective and orthographic cameras, in camera space. The plane at the focal distance is
  // sharp; radius 0: everything is.
  float lens_radius = 0;
  float focal_distance = 1e6f;
};

enum class PixelFilter { kBox, kTriangle, kGaussian, kBlackmanHarris };

// An infinitely distant map, or a constant radiance where it has none.
struct EnvironmentLight {
  std::string map_path;            // empty: constant
  std::optional<Image> map;        // or a lat-long map in memory (built-in skies)
  bool equal_area_square = false;  // a square file is pbrt-v4's equal-area square
  glm::vec3 scale{1.0f};           // factor per channel, or the constant radiance
  // Columns: the world directions of "right", "forward" and "up" of the map. Forward is the centre
  // of a lat-long image and of an angular map, right is where its right half looks. May mirror.
  glm::mat3 world_from_map{1.0f};  // columns: right, forward, up
};

// A light without extent.
struct PunctualLight {
  std::string name = {};
  LocalLightKind kind = LocalLightKind::kPoint;  // point, spot or distant
  glm::vec3 emission{0.0f};                      // as in LocalLight: intensity or irradiance
  glm::vec3 position{0.0f};                      // point, spot; world space
  glm::vec3 direction{0, 0, 1};  // spot: where it points; distant: towards it; world space, unit
  // Spot: cosines of the angles to `direction` up to which it is full and from which it is dark.
  float cos_full = 1, cos_dark = 0;
};

// A part of the film, as fractions of its width from the left and its height from the top.
struct CropFractions {
  float left = 0, right = 1, top = 0, bottom = 1;
};

// What the file says of the rendering; flags of the command line come before it.
struct RenderSettings {
  std::optional<int> width, height, samples_per_pixel, max_depth;
  std::optional<std::string> integrator;  // as the command line names it
  // Of photons: each sample of a pixel is a pass with its own; radius of the first pass.
  bool photons_each_sample = false;
  std::optional<float> photon_distance;
  std::optional<PixelFilter> filter;
  std::optional<float> filter_radius;  // [pixels]
  std::optional<CropFractions> crop;   // the part that is rendered
};

struct Scene {
  std::vector<Mesh> meshes;
  std::vector<Material> materials;
  std::vector<MeasuredBrdf> measured;
  std::vector<Texture> textures;
  std::vector<Image> images;  // of textures: linear RGB, or numbers as they are
  std::optional<Camera> camera;
  std::vector<EnvironmentLight> environments;
  std::vector<PunctualLight> lights;
  RenderSettings settings;
  // True if the world's axes are left-handed (pbrt's are): decides which way round a map given on
  // the command line is laid, so that it is never seen mirrored.
  bool left_handed = false;
  char up_axis = 'y';                 // 'x', 'y' or 'z': up of --env and of automatic framing
  std::vector<std::string> warnings;  // "file:line: what was not understood and what is done"
};

// Smallest axis-aligned box around all meshes; throws InputError(path) if there is no triangle.
struct Bounds {
  glm::vec3 low, high;
};
Bounds SceneBounds(const Scene& scene, const std::string& path);

// A camera at `eye` that sees `target` in its centre and `up` (any length, not along the view)
// above.
Camera LookAtCamera(const glm::vec3& eye, const glm::vec3& target, const glm::vec3& up,
                    float fov_degrees, bool left_handed);

// A camera that sees all of `bounds` from slightly above, `up_axis` being up, on a film of that
// `aspect` (width / height).
Camera FrameBounds(const Bounds& bounds, char up_axis, bool left_handed, float aspect = 1);

// The camera of another kind at the same place. A perspective camera that becomes orthographic
// shows as much as before of what is as far away as the middle of `bounds`; one that becomes
// spherical stands upright; one that becomes a fisheye looks where it looked and sees half of all.
Camera WithKind(const Camera& camera, CameraKind kind, const Bounds& bounds, char up_axis,
                bool left_handed);

// world_from_map for a map given on the command line: its middle turned `rotation_degrees`
// counter-clockwise about the up axis (seen from above) away from -z (y up), +y (z up) or +y
// (x up); in a left-handed world away from +z, -y or -y. So it is never seen mirrored.
glm::mat3 EnvironmentFrame(char up_axis, bool left_handed, float rotation_degrees);
// The rotation of it alone: turns a light about the up axis.
glm::mat3 EnvironmentTurn(char up_axis, bool left_handed, float rotation_degrees);

}  // namespace skywave
