// The extension module skywave._core: what skywave/skywave.h declares, for the Python package
// beside it, whose functions have checked and converted the arguments. Nothing here is meant for
// users.
#include <algorithm>
#include <array>
#include <concepts>
#include <exception>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "binding.h"
#include "skywave/skywave.h"

namespace {

namespace api = skywave::api;

// Texts of the package are bytes. Those of the library that are no UTF-8, as names of files may
// have, survive as Python's own functions keep them.
std::string StringOf(const py::bytes& text) {
  char* data = nullptr;
  Py_ssize_t size = 0;
  if (PyBytes_AsStringAndSize(text.ptr(), &data, &size) != 0) throw PythonError();
  return {data, std::size_t(size)};
}
py::str Text(const std::string& text) {
  PyObject* object = PyUnicode_DecodeUTF8(text.data(), Py_ssize_t(text.size()), "surrogateescape");
  if (object == nullptr) throw PythonError();
  return Steal<py::str>(object);
}
py::bytes Bytes(const std::string& bytes) { return py::bytes(bytes.data(), bytes.size()); }
py::list TextList(const std::vector<std::string>& lines) {
  py::list list;
  for (const std::string& line : lines) list.append(Text(line));
  return list;
}

// Calls `function` without Python's lock, so that other threads run meanwhile.
template <class Function>
auto Unlocked(Function function) {
  const py::gil_scoped_release release;
  return function();
}

// An object of the library that several threads of Python may hold. They take turns.
template <class Object>
class Shared {
 public:
  template <class... Arguments>
  requires std::constructible_from<Object, Arguments...>
  explicit Shared(Arguments&&... arguments) : object_(std::forward<Arguments>(arguments)...) {}

  template <class Function>
  auto Use(Function function) {
    return Unlocked([&] {
      const std::lock_guard lock(mutex_);
      return function(object_);
    });
  }

