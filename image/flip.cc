#include "image/flip.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "image/compare.h"

namespace skywave {
namespace {

using Plane = std::vector<float>;
using Vec3 = std::array<double, 3>;
using Matrix = std::array<Vec3, 3>;

Vec3 Times(const Matrix& m, const Vec3& v) {
  Vec3 result = {};
  for (int row = 0; row < 3; ++row) {
    for (int c = 0; c < 3; ++c) result[row] += m[row][c] * v[c];
  }
  return result;
}

Matrix Inverse(const Matrix& m) {
  const auto minor = [&](int r0, int r1, int c0, int c1) {
    return m[r0][c0] * m[r1][c1] - m[r0][c1] * m[r1][c0];
  };
  Matrix inverse;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      inverse[c][r] = minor((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
    }
  }
  const double determinant =
      m[0][0] * inverse[0][0] + m[0][1] * inverse[1][0] + m[0][2] * inverse[2][0];
  for (Vec3& row : inverse) {
    for (double& x : row) x /= determinant;
  }
  return inverse;
}

// XYZ of linear RGB with the primaries of Rec. 709 and the white point D65, from their
// chromaticities.
Matrix XyzFromRgb() {
  constexpr double kPrimaries[3][2] = {{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}};
  constexpr double kWhite[2] = {0.3127, 0.3290};
  const auto xyz = [](const double* xy) {
    return Vec3{xy[0] / xy[1], 1, (1 - xy[0] - xy[1]) / xy[1]};
  };
  Matrix m;
  for (int c = 0; c < 3; ++c) {
    const Vec3 primary = xyz(kPrimaries[c]);
    for (int row = 0; row < 3; ++row) m[row][c] = primary[row];
  }
  const Vec3 scale = Times(Inverse(m), xyz(kWhite));
  for (Vec3& row : m) {
    for (int c = 0; c < 3; ++c) row[c] *= scale[c];
  }
  return m;
}

// The colour spaces of the paper, relative to the white that RGB (1, 1, 1) has.
struct ColorSpaces {
  Matrix relative_xyz;  // XYZ over that of white, from RGB
  Matrix rgb;           // RGB, from XYZ over that of white
  ColorSpaces() {
    relative_xyz = XyzFromRgb();
    for (Vec3& row : relative_xyz) {
      const double white = row[0] + row[1] + row[2];
      for (double& x : row) x /= white;
    }
    rgb = Inverse(relative_xyz);
  }
};

// An opponent space that is linear in light (Section 4.1 of the paper).
Vec3 OpponentFromXyz(const Vec3& xyz) {
  return {116 * xyz[1] - 16, 500 * (xyz[0] - xyz[1]), 200 * (xyz[1] - xyz[2])};
}
Vec3 XyzFromOpponent(const Vec3& o) {
  const double y = (o[0] + 16) / 116;
  return {y + o[1] / 500, y, y - o[2] / 200};
}

// CIELAB, in which colourfulness grows with lightness as Hunt found.
Vec3 HuntLabFromXyz(const Vec3& xyz) {
  constexpr double kDelta = 6.0 / 29;
  const auto f = [](double t) {
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29;
  };
  const double fx = f(xyz[0]), fy = f(xyz[1]), fz = f(xyz[2]);
  const double lightness = 116 * fy - 16;
  return {lightness, 0.01 * lightness * 500 * (fx - fy), 0.01 * lightness * 200 * (fy - fz)};
}

// A distance that also holds for large differences (Abasi et al. 2020).
double HyAb(const Vec3& a, const Vec3& b) {
  return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

// The exponents and the knee of the redistribution of errors (Sections 4.1 and 4.3).
constexpr double kColorExponent = 0.7, kFeatureExponent = 0.5, kKnee = 0.4, kKneeError = 0.95;

// A filter over [-radius, radius] pixels.
using Taps = std::vector<float>;

// A Gaussian of the contrast sensitivity is a sqrt(pi / b) exp(-(pi x)^2 / b) with x in degrees
// (Table 1).
struct Gaussian {
  double a, b;
};
constexpr Gaussian kLightness = {1, 0.0047}, kRedGreen = {1, 0.0053},
                   kBlueYellow[] = {{34.1, 0.04}, {13.5, 0.025}};

struct Filters {
  // The sensitivities are Gaussians of sum 1; that of blue to yellow is a sum of two of them, which
  // have these shares.
  Taps lightness, red_green, blue_yellow[2];
  float blue_yellow_share[2];
  Taps smooth, slope, curvature;  // a Gaussian of sum 1 and its derivatives

  explicit Filters(double pixels_per_degree) {
    const double pi = std::numbers::pi;
    // Three standard deviations of the widest Gaussian.
    const int radius =
        int(std::ceil(3 * std::sqrt(kBlueYellow[0].b / (2 * pi * pi)) * pixels_per_degree));
    double sum = 0;
    const auto gaussian = [&](const Gaussian& g) {
      return Normalized(radius, sum, [&](int x) {
        const double degrees = x / pixels_per_degree;
        return std::exp(-pi * pi * degrees * degrees / g.b);
      });
    };
    lightness = gaussian(kLightness);
    red_green = gaussian(kRedGreen);
    double weight[2];
    for (int i = 0; i < 2; ++i) {
      blue_yellow[i] = gaussian(kBlueYellow[i]);
      weight[i] = kBlueYellow[i].a * std::sqrt(pi / kBlueYellow[i].b) * sum * sum;
    }
    for (int i = 0; i < 2; ++i) {
      blue_yellow_share[i] = float(weight[i] / (weight[0] + weight[1]));
    }
    // Edges and points are found by derivatives of a Gaussian whose width in degrees is that of a
    // feature (Section 4.2). Weights of each sign sum to 1.
    constexpr double kFeatureDegrees = 0.082;
    const double sigma = 0.5 * kFeatureDegrees * pixels_per_degree;
    const int feature_radius = int(std::ceil(3 * sigma));
    const auto bell = [&](int x) { return std::exp(-x * x / (2 * sigma * sigma)); };
    smooth = Normalized(feature_radius, sum, bell);
    slope = Normalized(feature_radius, sum, [&](int x) { return -x * bell(x); });
    curvature = Normalized(feature_radius, sum,
                           [&](int x) { return (x * x / (sigma * sigma) - 1) * bell(x); });
  }

 private:
  // Divides the weights of each sign by their sum; `sum` becomes that of the positive ones.
  template <class Function>
  static Taps Normalized(int radius, double& sum, const Function& weight) {
    double positive = 0, negative = 0;
    for (int x = -radius; x <= radius; ++x) {
      (weight(x) > 0 ? positive : negative) += std::abs(weight(x));
    }
    Taps taps;
    for (int x = -radius; x <= radius; ++x) {
      const double w = weight(x);
      taps.push_back(float(w == 0 ? 0 : w / (w > 0 ? positive : negative)));
    }
    sum = positive;
    return taps;
  }
};

struct Size {
  int width, height;
};

template <class Body>
void ForEachRow(const Size& size, const Body& body) {
  tbb::parallel_for(0, size.height, body);
}

// Filters along x; beyond the edges a row goes on with its last pixel.
Plane FilterRows(const Plane& in, const Size& size, const Taps& taps) {
  Plane out(in.size());
  const int radius = int(taps.size()) / 2;
  ForEachRow(size, [&](int y) {
    const float* const from = &in[std::size_t(y) * size.width];
    std::vector<float> row(std::size_t(size.width + 2 * radius));
    for (int x = 0; x < int(row.size()); ++x) {
      row[x] = from[std::clamp(x - radius, 0, size.width - 1)];
    }
    float* const to = &out[std::size_t(y) * size.width];
    for (std::size_t k = 0; k < taps.size(); ++k) {
      for (int x = 0; x < size.width; ++x) to[x] += taps[k] * row[x + k];
    }
  });
  return out;
}

// Filters along y.
Plane FilterColumns(const Plane& in, const Size& size, const Taps& taps) {
  Plane out(in.size());
  const int radius = int(taps.size()) / 2;
  ForEachRow(size, [&](int y) {
    float* const to = &out[std::size_t(y) * size.width];
    for (int k = 0; k < int(taps.size()); ++k) {
      const int from_y = std::clamp(y + k - radius, 0, size.height - 1);
      const float* const from = &in[std::size_t(from_y) * size.width];
      for (int x = 0; x < size.width; ++x) to[x] += taps[k] * from[x];
    }
  });
  return out;
}

Plane Filter(const Plane& in, const Size& size, const Taps& along_x, const Taps& along_y) {
  return FilterColumns(FilterRows(in, size, along_x), size, along_y);
}

// What the eye sees of a picture: its colours, and how strong edges and points are.
struct Seen {
  std::array<Plane, 3> color;  // after Hunt
  Plane edges, points;
};

Seen See(const Image& picture, const ColorSpaces& spaces, const Filters& filters) {
  const Size size = {picture.width, picture.height};
  const std::size_t pixels = picture.rgb.size() / 3;
  std::array<Plane, 3> opponent;
  for (Plane& plane : opponent) plane.resize(pixels);
  Plane grey(pixels);
  ForEachRow(size, [&](int y) {
    for (std::size_t i = std::size_t(y) * size.width; i < std::size_t(y + 1) * size.width; ++i) {
      const float* const rgb = &picture.rgb[3 * i];
      const Vec3 o = OpponentFromXyz(Times(spaces.relative_xyz, {rgb[0], rgb[1], rgb[2]}));
      for (int c = 0; c < 3; ++c) opponent[c][i] = float(o[c]);
      grey[i] = float((o[0] + 16) / 116);
    }
  });
  opponent[0] = Filter(opponent[0], size, filters.lightness, filters.lightness);
  opponent[1] = Filter(opponent[1], size, filters.red_green, filters.red_green);
  const Plane wide = Filter(opponent[2], size, filters.blue_yellow[0], filters.blue_yellow[0]);
  const Plane narrow = Filter(opponent[2], size, filters.blue_yellow[1], filters.blue_yellow[1]);
  const Plane smooth = FilterRows(grey, size, filters.smooth);
  const Plane edge_x = Filter(grey, size, filters.slope, filters.smooth);
  const Plane edge_y = FilterColumns(smooth, size, filters.slope);
  const Plane point_x = Filter(grey, size, filters.curvature, filters.smooth);
  const Plane point_y = FilterColumns(smooth, size, filters.curvature);
  Seen seen = {{Plane(pixels), Plane(pixels), Plane(pixels)}, Plane(pixels), Plane(pixels)};
  ForEachRow(size, [&](int y) {
    for (std::size_t i = std::size_t(y) * size.width; i < std::size_t(y + 1) * size.width; ++i) {
      const double blue_yellow =
          filters.blue_yellow_share[0] * wide[i] + filters.blue_yellow_share[1] * narrow[i];
      Vec3 rgb = Times(spaces.rgb, XyzFromOpponent({opponent[0][i], opponent[1][i], blue_yellow}));
      for (double& x : rgb) x = std::clamp(x, 0.0, 1.0);
      const Vec3 lab = HuntLabFromXyz(Times(spaces.relative_xyz, rgb));
      for (int c = 0; c < 3; ++c) seen.color[c][i] = float(lab[c]);
      seen.edges[i] = std::hypot(edge_x[i], edge_y[i]);
      seen.points[i] = std::hypot(point_x[i], point_y[i]);
    }
  });
  return seen;
}

// Raises each value of `map` to the FLIP of two pictures in [0, 1] where that is greater.
void RaiseToFlip(const Image& image, const Image& reference, const ColorSpaces& spaces,
                 const Filters& filters, std::vector<float>& map) {
  const Seen a = See(image, spaces, filters), b = See(reference, spaces, filters);
  // The largest distance within the gamut is that of green and blue.
  const auto lab = [&](const Vec3& rgb) { return HuntLabFromXyz(Times(spaces.relative_xyz, rgb)); };
  const double largest = std::pow(HyAb(lab({0, 1, 0}), lab({0, 0, 1})), kColorExponent);
  const double knee = kKnee * largest;
  ForEachRow({image.width, image.height}, [&](int y) {
    const std::size_t begin = std::size_t(y) * image.width;
    for (std::size_t i = begin; i < begin + image.width; ++i) {
      const double distance = HyAb({a.color[0][i], a.color[1][i], a.color[2][i]},
                                   {b.color[0][i], b.color[1][i], b.color[2][i]});
      const double power = std::pow(distance, kColorExponent);
      const double color = power < knee
                               ? power * kKneeError / knee
                               : kKneeError + (power - knee) / (largest - knee) * (1 - kKneeError);
      const double strongest =
          std::max(std::abs(a.edges[i] - b.edges[i]), std::abs(a.points[i] - b.points[i]));
      const double feature = std::pow(strongest / std::numbers::sqrt2, kFeatureExponent);
      map[i] = std::max(map[i], float(std::pow(color, 1 - feature)));
    }
  });
}

double MeanOf(std::span<const float> map) {
  double sum = 0;
  for (const float value : map) sum += value;
  return sum / double(map.size());
}

// Applies `curve` to all values times `scale`; what is not a number becomes 0.
template <class Curve>
Image OnScreen(const Image& picture, double scale, const Curve& curve) {
  Image shown(picture.width, picture.height);
  tbb::parallel_for(0, picture.height, [&](int y) {
    const std::size_t row = std::size_t(picture.width) * 3;
    for (std::size_t i = y * row; i < (y + 1) * row; ++i) {
      const double value = scale * picture.rgb[i];
      shown.rgb[i] = value > 0 ? float(std::min(curve(value), 1.0)) : 0;
    }
  });
  return shown;
}

}  // namespace

Flip LdrFlip(const Image& image, const Image& reference, double pixels_per_degree) {
  RequireSameSize(image, reference);
  const auto plain = [](double value) { return value; };
  Flip flip;
  flip.map.resize(reference.rgb.size() / 3);
  RaiseToFlip(OnScreen(image, 1, plain), OnScreen(reference, 1, plain), {},
              Filters(pixels_per_degree), flip.map);
  flip.mean = MeanOf(flip.map);
  return flip;
}

Flip HdrFlip(const Image& image, const Image& reference, double pixels_per_degree) {
  RequireSameSize(image, reference);
  Image test = image, truth = reference;
  RepairRadiance(test);
  RepairRadiance(truth);
  const ColorSpaces spaces;
  const Filters filters(pixels_per_degree);
  Flip flip;
  flip.map.resize(truth.rgb.size() / 3);

  // The tone curve with the factor 0.6 of its author, (k0 x^2 + k1 x) / (k3 x^2 + k4 x + k5), and
  // where it reaches 0.85.
  constexpr double k0 = 0.6 * 0.6 * 2.51, k1 = 0.6 * 0.03, k3 = 0.6 * 0.6 * 2.43, k4 = 0.6 * 0.59,
                   k5 = 0.14, kBright = 0.85;
  const auto curve = [=](double x) {
    x = std::min(x, 1e6);
    return x * (k0 * x + k1) / (x * (k3 * x + k4) + k5);
  };
  constexpr double a = k0 - kBright * k3, b = k1 - kBright * k4, c = -kBright * k5;
  const double bright = (-b + std::sqrt(b * b - 4 * a * c)) / (2 * a);

  // The longest exposure makes the median that bright, the shortest one the greatest luminance.
  std::vector<float> luminances(flip.map.size());
  for (std::size_t i = 0; i < luminances.size(); ++i) {
    const float* const rgb = &truth.rgb[3 * i];
    luminances[i] = float(0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]);
  }
  // Where more than half is black, the median of the rest counts.
  const auto positive = std::partition(luminances.begin(), luminances.end(),
                                       [](float luminance) { return !(luminance > 0); });
  const bool is_dark = positive - luminances.begin() > std::ptrdiff_t(luminances.size() / 2);
  const std::span<float> counted(is_dark ? positive : luminances.begin(), luminances.end());
  double median = 1, greatest = 1;
  if (positive != luminances.end()) {
    const auto middle = counted.begin() + std::ptrdiff_t(counted.size() / 2);
    std::nth_element(counted.begin(), middle, counted.end());
    median = *middle;
    greatest = *std::max_element(counted.begin(), counted.end());
  }
  flip.first_stops = std::log2(bright / greatest);
  flip.last_stops = std::log2(bright / median);
  flip.exposures = std::max(2, int(std::ceil(flip.last_stops - flip.first_stops)));
  for (int i = 0; i < flip.exposures; ++i) {
    const double stops =
        flip.first_stops + i * (flip.last_stops - flip.first_stops) / (flip.exposures - 1);
    RaiseToFlip(OnScreen(test, std::exp2(stops), curve), OnScreen(truth, std::exp2(stops), curve),
                spaces, filters, flip.map);
  }
  flip.mean = MeanOf(flip.map);
  return flip;
}

}  // namespace skywave
