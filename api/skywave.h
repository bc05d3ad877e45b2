// Skywave as a library: a scene from a file or from arrays, rendered by the same options, to the
// same bits, as by the command line. This is the only public header; link with skywave::skywave.
//
//   skywave::api::Scene scene("model.glb");
//   skywave::api::Renderer renderer(scene, {{"env", "sky.hdr"}, {"spp", "64"}});
//   renderer.Render();
//   std::vector<float> rgb(3 * renderer.width() * renderer.height());
//   renderer.CopyPicture(rgb);
//
// Every function reports bad input by throwing Error; a scene or renderer that threw is as it was
// before. Arrays are copied and need not outlive a call. Objects may be used by one thread at a
// time, different objects by different threads.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#if defined(__GNUC__)
#define SKYWAVE_API __attribute__((visibility("default")))
#else
#define SKYWAVE_API
#endif

namespace skywave::api {

// Returns the version of the library and of Embree, "0.1.0 (Embree 3.13.5)".
SKYWAVE_API std::string Version();

// Input that cannot be used.
class SKYWAVE_API Error : public std::runtime_error {
 public:
  enum class Kind {
    kUsage,     // an option or argument that makes no sense
    kBadInput,  // a file or array that cannot be used
    kIo         // a file that cannot be read or written
  };
  // what() is "place: reason".
  Error(Kind kind, const std::string& place, const std::string& reason);
  Kind kind() const { return kind_; }
  // Returns the file with the line or byte of the error ("scene.pbrt:12", "sky.hdr (byte 345)"),
  // the options ("light-samples 4 split 2") or the argument ("triangles").
  const std::string& place() const { return place_; }

 private:
  Kind kind_;
  std::string place_;
};

// A progress callback has asked to stop.
class SKYWAVE_API Canceled : public std::runtime_error {
 public:
  Canceled();
};

// Names and values of options, as on the command line but without dashes: {"spp", "64"},
// {"guide", "true"}. A later value of the same name counts. docs/options.md lists them.
using Options = std::vector<std::pair<std::string, std::string>>;

// A picture in memory: linear RGB, three floats per pixel, rows from the top, no padding.
struct ImageArray {
  std::span<const float> rgb;  // width * height * 3
  int width = 0, height = 0;
};

// The same with memory of its own.
struct Image {
  int width = 0, height = 0;
  std::vector<float> rgb;
  operator ImageArray() const { return {rgb, width, height}; }
};

// Reads OpenEXR, Radiance HDR or PFM.
SKYWAVE_API Image ReadImage(const std::string& path);

// A triangle mesh. Right-handed world space; faces are counter-clockwise seen from outside.
struct MeshArrays {
  std::span<const float> positions;          // three per vertex
  std::span<const std::uint32_t> triangles;  // three indices of vertices per triangle
  std::span<const float> normals = {};  // none: flat shading; three per vertex, of any length but 0
  std::span<const float> uvs = {};  // none, or two per vertex; (0, 0) is the top left of an image
  std::span<const float> colors = {};  // none, or factors of the reflectance, linear RGB per vertex
  int material = 0;                    // see Scene::AddMaterial
  std::string name = {};               // appears in errors
};

// What the numbers of a texture are. Normals are those of a tangent-space map, [0, 1] for [-1, 1].
enum class TextureUse { kColor, kOpacity, kNormals, kHeights };

// A parameter of a material: one number, or three of a colour; a colour may be given as one number.
struct MaterialParameter {
  std::string name;
  std::vector<float> values;
};

// A world direction, position or colour.
using Vector = std::array<float, 3>;

// Is called about ten times a second by the thread that called, with the share that is done, in [0,
// 1]. Rendering stops with Canceled if it returns false, and with its exception if it throws.
using ProgressCallback = std::function<bool(double done)>;

// Triangles, materials, textures, lights and a camera. Material 0 always exists: grey, diffuse.
class SKYWAVE_API Scene {
 public:
  // Makes an empty scene with y up. It needs a mesh before it can be rendered.
  Scene();
  // Reads a pbrt, OBJ, glTF or PLY file, or makes a built-in scene ("gallery"). `options` are those
  // of reading (strict, max-triangles). Meshes and lights can be added to it.
  explicit Scene(const std::string& path, const Options& options = {});
  Scene(const Scene&);
  Scene(Scene&&) noexcept;
  Scene& operator=(const Scene&);
  Scene& operator=(Scene&&) noexcept;
  ~Scene();

  // Returns the number by which materials refer to the texture; it repeats outside of [0, 1].
  // Colours are linear.
  int AddTexture(const ImageArray& image, TextureUse use = TextureUse::kColor);

