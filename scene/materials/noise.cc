#include "scene/materials/noise.h"

#include <cmath>
#include <cstdint>

namespace skywave {
namespace {

constexpr std::uint8_t kPermutation[256] = {
    151, 160, 137, 91,  90,  15,  131, 13,  201, 95,  96,  53,  194, 233, 7,   225, 140, 36,  103,
    30,  69,  142, 8,   99,  37,  240, 21,  10,  23,  190, 6,   148, 247, 120, 234, 75,  0,   26,
    197, 62,  94,  252, 219, 203, 117, 35,  11,  32,  57,  177, 33,  88,  237, 149, 56,  87,  174,
    20,  125, 136, 171, 168, 68,  175, 74,  165, 71,  134, 139, 48,  27,  166, 77,  146, 158, 231,
    83,  111, 229, 122, 60,  211, 133, 230, 220, 105, 92,  41,  55,  46,  245, 40,  244, 102, 143,
    54,  65,  25,  63,  161, 1,   216, 80,  73,  209, 76,  132, 187, 208, 89,  18,  169, 200, 196,
    135, 130, 116, 188, 159, 86,  164, 100, 109, 198, 173, 186, 3,   64,  52,  217, 226, 250, 124,
    123, 5,   202, 38,  147, 118, 126, 255, 82,  85,  212, 207, 206, 59,  227, 47,  16,  58,  17,
    182, 189, 28,  42,  223, 183, 170, 213, 119, 248, 152, 2,   44,  154, 163, 70,  221, 153, 101,
    155, 167, 43,  172, 9,   129, 22,  39,  253, 19,  98,  108, 110, 79,  113, 224, 232, 178, 185,
    112, 104, 218, 246, 97,  228, 251, 34,  242, 193, 238, 210, 144, 12,  191, 179, 162, 241, 81,
    51,  145, 235, 249, 14,  239, 107, 49,  192, 214, 31,  181, 199, 106, 157, 184, 84,  204, 176,
    115, 121, 50,  45,  127, 4,   150, 254, 138, 236, 205, 93,  222, 114, 67,  29,  24,  72,  243,
    141, 128, 195, 78,  66,  215, 61,  156, 180};

std::uint8_t Permuted(int i) { return kPermutation[i & 255]; }

// Returns the gradient of a corner times the way from it. It is one of the twelve directions to the
// edges of a cube; four of them count twice.
double CornerNoise(int hash, const glm::dvec3& away) {
  hash &= 15;
  const double u = hash < 8 || hash == 12 || hash == 13 ? away.x : away.y;
  const double v = hash < 4 || hash == 12 || hash == 13 ? away.y : away.z;
  return (hash & 1 ? -u : u) + (hash & 2 ? -v : v);
}

// Returns a whole number modulo the period.
int InPeriod(double whole) {
  constexpr double kPeriod = 256, kMostInt = 1 << 30;
  // Coordinates that no int can hold are far beyond the period.
  if (!(std::abs(whole) < kMostInt)) whole -= kPeriod * std::floor(whole / kPeriod);
  return int(whole) & 255;
}

}  // namespace

double GradientNoise(const glm::dvec3& at) {
  const glm::dvec3 whole = glm::floor(at), inside = at - whole;
  const int x = InPeriod(whole.x), y = InPeriod(whole.y), z = InPeriod(whole.z);
  const glm::dvec3 share =
      inside * inside * inside * (inside * (inside * 6.0 - 15.0) + glm::dvec3(10));
  const glm::dvec3 weights[2] = {1.0 - share, share}, away[2] = {inside, inside - 1.0};
  const int rows[2] = {Permuted(x), Permuted(x + 1)};
  double noise = 0;
  for (int k = 0; k < 2; ++k) {
    for (int j = 0; j < 2; ++j) {
      for (int i = 0; i < 2; ++i) {
        const int hash = Permuted(Permuted(rows[i] + y + j) + z + k);
        noise += weights[i].x * weights[j].y * weights[k].z *
                 CornerNoise(hash, {away[i].x, away[j].y, away[k].z});
      }
    }
  }
  return noise;
}

double FractalNoise(glm::dvec3 at, double roughness, int octaves) {
  double sum = 0, strength = 1;
  for (int i = 0; i < octaves; ++i) {
    sum += strength * GradientNoise(at);
    at *= 1.99, strength *= roughness;
  }
  return sum;
}

double TurbulentNoise(glm::dvec3 at, double roughness, int octaves) {
  double sum = 0, strength = 1;
  for (int i = 0; i < octaves; ++i) {
    sum += strength * std::abs(GradientNoise(at));
    at *= 1.99, strength *= roughness;
  }
  return sum + 0.2 * strength;
}

bool IsInDot(const glm::dvec2& at) {
  constexpr double kRadius = 0.35;
  const glm::dvec2 cell = glm::floor(at + 0.5);
  const auto noise = [&](double s, double t) {
    return GradientNoise({cell.x + s, cell.y + t, 0.5});
  };
  if (!(noise(0.5, 0.5) > 0)) return false;
  const glm::dvec2 shift(noise(1.5, 2.8), noise(4.5, 9.8));
  const glm::dvec2 away = at - (cell + (0.5 - kRadius) * shift);
  return glm::dot(away, away) < kRadius * kRadius;
}

}  // namespace skywave
