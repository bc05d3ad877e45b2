#include "job/camera_file.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/files.h"
#include "base/json.h"
#include "base/nearest_name.h"

namespace skywave {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kLongestSide = 65536;  // [pixels]

// The pinhole of a camera [pixels]: focal lengths, and the point on its axis from the top left
// corner of the picture.
struct Pinhole {
  double focal_x = 0, focal_y = 0, center_x = 0, center_y = 0;
  double width = 0, height = 0;  // as the file has them, which may be no whole numbers
};

// Where a camera stands and looks, in the world.
struct Pose {
  glm::dvec3 right, up, forward, eye;
};

// A camera of a file as it stands there, before it is needed.
struct Entry {
  std::string name;
  InputPosition position;
  Pinhole pinhole;
  Pose pose;
  std::string distortion;  // what of its lens is no pinhole, "k1 = 0.1"; empty: nothing
};

bool IsFinite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Returns a camera that shows what the pinhole does: its film is the plane at a distance of 1.
Camera CameraOf(const Entry& entry) {
  const Pinhole& p = entry.pinhole;
  const auto refuse = [&](const std::string& why) {
    throw InputError(entry.position, (entry.name.empty() ? "the camera" : entry.name) + " " + why);
  };
  if (!(p.focal_x > 0) || !(p.focal_y > 0) || !std::isfinite(p.focal_x + p.focal_y) ||
      !std::isfinite(p.center_x + p.center_y)) {
    refuse("has no focal length above 0, or no principal point");
  }
  const auto is_side = [](double side) {
    return side >= 1 && side <= kLongestSide && side == std::floor(side);
  };
  if (!is_side(p.width) || !is_side(p.height)) {
    refuse(fmt::format("has a picture of {} by {}, which has to be whole numbers in [1, {}]",
                       p.width, p.height, kLongestSide));
  }
  const Pose& pose = entry.pose;
  const double volume = glm::dot(glm::cross(pose.right, pose.up), pose.forward);
  const double sides = glm::length(pose.right) * glm::length(pose.up) * glm::length(pose.forward);
  if (!IsFinite(pose.eye) || !std::isfinite(sides) || !(std::abs(volume) > 0.99 * sides)) {
    refuse("has a pose whose axes are not at right angles");
  }
  Camera camera;
  constexpr float kDegreesOfDistance = 90;  // the screen window is in units of tan(fov / 2) = 1
  camera.fov_degrees = kDegreesOfDistance;
  camera.world_from_camera =
      glm::mat4(glm::vec4(glm::normalize(pose.right), 0), glm::vec4(glm::normalize(pose.up), 0),
                glm::vec4(glm::normalize(pose.forward), 0), glm::vec4(pose.eye, 1));
  // A film of the photograph's shape shows just what that does; another one shows more.
  camera.film_width = int(p.width), camera.film_height = int(p.height);
  camera.window = ScreenWindow{.left = float(-p.center_x / p.focal_x),
                               .right = float((p.width - p.center_x) / p.focal_x),
                               .bottom = float((p.center_y - p.height) / p.focal_y),
                               .top = float(p.center_y / p.focal_y)};
  return camera;
}

// Axes of OpenCV and COLMAP: x right, y down, z forward; rows of the rotation are these axes.
Pose PoseOfCv(const glm::dmat3& world_to_camera_rows, const glm::dvec3& translation) {
  const glm::dmat3& r = world_to_camera_rows;  // r[i] is row i
  return {.right = r[0],
          .up = -r[1],
          .forward = r[2],
          .eye = -(translation.x * r[0] + translation.y * r[1] + translation.z * r[2])};
}

// Returns the pinhole of a matrix K of OpenCV, whose pixels have their centres at whole numbers.
template <class Matrix>
Pinhole PinholeOfMatrix(const InputPosition& position, const Matrix& k, double width,
                        double height) {
  constexpr double kCenterOfPixel = 0.5;
  if (k[1][0] != 0 || k[2][0] != 0 || k[2][1] != 0 || k[2][2] != 1) {
    throw InputError(position, "K is no matrix of a camera, [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]");
  }
  return {.focal_x = k[0][0],
          .focal_y = k[1][1],
          .center_x = k[0][2] + kCenterOfPixel,
          .center_y = k[1][2] + kCenterOfPixel,
          .width = width,
          .height = height};
}

// ---- JSON ----

double Number(const Json& json, const char* name, double other) {
  const auto found = json.find(name);
  return found == json.end() ? other : found->get<double>();
}

template <std::size_t Rows, std::size_t Columns>
std::array<std::array<double, Columns>, Rows> Matrix(const Json& json, const char* name) {
  std::array<std::array<double, Columns>, Rows> matrix;
  const Json& rows = json.at(name);
  for (std::size_t row = 0; row < Rows; ++row) {
    for (std::size_t column = 0; column < Columns; ++column) {
      matrix[row][column] = rows.at(row).at(column).get<double>();
    }
  }
  return matrix;
}

// Returns "k1 = 0.1, p2 = 0.01" of the coefficients that are not 0, and the name of a model that
// is no pinhole with all of them 0.
std::string DistortionOf(const Json& json) {
  const std::string model = json.value("camera_model", "");
  const auto flag = json.find("is_fisheye");
  const bool is_flagged =
      flag != json.end() && (flag->is_boolean() ? flag->get<bool>() : *flag != 0);
  std::string text;
  if (model.find("FISHEYE") != std::string::npos || model == "EQUIRECTANGULAR") {
    text = model;
  } else if (is_flagged) {
    text = "is_fisheye";
  }
  for (const char* const name : {"k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2"}) {
    const double value = Number(json, name, 0);
    if (value != 0) text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", name, value);
  }
  return text;
}

// A frame of transforms.json (Instant-NGP): what it does not say, the file says for all. Poses go
// from the camera to the world, with the axes of OpenGL: x right, y up, z backward.
Entry EntryOfFrame(const std::string& path, const Json& file, const Json& frame, int width,
                   int height) {
  Json all = file;
  all.erase("frames");
  all.update(frame);
  Pinhole pinhole = {.width = Number(all, "w", width), .height = Number(all, "h", height)};
  const double w = pinhole.width, h = pinhole.height;
  if (all.contains("fl_x")) {
    pinhole.focal_x = Number(all, "fl_x", 0);
    pinhole.focal_y = Number(all, "fl_y", pinhole.focal_x);
  } else {
    pinhole.focal_x = w / 2 / std::tan(all.at("camera_angle_x").get<double>() / 2);
    pinhole.focal_y = all.contains("camera_angle_y")
                          ? h / 2 / std::tan(all.at("camera_angle_y").get<double>() / 2)
                          : pinhole.focal_x;
  }
  pinhole.center_x = Number(all, "cx", w / 2), pinhole.center_y = Number(all, "cy", h / 2);
  const auto m = Matrix<3, 4>(all, "transform_matrix");
  const auto column = [&](std::size_t i) { return glm::dvec3(m[0][i], m[1][i], m[2][i]); };
  return {.name = all.value("file_path", ""),
          .position = InputPosition::File(path),
          .pinhole = pinhole,
          .pose = {column(0), column(1), -column(2), column(3)},
          .distortion = DistortionOf(all)};
}

// K, R and t of OpenCV.
Entry EntryOfMatrices(const std::string& path, const Json& json, int width, int height) {
  const auto k = Matrix<3, 3>(json, "K"), r = Matrix<3, 3>(json, "R");
  const Json& t = json.at("t");
  const glm::dvec3 translation(t.at(0).get<double>(), t.at(1).get<double>(), t.at(2).get<double>());
  std::string distortion = DistortionOf(json);
  if (k[0][1] != 0) {
    distortion += fmt::format("{}skew = {}", distortion.empty() ? "" : ", ", k[0][1]);
  }
  const glm::dmat3 rows(glm::dvec3(r[0][0], r[0][1], r[0][2]),
                        glm::dvec3(r[1][0], r[1][1], r[1][2]),
                        glm::dvec3(r[2][0], r[2][1], r[2][2]));
  return {.name = json.value("name", ""),
          .position = InputPosition::File(path),
          .pinhole = PinholeOfMatrix(InputPosition::File(path), k, Number(json, "width", width),
                                     Number(json, "height", height)),
          .pose = PoseOfCv(rows, translation),
          .distortion = distortion};
}

std::vector<Entry> EntriesOfJson(const std::string& path, int width, int height) try {
  const Json json = ParseOrderedJson(ReadFile(path));
  if (!json.contains("frames")) return {EntryOfMatrices(path, json, width, height)};
  std::vector<Entry> entries;
  for (const Json& frame : json.at("frames")) {
    entries.push_back(EntryOfFrame(path, json, frame, width, height));
  }
  return entries;
} catch (const Json::parse_error& error) {
  throw InputError(InputPosition::Byte(path, error.byte), "is no JSON");
} catch (const Json::exception& error) {
  throw InputError(InputPosition::File(path),
                   fmt::format("is neither transforms.json of NeRF data nor a camera with K, R and "
                               "t: {}",
                               error.what()));
}

// ---- COLMAP ----

// How many focal lengths the first parameters of a model are; the principal point follows, then
// what is no pinhole.
const std::map<std::string_view, int>& ModelsOfColmap() {
  static const std::map<std::string_view, int> kModels = {{"SIMPLE_PINHOLE", 1},
                                                          {"PINHOLE", 2},
                                                          {"SIMPLE_RADIAL", 1},
                                                          {"RADIAL", 1},
                                                          {"OPENCV", 2},
                                                          {"SIMPLE_RADIAL_FISHEYE", 1},
                                                          {"RADIAL_FISHEYE", 1},
                                                          {"OPENCV_FISHEYE", 2},
                                                          {"FULL_OPENCV", 2},
                                                          {"FOV", 2},
                                                          {"THIN_PRISM_FISHEYE", 2}};
  return kModels;
}

// Calls f(line, words) for each line of a text, comments left out.
template <class F>
void ForEachLine(const std::string& path, const F& f) {
  std::istringstream text(ReadFile(path));
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    if (!line.empty() && line.front() == '#') continue;
    std::istringstream words(line);
    f(InputPosition::Line(path, number), words);
  }
}

