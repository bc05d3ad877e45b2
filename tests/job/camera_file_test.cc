// Tests cameras of photographs: three ways to write one down give the rays of its own projection.
#include "job/camera_file.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "base/error.h"
#include "job/job.h"
#include "scene/builtin/builtin.h"
#include "tests/support/temporary_folder.h"
#include "wavefront/frame.h"

namespace skywave {
namespace {

// A camera at (1, 2, 5) that looks down and to the left: R (rows: right, down, forward) is a
// rotation of 200 degrees about x after one of 20 degrees about y.
constexpr int kWidth = 320, kHeight = 200;
constexpr double kFocalX = 300, kFocalY = 310, kCenterX = 150.5, kCenterY = 111.25;

glm::dmat3 Rows() {
  const double a = glm::radians(200.0), b = glm::radians(20.0);
  const glm::dvec3 x(std::cos(b), 0, std::sin(b));
  const glm::dvec3 y(std::sin(a) * std::sin(b), std::cos(a), -std::sin(a) * std::cos(b));
  return {x, y, glm::cross(x, y)};
}
const glm::dvec3 kEye(1, 2, 5);

std::string Text(const glm::dvec3& v) {
  return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x, v.y, v.z);
}

// OpenCV counts pixels by their centres, so its principal point is half a pixel less.
std::string Matrices(const std::string& more = "") {
  const glm::dmat3 r = Rows();
  const glm::dvec3 t(-glm::dot(r[0], kEye), -glm::dot(r[1], kEye), -glm::dot(r[2], kEye));
  return fmt::format(
      R"({{"K": [[{}, 0, {}], [0, {}, {}], [0, 0, 1]], "R": [{}, {}, {}], "t": {},
          "width": {}, "height": {}{}}})",
      kFocalX, kCenterX - 0.5, kFocalY, kCenterY - 0.5, Text(r[0]), Text(r[1]), Text(r[2]), Text(t),
      kWidth, kHeight, more);
}

// The columns are x right, y up, z backward.
std::string Frame(const std::string& name) {
  const glm::dmat3 r = Rows();
  std::string matrix;
  for (int row = 0; row < 3; ++row) {
    matrix += fmt::format("[{:.17g}, {:.17g}, {:.17g}, {:.17g}], ", r[0][row], -r[1][row],
                          -r[2][row], kEye[row]);
  }
  return fmt::format(R"({{"file_path": "{}", "transform_matrix": [{}[0, 0, 0, 1]]}})", name,
                     matrix);
}
std::string Transforms(const std::string& more = "") {
  return fmt::format(
      R"({{"fl_x": {}, "fl_y": {}, "cx": {}, "cy": {}, "w": {}, "h": {}{},
          "frames": [{}, {}]}})",
      kFocalX, kFocalY, kCenterX, kCenterY, kWidth, kHeight, more, Frame("first.png"),
      Frame("second.png"));
}

// Returns the quaternion w, x, y, z of the rotation, by Shepperd's formulas where w is not small.
std::string ColmapImages() {
  const glm::dmat3 r = Rows();
  const glm::dvec3 t(-glm::dot(r[0], kEye), -glm::dot(r[1], kEye), -glm::dot(r[2], kEye));
  // x is the largest part of a turn of about 200 degrees about it.
  const double x = std::sqrt(1 + r[0][0] - r[1][1] - r[2][2]) / 2;
  const double w = (r[2][1] - r[1][2]) / (4 * x), y = (r[0][1] + r[1][0]) / (4 * x),
               z = (r[0][2] + r[2][0]) / (4 * x);
  const std::string line = fmt::format("{:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} 7 ",
                                       w, x, y, z, t.x, t.y, t.z);
  return "# comment\n1 " + line + "first.png\n10 20 3 11 21 -1\n2 " + line + "a name.png\n\n";
}
std::string ColmapCameras(const std::string& model = "PINHOLE", const std::string& more = "") {
  return fmt::format("# comment\n7 {} {} {} {} {} {} {} {}\n", model, kWidth, kHeight, kFocalX,
                     kFocalY, kCenterX, kCenterY, more);
}

class CameraFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_.Write("matrices.json", Matrices());
    folder_.Write("transforms.json", Transforms());
    folder_.Write("images.txt", ColmapImages());
    folder_.Write("cameras.txt", ColmapCameras());
  }

  CameraOfFile Read(const std::string& file, const std::string& name = "") {
    return ReadCameraOfFile(folder_.Path(file), name, 64, 48, warnings_);
  }

  // Expects InputError whose text has each of `words`.
  void ExpectRefused(const std::string& file, const std::vector<std::string>& words) {
    try {
      Read(file);
      ADD_FAILURE() << "not refused: " << file << " " << words.front();
    } catch (const InputError& error) {
      for (const std::string& word : words) {
        EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
      }
    }
  }

  TemporaryFolder folder_;
  Warnings warnings_ = MakeWarnings({});
};

