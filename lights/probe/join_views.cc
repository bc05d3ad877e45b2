#include "lights/probe/join_views.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <utility>

#include "base/error.h"
#include "lights/maps/environment_map.h"
#include "lights/maps/projections.h"
#include "lights/maps/resample.h"
#include "lights/maps/sphere_picture.h"

namespace skywave {
namespace {

using Rgb = std::array<double, 3>;

constexpr double kNearTurn = 0.5;  // from JoinOptions::turn [rad]

// ---- What a view is worth in a direction of its own ----

// Returns the resolution across a direction relative to that in the middle of the ball, where the
// camera is seen: along a radius of the picture it falls as the cosine of half the angle from
// there, to 0 at the rim.
double Resolution(const Vector3& direction) { return std::sqrt((1 - direction.y) / 2); }

// Returns 0 within `radius` of the camera [rad], 1 at about twice that, and a smooth step between.
double BesideCamera(const Vector3& direction, double radius) {
  const double chord = std::sqrt(2 + 2 * direction.y);  // from the camera, at -forward
  const double t = std::clamp(chord / (2 * std::sin(radius / 2)) - 1, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// ---- By which rotation two views agree ----

// A view as the search reads it: small, and of logarithms.
struct Logarithms {
  Image ball;     // ln of luminance, three times
  double camera;  // JoinOptions::camera

  double Weight(const Vector3& direction) const {
    return Resolution(direction) * BesideCamera(direction, camera);
  }
  double At(const Vector3& direction) const {
    Rgb sum = {};
    SpherePicture(ball, Projection::kMirrorBall)
        .Add(PointOfDirection(Projection::kMirrorBall, direction), 1, sum);
    return sum[0];
  }
};

Logarithms LogarithmsOf(const Image& view, int side, double camera) {
  Image ball = Resample(view, Projection::kMirrorBall, Projection::kMirrorBall, side, side);
  double mean = 0;
  for (const float value : ball.rgb) mean += value / double(ball.rgb.size());
  for (std::size_t i = 0; i < ball.rgb.size(); i += 3) {
    // What is far darker than the mean says nothing.
    std::fill_n(&ball.rgb[i], 3, float(std::log(Luminance(&ball.rgb[i]) + 1e-3 * mean)));
  }
  return {std::move(ball), camera};
}

// Returns `count` directions evenly over the sphere (a Fibonacci lattice).
std::vector<Vector3> EvenDirections(int count) {
  std::vector<Vector3> directions;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - z * z);
    const double angle = 2 * std::numbers::pi * std::fmod(i * std::numbers::phi, 1.0);
    directions.push_back({r * std::cos(angle), r * std::sin(angle), z});
  }
  return directions;
}

// The directions in which two views are compared, with what the first has there.
struct Comparison {
  const Logarithms& second;
  std::vector<Vector3> direction;  // of the first view
  std::vector<double> first, weight;

  Comparison(const Logarithms& one, const Logarithms& two, int count) : second(two) {
    for (const Vector3& d : EvenDirections(count)) {
      const double w = one.Weight(d);
      if (!(w > 0)) continue;
      direction.push_back(d), first.push_back(one.At(d)), weight.push_back(w);
    }
  }

