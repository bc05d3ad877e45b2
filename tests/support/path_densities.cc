#include "tests/support/path_densities.h"

namespace skywave {
namespace {

double Square(double x) { return x * x; }

// Directions at `from` to areas at `to`.
double AreaPerSolidAngle(Vec from, Vec to, Vec normal) {
  const Vec way = to - from;
  return std::fabs(Dot(normal, Unit(way))) / Dot(way, way);
}

}  // namespace

double WayDensity(const BidirectionalPath& path, std::size_t lights) {
  const std::vector<PathSurface>& s = path.surfaces;
  const std::size_t from_eye = s.size() + 1 - lights;  // surfaces of the sub-path of the eye, + 1
  const bool hits_light = lights == 0;
  const std::size_t eye_surfaces = hits_light ? s.size() : from_eye;
  if (hits_light && (path.light == PathLight::kPosition || path.light == PathLight::kDirection)) {
    return 0;
  }
  // Both ends of the connection scatter to where they are told.
  if (!hits_light && eye_surfaces > 0 && s[eye_surfaces - 1].delta) return 0;
  if (!hits_light && eye_surfaces < s.size() && s[eye_surfaces].delta) return 0;

  double density = eye_surfaces == 0 ? path.light_paths : 1;
  for (std::size_t i = 0; i < eye_surfaces; ++i) {
    const double direction = i == 0 ? path.eye_pdf : s[i - 1].pdf_to_light;
    density *=
        direction * AreaPerSolidAngle(i == 0 ? path.eye : s[i - 1].point, s[i].point, s[i].normal);
  }
  if (hits_light) {
    const PathSurface& last = s.back();
    return density * last.pdf_to_light *
           (path.distant() ? 1
                           : AreaPerSolidAngle(last.point, path.light_point, path.light_normal));
  }
  density *= path.light_pdf;
  for (std::size_t i = s.size(); i-- > eye_surfaces;) {
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

std::vector<double> WayWeights(const BidirectionalPath& path) {
  std::vector<double> weights;
  double sum = 0;
  for (std::size_t lights = 0; lights <= path.surfaces.size() + 1; ++lights) {
    weights.push_back(Square(WayDensity(path, lights)));
    sum += weights.back();
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

}  // namespace skywave
