#include "lights/probe/plot.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "base/error.h"
#include "image/srgb.h"

namespace skywave {
namespace {

using Color = std::array<double, 3>;  // as shown, [0, 1]

constexpr int kPlotSide = 2;  // samples along each side of a pixel
constexpr Color kBackground = {1, 1, 1};
constexpr double kLeastStops = -14;  // range of the false colours, below the brightest

// The ramp has equal steps of lightness from black through blue, violet and orange to pale yellow.
constexpr Color kRamp[] = {{0.00, 0.00, 0.03}, {0.11, 0.06, 0.30}, {0.32, 0.07, 0.48},
                           {0.55, 0.14, 0.47}, {0.77, 0.25, 0.36}, {0.93, 0.43, 0.22},
                           {0.99, 0.67, 0.20}, {0.98, 0.91, 0.45}, {1.00, 1.00, 0.85}};

Color RampColor(double position) {
  constexpr int kLast = int(std::size(kRamp)) - 1;
  const double at = std::clamp(position, 0.0, 1.0) * kLast;
  const int low = std::min(int(at), kLast - 1);
  Color color;
  for (int c = 0; c < 3; ++c) {
    color[c] = kRamp[low][c] + (at - low) * (kRamp[low + 1][c] - kRamp[low][c]);
  }
  return color;
}

// The picture of a sphere has these axes: towards the eye, to the right and up in the picture.
struct Eye {
  Vector3 towards, right, up;
};
Eye EyeOf(PlotView view) {
  Vector3 towards = {0, 1, 0}, up = {0, 0, 1};
  if (view == PlotView::kBack) towards = {0, -1, 0};
  if (view == PlotView::kLeft) towards = {-1, 0, 0};
  if (view == PlotView::kRight) towards = {1, 0, 0};
  if (view == PlotView::kUp) towards = {0, 0, 1}, up = {0, -1, 0};
  if (view == PlotView::kDown) towards = {0, 0, -1}, up = {0, 1, 0};
  return {towards, Cross(up, towards), up};
}

// Maps directions to points in the picture and back [pixels].
class Canvas {
 public:
  Canvas(const SphereMap& map, const PlotRequest& request)
      : map_(map),
        flat_(request.view == PlotView::kLatLong),
        height(request.height),
        width(flat_ ? 2 * request.height : request.height),
        eye_(EyeOf(request.view)),
        radius_(request.height / 2.0 - 2) {}

  // Returns the texel under a point of the picture.
  std::optional<std::size_t> Texel(double x, double y) const {
    double u = x / width, v = y / height;
    if (!flat_) {
      const double a = (x - width / 2.0) / radius_, b = (height / 2.0 - y) / radius_;
      if (a * a + b * b > 1) return std::nullopt;
      const Vector3 d = a * eye_.right + b * eye_.up + std::sqrt(1 - a * a - b * b) * eye_.towards;
      UvOfDirection(d, u, v);
    }
    return TexelOfUv(u, v, map_.width, map_.height);
  }

  // Returns the point where a direction is seen, if it is.
  std::optional<std::array<double, 2>> Point(const Vector3& d) const {
    if (flat_) {
      double u, v;
      UvOfDirection(d, u, v);
      return std::array<double, 2>{u * width, v * height};
    }
    if (Dot(d, eye_.towards) <= 0) return std::nullopt;
    return std::array<double, 2>{width / 2.0 + radius_ * Dot(d, eye_.right),
                                 height / 2.0 - radius_ * Dot(d, eye_.up)};
  }

  bool flat() const { return flat_; }

 private:
  const SphereMap& map_;
  bool flat_;

 public:
  const int height, width;

 private:
  Eye eye_;
  double radius_;
};

void Blend(const Color& color, double alpha, Color& target) {
  for (int c = 0; c < 3; ++c) target[c] += alpha * (color[c] - target[c]);
}

// Paints a texel in the map's own colour.
class Painter {
 public:
  Painter(const SphereMap& map, const PlotRequest& request) : map_(map), request_(request) {
    for (float luminance : map.luminance) brightest_ = std::max<double>(brightest_, luminance);
    exposure_ = std::exp2(request.exposure_stops);
  }

  Color operator()(std::size_t texel) const {
    Color color;
    if (request_.log_color) {
      const double stops = std::log2(std::max(map_.luminance[texel] / brightest_, 1e-30));
      color = RampColor(brightest_ > 0 ? 1 - stops / kLeastStops : 0);
    } else {
      for (int c = 0; c < 3; ++c) {
        color[c] = SrgbFromLinear(exposure_ * map_.image->rgb[3 * texel + c]);
      }
    }
    if (request_.strata && !request_.strata->in_a[texel]) {
      for (double& value : color) value *= 0.45;
    }
    return color;
  }

