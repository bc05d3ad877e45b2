// Tests maps from photographs of a mirror ball: views of a known place from several sides are laid
// over each other, no camera is left where another view sees what it hides, and what does not fit
// is refused.
#include "lights/probe/join_views.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "base/error.h"
#include "lights/maps/projections.h"

namespace skywave {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kCameraRadius = 15 * kDegree;  // of the dark disk in photographs
using Place = std::function<double(const Vector3&)>;

double Lobe(const Vector3& d, const Vector3& towards, double sharpness) {
  return std::exp(sharpness * (Dot(d, (1 / Length(towards)) * towards) - 1));
}

// A room: bright above, dark below, with three lamps and a window with edges.
double Room(const Vector3& d) {
  const bool window = std::abs(d.z - 0.2) < 0.25 && d.x < -0.4 && d.y > 0.3;
  return 0.4 + 0.2 * std::tanh(4 * d.z) + 0.1 * d.x + 40 * Lobe(d, {0.3, 0.8, 0.5}, 200) +
         8 * Lobe(d, {-0.9, 0.1, 0.3}, 50) + 3 * Lobe(d, {-0.2, -0.9, 0.4}, 30) +
         (window ? 2.5 : 0);
}

// Returns the rotation by `turn` about up, after one by `tilt` about right, after one by `roll`
// about forward [degrees].
Rotation Turned(double turn, double tilt, double roll) {
  const auto about = [](int axis, double degrees) {
    Rotation r = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    const double c = std::cos(degrees * kDegree), s = std::sin(degrees * kDegree);
    if (axis == 0) r[1] = {0, c, s}, r[2] = {0, -s, c};
    if (axis == 1) r[0] = {c, 0, -s}, r[2] = {s, 0, c};
    if (axis == 2) r[0] = {c, s, 0}, r[1] = {-s, c, 0};
    return r;
  };
  const Rotation a = about(2, turn), b = about(0, tilt), c = about(1, roll);
  Rotation all;
  for (std::size_t i = 0; i < 3; ++i) all[i] = Rotated(a, Rotated(b, c[i]));
  return all;
}

// Returns the photograph that a camera takes which has gone around the ball, with itself in it.
BallView Photograph(const Place& place, const Rotation& rotation, double gain = 1, int side = 240) {
  BallView view = {"ball.exr", Image(side, side)};
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const auto local =
          DirectionOfPoint(Projection::kMirrorBall, {(x + 0.5) / side, (y + 0.5) / side});
      if (!local) continue;
      const bool camera = AngleBetween(*local, {0, -1, 0}) < kCameraRadius;
      const double value = camera ? 0.03 : place(Rotated(rotation, *local));
      float* pixel = view.image.Pixel(x, y);
      pixel[0] = float(gain * value), pixel[1] = float(0.8 * value), pixel[2] = float(0.6 * value);
    }
  }
  return view;
}

// Returns the angle between two rotations' axes at most [degrees].
double Apart(const Rotation& a, const Rotation& b) {
  double most = 0;
  for (std::size_t i = 0; i < 3; ++i) most = std::max(most, AngleBetween(a[i], b[i]) / kDegree);
  return most;
}

TEST(JoinViews, AViewIsFoundFromWhereverItWasTaken) {
  const BallView first = Photograph(Room, Turned(0, 0, 0));
  for (const Rotation& truth : {Turned(90, 0, 0), Turned(-120, 8, 3), Turned(65, -35, 20)}) {
    const JoinedViews joined = JoinViews({first, Photograph(Room, truth)}, {.height = 16});
    // A pixel in the middle of the ball is 0.95 degrees.
    EXPECT_LT(Apart(joined.placed[1].map_from_view, truth), 0.3);
    EXPECT_GT(joined.placed[1].agreement, 0.9);
  }
}

TEST(JoinViews, TheAngleAroundTheBallIsToTheRightOfTheCamera) {
  EXPECT_NEAR(AngleAround(Turned(70, 0, 0)), 70 * kDegree, 1e-12);
  // That camera stands to the right of the first one, as that one sees it.
  const Vector3 camera = Rotated(Turned(70, 0, 0), {0, -1, 0});
  EXPECT_GT(camera.x, 0.9);
}

