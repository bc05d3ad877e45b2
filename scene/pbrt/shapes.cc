#include "scene/pbrt/shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "base/error.h"
#include "scene/pbrt/round_shapes.h"
#include "scene/shapes/curves.h"
#include "scene/shapes/patches.h"
#include "scene/shapes/ply.h"

namespace skywave {
namespace {

using TypeNames = std::initializer_list<std::string_view>;

std::vector<glm::vec3> FindVectors(PbrtParameters& parameters, TypeNames types,
                                   std::string_view name) {
  const PbrtParameter* found = Find(parameters, types, name);
  std::vector<glm::vec3> vectors;
  if (!found) return vectors;
  vectors.reserve(found->floats.size() / 3);
  for (std::size_t i = 0; i + 2 < found->floats.size(); i += 3) {
    vectors.emplace_back(found->floats[i], found->floats[i + 1], found->floats[i + 2]);
  }
  return vectors;
}

std::vector<glm::vec3> RequirePositions(PbrtParameters& parameters) {
  std::vector<glm::vec3> positions = FindVectors(parameters, {"point", "point3"}, "P");
  if (positions.empty()) {
    throw InputError(parameters.position, parameters.directive + " needs vertices \"point3 P\"");
  }
  return positions;
}

// Returns "indices" in groups of `group`, all of them valid vertices. In pbrt-v4, one group of
// vertices in order needs no indices.
std::vector<std::uint32_t> RequireIndices(PbrtParameters& parameters, std::size_t group,
                                          std::string_view groups, std::size_t vertices) {
  const PbrtParameter* found = Find(parameters, {"integer"}, "indices");
  std::vector<std::uint32_t> indices;
  if (!found) {
    if (vertices != group) {
      throw InputError(parameters.position, parameters.directive + " needs \"integer indices\"");
    }
    for (std::uint32_t i = 0; i < group; ++i) indices.push_back(i);
    return indices;
  }
  if (found->ints.empty() || found->ints.size() % group != 0) {
    throw InputError(found->position, fmt::format("{}: {} indices are no {}", parameters.directive,
                                                  found->ints.size(), groups));
  }
  indices.reserve(found->ints.size());
  for (const std::int32_t index : found->ints) {
    if (index < 0 || static_cast<std::size_t>(index) >= vertices) {
      throw InputError(found->position,
                       fmt::format("{}: index {} (number {}) is not in 0..{}, the vertices given",
                                   parameters.directive, index, indices.size(), vertices - 1));
    }
    indices.push_back(static_cast<std::uint32_t>(index));
  }
  return indices;
}

std::vector<glm::uvec3> RequireTriangles(PbrtParameters& parameters, std::size_t vertices) {
  const std::vector<std::uint32_t> indices = RequireIndices(parameters, 3, "triangles", vertices);
  std::vector<glm::uvec3> triangles(indices.size() / 3);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    triangles[i / 3][static_cast<int>(i % 3)] = indices[i];
  }
  return triangles;
}

void CheckPerVertex(const PbrtParameters& parameters, std::string_view name, std::size_t count,
                    std::size_t vertices) {
  if (count != 0 && count != vertices) {
    throw InputError(parameters.position, fmt::format("{}: {} \"{}\" for {} vertices",
                                                      parameters.directive, count, name, vertices));
  }
}

std::vector<glm::vec2> FindUvs(PbrtParameters& parameters) {
  std::vector<glm::vec2> uvs;
  for (const std::string_view name : {"uv", "st"}) {
    const PbrtParameter* found = Find(parameters, {"point2", "float"}, name);
    if (!found || !uvs.empty()) continue;
    if (found->floats.size() % 2 != 0) {
      throw InputError(found->position,
                       fmt::format("{}: {} values of \"{}\" are no pairs", parameters.directive,
                                   found->floats.size(), name));
    }
    for (std::size_t i = 0; i < found->floats.size(); i += 2) {
      uvs.emplace_back(found->floats[i], found->floats[i + 1]);
    }
  }
  return uvs;
}

Mesh TriangleMesh(PbrtParameters& parameters, bool corner_uvs) {
  Mesh mesh;
  mesh.positions = RequirePositions(parameters);
  mesh.triangles = RequireTriangles(parameters, mesh.positions.size());
  mesh.normals = FindVectors(parameters, {"normal", "normal3"}, "N");
  mesh.uvs = FindUvs(parameters);
  CheckPerVertex(parameters, "N", mesh.normals.size(), mesh.positions.size());
  CheckPerVertex(parameters, "uv", mesh.uvs.size(), mesh.positions.size());
  NormalizeNormals(mesh);
  if (corner_uvs && mesh.uvs.empty()) GiveCornersUvs(mesh);
  // pbrt too turns the geometric normal to the side of the shading normals.
  AlignWindingWithNormals(mesh);
  return mesh;
}

// Returns nothing, with a warning, for a file that is missing or cannot be read.
std::optional<Mesh> PlyMesh(PbrtParameters& parameters,
                            const std::function<std::string(const std::string&)>& resolve,
                            std::size_t& faces, Warnings& warnings) {
  const auto filename = FindString(parameters, "filename");
  if (!filename) {
    throw InputError(parameters.position, parameters.directive + " needs a \"string filename\"");
  }
  PlyReport report;
  Mesh mesh;
  try {
    mesh = ReadPly(resolve(*filename), &report);
  } catch (const InputError& error) {
    AddMissing(warnings, parameters.position, parameters.directive, error, "left out");
    return std::nullopt;
  }
  faces = report.polygons;
  WarnOfPly(report, parameters.position, warnings);
  mesh.colors.clear();  // pbrt does not read them
  return mesh;
}

Mesh LoopSubdivisionSurface(PbrtParameters& parameters, std::size_t limit, Warnings& warnings) {
  const std::vector<glm::vec3> positions = RequirePositions(parameters);
  const std::vector<glm::uvec3> triangles = RequireTriangles(parameters, positions.size());
  const auto v4_levels = FindInt(parameters, "levels"), v3_levels = FindInt(parameters, "nlevels");
  const int levels = v4_levels.value_or(v3_levels.value_or(3));
  std::size_t count = triangles.size();
  for (int level = 0; level < levels && count <= limit; ++level) count *= 4;
  if (levels < 0 || count > limit) {
    throw InputError(parameters.position,
                     fmt::format("{}: {} levels are negative or make more than {} triangles",
                                 parameters.directive, levels, limit));
  }
  const std::string scheme = FindString(parameters, "scheme").value_or("loop");
  if (scheme != "loop") {
    AddWarning(warnings, parameters.position,
               fmt::format("{}: scheme \"{}\" is not supported: loop is used", parameters.directive,
                           scheme));
  }
  return LoopSubdivide(positions, triangles, levels);
}

// pbrt-v3's heights over the unit square, row by row along x.
Mesh Heightfield(PbrtParameters& parameters, std::size_t limit) {
  const int columns = FindInt(parameters, "nu").value_or(-1),
            rows = FindInt(parameters, "nv").value_or(-1);
  const PbrtParameter* const found = Find(parameters, {"float"}, "Pz");
  const std::size_t given = found != nullptr ? found->floats.size() : 0;
  if (columns < 2 || rows < 2 || given != std::size_t(columns) * std::size_t(rows)) {
    throw InputError(parameters.position,
                     fmt::format("{}: {} heights \"Pz\" for \"nu\" {} times \"nv\" {}",
                                 parameters.directive, given, columns, rows));
  }
  if (2 * given > limit) {
    throw InputError(parameters.position, fmt::format("{}: {} heights make more than {} triangles",
                                                      parameters.directive, given, limit));
  }
  Mesh mesh;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const glm::vec2 uv(float(x) / float(columns - 1), float(y) / float(rows - 1));
      mesh.positions.emplace_back(uv, found->floats[mesh.positions.size()]);
      mesh.uvs.push_back(uv);
    }
  }
  const auto width = std::uint32_t(columns);
  for (std::uint32_t y = 0; y + 1 < std::uint32_t(rows); ++y) {
    for (std::uint32_t x = 0; x + 1 < width; ++x) {
      const std::uint32_t corner = y * width + x;
      mesh.triangles.emplace_back(corner, corner + 1, corner + width + 1);
      mesh.triangles.emplace_back(corner, corner + width + 1, corner + width);
    }
  }
  return mesh;
}