  // Returns the number by which meshes refer to the material. `bsdf` is a name of docs/materials,
  // such as "lambert", "conductor" or "dielectric"; parameters are those that `skywave info --json`
  // prints
  // ("reflectance", "alpha", "ior", "emission", "opacity", "color_texture", ...).
  int AddMaterial(const std::string& bsdf, const std::vector<MaterialParameter>& parameters,
                  const std::string& name = {});

  void AddMesh(const MeshArrays& mesh);

  // A point light of `intensity` [W/sr], and a spot that is full up to `full_degrees` from its axis
  // and dark from `dark_degrees` on.
  void AddPointLight(const Vector& position, const Vector& intensity);
  void AddSpotLight(const Vector& position, const Vector& axis, const Vector& intensity,
                    float full_degrees, float dark_degrees);
  // A light from infinitely far away in `direction` (towards the light), which gives `irradiance`
  // to surfaces that face it.
  void AddDistantLight(const Vector& direction, const Vector& irradiance);

  // The illumination map, in place of a file that the option "env" names: it takes part in
  // "env-rotate", "env-intensity", "env-up" and "env-projection" likewise. NaN, infinite and
  // negative values become 0, which Renderer::notes tells.
  void SetEnvironment(const ImageArray& map);

  // Looks from `eye` to `target`; `fov_degrees` is that of the shorter side of the picture.
  void SetCamera(const Vector& eye, const Vector& target, const Vector& up, float fov_degrees);
  // Sets the axis that is up ('x', 'y' or 'z') for the map and for a camera that is placed
  // automatically.
  void SetUp(char axis);

  std::size_t triangles() const;

  struct State;  // not for users
  State& state() { return *state_; }

 private:
  std::unique_ptr<State> state_;
};

// A layer in addition to the picture, as the option "aovs" asks for it.
struct Layer {
  std::string name;      // "albedo"; those of groups of lights have their names in addition
  std::string channels;  // one letter each, "RGB" or "Z"
};

// One picture of a scene.
class SKYWAVE_API Renderer {
 public:
  // Reads the map, builds BVH and tables. A later change of the scene makes no difference; moving
  // it here saves a copy. Besides the options of a render that make its picture, those of its PNG
  // are known: exposure, tone, shutter, f-number, iso.
  Renderer(Scene scene, const Options& options);
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;
  ~Renderer();

  int width() const;  // of the picture, or of its part that "crop" asks for [pixels]
  int height() const;
  // Returns what was assumed, repaired or left out, a line each.
  const std::vector<std::string>& notes() const;

  // Renders the picture with the number of threads that the option "threads" gives.
  void Render(const ProgressCallback& progress = {});

  // The following need a complete Render.

  const std::vector<Layer>& layers() const;
  // Writes the picture to `rgb`, width() * height() * 3 floats like an ImageArray.
  void CopyPicture(std::span<float> rgb) const;
  // Writes the layer with that name, with as many floats per pixel as it has channels.
  void CopyLayer(const std::string& name, std::span<float> values) const;
  // Returns times, rays and stages as `skywave render --stats` writes them, JSON.
  std::string Statistics() const;
  // Returns the same for people, in lines.
  std::string Summary() const;
  // Writes picture and layers and, for a scene that was not changed after it had been read, the
  // command that repeats them.
  void WriteExr(const std::string& path) const;
  void WritePng(const std::string& path) const;
  // Returns the bytes that WritePng writes.
  std::string EncodePng() const;

  struct State;  // not for users

 private:
  std::unique_ptr<State> state_;
};

// Returns the bytes of a PNG, 8-bit sRGB: radiance is multiplied by 2^exposure; `tone` is a curve
// of the option "tone".
SKYWAVE_API std::string EncodePng(const ImageArray& image, float exposure = 0,
                                  const std::string& tone = "clip");

// Returns the measures of `skywave compare --json` of two pictures of the same size.
SKYWAVE_API std::string Compare(const ImageArray& image, const ImageArray& reference);

// Returns what `skywave converge --json` writes. `options` are those of render and of converge
// ({"strategies", "importance product"}, {"budgets", "1,4,16"}). The callback sees the reference
// from 0 to 1 first, and then the measurement.
SKYWAVE_API std::string Converge(Scene scene, const Options& options,
                                 const ProgressCallback& progress = {});

// Returns what `skywave probe info --json` writes of a map; `projection` as "env-projection" has
// it, empty: by its shape.
SKYWAVE_API std::string DescribeMap(const ImageArray& map, const std::string& projection = {});

}  // namespace skywave::api
