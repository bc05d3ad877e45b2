// Vectors in double precision serve to build tables; nothing that runs once per ray uses them.
#pragma once

#include <cmath>

namespace skywave {

struct Vector3 {
  double x = 0, y = 0, z = 0;
};

inline Vector3 operator+(const Vector3& a, const Vector3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vector3 operator-(const Vector3& a, const Vector3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vector3 operator*(double s, const Vector3& a) { return {s * a.x, s * a.y, s * a.z}; }
inline Vector3& operator+=(Vector3& a, const Vector3& b) { return a = a + b; }
inline bool operator==(const Vector3& a, const Vector3& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}

inline double Dot(const Vector3& a, const Vector3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vector3 Cross(const Vector3& a, const Vector3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double Length(const Vector3& a) { return std::sqrt(Dot(a, a)); }

// Returns a / |a|, or `fallback` if a is only the rounding of a sum of vectors whose lengths sum to
// `scale`.
inline Vector3 NormalizeOr(const Vector3& a, double scale, const Vector3& fallback) {
  const double length = Length(a);
  return length > 1e-11 * scale ? (1 / length) * a : fallback;
}

// Returns the angle between unit vectors [rad], accurate near 0 and pi.
inline double AngleBetween(const Vector3& a, const Vector3& b) {
  return 2 * std::atan2(Length(a - b), Length(a + b));
}

}  // namespace skywave