// Points are projected by K (R X + t), the definition of OpenCV. The film position of a pixel that
// is counted by its centre is half a pixel more.
void ExpectRaysOfProjection(const Camera& camera, int width, int height) {
  const double scale = double(width) / kWidth;
  const CameraView view = MakeCameraView(camera, width, height, nullptr);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-3, 3);
  const glm::dmat3 r = Rows();
  int seen = 0;
  while (seen < 100) {
    const glm::dvec3 point = kEye + glm::dvec3(any(random), any(random), any(random));
    const glm::dvec3 q = point - kEye;
    const glm::dvec3 in_camera(glm::dot(r[0], q), glm::dot(r[1], q), glm::dot(r[2], q));
    if (in_camera.z < 0.5) continue;
    ++seen;
    const double x = scale * (kFocalX * in_camera.x / in_camera.z + kCenterX);
    const double y = scale * (kFocalY * in_camera.y / in_camera.z + kCenterY);
    glm::dvec3 ray;
    for (int axis = 0; axis < 3; ++axis) {
      ray[axis] = view.corner[axis] + x * double(view.right[axis]) + y * double(view.down[axis]);
      EXPECT_FLOAT_EQ(view.origin[axis], float(kEye[axis]));
    }
    EXPECT_LT(glm::length(glm::normalize(ray) - glm::normalize(q)), 2e-6);
  }
}

TEST_F(CameraFile, AllFormsGiveTheRaysOfTheProjection) {
  for (const char* const file : {"matrices.json", "transforms.json", "images.txt", "cameras.txt"}) {
    SCOPED_TRACE(file);
    const CameraOfFile read = Read(file);
    EXPECT_EQ(read.width, kWidth);
    EXPECT_EQ(read.height, kHeight);
    ExpectRaysOfProjection(read.camera, kWidth, kHeight);
    ExpectRaysOfProjection(read.camera, 2 * kWidth, 2 * kHeight);
  }
  EXPECT_TRUE(WarningLines(warnings_).empty());
  EXPECT_EQ(Read("images.txt").name, "first.png");
  EXPECT_EQ(Read("images.txt", "a name.png").name, "a name.png");
  EXPECT_EQ(Read("transforms.json", "second.png").name, "second.png");
}

// NeRF's synthetic scenes have an angle and no size.
TEST_F(CameraFile, AnAngleIsThatOfTheWidthOfTheFilm) {
  folder_.Write("angle.json", R"({"camera_angle_x": 1.5707963267948966, "frames": [)" +
                                  Frame("./train/r_0") + "]}");
  const CameraOfFile read = Read("angle.json");
  EXPECT_EQ(read.width, 64);
  EXPECT_EQ(read.height, 48);
  EXPECT_NEAR(read.camera.window->right, 1, 1e-6);
  EXPECT_NEAR(read.camera.window->left, -1, 1e-6);
  EXPECT_NEAR(read.camera.window->top, 0.75, 1e-6);
}

TEST_F(CameraFile, TheFilmIsThatOfThePhotograph) {
  const auto job = [&](JobRequest request) {
    request.scene = "spheres";
    request.camera.from = folder_.Path("transforms.json");
    request.samples_per_pixel = 1;
    return RenderJob(BuiltinScene("spheres"), request);
  };
  const RenderJob whole = job({});
  EXPECT_EQ(whole.options().width, kWidth);
  EXPECT_EQ(whole.options().height, kHeight);
  // Pixels of a film of another shape are squares, and it shows all of the photograph.
  JobRequest square;
  square.width = square.height = 320;
  const FrameView frame = job(square).frame();
  const auto length = [](const float* v) { return std::hypot(v[0], v[1], v[2]); };
  EXPECT_FLOAT_EQ(length(frame.camera.right), length(frame.camera.down));
  JobRequest named;
  named.camera.name = "second.png";
  ExpectRaysOfProjection(Read("transforms.json", "second.png").camera, kWidth, kHeight);
  EXPECT_EQ(job(named).frame().camera.corner[0], whole.frame().camera.corner[0]);
  JobRequest unknown;
  unknown.camera.name = "third.png";
  try {
    job(unknown);
    ADD_FAILURE() << "a photograph that is not there";
  } catch (const OptionError& error) {
    EXPECT_NE(std::string(error.what()).find("second.png"), std::string::npos) << error.what();
  }
}

