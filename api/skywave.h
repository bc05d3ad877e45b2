// Skywave as a library: a scene from a file or from arrays, rendered by the same options, to the
// same bits, as by the command line. This is the only public header; link with skywave::skywave.
//
//   skywave::api::Scene scene("model.glb");
//   skywave::api::Renderer renderer(scene, {{"env", "sky.hdr"}, {"spp", 64}});
//   renderer.Render();
//   std::vector<float> rgb(3 * renderer.width() * renderer.height());
//   renderer.CopyPicture(rgb);
//
// Every function reports bad input by throwing Error; a scene or renderer that threw is as it was
// before, except that a Render which throws leaves no picture. Arrays are copied and need not
// outlive a call. An object may be used by one thread at a time, different objects by different
// threads. An object that was moved from may only be assigned to or destroyed.
#pragma once

#include <array>
#include <concepts>
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

// Returns the versions of the library and of Embree, for example "0.1.0 (Embree 3.13.5)".
SKYWAVE_API std::string Version();

// This is thrown for input that cannot be used.
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
  // Returns where the error is: a file with line or byte ("scene.pbrt:12", "sky.hdr (byte 345)"),
  // options ("light-samples 4 split 2") or an argument ("triangles").
  const std::string& place() const { return place_; }

 private:
  Kind kind_;
  std::string place_;
};

// This is thrown when a progress callback has asked to stop.
class SKYWAVE_API Canceled : public std::runtime_error {
 public:
  Canceled();
};

// The value of an option: text as on the command line, or a number or truth value.
class SKYWAVE_API OptionValue {
 public:
  OptionValue(std::string text) : text_(std::move(text)) {}
  OptionValue(const char* text) : text_(text) {}
  OptionValue(bool value);
  OptionValue(float value);
  OptionValue(double value);
  template <std::integral Number>
  OptionValue(Number value) : text_(std::to_string(value)) {}
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

// Names and values of options, as on the command line but without dashes: {"spp", 64},
// {"guide", true}, {"size", "640x480"}. The last value of a name counts. docs/options.md lists the
// options.
using Options = std::vector<std::pair<std::string, OptionValue>>;

// A picture in memory: linear RGB, three floats per pixel, rows from the top, no padding.
struct ImageArray {
  std::span<const float> rgb;  // width * height * 3
  int width = 0, height = 0;
};

// A picture that owns its memory.
struct Image {
  int width = 0, height = 0;
  std::vector<float> rgb;
  operator ImageArray() const { return {rgb, width, height}; }
};

// Reads OpenEXR, Radiance HDR or PFM. Values are unchanged, NaN and negative ones included.
SKYWAVE_API Image ReadImage(const std::string& path);

// A triangle mesh. Right-handed world space; faces are counter-clockwise seen from outside.
struct MeshArrays {
  std::span<const float> positions;          // three per vertex
  std::span<const std::uint32_t> triangles;  // three indices of vertices per triangle
  // Three per vertex, of any length but 0. Without normals, shading is flat.
  std::span<const float> normals = {};
  // Two per vertex, or none. (0, 0) is the top left of an image.
  std::span<const float> uvs = {};
  // Linear RGB per vertex, or none: factors of the reflectance.
  std::span<const float> colors = {};
  // One in [0, 1] per vertex, or none: factors of the opacity.
  std::span<const float> alphas = {};
  int material = 0;       // see Scene::AddMaterial
  std::string name = {};  // appears in errors
  int object = -1;        // see Scene::AddObject; -1: the mesh stands in the world
};

// Points that are seen as spheres, and lines between them as tubes.
struct PointArrays {
  std::span<const float> positions;           // three per point
  float diameter;                             // of spheres and tubes
  std::span<const std::uint32_t> lines = {};  // two indices of points per line; none: points alone
  std::span<const float> colors = {};         // as in MeshArrays
  std::span<const float> alphas = {};
  int material = 0;
  std::string name = {};
  int object = -1;
};

// A texture is used for one of these. Normals are those of a tangent-space map, whose values in
// [0, 1] stand for [-1, 1].
enum class TextureUse { kColor, kOpacity, kNormals, kHeights };

// A parameter of a material: one number, or three of a colour; a colour may be given as one number.
struct MaterialParameter {
  std::string name;
  std::vector<float> values;
};

// A world direction, position or colour.
using Vector = std::array<float, 3>;

// A callback is called about ten times a second with the share that is done, in [0, 1], by the
// thread that called the library. Rendering stops with Canceled if it returns false, and with its
// exception if it throws.
using ProgressCallback = std::function<bool(double done)>;

// What happens while a picture is rendered.
struct RenderControl {
  ProgressCallback progress = {};
  // A file that keeps what has been rendered if Render ends early, and, if `checkpoint_seconds` is
  // not 0, as often as that. It stays until the caller removes it. Empty: there is none.
  std::string checkpoint = {};
  double checkpoint_seconds = 0;
  bool resume = false;  // go on from that file, if it exists, to the same bytes
  // Called as often as `progress`. If it returns the name of an EXR, the current picture is written
  // there, and to a PNG of the same name. If that fails, notes() says so after Render.
  std::function<std::string()> snapshot = {};
  // "HOST:PORT" of the viewer tev, which shows tiles and layers as they are finished, and in the
  // end the picture. If it cannot be reached, notes() says so after Render. Empty: nothing is
  // shown.
  std::string viewer = {};
  std::string name_in_viewer = "skywave";
  // If false, film rows are released once they are resolved, and WriteFilm fails. With all layers
  // this halves the memory.
  bool keep_film = true;
};

// What the objects of the library hold.
struct SceneState;
struct RendererState;

// Triangles, materials, textures, lights and a camera. A copy costs little: copies share their
// contents, and what renderers have made of them, until one is changed. Material 0 always exists;
// that of an empty scene is grey and diffuse.
class SKYWAVE_API Scene {
 public:
  // Makes an empty scene with y up. It needs a mesh before it can be rendered.
  Scene();
  // Reads a pbrt, OBJ, glTF or PLY file, or makes a built-in scene ("gallery"). `options` are those
  // of reading (OptionsOfReading). Meshes and lights can be added to it.
  explicit Scene(const std::string& path, const Options& options = {});
  Scene(const Scene&);
  Scene(Scene&&) noexcept;
  Scene& operator=(const Scene&);
  Scene& operator=(Scene&&) noexcept;
  ~Scene();

