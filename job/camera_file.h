// Cameras that took photographs, as programs of computer vision write them: transforms.json of NeRF
// data, the text files of COLMAP, and the matrices of OpenCV.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "job/request.h"
#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

// A camera of a file and the size of its photographs [pixels].
struct CameraOfFile {
  std::string name;  // of its photograph; empty: the file has one camera without a name
  Camera camera;
  glm::dvec3 eye{0.0};  // its place, which the matrix of the camera has rounded
  int width = 0, height = 0;
};

// Returns the camera called `name`, or the first one if that is empty. A file that does not say how
// large its photographs are is of some with `width` x `height` pixels. Warns of what is left out,
// as the distortion of a lens. Throws InputError with the place in the file.
CameraOfFile ReadCameraOfFile(const std::string& path, const std::string& name, int width,
                              int height, Warnings& warnings);

// Returns the names of the photographs of a file, in its order, none for a camera without a name.
// Throws InputError.
std::vector<std::string> PhotographsOfFile(const std::string& path);
// Returns what stands for a photograph in names of outputs: "r_0" for "./train/r_0.png".
std::string LabelOfPhotograph(const std::string& name);

// Returns a camera with the matrix K of OpenCV, row by row, whose pixels have their centres at
// whole numbers and whose axes are x right, y down, z forward. Throws InputError.
Camera CameraOfMatrix(const std::array<double, 9>& k, const glm::dmat4& world_from_camera,
                      int width, int height);

// Puts the camera that the option `camera-from` names into the request, and the size of its
// photographs where the request has none. Appends warnings.
void TakeCameraOfFile(JobRequest& request, std::vector<std::string>& warnings);

}  // namespace skywave