TEST_F(CameraFile, DistortionIsWarnedOfAndRefusedWhereWarningsAre) {
  folder_.Write("k1.json", Transforms(R"(, "k1": 0.125, "k2": 0)"));
  folder_.Write("skew.json", [] {
    std::string text = Matrices();
    return text.replace(text.find(", 0, "), 5, ", 0.5, ");
  }());
  folder_.Write("fisheye.json", Transforms(R"(, "camera_model": "OPENCV_FISHEYE")"));
  folder_.Write("flag.json", Transforms(R"(, "is_fisheye": true)"));
  for (const auto& [file, word] : {std::pair("k1.json", "k1 = 0.125"),
                                   {"skew.json", "skew"},
                                   {"fisheye.json", "OPENCV_FISHEYE"},
                                   {"flag.json", "is_fisheye"}}) {
    warnings_ = MakeWarnings({});
    Read(file);
    ASSERT_EQ(WarningLines(warnings_).size(), 1u) << file;
    EXPECT_NE(WarningLines(warnings_)[0].find(word), std::string::npos);
    EXPECT_NE(WarningLines(warnings_)[0].find(file), std::string::npos);
  }
  // A fisheye lens is no pinhole, whatever its coefficients are.
  for (const char* const model : {"OPENCV", "OPENCV_FISHEYE"}) {
    const bool is_fisheye = std::string(model) != "OPENCV";
    folder_.Write("cameras.txt", ColmapCameras(model, is_fisheye ? "0 0 0 0" : "0 0 0.01 0"));
    warnings_ = MakeWarnings({});
    Read("images.txt");
    EXPECT_EQ(WarningLines(warnings_).size(), 1u) << model;
  }
  folder_.Write("plain.json", Transforms(R"(, "camera_model": "OPENCV", "is_fisheye": false)"));
  warnings_ = MakeWarnings({});
  Read("plain.json");
  EXPECT_TRUE(WarningLines(warnings_).empty());
  ReadOptions strict;
  strict.strict = true;
  warnings_ = MakeWarnings(strict);
  EXPECT_THROW(Read("k1.json"), InputError);
  // Models with one focal length have it for both axes.
  folder_.Write("cameras.txt", "7 SIMPLE_RADIAL 320 200 300 160 100 0\n");
  EXPECT_FLOAT_EQ(Read("images.txt").camera.window->top, 1.0f / 3);
}

TEST_F(CameraFile, BadFilesAreRefusedWithTheirPlace) {
  const auto with = [&](const std::string& file, std::string text, const std::string& old,
                        const std::string& now) {
    const std::size_t at = text.find(old);
    ASSERT_NE(at, std::string::npos) << old;
    folder_.Write(file, text.replace(at, old.size(), now));
  };
  ExpectRefused("missing.json", {"missing.json"});
  for (const char* const side : {"0", "1e12", "320.5"}) {
    with("side.json", Transforms(), "\"w\": 320", std::string("\"w\": ") + side);
    ExpectRefused("side.json", {"side.json", "whole numbers in [1, 65536]"});
  }
  folder_.Write("bad.json", "{\"K\": [");
  ExpectRefused("bad.json", {"bad.json (byte ", "JSON"});
  folder_.Write("bad.json", "{\"camera\": 1}");
  ExpectRefused("bad.json", {"bad.json", "transforms.json"});
  folder_.Write("bad.json", "{\"frames\": []}");
  ExpectRefused("bad.json", {"no camera"});
  with("bad.json", Matrices(), "[[300", "[[0");
  ExpectRefused("bad.json", {"bad.json", "focal length"});
  with("bad.json", Matrices(), "[0, 0, 1]", "[0, 0, 2]");
  ExpectRefused("bad.json", {"K is no matrix"});
  with("bad.json", Transforms(), "\"transform_matrix\": [[", "\"transform_matrix\": [[9");
  ExpectRefused("bad.json", {"right angles"});
  folder_.Write("images.txt", "# c\n1 0.1 0.2 0.3\n");
  ExpectRefused("images.txt", {"images.txt:2", "quaternion"});
  folder_.Write("images.txt", "1 1 0 0 0 0 0 0 8 a.png\n\n");
  ExpectRefused("images.txt", {"images.txt:1", "no camera 8"});
  folder_.Write("images.txt", ColmapImages());
  folder_.Write("cameras.txt", "7 PANORAMA 320 200 1 2 3\n");
  ExpectRefused("images.txt", {"cameras.txt:1", "PANORAMA"});
  folder_.Write("cameras.txt", "7 PINHOLE 320 200 300\n");
  ExpectRefused("images.txt", {"cameras.txt:1", "parameters"});
}

}  // namespace
}  // namespace skywave
