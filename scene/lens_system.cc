#include "scene/lens_system.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>

namespace skywave {
namespace {

struct AxisRay {
  glm::dvec3 origin, dir;  // unit
};

// An interface between media as a ray meets it that goes along +z: `eta` is the index before it
// over that behind it.
struct Crossing {
  double vertex, radius, aperture, eta;
};

double IorBefore(const LensDesign& design, std::size_t i) {
  return i == 0 || design.interfaces[i - 1].ior == 0 ? 1 : design.interfaces[i - 1].ior;
}

// Returns the interfaces from the film, at z = 0, to the scene.
std::vector<Crossing> CrossingsFromFilm(const LensDesign& design) {
  std::vector<Crossing> crossings;
  double z = 0;
  for (std::size_t i = design.interfaces.size(); i-- > 0;) {
    const LensInterface& at = design.interfaces[i];
    z += at.thickness;
    // The medium around a stop is the same on both sides.
    const double behind = at.ior == 0 ? 1 : at.ior;
    crossings.push_back({z, at.radius, at.aperture, behind / IorBefore(design, i)});
  }
  return crossings;
}

// Returns the interfaces from the scene to the film, mirrored so that rays go along +z, too.
std::vector<Crossing> CrossingsFromScene(const LensDesign& design) {
  std::vector<Crossing> crossings = CrossingsFromFilm(design);
  std::reverse(crossings.begin(), crossings.end());
  for (Crossing& step : crossings) {
    step.vertex = -step.vertex, step.radius = -step.radius, step.eta = 1 / step.eta;
  }
  return crossings;
}

// Refracts a ray at one interface; returns false if it does not pass. `wide` opens every aperture.
bool Pass(const Crossing& step, bool wide, AxisRay& ray) {
  const auto is_open = [&](const glm::dvec3& at) {
    return wide || at.x * at.x + at.y * at.y <= step.aperture * step.aperture;
  };
  if (step.radius == 0) {
    ray.origin += ray.dir * ((step.vertex - ray.origin.z) / ray.dir.z);
    return is_open(ray.origin);
  }
  const glm::dvec3 centre(0, 0, step.vertex - step.radius), from = ray.origin - centre;
  const double b = glm::dot(from, ray.dir);
  const double discriminant = b * b - glm::dot(from, from) + step.radius * step.radius;
  if (discriminant < 0) return false;
  // The vertex is the far side of a sphere around a centre on the side that the ray comes from.
  const double t = -b + std::copysign(std::sqrt(discriminant), step.radius);
  if (t < 0) return false;
  ray.origin += ray.dir * t;
  if (!is_open(ray.origin)) return false;
  const glm::dvec3 normal = (centre - ray.origin) / step.radius;
  const double cosine = -glm::dot(ray.dir, normal);
  const double sine2 = step.eta * step.eta * (1 - cosine * cosine);
  if (sine2 >= 1) return false;
  ray.dir =
      glm::normalize(step.eta * ray.dir + (step.eta * cosine - std::sqrt(1 - sine2)) * normal);
  return true;
}

bool Passes(const std::vector<Crossing>& crossings, AxisRay ray) {
  return std::all_of(crossings.begin(), crossings.end(),
                     [&](const Crossing& step) { return Pass(step, /*wide=*/false, ray); });
}

// The focal plane and the principal plane on the side to which rays go [z].
struct CardinalPlanes {
  double focal, principal;
};

// Follows a ray parallel to the axis, close to it.
std::optional<CardinalPlanes> PlanesBehind(const std::vector<Crossing>& crossings, double height) {
  double first = std::numeric_limits<double>::infinity();
  for (const Crossing& step : crossings) first = std::min(first, step.vertex);
  AxisRay ray = {{height, 0, first - 1}, {0, 0, 1}};
  for (const Crossing& step : crossings) {
    if (!Pass(step, /*wide=*/true, ray)) return std::nullopt;
  }
  if (!(std::abs(ray.dir.x) > 0)) return std::nullopt;  // the lens has no power
  const auto z_at = [&](double x) {
    return ray.origin.z + (x - ray.origin.x) / ray.dir.x * ray.dir.z;
  };
  return CardinalPlanes{z_at(0), z_at(height)};
}

struct ThickLens {
  double f;            // focal length on both sides, in air
  double film, scene;  // principal planes of rays to the film and to the scene [z from the film]
};

std::optional<ThickLens> ThickLensOf(const LensDesign& design) {
  if (design.interfaces.empty()) return std::nullopt;
  const double height = 1e-3 * design.film_diagonal;
  const auto to_scene = PlanesBehind(CrossingsFromFilm(design), height);
  const auto to_film = PlanesBehind(CrossingsFromScene(design), height);
  if (!to_scene || !to_film) return std::nullopt;
  return ThickLens{to_scene->focal - to_scene->principal, -to_film->principal, to_scene->principal};
}

// The box around the exit pupil, on the plane of the last element, of the points of the film at a
// distance from its middle along x.
struct PupilBox {
  glm::dvec2 low{std::numeric_limits<double>::infinity()},
      high{-std::numeric_limits<double>::infinity()};
  bool is_empty() const { return !(low.x <= high.x); }
  void Add(const glm::dvec2& p) { low = glm::min(low, p), high = glm::max(high, p); }
};

constexpr int kPupilGrid = 96;  // points along a side of the square that is searched

void AddPupil(const std::vector<Crossing>& crossings, double film_x, double reach, PupilBox& box) {
  const double rear = crossings[0].vertex, spacing = 2 * reach / kPupilGrid;
  const auto passes = [&](const glm::dvec2& p) {
    const glm::dvec3 from(film_x, 0, 0), to(p, rear);
    return Passes(crossings, {from, glm::normalize(to - from)});
  };
  const auto at = [&](int i) { return -reach + (i + 0.5) * spacing; };
  // Along each line the first and the last point that pass are moved outwards to the edge.
  const auto edge = [&](glm::dvec2 inside, const glm::dvec2& step) {
    glm::dvec2 outside = inside + step;
    for (int i = 0; i < 8; ++i) {
      const glm::dvec2 middle = 0.5 * (inside + outside);
      (passes(middle) ? inside : outside) = middle;
    }
    return inside;
  };
  std::array<std::array<bool, kPupilGrid>, kPupilGrid> pass;
  for (int y = 0; y < kPupilGrid; ++y) {
    for (int x = 0; x < kPupilGrid; ++x) pass[y][x] = passes({at(x), at(y)});
  }
  const auto search = [&](bool along_x) {
    for (int line = 0; line < kPupilGrid; ++line) {
      int first = kPupilGrid, last = -1;
      for (int i = 0; i < kPupilGrid; ++i) {
        if (along_x ? pass[line][i] : pass[i][line]) first = std::min(first, i), last = i;
      }
      if (last < 0) continue;
      const auto point = [&](int i) {
        return along_x ? glm::dvec2(at(i), at(line)) : glm::dvec2(at(line), at(i));
      };
      const glm::dvec2 step = along_x ? glm::dvec2(spacing, 0) : glm::dvec2(0, spacing);
      box.Add(edge(point(first), -step)), box.Add(edge(point(last), step));
    }
  };
  search(true), search(false);
}

// As pbrt does, the boxes are a little larger than the pupils that its 1024^2 points find.
std::vector<PupilBox> PupilsOf(const LensDesign& design) {
  const std::vector<Crossing> crossings = CrossingsFromFilm(design);
  const double reach = 1.5 * crossings[0].aperture, margin = 2 * std::sqrt(8.0) * reach / 1024;
  std::vector<PupilBox> boxes(kPupils);
  tbb::parallel_for(std::uint32_t{0}, kPupils, [&](std::uint32_t i) {
    for (const double end : {i, i + 1}) {
      AddPupil(crossings, end / kPupils * design.film_diagonal / 2, reach, boxes[i]);
    }
    // Nothing is seen from there.
    if (boxes[i].is_empty()) boxes[i].Add(glm::dvec2(-reach)), boxes[i].Add(glm::dvec2(reach));
    boxes[i].low -= margin, boxes[i].high += margin;
  });
  return boxes;
}

double Area(const PupilBox& box) {
  const glm::dvec2 size = box.high - box.low;
  return size.x * size.y;
}

}  // namespace

bool FocusLens(LensDesign& design, double distance) {
  const auto lens = ThickLensOf(design);
  if (!lens || !(lens->f > 0)) return false;
  // The lens moves by m from the film, so that 1 / (film + m) + 1 / (distance - scene - m) = 1 / f
  // with the distances from its principal planes.
  const double sum = lens->film + distance - lens->scene;
  const double root2 = sum * (sum - 4 * lens->f);
  if (!(root2 >= 0)) return false;
  const double from_film = 0.5 * (sum - std::sqrt(root2));
  design.interfaces.back().thickness += from_film - lens->film;
  return true;
}

double FocalLength(const LensDesign& design) {
  const auto lens = ThickLensOf(design);
  return lens ? lens->f : 0;
}

std::optional<LensRayOfFilm> FollowFromFilm(const LensDesign& design, const LensRayOfFilm& ray) {
  AxisRay at = {{ray.origin[0], ray.origin[1], ray.origin[2]},
                {ray.dir[0], ray.dir[1], ray.dir[2]}};
  for (const Crossing& step : CrossingsFromFilm(design)) {
    if (!Pass(step, /*wide=*/false, at)) return std::nullopt;
  }
  return LensRayOfFilm{{at.origin.x, at.origin.y, at.origin.z}, {at.dir.x, at.dir.y, at.dir.z}};
}

LensSystem::LensSystem(const LensDesign& of) : design(of), focal_length(FocalLength(of)) {
  const std::vector<Crossing> crossings = CrossingsFromFilm(design);
  const std::vector<PupilBox> pupils = PupilsOf(design);
  const double rear = crossings[0].vertex, middle = Area(pupils[0]);
  const auto add = [&](const auto& list, const auto& value) {
    for (const auto& entry : list) columns.push_back(float(value(entry)));
  };
  add(crossings, [](const Crossing& s) { return s.vertex; });
  add(crossings, [](const Crossing& s) { return s.radius; });
  add(crossings, [](const Crossing& s) { return s.aperture * s.aperture; });
  add(crossings, [](const Crossing& s) { return s.eta; });
  add(pupils, [](const PupilBox& b) { return b.low.x; });
  add(pupils, [](const PupilBox& b) { return b.low.y; });
  add(pupils, [](const PupilBox& b) { return b.high.x - b.low.x; });
  add(pupils, [](const PupilBox& b) { return b.high.y - b.low.y; });
  add(pupils, [&](const PupilBox& b) {
    const double relative_to = design.weight == LensWeight::kRelative ? middle : rear * rear;
    return design.gain * Area(b) / relative_to;
  });
  const std::size_t n = crossings.size();
  const float* const first = columns.data();
  view = {.interfaces = std::uint32_t(n),
          .vertex = first,
          .radius = first + n,
          .aperture2 = first + 2 * n,
          .eta = first + 3 * n,
          .pupil_x = first + 4 * n,
          .pupil_y = first + 4 * n + kPupils,
          .pupil_width = first + 4 * n + 2 * kPupils,
          .pupil_height = first + 4 * n + 3 * kPupils,
          .pupil_weight = first + 4 * n + 4 * kPupils,
          .half_diagonal = float(design.film_diagonal / 2)};
}

}  // namespace skywave
