#include "tests/support/path_densities.h"

namespace skywave {
namespace {

double Square(double x) { return x * x; }

// Converts densities per solid angle at `from` to densities per area at `to`.
double AreaPerSolidAngle(Vec from, Vec to, Vec normal) {
  const Vec offset = to - from;
  return std::fabs(Dot(normal, Unit(offset))) / Dot(offset, offset);
}

// Returns the density of the first `count` surfaces from the eye.
double EyeDensity(const BidirectionalPath& path, std::size_t count) {
  const std::vector<PathSurface>& s = path.surfaces;
  double density = 1;
  for (std::size_t i = 0; i < count; ++i) {
    const double direction = i == 0 ? path.eye_pdf : s[i - 1].pdf_to_light;
    density *=
        direction * AreaPerSolidAngle(i == 0 ? path.eye : s[i - 1].point, s[i].point, s[i].normal);
  }
  return density;
}

// Returns the density of the light and the surfaces from the last one to `first`.
double LightDensity(const BidirectionalPath& path, std::size_t first) {
  const std::vector<PathSurface>& s = path.surfaces;
  double density = path.light_pdf;
  for (std::size_t i = s.size(); i-- > first;) {
    if (i + 1 < s.size()) {
      density *= s[i + 1].pdf_to_eye * AreaPerSolidAngle(s[i + 1].point, s[i].point, s[i].normal);
    } else if (path.distant()) {
      density *= path.emission_pdf * std::fabs(Dot(s[i].normal, path.light_point));
    } else {
      density *= path.emission_pdf * AreaPerSolidAngle(path.light_point, s[i].point, s[i].normal);
    }
  }
  return density;
}

}  // namespace

double TechniqueDensity(const BidirectionalPath& path, std::size_t lights) {
  const std::vector<PathSurface>& s = path.surfaces;
  if (lights == 0) {
    if (path.light == PathLight::kPosition || path.light == PathLight::kDirection) return 0;
    const PathSurface& last = s.back();
    return EyeDensity(path, s.size()) * last.pdf_to_light *
           (path.distant() ? 1
                           : AreaPerSolidAngle(last.point, path.light_point, path.light_normal));
  }
  const std::size_t eye_surfaces = s.size() + 1 - lights;
  // The connection fixes the scattered direction at both ends, which a delta BSDF cannot produce.
  if (eye_surfaces > 0 && s[eye_surfaces - 1].delta) return 0;
  if (eye_surfaces < s.size() && s[eye_surfaces].delta) return 0;
  const double count = eye_surfaces == 0 ? path.light_paths : 1;
  return count * EyeDensity(path, eye_surfaces) * LightDensity(path, eye_surfaces);
}

double MergeDensity(const BidirectionalPath& path, std::size_t surface) {
  if (path.surfaces[surface].delta) return 0;
  return path.eta_vcm * EyeDensity(path, surface + 1) * LightDensity(path, surface);
}

TechniqueWeights::TechniqueWeights(const BidirectionalPath& path) {
  double sum = 0;
  const auto add = [&sum](double density, std::vector<double>& weights) {
    weights.push_back(Square(density));
    sum += weights.back();
  };
  for (std::size_t i = 0; i <= path.surfaces.size() + 1; ++i)
    add(TechniqueDensity(path, i), connected);
  for (std::size_t i = 0; i < path.surfaces.size(); ++i) add(MergeDensity(path, i), merged);
  for (double& weight : connected) weight /= sum;
  for (double& weight : merged) weight /= sum;
}

}  // namespace skywave