struct LensOfColmap {
  Pinhole pinhole;
  std::string distortion;
};

std::map<int, LensOfColmap> LensesOfColmap(const std::string& path) {
  std::map<int, LensOfColmap> lenses;
  ForEachLine(path, [&](const InputPosition& position, std::istream& words) {
    int id = 0;
    std::string model;
    LensOfColmap lens;
    Pinhole& p = lens.pinhole;
    if (!(words >> id)) return;  // an empty line
    words >> model >> p.width >> p.height;
    const auto known = ModelsOfColmap().find(model);
    if (known == ModelsOfColmap().end()) {
      throw InputError(position, fmt::format("{} is no camera model of COLMAP", model));
    }
    words >> p.focal_x;
    p.focal_y = p.focal_x;
    if (known->second == 2) words >> p.focal_y;
    words >> p.center_x >> p.center_y;
    if (!words) {
      throw InputError(position, fmt::format("a {} needs a size and more parameters", model));
    }
    if (model.find("FISHEYE") != std::string::npos) lens.distortion = model;
    for (double value = 0; words >> value;) {
      if (value != 0) lens.distortion = model;
    }
    lenses[id] = std::move(lens);
  });
  return lenses;
}

glm::dmat3 RowsOfQuaternion(double w, double x, double y, double z) {
  const double norm = std::sqrt(w * w + x * x + y * y + z * z);
  w /= norm, x /= norm, y /= norm, z /= norm;
  return {glm::dvec3(1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
          glm::dvec3(2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
          glm::dvec3(2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y))};
}

// Images take two lines each, of which the second one has points.
std::vector<Entry> EntriesOfColmap(const std::filesystem::path& folder) {
  const std::map<int, LensOfColmap> lenses = LensesOfColmap((folder / "cameras.txt").string());
  std::vector<Entry> entries;
  bool of_points = false;
  ForEachLine((folder / "images.txt").string(),
              [&](const InputPosition& position, std::istream& words) {
                if (std::exchange(of_points, false) || (words >> std::ws).eof()) return;
                of_points = true;
                int image = 0, lens = 0;
                double q[4];
                glm::dvec3 t;
                std::string name;
                words >> image >> q[0] >> q[1] >> q[2] >> q[3] >> t.x >> t.y >> t.z >> lens;
                if (!words || !std::getline(words >> std::ws, name)) {
                  throw InputError(position,
                                   "an image needs its number, a quaternion, a translation, the "
                                   "number of its camera and its name");
                }
                const auto found = lenses.find(lens);
                if (found == lenses.end()) {
                  throw InputError(position, fmt::format("cameras.txt has no camera {}", lens));
                }
                entries.push_back({.name = name,
                                   .position = position,
                                   .pinhole = found->second.pinhole,
                                   .pose = PoseOfCv(RowsOfQuaternion(q[0], q[1], q[2], q[3]), t),
                                   .distortion = found->second.distortion});
              });
  return entries;
}

std::vector<Entry> EntriesOf(const std::string& path, int width, int height) {
  const std::filesystem::path file(path);
  if (file.extension() == ".json") return EntriesOfJson(path, width, height);
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) return EntriesOfColmap(file);
  return EntriesOfColmap(file.parent_path());
}

}  // namespace

