#include "lights/probe/camera_response.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace skywave {
namespace {

constexpr int kMiddle = 128;
constexpr std::size_t kMostUsed = 40000;  // pixels that find the response

// What the exposures show of the pixels that take part, in one channel.
struct SeenCodes {
  std::vector<double> time;        // of each exposure
  std::vector<std::uint8_t> code;  // pixel by pixel, one of each exposure; black: it shows none
};

SeenCodes CodesOf(const ExposureStack& stack, int channel) {
  SeenCodes seen;
  for (const Exposure& exposure : stack.exposures) seen.time.push_back(exposure.exposure);
  const Image& first = stack.exposures[0].image;
  const std::size_t pixels = first.rgb.size() / 3, width = std::size_t(first.width);
  const std::size_t stride = (pixels + kMostUsed - 1) / kMostUsed;
  for (std::size_t i = 0; i < pixels; i += stride) {
    for (std::size_t j = 0; j < seen.time.size(); ++j) {
      const float* pixel = stack.Pixel(j, int(i % width), int(i / width));
      seen.code.push_back(std::uint8_t(pixel == nullptr ? 0 : CodeOf(pixel[channel])));
    }
  }
  return seen;
}

// ---- Debevec and Malik 1997 ----

constexpr double kSmoothness = 20;    // lambda of equation 3,
constexpr double kPixelsOfIt = 1000;  // for as many pixels

using Matrix = std::vector<double>;  // kCodes * kCodes, row-major

// Equation 4: how much a code is worth, 0 for black and white.
double Hat(int code) { return code < kMiddle ? code : kCodes - 1 - code; }

// Solves A x = b for a symmetric, positive definite A, which is overwritten (Cholesky).
CodeValues Solve(Matrix& a, CodeValues b) {
  const auto at = [&](int row, int column) -> double& {
    return a[std::size_t(row) * kCodes + std::size_t(column)];
  };
  for (int j = 0; j < kCodes; ++j) {
    for (int i = j; i < kCodes; ++i) {
      double sum = at(i, j);
      for (int k = 0; k < j; ++k) sum -= at(i, k) * at(j, k);
      at(i, j) = i == j ? std::sqrt(sum) : sum / at(j, j);
    }
  }
  for (int i = 0; i < kCodes; ++i) {
    for (int k = 0; k < i; ++k) b[std::size_t(i)] -= at(i, k) * b[std::size_t(k)];
    b[std::size_t(i)] /= at(i, i);
  }
  for (int i = kCodes - 1; i >= 0; --i) {
    for (int k = i + 1; k < kCodes; ++k) b[std::size_t(i)] -= at(k, i) * b[std::size_t(k)];
    b[std::size_t(i)] /= at(i, i);
  }
  return b;
}

// What codes say about the logarithm of the light is worth as much as it is exact: an error of a
// code is one of g' there. 1 at the middle.
CodeValues Worth(const CodeValues& g) {
  const auto slope = [&](int z) {
    return std::max(1e-6, (g[std::size_t(z + 1)] - g[std::size_t(z - 1)]) / 2);
  };
  CodeValues worth = {};
  for (int z = 1; z + 1 < kCodes; ++z) {
    worth[std::size_t(z)] = Hat(z) * std::min(1.0, slope(kMiddle) / slope(z));
  }
  return worth;
}

// Equation 3 for one channel. The ln E of a pixel that is best for a response is its weighted mean
// of g(Z) - ln t; put back, it leaves equations of the 256 values of g alone, so every pixel can
// take part.
CodeValues LeastSquares(const SeenCodes& seen, const CodeValues& worth) {
  Matrix a(std::size_t(kCodes) * kCodes);
  CodeValues b = {};
  const auto at = [&](int row, int column) -> double& {
    return a[std::size_t(row) * kCodes + std::size_t(column)];
  };
  const std::size_t exposures = seen.time.size();
  const double scale = kPixelsOfIt / double(seen.code.size() / exposures);
  struct Term {
    int code;
    double weight, log_time;
  };
  std::vector<Term> pixel;
  for (std::size_t first = 0; first < seen.code.size(); first += exposures) {
    pixel.clear();
    double weights = 0, mean_time = 0;
    for (std::size_t j = 0; j < exposures; ++j) {
      const std::size_t code = seen.code[first + j];
      const double weight = worth[code] * worth[code] * scale;
      if (weight <= 0) continue;
      pixel.push_back({int(code), weight, std::log(seen.time[j])});
      weights += weight, mean_time += weight * pixel.back().log_time;
    }
    if (pixel.size() < 2) continue;
    mean_time /= weights;
    for (const Term& p : pixel) {
      at(p.code, p.code) += p.weight;
      b[std::size_t(p.code)] += p.weight * (p.log_time - mean_time);
      for (const Term& q : pixel) at(p.code, q.code) -= p.weight * q.weight / weights;
    }
  }
  constexpr double kSecond[] = {1, -2, 1};
  for (int z = 1; z + 1 < kCodes; ++z) {
    const double weight = kSmoothness * kSmoothness * Hat(z) * Hat(z);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) at(z - 1 + i, z - 1 + j) += weight * kSecond[i] * kSecond[j];
    }
  }
  // The scale is free: g(128) = 0. The slope is too where no pixel is seen twice; a weak pull
  // towards 0 leaves the equations one solution then.
  double largest = 0;
  for (int z = 0; z < kCodes; ++z) largest = std::max(largest, at(z, z));
  for (int z = 0; z < kCodes; ++z) at(z, z) += 1e-12 * largest;
  at(kMiddle, kMiddle) += largest;
  return Solve(a, b);
}

