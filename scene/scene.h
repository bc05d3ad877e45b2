// A scene as plain data: every reader and built-in scene produces one, and Geometry (geometry.h)
// turns it into Embree's and the kernels' tables.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "image/compact_image.h"
#include "image/image.h"
#include "kernels/bsdf/material.h"
#include "kernels/camera.h"
#include "kernels/columns.h"
#include "kernels/lights/local_lights.h"
#include "kernels/lights/portals.h"

namespace skywave {

// The texels of a texture stand for one of these. A normal has x right in the image, y up and z off
// the surface, and [0, 1] stands for [-1, 1]. pbrt's normals have y along normal x tangent instead,
// which is down in the image where the coordinates are mirrored. Opacity and heights are the mean
// of the channels.
enum class TextureUse : std::uint32_t { kColor, kOpacity, kNormals, kHeights, kPbrtNormals };

// Which of the coordinates of a mesh a texture is looked up at.
enum class UvSet : std::uint32_t { kFirst, kSecond };

// An image as a material uses it. After `transform`, whose columns are the factors of u, v and 1,
// uv (0, 0) is the top left corner of the image and (1, 1) the bottom right one.
struct Texture {
  std::uint32_t image = 0;  // index into Scene::images
  TextureWrap wrap_u = TextureWrap::kRepeat, wrap_v = TextureWrap::kRepeat;
  glm::mat3x2 transform{1, 0, 0, 1, 0, 0};
  TextureUse use = TextureUse::kColor;
  // There are no coarser levels: neighbours in the image may be far apart on the surface.
  bool one_level = false;
  UvSet uv_set = UvSet::kFirst;
};

// A mesh is triangles. (p1 - p0) x (p2 - p0) is on the side that the normals point to, in
// left-handed worlds too: they are counter-clockwise seen from there, once the axes are drawn
// right-handed.
struct Mesh {
  std::string name;
  std::string node;  // what stands it in the world, by which it goes too; may be empty
  std::vector<glm::vec3> positions;   // world space
  std::vector<glm::vec3> normals;     // empty (flat shading) or one per position, unit length
  std::vector<glm::vec2> uvs;         // empty or one per position
  std::vector<glm::vec2> second_uvs;  // likewise
  // Empty or one per position: the direction in which u grows, and the side on which v does (+-1,
  // of normal x tangent), as glTF has it. Where they are empty, the uvs give those of each
  // triangle.
  std::vector<glm::vec4> tangents;
  // Empty or one per position: factors of the reflectance (linear RGB) and of the opacity.
  std::vector<glm::vec3> colors;
  std::vector<float> alphas;
  std::vector<glm::uvec3> triangles;  // indices into positions
  std::uint32_t material = 0;         // index into Scene::materials