Mesh BilinearMesh(PbrtParameters& parameters, std::size_t limit, std::size_t& patches) {
  const std::vector<glm::vec3> positions = RequirePositions(parameters);
  const std::vector<glm::vec3> normals = FindVectors(parameters, {"normal", "normal3"}, "N");
  const std::vector<glm::vec2> uvs = FindUvs(parameters);
  CheckPerVertex(parameters, "N", normals.size(), positions.size());
  CheckPerVertex(parameters, "uv", uvs.size(), positions.size());
  FindString(parameters, "emissionfilename");  // pbrt only uses it to place light samples
  const std::vector<std::uint32_t> indices =
      RequireIndices(parameters, 4, "bilinear patches", positions.size());
  if (indices.size() / 4 > limit / (2 * kBilinearSteps * kBilinearSteps)) {
    throw InputError(parameters.position,
                     fmt::format("{}: {} patches may become more than {} triangles",
                                 parameters.directive, indices.size() / 4, limit));
  }
  patches = indices.size() / 4;
  Mesh mesh;
  for (std::size_t i = 0; i + 3 < indices.size(); i += 4) {
    AddBilinearPatch({positions, normals, uvs},
                     {indices[i], indices[i + 1], indices[i + 2], indices[i + 3]}, mesh);
  }
  AlignWindingWithNormals(mesh);
  return mesh;
}