  // Returns the correlation of both, weighted by the worth of both, which does not see a factor
  // between their brightnesses.
  double Agreement(const Rotation& first_from_second) const {
    double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    for (std::size_t i = 0; i < direction.size(); ++i) {
      const Vector3 d = RotatedBack(first_from_second, direction[i]);
      const double w = weight[i] * second.Weight(d);
      if (!(w > 0)) continue;
      const double p = first[i], q = second.At(d);
      n += w, a += w * p, b += w * q, aa += w * p * p, bb += w * q * q, ab += w * p * q;
    }
    const double variances = (n * aa - a * a) * (n * bb - b * b);
    return variances > 0 ? (n * ab - a * b) / std::sqrt(variances) : 0;
  }
};

// Returns the rotation about a unit vector (Rodrigues).
Rotation About(const Vector3& axis, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const auto turned = [&](const Vector3& v) {
    return c * v + s * Cross(axis, v) + ((1 - c) * Dot(axis, v)) * axis;
  };
  return {turned({1, 0, 0}), turned({0, 1, 0}), turned({0, 0, 1})};
}

Rotation Product(const Rotation& a, const Rotation& b) {
  return {Rotated(a, b[0]), Rotated(a, b[1]), Rotated(a, b[2])};
}

// Returns rotations about `step` apart [rad]: forward to each of evenly spread directions, and from
// there about it.
std::vector<Rotation> EvenRotations(double step) {
  std::vector<Rotation> rotations;
  const int rolls = int(std::ceil(2 * std::numbers::pi / step));
  for (const Vector3& forward :
       EvenDirections(int(std::ceil(4 * std::numbers::pi / (step * step))))) {
    const Vector3 axis = NormalizeOr(Cross({0, 1, 0}, forward), 1, {0, 0, 1});
    const Rotation there = About(axis, AngleBetween({0, 1, 0}, forward));
    for (int roll = 0; roll < rolls; ++roll) {
      rotations.push_back(Product(there, About({0, 1, 0}, 2 * std::numbers::pi * roll / rolls)));
    }
  }
  return rotations;
}

// True unless a rotation is far from what the options say of it.
bool IsNearTurn(const Rotation& rotation, const std::optional<double>& turn) {
  if (!turn) return true;
  const double apart = std::remainder(AngleAround(rotation) - *turn, 2 * std::numbers::pi);
  return std::abs(apart) < kNearTurn && AngleBetween(rotation[2], {0, 0, 1}) < kNearTurn;
}

struct Found {
  double agreement;
  Rotation rotation;
};

// Returns the best of the rotations around one, by steps about the three axes that are halved
// until they are shorter than `least` [rad].
Found Climb(const Comparison& views, Found best, double step, double least) {
  while (step > least) {
    const Found before = best;
    for (int axis = 0; axis < 3; ++axis) {
      for (const double angle : {-step, step}) {
        const Vector3 about = {double(axis == 0), double(axis == 1), double(axis == 2)};
        const Rotation rotation = Product(About(about, angle), before.rotation);
        const double agreement = views.Agreement(rotation);
        if (agreement > best.agreement) best = {agreement, rotation};
      }
    }
    if (best.agreement == before.agreement) step /= 2;
  }
  return best;
}

// Returns the rotation from the axes of `second` to those of `first`: all of a coarse grid are
// tried, and the best of them climb through finer and finer maps.
Found FindRotation(const Image& first, const Image& second, const JoinOptions& options) {
  constexpr int kCoarsest = 32;      // side of the picture [pixels],
  constexpr double kGrid = 0.15;     // distance of rotations that are tried in it [rad],
  constexpr std::size_t kKept = 24;  // how many of these climb, and a quarter of them at each level
  const int finest = std::min(512, std::min(first.width, second.width));
  std::vector<Found> found;
  std::size_t kept = kKept;
  for (int side = kCoarsest;; side = std::min(2 * side, finest), kept = (kept + 3) / 4) {
    const Logarithms one = LogarithmsOf(first, side, options.camera);
    const Logarithms two = LogarithmsOf(second, side, options.camera);
    const double pixel = 4.0 / side;  // in the middle of the ball [rad]
    if (found.empty()) {
      for (const Rotation& rotation : EvenRotations(kGrid)) {
        if (IsNearTurn(rotation, options.turn)) found.push_back({0, rotation});
      }
      const Comparison few(one, two, 300);
      tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t i) {
        found[i].agreement = few.Agreement(found[i].rotation);
      });
    }
    const auto better = [](const Found& a, const Found& b) { return a.agreement > b.agreement; };
    std::stable_sort(found.begin(), found.end(), better);
    found.resize(std::min(found.size(), kept));
    const Comparison views(one, two, std::min(side * side / 2, 20000));
    tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t i) {
      found[i].agreement = views.Agreement(found[i].rotation);
      found[i] = Climb(views, found[i], side == kCoarsest ? kGrid / 2 : pixel, pixel / 32);
    });
    std::stable_sort(found.begin(), found.end(), better);
    if (side == finest) return found[0];
  }
}

// ---- How much brighter one is ----

// Returns the medians of the ratios of first to second where both see well.
Rgb GainOf(const Image& first, const Image& second, const Rotation& first_from_second,
           const JoinOptions& options) {
  constexpr double kWell = 0.4;  // Resolution
  const SpherePicture one(first, Projection::kMirrorBall), two(second, Projection::kMirrorBall);
  std::array<std::vector<double>, 3> ratios;
  for (const Vector3& d : EvenDirections(20000)) {
    const Vector3 e = RotatedBack(first_from_second, d);
    if (std::min(Resolution(d) * BesideCamera(d, options.camera),
                 Resolution(e) * BesideCamera(e, options.camera)) < kWell) {
      continue;
    }
    Rgb a = {}, b = {};
    one.Add(PointOfDirection(Projection::kMirrorBall, d), 1, a);
    two.Add(PointOfDirection(Projection::kMirrorBall, e), 1, b);
    for (std::size_t c = 0; c < 3; ++c) {
      if (a[c] > 0 && b[c] > 0) ratios[c].push_back(a[c] / b[c]);
    }
  }
  Rgb gain = {1, 1, 1};
  for (std::size_t c = 0; c < 3; ++c) {
    if (ratios[c].empty()) continue;
    const auto middle = ratios[c].begin() + std::ptrdiff_t(ratios[c].size() / 2);
    std::nth_element(ratios[c].begin(), middle, ratios[c].end());
    gain[c] = *middle;
  }
  return gain;
}