CameraOfFile ReadCameraOfFile(const std::string& path, const std::string& name, int width,
                              int height, Warnings& warnings) {
  const std::vector<Entry> entries = EntriesOf(path, width, height);
  if (entries.empty()) throw InputError(InputPosition::File(path), "has no camera");
  const Entry* chosen = name.empty() ? &entries.front() : nullptr;
  std::vector<std::string_view> names;
  for (const Entry& entry : entries) {
    if (chosen == nullptr && entry.name == name) chosen = &entry;
    names.push_back(entry.name);
  }
  if (chosen == nullptr) {
    throw OptionError(
        "scene-camera", name,
        fmt::format("{} has no such photograph; it has {}", path, NearestFirst(name, names)));
  }
  if (!chosen->distortion.empty()) {
    AddWarning(warnings, chosen->position,
               fmt::format("the distortion of the lens is left out ({}): put objects into a "
                           "photograph without it",
                           chosen->distortion));
  }
  Camera camera = CameraOf(*chosen);
  return {.name = chosen->name,
          .camera = camera,
          .eye = chosen->pose.eye,
          .width = int(chosen->pinhole.width),
          .height = int(chosen->pinhole.height)};
}

std::vector<std::string> PhotographsOfFile(const std::string& path) {
  const RenderOptions defaults;
  std::vector<std::string> names;
  for (const Entry& entry : EntriesOf(path, defaults.width, defaults.height)) {
    if (!entry.name.empty()) names.push_back(entry.name);
  }
  return names;
}