  // Returns the number by which materials refer to the texture, which repeats outside of [0, 1].
  // Colours are linear; all values have to be finite.
  int AddTexture(const ImageArray& image, TextureUse use = TextureUse::kColor);

  // Returns the number by which meshes refer to the material. docs/design/bsdfs.md has the names of
  // BSDFs ("lambert", "conductor", "dielectric", ...). Parameters have the names that `skywave info
  // --json` prints ("reflectance", "alpha", "ior", "emission", "opacity", "color_texture", ...).
  // The error about an unknown name lists those that exist.
  int AddMaterial(const std::string& bsdf, const std::vector<MaterialParameter>& parameters,
                  const std::string& name = {});

  void AddMesh(const MeshArrays& mesh);
  // Adds a sphere for each point, and a tube for each line.
  void AddPoints(const PointArrays& points);

  // Adds an empty object and returns its number. Its meshes are added by AddMesh, in a space of the
  // object's own; they are seen where it has instances.
  int AddObject(const std::string& name = "");
  // Adds instances of the object, 12 numbers each: the rows of the 3 x 4 matrix that takes its
  // space to the world. They share its triangles if copies would take much more memory.
  void AddInstances(int object, std::span<const float> matrices);

  // Adds a point light of `intensity` [W/sr].
  void AddPointLight(const Vector& position, const Vector& intensity);
  // Adds a spot of `intensity` [W/sr] that is full up to `full_degrees` from its axis and dark from
  // `dark_degrees` on; 0 <= full_degrees <= dark_degrees <= 180.
  void AddSpotLight(const Vector& position, const Vector& axis, const Vector& intensity,
                    float full_degrees, float dark_degrees);
  // Adds a light infinitely far away in `direction` (towards the light), which gives surfaces that
  // face it `irradiance` [W/m^2].
  void AddDistantLight(const Vector& direction, const Vector& irradiance);

  // Sets the illumination map, as the option "env" does by the name of a file; if that is given
  // too, the file is taken. The options "env-rotate", "env-intensity", "env-up" and
  // "env-projection" apply to both. NaN and negative values become 0, infinite ones the largest
  // finite value, and Renderer::notes says so.
  void SetEnvironment(const ImageArray& map);

  // Sets a camera that looks from `eye` to `target`; `fov_degrees` is the field of view along the
  // shorter side of the picture.
  void SetCamera(const Vector& eye, const Vector& target, const Vector& up, float fov_degrees);
  // Sets a camera with the matrix `k` of OpenCV, row by row [pixels], whose pixels have their
  // centres at whole numbers, and a pose whose columns are the camera's x (right), y (down), z
  // (forward) and its place, rows one after the other. Its pictures have `width` x `height` pixels:
  // the option "size" has to have that shape.
  void SetCamera(const std::array<double, 9>& k, const std::array<double, 16>& world_from_camera,
                 int width, int height);
  // Sets the axis that is up ('x', 'y' or 'z') for the map and for a camera that is placed
  // automatically.
  void SetUp(char axis);

  // Returns the number of triangles.
  std::size_t triangles() const;  // those of an object once