// Returns the name that is given, or the first of those that are known. Throws InputError on
// others.
std::string FindName(PbrtParameters& parameters, std::string_view parameter,
                     std::initializer_list<std::string_view> known) {
  const std::string name = FindString(parameters, parameter).value_or(std::string(*known.begin()));
  if (std::find(known.begin(), known.end(), name) == known.end()) {
    throw InputError(
        Find(parameters, {"string"}, parameter)->position,
        fmt::format("{}: there is no {} \"{}\"", parameters.directive, parameter, name));
  }
  return name;
}

// Returns segment `i` of a curve as a cubic Bezier curve.
std::array<glm::dvec3, 4> BezierPoints(std::span<const glm::vec3> points, bool spline, int degree,
                                       std::size_t i) {
  const auto at = [&](std::size_t k) {
    return glm::dvec3(points[i * (spline ? 1 : std::size_t(degree)) + k]);
  };
  if (degree == 3) {
    if (!spline) return {at(0), at(1), at(2), at(3)};
    return {(at(0) + 4.0 * at(1) + at(2)) / 6.0, (2.0 * at(1) + at(2)) / 3.0,
            (at(1) + 2.0 * at(2)) / 3.0, (at(1) + 4.0 * at(2) + at(3)) / 6.0};
  }
  const glm::dvec3 begin = spline ? (at(0) + at(1)) / 2.0 : at(0),
                   end = spline ? (at(1) + at(2)) / 2.0 : at(2);
  return {begin, (begin + 2.0 * at(1)) / 3.0, (2.0 * at(1) + end) / 3.0, end};
}

// Returns the number of segments of a curve of so many points. Throws InputError if they are none.
std::size_t CountSegments(const PbrtParameters& parameters, std::size_t points, bool spline,
                          std::size_t degree) {
  if (points <= degree || (!spline && (points - 1) % degree != 0)) {
    throw InputError(parameters.position,
                     fmt::format("{}: {} points \"P\" are no {} of degree {}", parameters.directive,
                                 points, spline ? "B-spline" : "Bezier segments", degree));
  }
  return spline ? points - degree : (points - 1) / degree;
}

// Sets the normals of a ribbon, of which there is one at each end of a segment.
void SetRibbonNormals(PbrtParameters& parameters, std::span<CurveSegment> segments) {
  const std::vector<glm::vec3> normals = FindVectors(parameters, {"normal", "normal3"}, "N");
  if (normals.size() != segments.size() + 1) {
    throw InputError(
        parameters.position,
        fmt::format("{}: {} normals \"N\" for {} segments, which need {}", parameters.directive,
                    normals.size(), segments.size(), segments.size() + 1));
  }
  for (std::size_t i = 0; i < segments.size(); ++i) {
    for (std::size_t end = 0; end < 2; ++end) {
      const glm::dvec3 normal = glm::normalize(glm::dvec3(normals[i + end]));
      if (!std::isfinite(normal.x + normal.y + normal.z)) {
        throw InputError(
            Find(parameters, {"normal", "normal3"}, "N")->position,
            fmt::format("{}: normal {} is no direction", parameters.directive, i + end));
      }
      segments[i].normals[end] = normal;
    }
  }
}

