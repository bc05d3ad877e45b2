// Handles pbrt's transform directives. Each multiplies the current matrix from the right.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "base/error.h"
#include "scene/pbrt/state.h"

namespace skywave {
namespace {

// Returns why nothing can be placed by a matrix whose numbers are finite, or nothing. Rounding is
// no flaw: the last number of an inverse is 1 to a few units in the last place.
std::string_view FlawOf(const glm::dmat4& matrix) {
  constexpr double kRounding = 1e-12;
  const glm::dmat4 inverse = glm::inverse(matrix);
  bool has_inverse = std::isnormal(glm::determinant(matrix));
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      has_inverse = has_inverse && std::isfinite(inverse[column][row]);
    }
  }
  if (!has_inverse) return "singular";
  const bool affine = matrix[0].w == 0 && matrix[1].w == 0 && matrix[2].w == 0 &&
                      std::abs(matrix[3].w - 1) < kRounding;
  return affine ? "" : "projective";
}

bool IsFinite(const glm::dmat4& matrix) {
  bool finite = true;
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) finite = finite && std::isfinite(matrix[column][row]);
  }
  return finite;
}

// A matrix by which nothing can be placed does no harm where nothing is placed.
void SetTransform(PbrtReader& reader, const InputPosition& position, std::string_view directive,
                  const glm::dmat4& matrix) {
  if (!IsFinite(matrix)) {
    throw InputError(position, fmt::format("{} makes the transform singular", directive));
  }
  reader.state.to_world = matrix;
  auto& flaw = reader.state.flaw;
  const std::string_view what = FlawOf(matrix);
  if (what.empty()) {
    flaw.reset();
  } else if (!flaw || flaw->what != what) {
    flaw = {std::string(what), std::string(directive), position};
  }
}

// The same at the start of the exposure, unless the directive is of its end alone.
void SetActiveTransform(PbrtReader& reader, const InputPosition& position,
                        std::string_view directive, const glm::dmat4& matrix) {
  if (reader.state.transform_active) SetTransform(reader, position, directive, matrix);
}

void Concatenate(PbrtReader& reader, const PbrtSource& source, const PbrtToken& word,
                 const glm::dmat4& matrix) {
  SetActiveTransform(reader, PositionOf(source, word), word.text, reader.state.to_world * matrix);
}

void Identity(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  SetActiveTransform(reader, PositionOf(source, word), word.text, glm::dmat4(1));
}

void Translate(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  glm::dvec3 by;
  ExpectNumbers(source, word.text, 3, glm::value_ptr(by));
  Concatenate(reader, source, word, glm::translate(glm::dmat4(1), by));
}

void Scale(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  glm::dvec3 by;
  ExpectNumbers(source, word.text, 3, glm::value_ptr(by));
  Concatenate(reader, source, word, glm::scale(glm::dmat4(1), by));
}

void Rotate(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  std::array<double, 4> n{};  // angle in degrees, axis
  ExpectNumbers(source, word.text, 4, n.data());
  const glm::dvec3 axis(n[1], n[2], n[3]);
  if (axis == glm::dvec3(0)) {
    throw InputError(PositionOf(source, word), "Rotate about an axis of length zero");
  }
  Concatenate(reader, source, word, glm::rotate(glm::dmat4(1), glm::radians(n[0]), axis));
}

// Concatenates LookAt's matrix: from the world to a viewer with x right, y up and z forward in
// pbrt's left-handed world.
void LookAt(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  std::array<double, 9> n{};
  ExpectNumbers(source, word.text, 9, n.data());
  const glm::dvec3 eye = glm::make_vec3(&n[0]), target = glm::make_vec3(&n[3]),
                   up = glm::make_vec3(&n[6]);
  const glm::dvec3 forward = glm::normalize(target - eye);
  const glm::dvec3 right = glm::normalize(glm::cross(glm::normalize(up), forward));
  const glm::dmat4 to_world(glm::dvec4(right, 0), glm::dvec4(glm::cross(forward, right), 0),
                            glm::dvec4(forward, 0), glm::dvec4(eye, 1));
  Concatenate(reader, source, word, glm::inverse(to_world));
}

// pbrt and GLM both list matrices by column.
glm::dmat4 ReadMatrix(PbrtSource& source, const PbrtToken& word) {
  std::array<double, 16> n{};
  ExpectNumbers(source, word.text, 16, n.data());
  const glm::dmat4 matrix = glm::make_mat4(n.data());
  return matrix[3].w != 0 ? matrix / matrix[3].w : matrix;
}

void Transform(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  SetActiveTransform(reader, PositionOf(source, word), word.text, ReadMatrix(source, word));
}

void ConcatTransform(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  Concatenate(reader, source, word, ReadMatrix(source, word));
}

void CoordinateSystem(PbrtReader& reader, PbrtSource& source, const PbrtToken&) {
  const std::string name = ExpectString(source, "the name of a coordinate system");
  reader.coordinate_systems[name] = reader.state.to_world;
}

void CoordSysTransform(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const std::string name = ExpectString(source, "the name of a coordinate system");
  const auto found = reader.coordinate_systems.find(name);
  if (found == reader.coordinate_systems.end()) {
    throw InputError(PositionOf(source, word),
                     fmt::format("there is no coordinate system \"{}\"", name));
  }
  SetTransform(reader, PositionOf(source, word), word.text, found->second);
}

void ReverseOrientation(PbrtReader& reader, PbrtSource&, const PbrtToken&) {
  reader.state.reverse_orientation = !reader.state.reverse_orientation;
}

// Motion is not rendered: everything stays where it is at the start of the exposure.
void ActiveTransform(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const PbrtToken which = NextToken(source);
  if (which.text != "All" && which.text != "StartTime" && which.text != "EndTime") {
    throw InputError(PositionOf(source, which),
                     "ActiveTransform takes All, StartTime or EndTime, not " + Describe(which));
  }
  reader.state.transform_active = which.text != "EndTime";
  if (which.text == "All") return;
  AddWarning(reader.warnings, PositionOf(source, word),
             "ActiveTransform: motion is not supported: rendered as at StartTime");
}

void TransformTimes(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  std::array<double, 2> times{};
  ExpectNumbers(source, word.text, 2, times.data());
  AddWarning(reader.warnings, PositionOf(source, word),
             "TransformTimes: motion is not supported: ignored");
}

constexpr PbrtDirective kTransformDirectives[] = {
    {"Identity", Identity},
    {"Translate", Translate},
    {"Scale", Scale},
    {"Rotate", Rotate},
    {"LookAt", LookAt},
    {"Transform", Transform},
    {"ConcatTransform", ConcatTransform},
    {"CoordinateSystem", CoordinateSystem},
    {"CoordSysTransform", CoordSysTransform},
    {"ReverseOrientation", ReverseOrientation},
    {"ActiveTransform", ActiveTransform},
    {"TransformTimes", TransformTimes},
};

}  // namespace

bool CanPlace(PbrtReader& reader, const InputPosition& position, std::string_view what) {
  const auto& flaw = reader.state.flaw;
  if (!flaw) return true;
  AddWarning(reader.warnings, position,
             fmt::format("{} under a transform that is {} since the {} of {}: left out", what,
                         flaw->what, flaw->directive, ToString(flaw->position)));
  return false;
}

PbrtHandler FindPbrtTransformDirective(std::string_view word) {
  return FindPbrtDirective(kTransformDirectives, word);
}

}  // namespace skywave
