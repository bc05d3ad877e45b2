#include "lights/maps/healpix.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skywave {

Vector3 DirectionOfHealpix(int square, double x, double y) {
  // Rows run from 0 at up to 4 at down; the middle of a square lies in row 1, 2 or 3. Azimuths are
  // counted in eighths of a turn.
  const int belt = square / 4;
  const double row = belt + 2 - x - y;
  const double middle = 2 * (square % 4) + (belt == 1 ? 0 : 1);
  double up = (2 - row) * 2 / 3, azimuth = middle + x - y, sine = std::sqrt(1 - up * up);
  // Within 1 of a pole a row is narrower, in proportion to its distance from there.
  const double reach = std::min(row, 4 - row);
  if (reach < 1) {
    const double below = reach * reach / 3;  // the pole, in height
    up = row < 2 ? 1 - below : below - 1;
    azimuth = middle + (reach > 0 ? (x - y) / reach : 0);
    sine = std::sqrt(below * (2 - below));
  }
  const double angle = azimuth * std::numbers::pi / 4;
  return {sine * std::sin(angle), sine * std::cos(angle), up};
}

}  // namespace skywave