// A flat curve, which faces every ray, has the outline of a tube for each of them, but not its
// normals.
Mesh PbrtCurve(PbrtParameters& parameters, const PbrtShapeOptions& options, std::size_t limit,
               Warnings& warnings) {
  const std::vector<glm::vec3> points = RequirePositions(parameters);
  const int degree = FindInt(parameters, "degree").value_or(3);
  if (degree != 2 && degree != 3) {
    throw InputError(Find(parameters, {"integer"}, "degree")->position,
                     fmt::format("{}: the degree is {}, not 2 or 3", parameters.directive, degree));
  }
  const bool spline = FindName(parameters, "basis", {"bezier", "bspline"}) == "bspline";
  const std::string type = FindName(parameters, "type", {"flat", "cylinder", "ribbon"});
  const bool ribbon = type == "ribbon";
  if (type == "flat") {
    AddWarning(warnings, parameters.position,
               "a curve of the type \"flat\", the default, becomes a tube like \"cylinder\", whose "
               "sides are darker");
  }
  const float width = FindFloat(parameters, "width").value_or(1);
  const float begin = FindFloat(parameters, "width0").value_or(width),
              end = FindFloat(parameters, "width1").value_or(width);
  if (!(begin >= 0 && end >= 0 && std::max(begin, end) > 0)) {
    throw InputError(parameters.position, fmt::format("{}: widths of {} and {} are invalid",
                                                      parameters.directive, begin, end));
  }
  FindInt(parameters, "splitdepth");  // changes nothing but pbrt's speed

  std::vector<CurveSegment> segments(
      CountSegments(parameters, points.size(), spline, std::size_t(degree)));
  const double count = double(segments.size());
  for (std::size_t i = 0; i < segments.size(); ++i) {
    segments[i].points = BezierPoints(points, spline, degree, i);
    segments[i].widths = {glm::mix(double(begin), double(end), double(i) / count),
                          glm::mix(double(begin), double(end), double(i + 1) / count)};
  }
  if (ribbon) {
    SetRibbonNormals(parameters, segments);
  } else if (Find(parameters, {"normal", "normal3"}, "N")) {
    AddNote(warnings, parameters.position,
            parameters.directive + ": only ribbons have normals \"N\": ignored");
  }
  const CurveForm form = ribbon ? CurveForm::kRibbon : CurveForm::kTube;
  if (CurveTriangles(segments, form) > limit) {
    throw InputError(parameters.position,
                     fmt::format("{}: {} segments may become more than {} triangles",
                                 parameters.directive, segments.size(), limit));
  }
  Mesh mesh = TessellateCurve(segments, form);
  if (!options.needs_uvs) mesh.uvs.clear();
  return mesh;
}

}  // namespace

std::optional<PbrtShape> MakePbrtShape(
    const std::string& type, PbrtParameters& parameters,
    const std::function<std::string(const std::string&)>& resolve, const PbrtShapeOptions& options,
    Warnings& warnings) {
  const std::size_t limit = std::min(options.max_triangles, kMaxSubdividedTriangles);
  PbrtShape shape;
  Mesh& mesh = shape.mesh;
  if (type == "trianglemesh") {
    mesh = TriangleMesh(parameters, options.corner_uvs);
    shape.faces = mesh.triangles.size();
  } else if (type == "plymesh") {
    std::optional<Mesh> read = PlyMesh(parameters, resolve, shape.faces, warnings);
    if (!read) return std::nullopt;
    mesh = *std::move(read);
    if (options.corner_uvs && mesh.uvs.empty()) GiveCornersUvs(mesh);
  } else if (type == "loopsubdiv") {
    mesh = LoopSubdivisionSurface(parameters, limit, warnings);
    if (options.corner_uvs) GiveCornersUvs(mesh);
    shape.faces = mesh.triangles.size();
  } else if (IsRoundPbrtShape(type)) {
    mesh = MakeRoundPbrtShape(type, parameters, options.needs_uvs, warnings);
  } else if (type == "heightfield") {
    mesh = Heightfield(parameters, limit);
    shape.faces = mesh.triangles.size();
  } else if (type == "bilinearmesh") {
    mesh = BilinearMesh(parameters, limit, shape.faces);
  } else if (type == "curve") {
    mesh = PbrtCurve(parameters, options, limit, warnings);
  } else {
    AddWarning(warnings, parameters.position, parameters.directive + " is not supported: left out");
    return std::nullopt;
  }
  ReportUnused(parameters, warnings);
  return shape;
}

}  // namespace skywave