 private:
  Object object_;
  std::mutex mutex_;
};
using Scene = Shared<api::Scene>;
using Renderer = Shared<api::Renderer>;

// Options as the package hands them over.
using OptionTexts = std::vector<std::pair<py::bytes, py::bytes>>;

api::Options OptionsOf(const OptionTexts& texts) {
  api::Options options;
  for (const auto& [name, value] : texts) options.emplace_back(StringOf(name), StringOf(value));
  return options;
}

template <class Number>
std::span<const Number> SpanOf(const Array<Number>& array) {
  return {array.data(), std::size_t(array.size())};
}

std::span<float> SpanOf(FloatArray& array) { return {DataOf(array), std::size_t(array.size())}; }

template <class Number>
std::span<const Number> SpanOf(const std::optional<Array<Number>>& array) {
  return array ? SpanOf(*array) : std::span<const Number>();
}

api::ImageArray ImageOf(const Array<float>& array) {
  if (array.ndim() != 3 || array.shape(2) != 3) {
    throw py::value_error("the shape of an image is (height, width, 3)");
  }
  return {SpanOf(array), int(array.shape(1)), int(array.shape(0))};
}

FloatArray NewArray(int height, int width, int channels) {
  const std::array shape = {std::size_t(height), std::size_t(width), std::size_t(channels)};
  return NewFloatArray(channels == 1 ? 2 : 3, shape.data());
}

FloatArray ReadImage(const py::bytes& path) {
  const std::string name = StringOf(path);
  const api::Image image = Unlocked([&] { return api::ReadImage(name); });
  FloatArray array = NewArray(image.height, image.width, 3);
  std::copy(image.rgb.begin(), image.rgb.end(), DataOf(array));
  return array;
}

// Calls the user's function, if there is one, and lets Ctrl-C through. Exceptions of Python pass
// through the library and end the render.
api::ProgressCallback CallbackOf(const py::object& progress) {
  return [&progress](double done) {
    const py::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw PythonError();
    return progress.is_none() || !progress(done).is(py::bool_(false));
  };
}

const char* NameOf(api::Error::Kind kind) {
  switch (kind) {
    case api::Error::Kind::kUsage:
      return "usage";
    case api::Error::Kind::kBadInput:
      return "bad-input";
    case api::Error::Kind::kIo:
      return "io";
  }
  return "";
}

void TranslateException(const std::exception_ptr& exception) {
  try {
    if (exception) std::rethrow_exception(exception);
  } catch (const api::Error& error) {
    try {
      std::rethrow_if_nested(error);
    } catch (const std::bad_alloc&) {
      PyErr_NoMemory();
      return;
    } catch (...) {  // the cause of bad input, which the error names
    }
    const py::object object =
        Import("skywave._errors")
            .attr("make_error")(Text(error.what()), NameOf(error.kind()), Text(error.place()));
    PyErr_SetObject(object.attr("__class__").ptr(), object.ptr());
  } catch (const api::Canceled& canceled) {
    const py::object type = Import("skywave._errors").attr("Canceled");
    PyErr_SetString(type.ptr(), canceled.what());
  }
}

void AddScene(py::module_& module) {
  using Numbers = std::vector<std::pair<py::bytes, std::vector<float>>>;
  py::class_<Scene>(module, "Scene")
      .def(Constructor([] { return std::make_unique<Scene>(); }))
      .def(Constructor([](const py::bytes& path, const OptionTexts& texts) {
        const std::string name = StringOf(path);
        const api::Options options = OptionsOf(texts);
        return Unlocked([&] { return std::make_unique<Scene>(name, options); });
      }))
      .def("copy",
           [](Scene& scene) {
             return scene.Use(
                 [](api::Scene& s) { return std::make_unique<Scene>(std::as_const(s)); });
           })
      .def("triangles",
           [](Scene& scene) { return scene.Use([](api::Scene& s) { return s.triangles(); }); })
      .def(
          "add_mesh",
          [](Scene& scene, const Array<float>& vertices, const Array<std::uint32_t>& faces,
             const std::optional<Array<float>>& normals, const std::optional<Array<float>>& uvs,
             const std::optional<Array<float>>& colors, const std::optional<Array<float>>& alphas,
             int material, const py::bytes& name, int object) {
            const api::MeshArrays mesh = {.positions = SpanOf(vertices),
                                          .triangles = SpanOf(faces),
                                          .normals = SpanOf(normals),
                                          .uvs = SpanOf(uvs),
                                          .colors = SpanOf(colors),
                                          .alphas = SpanOf(alphas),
                                          .material = material,
                                          .name = StringOf(name),
                                          .object = object};
            scene.Use([&](api::Scene& s) { s.AddMesh(mesh); });
          },
          py::arg("vertices").noconvert(), py::arg("faces").noconvert(),
          py::arg("normals").noconvert(), py::arg("uvs").noconvert(), py::arg("colors").noconvert(),
          py::arg("alphas").noconvert(), py::arg("material"), py::arg("name"), py::arg("object"))
      .def(
          "add_points",
          [](Scene& scene, const Array<float>& points, float size,
             const std::optional<Array<std::uint32_t>>& lines,
             const std::optional<Array<float>>& colors, const std::optional<Array<float>>& alphas,
             int material, const py::bytes& name, int object) {
            const api::PointArrays arrays = {.positions = SpanOf(points),
                                             .diameter = size,
                                             .lines = SpanOf(lines),
                                             .colors = SpanOf(colors),
                                             .alphas = SpanOf(alphas),
                                             .material = material,
                                             .name = StringOf(name),
                                             .object = object};
            scene.Use([&](api::Scene& s) { s.AddPoints(arrays); });
          },
          py::arg("points").noconvert(), py::arg("size"), py::arg("lines").noconvert(),
          py::arg("colors").noconvert(), py::arg("alphas").noconvert(), py::arg("material"),
          py::arg("name"), py::arg("object"))
      .def("add_object",
           [](Scene& scene, const py::bytes& text) {
             const std::string name = StringOf(text);
             return scene.Use([&](api::Scene& s) { return s.AddObject(name); });
           })
      .def(
          "add_instances",
          [](Scene& scene, int object, const Array<float>& matrices) {
            scene.Use([&](api::Scene& s) { s.AddInstances(object, SpanOf(matrices)); });
          },
          py::arg("object"), py::arg("matrices").noconvert())
      .def(
          "add_texture",
          [](Scene& scene, const Array<float>& image, api::TextureUse use) {
            const api::ImageArray array = ImageOf(image);
            return scene.Use([&](api::Scene& s) { return s.AddTexture(array, use); });
          },
          py::arg("image").noconvert(), py::arg("use"))
      .def("add_material",
           [](Scene& scene, const py::bytes& kind, const Numbers& numbers, const py::bytes& text) {
             const std::string bsdf = StringOf(kind), name = StringOf(text);
             std::vector<api::MaterialParameter> parameters;
             for (const auto& [key, values] : numbers) {
               parameters.push_back({StringOf(key), values});
             }
             return scene.Use([&](api::Scene& s) { return s.AddMaterial(bsdf, parameters, name); });
           })
      .def("add_point_light",
           [](Scene& scene, const api::Vector& position, const api::Vector& intensity) {
             scene.Use([&](api::Scene& s) { s.AddPointLight(position, intensity); });
           })
      .def("add_spot_light",
           [](Scene& scene, const api::Vector& position, const api::Vector& axis,
              const api::Vector& intensity, float full_degrees, float dark_degrees) {
             scene.Use([&](api::Scene& s) {
               s.AddSpotLight(position, axis, intensity, full_degrees, dark_degrees);
             });
           })
      .def("add_distant_light",
           [](Scene& scene, const api::Vector& direction, const api::Vector& irradiance) {
             scene.Use([&](api::Scene& s) { s.AddDistantLight(direction, irradiance); });
           })
      .def(
          "set_environment",
          [](Scene& scene, const Array<float>& map) {
            const api::ImageArray array = ImageOf(map);
            scene.Use([&](api::Scene& s) { s.SetEnvironment(array); });
          },
          py::arg("map").noconvert())
      .def("set_camera",
           [](Scene& scene, const api::Vector& eye, const api::Vector& target,
              const api::Vector& up, float fov_degrees) {
             scene.Use([&](api::Scene& s) { s.SetCamera(eye, target, up, fov_degrees); });
           })
      .def("set_camera_matrix",
           [](Scene& scene, const std::array<double, 9>& k,
              const std::array<double, 16>& world_from_camera, int width, int height) {
             scene.Use([&](api::Scene& s) { s.SetCamera(k, world_from_camera, width, height); });
           })
      .def("set_up",
           [](Scene& scene, char axis) { scene.Use([&](api::Scene& s) { s.SetUp(axis); }); });
}

void AddRenderer(py::module_& module) {
  py::class_<Renderer>(module, "Renderer")
      .def(Constructor([](Scene& scene, const OptionTexts& texts) {
        const api::Options options = OptionsOf(texts);
        return scene.Use([&](api::Scene& s) { return std::make_unique<Renderer>(s, options); });
      }))
      .def("width",
           [](Renderer& renderer) {
             return renderer.Use([](api::Renderer& r) { return r.width(); });
           })
      .def("height",
           [](Renderer& renderer) {
             return renderer.Use([](api::Renderer& r) { return r.height(); });
           })
      .def("layers",
           [](Renderer& renderer) {
             py::list layers;
             for (const api::Layer& layer :
                  renderer.Use([](api::Renderer& r) { return r.layers(); })) {
               layers.append(py::make_tuple(Text(layer.name), layer.channels));
             }
             return layers;
           })
      .def("warnings",
           [](Renderer& renderer) {
             return TextList(renderer.Use([](api::Renderer& r) { return r.warnings(); }));
           })
      .def("notes",
           [](Renderer& renderer) {
             return TextList(renderer.Use([](api::Renderer& r) { return r.notes(); }));
           })
      .def(
          "render",
          [](Renderer& renderer, const py::object& progress, const py::bytes& checkpoint,
             double seconds, bool resume) {
            const api::RenderControl control = {.progress = CallbackOf(progress),
                                                .checkpoint = StringOf(checkpoint),
                                                .checkpoint_seconds = seconds,
                                                .resume = resume};
            renderer.Use([&](api::Renderer& r) { r.Render(control); });
          },
          py::arg("progress").none(), py::arg("checkpoint"), py::arg("checkpoint_seconds"),
          py::arg("resume"))
      .def("picture",
           [](Renderer& renderer) {
             const auto [width, height] =
                 renderer.Use([](api::Renderer& r) { return std::pair(r.width(), r.height()); });
             FloatArray rgb = NewArray(height, width, 3);
             const std::span<float> span = SpanOf(rgb);
             renderer.Use([&](api::Renderer& r) { r.CopyPicture(span); });
             return rgb;
           })
      .def("layer",
           [](Renderer& renderer, const std::string& name, int channels) {
             const auto [width, height] =
                 renderer.Use([](api::Renderer& r) { return std::pair(r.width(), r.height()); });
             FloatArray values = NewArray(height, width, channels);
             const std::span<float> span = SpanOf(values);
             renderer.Use([&](api::Renderer& r) { r.CopyLayer(name, span); });
             return values;
           })
      .def("object_names",
           [](Renderer& renderer) {
             return TextList(renderer.Use([](api::Renderer& r) { return r.ObjectNames(); }));
           })
      .def("material_names",
           [](Renderer& renderer) {
             return TextList(renderer.Use([](api::Renderer& r) { return r.MaterialNames(); }));
           })
      .def("statistics",
           [](Renderer& renderer) {
             return Text(renderer.Use([](api::Renderer& r) { return r.Statistics(); }));
           })
      .def("summary",
           [](Renderer& renderer) {
             return Text(renderer.Use([](api::Renderer& r) { return r.Summary(); }));
           })
      .def("write_exr",
           [](Renderer& renderer, const py::bytes& path) {
             const std::string name = StringOf(path);
             renderer.Use([&](api::Renderer& r) { r.WriteExr(name); });
           })
      .def("write_png",
           [](Renderer& renderer, const py::bytes& path) {
             const std::string name = StringOf(path);
             renderer.Use([&](api::Renderer& r) { r.WritePng(name); });
           })
      .def("write_film",
           [](Renderer& renderer, const py::bytes& path) {
             const std::string name = StringOf(path);
             renderer.Use([&](api::Renderer& r) { r.WriteFilm(name); });
           })
      .def("encode_png", [](Renderer& renderer) {
        return Bytes(renderer.Use([](api::Renderer& r) { return r.EncodePng(); }));
      });
}

void AddFunctions(py::module_& module) {
  const auto image = py::arg("image").noconvert();
  module.def("version", [] { return api::Version(); });
  module.def("options_of_reading", &api::OptionsOfReading);
  module.def("read_image", &ReadImage);
  module.def(
      "encode_png",
      [](const Array<float>& array, float exposure, const py::bytes& tone) {
        const api::ImageArray pixels = ImageOf(array);
        const std::string name = StringOf(tone);
        return Bytes(Unlocked([&] { return api::EncodePng(pixels, exposure, name); }));
      },
      image, py::arg("exposure"), py::arg("tone"));
  module.def(
      "compare",
      [](const Array<float>& array, const Array<float>& other) {
        const api::ImageArray pixels = ImageOf(array), reference = ImageOf(other);
        return Text(Unlocked([&] { return api::Compare(pixels, reference); }));
      },
      image, py::arg("reference").noconvert());
  module.def(
      "converge",
      [](Scene& scene, const OptionTexts& texts, const py::object& progress) {
        const api::ProgressCallback callback = CallbackOf(progress);
        const api::Options options = OptionsOf(texts);
        // A copy, so that others may use the scene meanwhile.
        const api::Scene copy = scene.Use([](api::Scene& s) { return s; });
        return Text(Unlocked([&] { return api::Converge(copy, options, callback); }));
      },
      py::arg("scene"), py::arg("options"), py::arg("progress").none());
  module.def(
      "describe_map",
      [](const Array<float>& map, const py::bytes& projection) {
        const api::ImageArray pixels = ImageOf(map);
        const std::string name = StringOf(projection);
        return Text(Unlocked([&] { return api::DescribeMap(pixels, name); }));
      },
      py::arg("map").noconvert(), py::arg("projection"));
}

}  // namespace

SKYWAVE_PYTHON_MODULE(_core, module) {
  RegisterTranslator<TranslateException>();
  py::enum_<api::TextureUse>(module, "TextureUse")
      .value("color", api::TextureUse::kColor)
      .value("opacity", api::TextureUse::kOpacity)
      .value("normals", api::TextureUse::kNormals)
      .value("heights", api::TextureUse::kHeights);
  AddScene(module);
  AddRenderer(module);
  AddFunctions(module);
}