// ---- The map ----

// Fills a row of the map, and returns the solid angle in it that only cameras see [sr].
double FillRow(const std::vector<SpherePicture>& pictures, const std::vector<PlacedView>& placed,
               double camera, int y, Image& map) {
  constexpr int kSamples = 4;  // samples along a side of a texel
  double unseen = 0;
  for (int x = 0; x < map.width; ++x) {
    Rgb sum = {};
    double weights = 0;
    for (int s = 0; s < kSamples * kSamples; ++s) {
      const ImagePoint point = {(x + (s % kSamples + 0.5) / kSamples) / map.width,
                                (y + (s / kSamples + 0.5) / kSamples) / map.height};
      const Vector3 direction = *DirectionOfPoint(Projection::kLatLong, point);
      bool seen = false;
      for (std::size_t i = 0; i < pictures.size(); ++i) {
        const Vector3 local = RotatedBack(placed[i].map_from_view, direction);
        const double beside = BesideCamera(local, camera);
        seen = seen || beside > 0;
        // The eighth power leaves the mean of two to where both see about as well. What only
        // cameras see is taken from them.
        const double weight = std::pow(Resolution(local), 8) * std::max(beside, 1e-6);
        Rgb radiance = {};
        pictures[i].Add(PointOfDirection(Projection::kMirrorBall, local), weight, radiance);
        for (std::size_t c = 0; c < 3; ++c) sum[c] += placed[i].gain[c] * radiance[c];
        weights += weight;
      }
      if (!seen) unseen += RowSolidAngle(map.width, map.height, y) / (kSamples * kSamples);
    }
    for (std::size_t c = 0; c < 3; ++c) map.Pixel(x, y)[c] = float(sum[c] / weights);
  }
  return unseen;
}

void Check(const std::vector<BallView>& views) {
  if (views.size() < 2) throw InputError({}, "two views at least are needed", kExitUsage);
  for (const BallView& view : views) {
    const auto refuse = [&](const std::string& why) {
      throw InputError(InputPosition::File(view.name), why);
    };
    const int width = view.image.width, height = view.image.height;
    if (50 * std::abs(width - height) > std::max(width, height)) {
      refuse(fmt::format("is {}x{}: crop photographs to the square that the ball fills", width,
                         height));
    }
    constexpr int kSmallest = 48;
    if (std::min(width, height) < kSmallest) {
      refuse(
          fmt::format("is {}x{}; at least {} pixels across are needed", width, height, kSmallest));
    }
    if (std::all_of(view.image.rgb.begin(), view.image.rgb.end(),
                    [](float value) { return value == 0; })) {
      refuse("is black");
    }
  }
}

}  // namespace

double AngleAround(const Rotation& map_from_view) {
  return std::atan2(-map_from_view[1].x, map_from_view[1].y);
}

JoinedViews JoinViews(const std::vector<BallView>& views, const JoinOptions& options) {
  constexpr double kAgree = 0.5;
  Check(views);
  const Image& first = views[0].image;
  JoinedViews joined;
  joined.placed.resize(views.size());
  for (std::size_t i = 1; i < views.size(); ++i) {
    JoinOptions to_this = options;
    if (options.turn) to_this.turn = double(i) * *options.turn;
    const Found found = FindRotation(first, views[i].image, to_this);
    if (!(found.agreement > kAgree)) {
      throw InputError(InputPosition::File(views[i].name),
                       fmt::format("does not show what {} shows: their best correlation is {:.2f}, "
                                   "and 1 is that of equal ones",
                                   views[0].name, found.agreement));
    }
    joined.placed[i] = {found.rotation, GainOf(first, views[i].image, found.rotation, options),
                        found.agreement};
  }
  const int height = options.height > 0
                         ? options.height
                         : LatLongHeight(Projection::kMirrorBall, first.width, first.height);
  joined.latlong = Image(2 * height, height);
  std::vector<SpherePicture> pictures;
  for (const BallView& view : views) pictures.emplace_back(view.image, Projection::kMirrorBall);
  std::vector<double> unseen(std::size_t(height), 0.0);
  tbb::parallel_for(0, height, [&](int y) {
    unseen[std::size_t(y)] = FillRow(pictures, joined.placed, options.camera, y, joined.latlong);
  });
  for (const double row : unseen) joined.unseen += row;
  return joined;
}

}  // namespace skywave
