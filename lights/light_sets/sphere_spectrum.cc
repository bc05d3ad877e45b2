#include "lights/light_sets/sphere_spectrum.h"

namespace skywave {

std::vector<double> SpherePower(std::span<const Vector3> directions, int degrees) {
  std::vector<double> power(std::size_t(degrees) + 1);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      const double x = Dot(directions[i], directions[j]), pairs = i == j ? 1 : 2;
      double last = 0, polynomial = 1;
      for (int l = 0; l <= degrees; ++l) {
        power[std::size_t(l)] += pairs * polynomial;
        const double next = ((2 * l + 1) * x * polynomial - l * last) / (l + 1);
        last = polynomial;
        polynomial = next;
      }
    }
  }
  for (double& value : power) value /= double(directions.size());
  return power;
}

}  // namespace skywave