 private:
  const SphereMap& map_;
  const PlotRequest& request_;
  double brightest_ = 0, exposure_ = 1;
};

// Draws a line where `id(texel)` changes from a point to its right or lower neighbour, one pixel
// apart.
template <class Id>
void DrawBorders(const Canvas& canvas, const Id& id, const Color& color, double alpha,
                 std::vector<Color>& picture) {
  tbb::parallel_for(0, canvas.height, [&](int y) {
    for (int x = 0; x < canvas.width; ++x) {
      double covered = 0;
      for (int s = 0; s < kPlotSide * kPlotSide; ++s) {
        const double px = x + (s % kPlotSide + 0.5) / kPlotSide,
                     py = y + (s / kPlotSide + 0.5) / kPlotSide;
        const auto here = canvas.Texel(px, py);
        if (!here) continue;
        const auto right = canvas.Texel(px + 1, py), below = canvas.Texel(px, py + 1);
        covered += (right && id(*right) != id(*here)) || (below && id(*below) != id(*here));
      }
      Blend(color, alpha * covered / (kPlotSide * kPlotSide),
            picture[std::size_t(y) * canvas.width + x]);
    }
  });
}

// Draws an antialiased disk with a dark outline, across the seam of a flat map too.
void DrawDot(const Canvas& canvas, double x, double y, double radius, const Color& color,
             std::vector<Color>& picture) {
  constexpr double kOutline = 1.3;
  const double reach = radius + kOutline + 1;
  const int y0 = std::max(int(y - reach), 0), y1 = std::min(int(y + reach) + 1, canvas.height);
  for (int py = y0; py < y1; ++py) {
    for (int px = int(std::floor(x - reach)); px <= int(x + reach); ++px) {
      int column = px;
      if (canvas.flat()) column = (px % canvas.width + canvas.width) % canvas.width;
      if (column < 0 || column >= canvas.width) continue;
      const double distance = std::hypot(px + 0.5 - x, py + 0.5 - y);
      Color& pixel = picture[std::size_t(py) * canvas.width + column];
      Blend({0.02, 0.05, 0.1}, std::clamp(radius + kOutline + 0.5 - distance, 0.0, 1.0), pixel);
      Blend(color, std::clamp(radius + 0.5 - distance, 0.0, 1.0), pixel);
    }
  }
}

void DrawLights(const Canvas& canvas, const std::vector<DirectionalLight>& lights,
                std::vector<Color>& picture) {
  constexpr Color kLight = {0.35, 1.0, 0.95};
  if (lights.empty()) return;
  double mean = 0;
  for (const DirectionalLight& light : lights) mean += light.energy / double(lights.size());
  const double unit = canvas.height / 512.0 * std::clamp(8 / std::sqrt(lights.size()), 0.45, 1.0);
  for (const DirectionalLight& light : lights) {
    const auto point = canvas.Point(light.direction);
    if (!point) continue;
    const double size = std::clamp(std::log2(light.energy / mean) / 4, -1.0, 1.5);
    DrawDot(canvas, (*point)[0], (*point)[1], std::max(unit * (3.4 + 1.4 * size), 1.2), kLight,
            picture);
  }
}

void DrawDots(const Canvas& canvas, const PlotDots& dots, std::vector<Color>& picture) {
  const double unit = canvas.height / 512.0;
  for (const Vector3& direction : dots.directions) {
    const auto point = canvas.Point(direction);
    if (point)
      DrawDot(canvas, (*point)[0], (*point)[1], std::max(2 * unit, 1.2), dots.color, picture);
  }
}

}  // namespace

std::vector<std::uint8_t> PlotMap(const SphereMap& map, const PlotRequest& request, int& width,
                                  int& height) {
  if (request.height < 16 || request.height > 16384) {
    throw InputError({}, "a plot is 16 to 16384 pixels high", kExitUsage);
  }
  const Canvas canvas(map, request);
  const Painter painter(map, request);
  width = canvas.width, height = canvas.height;
  std::vector<Color> picture(std::size_t(width) * height);
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      Color sum = {};
      for (int s = 0; s < kPlotSide * kPlotSide; ++s) {
        const auto texel = canvas.Texel(x + (s % kPlotSide + 0.5) / kPlotSide,
                                        y + (s / kPlotSide + 0.5) / kPlotSide);
        const Color color = texel ? painter(*texel) : kBackground;
        for (int c = 0; c < 3; ++c) sum[c] += color[c] / (kPlotSide * kPlotSide);
      }
      picture[std::size_t(y) * width + x] = sum;
    }
  });
  if (request.cells) {
    const auto cell = [&](std::size_t texel) { return (*request.cells)[texel]; };
    DrawBorders(canvas, cell, {0.9, 0.95, 1.0}, 0.8, picture);
  }
  if (request.strata) {
    const auto stratum = [&](std::size_t texel) { return request.strata->in_a[texel]; };
    DrawBorders(canvas, stratum, {0.2, 1.0, 0.3}, 1.0, picture);
  }
  DrawLights(canvas, request.lights, picture);
  for (const PlotDots& dots : request.dots) DrawDots(canvas, dots, picture);
  std::vector<std::uint8_t> rgb;
  rgb.reserve(3 * picture.size());
  for (const Color& color : picture) {
    for (double value : color) {
      rgb.push_back(std::uint8_t(std::lround(255 * std::clamp(value, 0.0, 1.0))));
    }
  }
  return rgb;
}

std::vector<std::uint8_t> CellColors(const CellMap& cells) {
  std::vector<std::uint8_t> rgb;
  rgb.reserve(3 * cells.size());
  for (std::uint32_t cell : cells) {
    std::uint32_t mixed = (cell + 1) * 2654435761u;
    mixed = (mixed ^ mixed >> 15) * 2246822519u;
    mixed ^= mixed >> 13;
    for (int c = 0; c < 3; ++c) {
      rgb.push_back(cell == kNoCell ? 0 : std::uint8_t(40 + (mixed >> 8 * c & 255) * 215 / 255));
    }
  }
  return rgb;
}

}  // namespace skywave
