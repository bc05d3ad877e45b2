#include "tests/support/layered_walk.h"

#include <cmath>
#include <complex>

namespace skywave {
namespace {

double Uniform(Random& random) { return random.Between(0, 1); }

// Returns a direction at a cosine to `axis`, at a random azimuth.
Vec Around(Vec axis, double cosine, Random& random) {
  const Vec other = std::fabs(axis.x) < 0.5 ? Vec{1, 0, 0} : Vec{0, 1, 0};
  const Vec s = Unit(Cross(axis, other)), t = Cross(axis, s);
  const double phi = 2 * kPi * Uniform(random),
               sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  return cosine * axis + sine * std::cos(phi) * s + sine * std::sin(phi) * t;
}

// Draws a facet as seen from v, whose z is positive, by the disk of Heitz 2018.
Vec VisibleFacet(Vec v, double alpha, Random& random) {
  const Vec stretched = Unit({alpha * v.x, alpha * v.y, v.z});
  const double across2 = stretched.x * stretched.x + stretched.y * stretched.y;
  const Vec s = across2 > 0 ? Unit({-stretched.y, stretched.x, 0}) : Vec{1, 0, 0};
  const Vec t = Cross(stretched, s);
  const double r = std::sqrt(Uniform(random)), phi = 2 * kPi * Uniform(random);
  const double a = r * std::cos(phi), middle = 0.5 * (1 + stretched.z);
  const double b =
      (1 - middle) * std::sqrt(std::max(0.0, 1 - a * a)) + middle * (r * std::sin(phi));
  const Vec n = a * s + b * t + std::sqrt(std::max(0.0, 1 - a * a - b * b)) * stretched;
  return Unit({alpha * n.x, alpha * n.y, std::max(n.z, 1e-9)});
}

double Masking(double alpha, double cosine) {
  const double tangent2 = 1 / (cosine * cosine) - 1;
  return 0.5 * (std::sqrt(1 + alpha * alpha * tangent2) - 1);
}
// The part of the light from v, masked already, that is not masked on its way to w.
double Unmasked(double alpha, double v, double w) {
  return (1 + Masking(alpha, v)) / (1 + Masking(alpha, v) + Masking(alpha, w));
}

// Returns the reflectance at the border to a relative index, by the amplitudes of both
// polarisations.
double Reflectance(double cosine, std::complex<double> index) {
  const auto inner = std::sqrt(1.0 - (1 - cosine * cosine) / (index * index));
  return 0.5 * (std::norm((cosine - index * inner) / (cosine + index * inner)) +
                std::norm((index * cosine - inner) / (index * cosine + inner)));
}

struct Light {
  Vec direction;  // in which it travels
  double weight = 1;
};

// Light meets the interface from the side of its z. `index` is that of the other side over this
// one.
void MeetInterface(double alpha, double index, Light& light, Random& random) {
  const double side = light.direction.z < 0 ? 1 : -1;
  const Vec seen = {-light.direction.x, -light.direction.y, std::fabs(light.direction.z)};
  const Vec facet = alpha < 2e-3 ? Vec{0, 0, 1} : VisibleFacet(seen, alpha, random);
  const double toward = Dot(seen, facet);
  const double sine2 = (1 - toward * toward) / (index * index);
  const double reflectance = sine2 >= 1 ? 1 : Reflectance(toward, index);
  Vec w = {};
  bool right = false;
  if (Uniform(random) < reflectance) {
    w = 2 * toward * facet - seen;
    right = w.z > 0;
  } else {
    w = (toward / index - std::sqrt(1 - sine2)) * facet - (1 / index) * seen;
    right = w.z < 0;
  }
  light.weight *= right ? Unmasked(alpha, seen.z, std::fabs(w.z)) : 0;
  light.direction = {w.x, w.y, w.z * side};
}

void MeetBase(const Material& material, int channel, Light& light, Random& random) {
  const Vec up = {0, 0, 1};
  if (material.bsdf == BsdfKind::kCoatedDiffuse) {
    light.weight *= material.reflectance[channel];
    light.direction = Around(up, std::sqrt(1 - Uniform(random)), random);
    return;
  }
  const double alpha = material.alpha;
  const Vec v = -light.direction;
  const Vec facet = VisibleFacet(v, alpha, random);
  const Vec w = 2 * Dot(v, facet) * facet - v;
  const std::complex<double> index(material.eta[channel], -material.k[channel]);
  light.weight *= w.z > 0 ? material.reflectance[channel] * Unmasked(alpha, v.z, w.z) *
                                Reflectance(Dot(v, facet), index / double(material.ior))
                          : 0;
  light.direction = w;
}

double ScatteredCosine(double g, double u) {
  if (std::fabs(g) < 1e-3) return 2 * u - 1;
  const double root = (1 - g * g) / (1 - g + 2 * g * u);
  return (1 + g * g - root * root) / (2 * g);
}

}  // namespace

LayeredPath WalkLayers(const Material& material, int channel, Vec wo, Random& random) {
  const double coat =
      material.bsdf == BsdfKind::kCoatedDiffuse ? material.alpha : material.coat_alpha;
  const double ior = material.ior, thickness = material.coat_thickness;
  Light light = {-wo};
  double depth = 0;  // below the interface
  MeetInterface(coat, ior, light, random);
  while (light.weight > 0 && !(depth == 0 && light.direction.z > 0)) {
    if (light.weight < 0.05) {
      if (Uniform(random) > 0.5) return {};
      light.weight *= 2;
    }
    const double way = -std::log(1 - Uniform(random));
    const double next = depth - way * light.direction.z;
    if (thickness > 0 && next > 0 && next < thickness) {
      depth = next;
      light.weight *= material.coat_albedo[channel];
      light.direction = Around(light.direction,
                               ScatteredCosine(material.coat_asymmetry, Uniform(random)), random);
      continue;
    }
    if (light.direction.z < 0) {
      depth = thickness;
      MeetBase(material, channel, light, random);
      // A clear coat has no thickness: light is at once below the interface again.
      if (thickness > 0) continue;
    }
    if (!(light.weight > 0)) break;
    depth = 0;
    MeetInterface(coat, 1 / ior, light, random);
    if (light.direction.z > 0) break;
  }
  return {light.direction, light.weight};
}

}  // namespace skywave