 private:
  friend class Renderer;
  friend SKYWAVE_API std::string Converge(const Scene&, const Options&, const ProgressCallback&);
  std::unique_ptr<SceneState> state_;
};

// A layer in addition to the picture, which the option "aovs" asks for.
struct Layer {
  std::string name;      // "albedo"; with the name of the group for layers of light groups
  std::string channels;  // one letter each, "RGB" or "Z"
};

// One picture of a scene.
class SKYWAVE_API Renderer {
 public:
  // Reads the map and builds the BVH and tables, unless another renderer of the scene, which may be
  // gone, has done so: another camera, map, strategy or size builds nothing again. A later change
  // of the scene makes no difference. `options` are those of `skywave render`, except for those
  // that a Scene takes, and for output, stats and quiet.
  Renderer(const Scene& scene, const Options& options);
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;
  ~Renderer();

  int width() const;  // of the picture, or of its part that "crop" asks for [pixels]
  int height() const;
  std::uint64_t samples() const;  // of the whole picture
  // Returns one line for each thing that is not rendered as the scene asks.
  const std::vector<std::string>& warnings() const;
  // Returns one line for each thing that was assumed or repaired.
  const std::vector<std::string>& notes() const;

  // Renders the picture with the number of threads that the option "threads" gives.
  void Render(const RenderControl& control = {});
  template <std::invocable<double> Callback>
  void Render(Callback&& progress) {
    Render(RenderControl{.progress = std::forward<Callback>(progress)});
  }

  // All of the following need a complete Render.

  // Returns the layers that the option "aovs" asked for, and for a picture with alpha (the options
  // "catcher" and "background") those of catchers and "alpha", by which its colours are multiplied.
  const std::vector<Layer>& layers() const;
  // Writes the picture to `rgb`, width() * height() * 3 floats like an ImageArray.
  void CopyPicture(std::span<float> rgb) const;
  // Writes the layer with that name, with as many floats per pixel as it has channels.
  void CopyLayer(const std::string& name, std::span<float> values) const;
  // Returns the names of meshes, or of materials, by their numbers from 0 on: those of the layers
  // "object-id" and "material-id" count from 1. One without a name is "mesh N" or "material N". Of
  // a picture without layers of numbers or mattes there are none.
  std::vector<std::string> ObjectNames() const;
  std::vector<std::string> MaterialNames() const;
  // Returns times, rays and stages as `skywave render --stats` writes them, in JSON.
  std::string Statistics() const;
  // Returns the same as lines for people.
  std::string Summary() const;
  // Writes the picture and its layers, with the command that repeats them if the scene was not
  // changed after it had been read. A file that exists is replaced.
  void WriteExr(const std::string& path) const;
  // Writes the sums of the film, to be added to those of other parts of the same picture by
  // `skywave merge`. A file that exists is replaced.
  void WriteFilm(const std::string& path) const;
  // Writes 8-bit sRGB, exposed and tone-mapped as the options say.
  void WritePng(const std::string& path) const;
  // Writes the EXR `path` and the PNG of that name. If either cannot be written, both remain what
  // they were; the one exception is a folder that lets the PNG be replaced but not the EXR (because
  // it is immutable, or another user's in a sticky folder): then the new PNG is beside the old EXR.
  void WriteExrAndPng(const std::string& path) const;
  // Returns the bytes that WritePng writes.
  std::string EncodePng() const;

 private:
  std::unique_ptr<RendererState> state_;
};

// Returns the names of the options that Scene takes; Renderer takes all others.
SKYWAVE_API std::vector<std::string> OptionsOfReading();

// Returns the bytes of a PNG, 8-bit sRGB. Radiance is multiplied by 2^exposure; `tone` is a value
// of the option "tone".
SKYWAVE_API std::string EncodePng(const ImageArray& image, float exposure = 0,
                                  const std::string& tone = "clip");

// Returns what `skywave compare --json` writes about two pictures of the same size.
SKYWAVE_API std::string Compare(const ImageArray& image, const ImageArray& reference);

// Returns what `skywave converge --json` writes. `options` are those of `skywave converge`, for
// example {"strategies", "importance product"} and {"budgets", "1,4,16"}, except for those of
// reading, which a Scene takes, and for json, plot, report, exposure and quiet. If the reference is
// rendered, the callback sees its share from 0 to 1 first, and then that of the measurement. Making
// tables and warming up come before and are not interrupted.
SKYWAVE_API std::string Converge(const Scene& scene, const Options& options,
                                 const ProgressCallback& progress = {});

// Returns what `skywave probe info --json` writes about a map. `projection` is a value of the
// option "env-projection"; if it is empty, it follows from the shape of the map.
SKYWAVE_API std::string DescribeMap(const ImageArray& map, const std::string& projection = {});

}  // namespace skywave::api