std::string LabelOfPhotograph(const std::string& name) {
  return std::filesystem::path(name).stem().string();
}

Camera CameraOfMatrix(const std::array<double, 9>& k, const glm::dmat4& world_from_camera,
                      int width, int height) {
  const InputPosition position = InputPosition::File("camera");
  const double rows[3][3] = {{k[0], k[1], k[2]}, {k[3], k[4], k[5]}, {k[6], k[7], k[8]}};
  if (k[1] != 0) throw InputError(position, "K has skew, which is not rendered");
  const glm::dmat4& m = world_from_camera;
  return CameraOf({.name = "",
                   .position = position,
                   .pinhole = PinholeOfMatrix(position, rows, width, height),
                   .pose = {.right = glm::dvec3(m[0]),
                            .up = -glm::dvec3(m[1]),
                            .forward = glm::dvec3(m[2]),
                            .eye = glm::dvec3(m[3])},
                   .distortion = ""});
}

void TakeCameraOfFile(JobRequest& request, std::vector<std::string>& warnings) {
  if (request.camera.from.empty()) return;
  const RenderOptions defaults;
  Warnings found = MakeWarnings(request.read);
  CameraOfFile read = ReadCameraOfFile(request.camera.from, request.camera.name,
                                       request.width.value_or(defaults.width),
                                       request.height.value_or(defaults.height), found);
  for (std::string& line : WarningLines(found)) warnings.push_back(std::move(line));
  request.width = request.width.value_or(read.width);
  request.height = request.height.value_or(read.height);
  request.camera.placed = read.camera, request.camera.placed_at = read.eye;
}

}  // namespace skywave