// ---- Robertson et al. 2003 ----

// How exact a code is, relative to the middle: a bell, 0 for black and white.
CodeValues Bell() {
  CodeValues bell = {};
  for (int z = 1; z + 1 < kCodes; ++z) {
    const double x = (z - 127.5) / 127.5;
    bell[std::size_t(z)] = std::exp(-4 * x * x);
  }
  return bell;
}

// Sets the logarithms of codes that no pixel has from those of their neighbours that some have,
// beyond both ends from the two last ones.
void FillGaps(const std::vector<int>& known, CodeValues& g) {
  const auto line = [&](int from, int to, int z) {
    const double slope = (g[std::size_t(to)] - g[std::size_t(from)]) / (to - from);
    return g[std::size_t(from)] + slope * (z - from);
  };
  for (int z = 0; z < kCodes; ++z) {
    const auto above = std::lower_bound(known.begin(), known.end(), z);
    if (above != known.end() && *above == z) continue;
    const auto to = std::clamp(above, known.begin() + 1, known.end() - 1);
    g[std::size_t(z)] = line(to[-1], to[0], z);
  }
}

// One turn: the radiance of every pixel that is most likely for a response, x = sum(w t I) / sum(w
// t^2), and the response that is most likely for these, I = mean of t x over the pixels of a code;
// 0 for codes that no pixel has.
CodeValues NextResponse(const SeenCodes& seen, const CodeValues& bell, const CodeValues& response) {
  const std::size_t exposures = seen.time.size();
  CodeValues sum = {}, count = {};
  for (std::size_t first = 0; first < seen.code.size(); first += exposures) {
    double above = 0, below = 0;
    for (std::size_t j = 0; j < exposures; ++j) {
      const std::size_t code = seen.code[first + j];
      above += bell[code] * seen.time[j] * response[code];
      below += bell[code] * seen.time[j] * seen.time[j];
    }
    if (!(below > 0)) continue;
    for (std::size_t j = 0; j < exposures; ++j) {
      const std::size_t code = seen.code[first + j];
      sum[code] += seen.time[j] * above / below, count[code] += 1;
    }
  }
  for (std::size_t z = 0; z < kCodes; ++z) sum[z] = count[z] > 0 ? sum[z] / count[z] : 0;
  return sum;
}

// Returns ln I after turns that begin with a smooth g, not with codes in proportion to light as in
// the paper: exposures that are stops apart tie a code to few others, so turns take long to say how
// these chains lie beside each other. They stop before they fit what codes have been rounded by.
CodeValues MostLikely(const SeenCodes& seen, CodeValues g) {
  constexpr int kMostTurns = 30;
  constexpr double kStill = 1e-4;  // change of a logarithm in a turn, but near black and white
  constexpr std::size_t kEnds = 8;
  const CodeValues bell = Bell();
  CodeValues response;
  for (std::size_t z = 0; z < kCodes; ++z) response[z] = std::exp(g[z]);
  double change = 1;
  for (int turn = 0; turn < kMostTurns && change > kStill; ++turn) {
    const CodeValues before = g, next = NextResponse(seen, bell, response);
    std::vector<int> known;
    for (int z = 1; z + 1 < kCodes; ++z) {
      if (!(next[std::size_t(z)] > 0)) continue;
      known.push_back(z);
      g[std::size_t(z)] = std::log(next[std::size_t(z)]);
    }
    if (known.size() < 2) return {};
    FillGaps(known, g);
    change = 0;
    const double scale = g[kMiddle];
    for (std::size_t z = 0; z < kCodes; ++z) {
      g[z] -= scale, response[z] = std::exp(g[z]);
      if (z >= kEnds && z < kCodes - kEnds) change = std::max(change, std::abs(g[z] - before[z]));
    }
  }
  return g;
}

}  // namespace

int CodeOf(float value) { return int(std::lround(std::clamp(value, 0.0f, 1.0f) * (kCodes - 1))); }

Response FindResponse(const ExposureStack& stack, ResponseMethod method) {
  Response response;
  for (int channel = 0; channel < 3; ++channel) {
    const SeenCodes seen = CodesOf(stack, channel);
    // The first response says what codes are worth for the second one.
    CodeValues worth;
    for (int z = 0; z < kCodes; ++z) worth[std::size_t(z)] = Hat(z);
    CodeValues& g = response[std::size_t(channel)];
    g = LeastSquares(seen, worth);
    g = LeastSquares(seen, Worth(g));
    if (method == ResponseMethod::kRobertson) g = MostLikely(seen, g);
  }
  return response;
}

CodeValues WeightsOfCodes(const CodeValues& response, ResponseMethod method) {
  return method == ResponseMethod::kRobertson ? Bell() : Worth(response);
}

}  // namespace skywave