  const std::vector<glm::vec2>& UvsOf(UvSet set) const {
    return set == UvSet::kFirst ? uvs : second_uvs;
  }
};

// Meshes that stand in the world by instances alone, in a space of their own. None of them shines
// once ResolveInstances (scene/instances.h) has been called.
struct Object {
  std::string name;
  std::vector<Mesh> meshes;
};

// An object in the world.
inline constexpr std::uint32_t kNoNode = 0xFFFFFFFFu;
struct Instance {
  std::uint32_t object = 0;  // index into Scene::objects
  glm::dmat4x3 world_from_object{1.0};
  // The number of Scene::meshes that come before it in the file: its copies would stand there.
  std::uint32_t meshes_before = 0;
  std::uint32_t node = kNoNode;  // index into Scene::nodes
};

// The film shows this rectangle of the plane z = 1 (perspective, in units of tan(fov / 2)) or z = 0
// (orthographic).
struct ScreenWindow {
  float left = -1, right = 1, bottom = -1, top = 1;
};

// Camera space: x right, y up, looking along +z; in a right-handed world the matrix mirrors. A
// scene file's camera may be scaled: directions need normalising after the matrix.
struct LensSystem;  // scene/lens_system.h

struct Camera {
  CameraKind kind = CameraKind::kPerspective;
  glm::mat4 world_from_camera{1.0f};
  float fov_degrees = 45.0f;           // angle of a screen window's [-1, 1], of a fisheye's circle
  std::optional<ScreenWindow> window;  // unset: [-1, 1] on the shorter side of the film
  // A film of another shape than the window shows all of it and more on two sides, so that pixels
  // are squares. Otherwise the window is stretched over the film.
  bool square_pixels = false;
  // The film of a photograph [pixels]: only that shape is stretched. 0: every shape is.
  int film_width = 0, film_height = 0;
  // The lens of perspective and orthographic cameras, in camera space. The plane at the focal
  // distance is sharp; with a radius of 0 everything is.
  float lens_radius = 0;
  float focal_distance = 1e6f;
  // That of a realistic camera.
  std::shared_ptr<const LensSystem> realistic;
};

// One of the cameras of a file, by which it can be asked for.
struct NamedCamera {
  std::string name;  // no other camera of the scene has it
  Camera camera;
};

// What a file can move, for those who choose from it.
struct AnimationInfo {
  std::string name;    // no other animation of the scene has it
  double seconds = 0;  // the time of the last key
  std::size_t channels = 0;
};

enum class PixelFilter { kBox, kTriangle, kGaussian, kBlackmanHarris, kMitchell, kSinc };

// An infinitely distant light: a map, or a constant radiance where it has none.
struct EnvironmentLight {
  std::string map_path;            // empty: constant
  std::optional<Image> map;        // a lat-long map in memory instead (built-in skies)
  bool equal_area_square = false;  // a square file is pbrt-v4's equal-area square
  glm::vec3 scale{1.0f};           // factor per channel, or the constant radiance
  // The columns are the world directions of "right", "forward" and "up" of the map. Forward is the
  // centre of a lat-long image and of an angular map; its right half looks to the right. The matrix
  // may mirror.
  glm::mat3 world_from_map{1.0f};
};

// What a light of one point sends into the directions of a space of its own
// (kernels/lights/light_shapes.h). A cone has the cosines of its light.
struct LightForm {
  LightMapping mapping = LightMapping::kCone;
  glm::mat3 world_from_light{1.0f};    // any scale; directions need normalising after the matrix
  std::optional<std::uint32_t> image;  // index into Scene::images: factors of the emission
  glm::vec2 half_size{1.0f};           // plane: half of its width and height at z = 1
};

// A light without extent.
struct PunctualLight {
  std::string name = {};
  LocalLightKind kind = LocalLightKind::kPoint;  // point, spot, distant or shaped
  glm::vec3 emission{0.0f};                      // as in LocalLight: intensity or irradiance
  glm::vec3 position{0.0f};                      // point, spot, shaped; world space
  glm::vec3 direction{0, 0, 1};  // spot: its axis; distant: towards the light; world space, unit
  // A spot is full up to the angle to `direction` with the first cosine, and dark from that with
  // the second one.
  float cos_full = 1, cos_dark = 0;
  SpotCurve curve = SpotCurve::kSmoothStep;
  std::optional<LightForm> form = {};  // shaped
};

// A part of the film, as fractions of its width from the left and its height from the top.
struct CropFractions {
  float left = 0, right = 1, top = 0, bottom = 1;
};

// The file's settings of the rendering; flags of the command line override them.
struct RenderSettings {
  std::optional<int> width, height, samples_per_pixel, max_depth;
  std::optional<std::string> integrator, strategy;  // as the command line names them
  // Photons: whether each sample of a pixel is a pass with its own; radius of the first pass.
  bool photons_each_sample = false;
  std::optional<float> photon_distance;
  std::optional<PixelFilter> filter;
  std::optional<float> filter_radius;  // [pixels]
  std::optional<CropFractions> crop;   // the part that is rendered
  // The largest channel and the largest luminance of a sample of a pixel [scene radiance].
  std::optional<float> largest_of_sample, luminance_of_sample;
};

struct Bounds {
  glm::vec3 low, high;
};

struct Scene {
  // The place of the file's world that is (0, 0, 0) here, because floats are coarse far from there.
  // What users see or give has the coordinates of the file.
  glm::dvec3 origin{0.0};
  std::vector<Mesh> meshes;
  std::vector<Object> objects;
  std::vector<Instance> instances;
  std::vector<std::string> nodes;  // names of what stands instances in the world
  std::vector<Material> materials;
  std::vector<MeasuredBrdf> measured;
  std::vector<Texture> textures;
  // Those of textures and lights: linear RGB, or numbers as they are.
  std::vector<CompactImage> images;
  std::optional<Camera> camera;
  std::vector<NamedCamera> cameras;  // all those of a file that names them, the one above first
  std::vector<AnimationInfo> animations;
  // What else there is to choose from in the file: its scenes, and the variants of its materials.
  std::vector<std::string> scenes, variants;
  std::vector<EnvironmentLight> environments;
  std::vector<PunctualLight> lights;
  // Openings through which light from infinitely far away comes in. They decide where samples are
  // taken, not what is seen.
  std::vector<Portal> portals;
  RenderSettings settings;
  // True if the world's axes are left-handed (pbrt's are). A map given on the command line is laid
  // the other way round then, so that it is never seen mirrored.
  bool left_handed = false;
  char up_axis = 'y';  // 'x', 'y' or 'z': up of --env and of automatic framing
  // Of an animated scene at its frame 0, if it is another frame that was read. They place what must
  // not move with it: a ground, and a camera that the file does not have.
  std::optional<Bounds> first_bounds;
  std::vector<std::string> warnings;  // "file:line: what is not supported and what happens instead"
  std::vector<std::string> notes;     // "file:line: what has no effect on the picture"
};

// Return whether some material is a catcher, or a holdout.
bool HasCatchers(const Scene& scene);
bool HasHoldouts(const Scene& scene);

// Returns where a place of the file's world is in the scene, and a box of the scene in that world.
glm::vec3 PlaceInScene(const Scene& scene, const glm::dvec3& in_world);
Bounds BoundsInWorld(const Scene& scene, const Bounds& box);

// Returns the box around `box` after the affine `to`.
Bounds TransformBounds(const glm::dmat4x3& to, const Bounds& box);
// Returns the boxes around the instances, each of them that of its object's box. Those of objects
// without a triangle are left out.
std::vector<Bounds> InstanceBounds(const Scene& scene);
// Whether nothing is inside, as of a scene without a triangle.
bool IsEmpty(const Bounds& bounds);
// Returns the smallest axis-aligned box around all meshes and InstanceBounds, which may be empty.
Bounds TriangleBounds(const Scene& scene);
// Returns TriangleBounds. Where there is no
// triangle, a file that has an infinite light gets a box around the origin, and another one
// InputError(path).
Bounds SceneBounds(const Scene& scene, const std::string& path);

// Returns a camera at `eye` that sees `target` in its centre and `up` (any length, not along the
// view) above.
Camera LookAtCamera(const glm::vec3& eye, const glm::vec3& target, const glm::vec3& up,
                    float fov_degrees, bool left_handed);

// Returns a camera that sees all of `bounds` in a three-quarter view, from the right of the front
// and a little above, with `up_axis` up, on a film of that `aspect` (width / height). A model
// that is flat along an axis of the world is not seen edge-on.
Camera FrameBounds(const Bounds& bounds, char up_axis, bool left_handed, float aspect = 1);

// Returns a camera of another kind at the same place. A perspective camera that becomes
// orthographic shows as much as before at the distance of the middle of `bounds`; one that becomes
// spherical stands upright; one that becomes a fisheye keeps its direction and sees half of all.
Camera WithKind(const Camera& camera, CameraKind kind, const Bounds& bounds, char up_axis,
                bool left_handed);

// Returns world_from_map for a map given on the command line: its middle is turned
// `rotation_degrees` counter-clockwise about the up axis (seen from above) away from -z (y up), +y
// (z up) or +y (x up); in a left-handed world away from +z, -y or -y. So it is never seen mirrored.
glm::mat3 EnvironmentFrame(char up_axis, bool left_handed, float rotation_degrees);
// Returns the rotation of EnvironmentFrame alone, which turns a light about the up axis.
glm::mat3 EnvironmentTurn(char up_axis, bool left_handed, float rotation_degrees);

}  // namespace skywave