TEST(JoinViews, NoCameraIsLeftAndTheMapIsThePlace) {
  const JoinedViews joined =
      JoinViews({Photograph(Room, Turned(0, 0, 0)), Photograph(Room, Turned(90, 4, -2))}, {});
  EXPECT_EQ(joined.latlong.height, 160);
  EXPECT_EQ(joined.unseen, 0);
  const Image& map = joined.latlong;
  const Vector3 cameras[] = {{0, -1, 0}, Rotated(Turned(90, 4, -2), {0, -1, 0})};
  double error = 0, energy = 0;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const Vector3 d =
          *DirectionOfPoint(Projection::kLatLong, {(x + 0.5) / map.width, (y + 0.5) / map.height});
      const double truth = Room(d), value = map.Pixel(x, y)[0];
      const double area = std::sin(std::numbers::pi * (y + 0.5) / map.height);
      error += area * std::abs(value - truth), energy += area * truth;
      EXPECT_NEAR(map.Pixel(x, y)[1], 0.8 * value, 1e-3 * value);
      // Around the cameras the place is smooth.
      for (const Vector3& camera : cameras) {
        if (AngleBetween(d, camera) < kCameraRadius) {
          EXPECT_NEAR(value, truth, 0.05 * truth);
        }
      }
    }
  }
  EXPECT_LT(error / energy, 0.02);
}

TEST(JoinViews, ViewsOfOtherExposuresAreMadeAsBright) {
  const JoinedViews joined = JoinViews(
      {Photograph(Room, Turned(0, 0, 0)), Photograph(Room, Turned(90, 0, 0), 2.5)}, {.height = 64});
  const auto& gain = joined.placed[1].gain;
  EXPECT_NEAR(gain[0], 1 / 2.5, 0.004);
  EXPECT_NEAR(gain[1], 1, 0.01);
  EXPECT_NEAR(gain[2], 1, 0.01);
  // Behind the first camera, where the second view alone has something.
  const double truth = Room(*DirectionOfPoint(Projection::kLatLong, {0.5 / 128, 28.5 / 64}));
  EXPECT_NEAR(joined.latlong.Pixel(0, 28)[0], truth, 0.05 * truth);
}

// What looks the same after half a turn does not say where the camera went, so one says it.
TEST(JoinViews, TheTurnDecidesBetweenPlacesThatLookAlike) {
  const Place twice = [](const Vector3& d) { return Room(d) + Room({-d.x, -d.y, d.z}); };
  const std::vector<BallView> views = {Photograph(twice, Turned(0, 0, 0)),
                                       Photograph(twice, Turned(75, 0, 0))};
  for (const double turn : {75.0, -105.0}) {
    const JoinedViews joined = JoinViews(views, {.turn = (turn + 10) * kDegree, .height = 16});
    EXPECT_NEAR(AngleAround(joined.placed[1].map_from_view) / kDegree, turn, 0.3);
  }
}

TEST(JoinViews, ViewsFollowEachOtherAroundTheBall) {
  const JoinedViews joined =
      JoinViews({Photograph(Room, Turned(0, 0, 0)), Photograph(Room, Turned(120, 0, 0)),
                 Photograph(Room, Turned(-120, 0, 0))},
                {.turn = 120 * kDegree, .height = 16});
  EXPECT_LT(Apart(joined.placed[1].map_from_view, Turned(120, 0, 0)), 0.25);
  EXPECT_LT(Apart(joined.placed[2].map_from_view, Turned(-120, 0, 0)), 0.25);
}

TEST(JoinViews, WhatOnlyCamerasSeeIsCounted) {
  const BallView one = Photograph(Room, Turned(0, 0, 0));
  const JoinedViews joined = JoinViews({one, one}, {.camera = 0.4, .height = 90});
  const double cap = 2 * std::numbers::pi * (1 - std::cos(0.4));
  EXPECT_NEAR(joined.unseen, cap, 0.02 * cap);
  EXPECT_GT(joined.latlong.Pixel(0, 45)[0], 0);
}

TEST(JoinViews, WhatDoesNotGoTogetherIsRefused) {
  const BallView one = Photograph(Room, Turned(0, 0, 0), 1, 96);
  const auto refused = [](const std::vector<BallView>& views, const std::string& why) {
    try {
      JoinViews(views, {.height = 16});
      ADD_FAILURE() << why;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    }
  };
  refused({one}, "two views at least");
  refused({one, {"wide.exr", Image(120, 96)}}, "wide.exr: is 120x96: crop");
  refused({one, {"small.exr", Image(20, 20)}}, "at least 48 pixels");
  refused({one, {"black.exr", Image(96, 96)}}, "black.exr: is black");
  const Place stripes = [](const Vector3& d) {
    return 1.5 + std::sin(15 * d.x) * std::sin(19 * d.z);
  };
  BallView other = Photograph(stripes, Turned(0, 0, 0), 1, 96);
  other.name = "other.exr";
  refused({one, other}, "other.exr: does not show what ball.exr shows");
}

}  // namespace
}  // namespace skywave
