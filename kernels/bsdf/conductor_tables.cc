#include "kernels/bsdf/conductor_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include "kernels/bsdf/visible_normals.h"

namespace skywave {
namespace {

// Computes the means of G2 / G1(wo) over visible normals (the weight of a sample when F = 1), and
// of that times (1 - wo . h)^5.
struct Albedos {
  double all, grazing;
};
Albedos DirectionalAlbedo(double alpha, double mu) {
  constexpr int kTurns = 32, kHeights = 128;
  mu = std::max(mu, 1e-4);
  double sum = 0, grazing = 0;
  ForEachVisibleFacet(alpha, mu, kTurns, kHeights, [&](const VisibleFacet& facet) {
    const double cosine = 2 * facet.toward * facet.z - mu;
    if (cosine <= 0) return;
    const double out = GgxLambda(alpha, mu), in = GgxLambda(alpha, std::min(cosine, 1.0));
    const double weight = (1 + out) / (1 + out + in);
    const double away = std::max(0.0, 1 - facet.toward), away2 = away * away;
    sum += weight, grazing += weight * away2 * away2 * away;
  });
  return {sum / (kTurns * kHeights), grazing / (kTurns * kHeights)};
}

using Column = std::array<double, kAlbedoColumns>;

void StoreRow(const Column& column, std::uint32_t row, float* table) {
  for (std::uint32_t c = 0; c <= kAlbedoColumns; ++c) {
    table[row * (kAlbedoColumns + 1) + c] = float(column[std::min(c, kAlbedoColumns - 1)]);
  }
}

std::unique_ptr<ConductorTables> Build() {
  auto tables = std::make_unique<ConductorTables>();
  Column all = {}, grazing = {};
  for (std::uint32_t r = 0; r <= kAlbedoRows; ++r) {
    if (r < kAlbedoRows) {
      const double root = double(r) / (kAlbedoRows - 1);
      const double alpha = std::max(root * root, 1e-4);
      for (std::uint32_t c = 0; c < kAlbedoColumns; ++c) {
        const double mu = double(c) / (kAlbedoColumns - 1);
        const Albedos albedos = DirectionalAlbedo(alpha, mu * mu);
        all[c] = albedos.all, grazing[c] = albedos.grazing;
      }
      tables->mean_albedo[r] = float(MeanOverCosine(all));
    }
    StoreRow(all, r, tables->albedo);
    StoreRow(grazing, r, tables->grazing);
    tables->padded_mean_albedo[r] = float(MeanOverCosine(all));
    tables->mean_grazing[r] = float(MeanOverCosine(grazing));
  }
  return tables;
}

// Returns the mean of the Fresnel reflectance over the cosine-weighted hemisphere.
double MeanFresnel(double eta, double k) {
  constexpr int kSteps = 256;
  double mean = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double c = (i + 0.5) / kSteps, c2 = c * c, s2 = 1 - c2;
    const double t0 = eta * eta - k * k - s2;
    const double ab = std::sqrt(t0 * t0 + 4 * eta * eta * k * k);
    const double a = std::sqrt(std::max(0.0, 0.5 * (ab + t0)));
    const double rs = (ab + c2 - 2 * a * c) / (ab + c2 + 2 * a * c);
    const double p = c2 * ab + s2 * s2, q = 2 * a * c * s2;
    mean += 0.5 * rs * (1 + (p - q) / std::max(p + q, 1e-30)) * 2 * c / kSteps;
  }
  return mean;
}

}  // namespace

const ConductorTables& GgxTables() {
  static const std::unique_ptr<const ConductorTables> tables = Build();
  return *tables;
}

namespace {

double SheenAlbedo(double alpha, double mu) {
  constexpr int kHeights = 64, kTurns = 32;
  mu = std::max(mu, 1e-3);
  const double sine = std::sqrt(1 - mu * mu), power = 1 / alpha;
  double sum = 0;
  for (int i = 0; i < kHeights; ++i) {
    const double z = (i + 0.5) / kHeights, r = std::sqrt(1 - z * z);
    for (int j = 0; j < kTurns; ++j) {
      const double phi = std::numbers::pi * (j + 0.5) / kTurns;
      const double hx = sine + r * std::cos(phi), hy = r * std::sin(phi), hz = mu + z;
      const double across2 = hx * hx + hy * hy;
      const double d = (2 + power) * std::pow(across2 / (across2 + hz * hz), power / 2);
      sum += d * z / (4 * (mu + z - mu * z));
    }
  }
  // Solid angle is dz dphi over a full turn, which cancels the 1 / (2 pi) of D.
  return sum / (kHeights * kTurns);
}

std::unique_ptr<SheenTables> BuildSheen() {
  auto tables = std::make_unique<SheenTables>();
  Column column = {};
  for (std::uint32_t r = 0; r <= kAlbedoRows; ++r) {
    if (r < kAlbedoRows) {
      const double root = double(r) / (kAlbedoRows - 1);
      const double alpha = std::max(root * root, double(kMinSheenAlpha));
      double largest = 1;
      for (std::uint32_t c = 0; c < kAlbedoColumns; ++c) {
        const double mu = double(c) / (kAlbedoColumns - 1);
        column[c] = SheenAlbedo(alpha, mu * mu);
        largest = std::max(largest, column[c]);
      }
      for (double& albedo : column) albedo /= largest;
      tables->scale[r] = float(1 / largest);
    } else {
      tables->scale[r] = tables->scale[r - 1];
    }
    StoreRow(column, r, tables->albedo);
  }
  return tables;
}

}  // namespace

const SheenTables& GetSheenTables() {
  static const std::unique_ptr<const SheenTables> tables = BuildSheen();
  return *tables;
}

namespace {

// Every further bounce meets F again, which makes a geometric series (Kulla and Conty 2017). `e` is
// the mean albedo of single scattering.
float FurtherBounces(double e, float eta, float k) {
  const double f = MeanFresnel(eta, k);
  const double lost = std::max(1 - e, 1e-6);
  return float(f * f * e / (1 - f * lost) / (std::numbers::pi * lost));
}

}  // namespace

float ConductorMultiscatter(const ConductorTables& tables, float alpha, float eta, float k) {
  const double at = std::sqrt(std::clamp(alpha, 0.0f, 1.0f)) * (kAlbedoRows - 1);
  const auto low = std::min(std::uint32_t(at), kAlbedoRows - 2);
  const double e = tables.mean_albedo[low] +
                   (at - low) * (tables.mean_albedo[low + 1] - tables.mean_albedo[low]);
  return FurtherBounces(e, eta, k);
}

namespace {

constexpr auto kWidths = std::size_t{kTabledWidths}, kCosines = std::size_t{kTabledCosines},
               kAzimuths = std::size_t{kTabledAzimuths};

// Computes DirectionalAlbedo for two widths; `y_share` is |y| / (|x| + |y|) of the direction.
double DirectionalAlbedo(double x_width, double y_width, double mu, double y_share) {
  constexpr int kTurns = 24, kHeights = 40;
  const Facing wo = FacingAt(mu, y_share);
  const double out = GgxLambda(x_width, y_width, wo);
  double sum = 0;
  const auto reflect = [&](const VisibleFacet& facet) {
    const double twice = 2 * facet.toward;
    const Facing wi = {twice * facet.normal.x - wo.x, twice * facet.normal.y - wo.y,
                       twice * facet.z - mu};
    if (wi.z > 0) sum += (1 + out) / (1 + out + GgxLambda(x_width, y_width, wi));
  };
  ForEachVisibleFacet(x_width, y_width, wo, kTurns, kHeights, reflect);
  return sum / (kTurns * kHeights);
}

double TabledWidth(std::size_t row) {
  const double root = double(row) / double(kWidths - 1);
  return std::max(root * root, 1e-4);
}

std::unique_ptr<AnisotropicTables> BuildAnisotropic() {
  auto tables = std::make_unique<AnisotropicTables>();
  for (std::size_t a = 0; a < kWidths; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      for (std::size_t c = 0; c < kCosines; ++c) {
        const double root = double(c) / double(kCosines - 1), mu = std::max(root * root, 1e-4);
        for (std::size_t p = 0; p < kAzimuths; ++p) {
          const double share = double(p) / double(kAzimuths - 1);
          const auto albedo = float(DirectionalAlbedo(TabledWidth(a), TabledWidth(b), mu, share));
          tables->albedo[a][b][c][p] = albedo;
          tables->albedo[b][a][c][kAzimuths - 1 - p] = albedo;
        }
      }
      tables->mean_albedo[a][b] = float(MeanOverHemisphere<kCosines>(
          kAzimuths, [&](std::size_t p, std::size_t c) { return tables->albedo[a][b][c][p]; }));
      tables->mean_albedo[b][a] = tables->mean_albedo[a][b];
    }
  }
  return tables;
}

}  // namespace

const AnisotropicTables& GetAnisotropicTables() {
  static const std::unique_ptr<const AnisotropicTables> tables = BuildAnisotropic();
  return *tables;
}

float ConductorMultiscatter(const AnisotropicTables& tables, float along, float across, float eta,
                            float k) {
  const auto place = [](float width) {
    return std::sqrt(std::clamp(double(width), 0.0, 1.0)) * double(kWidths - 1);
  };
  const double a = place(along), b = place(across);
  const auto low_a = std::min(std::size_t(a), kWidths - 2);
  const auto low_b = std::min(std::size_t(b), kWidths - 2);
  const auto of_row = [&](std::size_t row) {
    const float* const means = tables.mean_albedo[row];
    return std::lerp(double(means[low_b]), double(means[low_b + 1]), b - double(low_b));
  };
  return FurtherBounces(std::lerp(of_row(low_a), of_row(low_a + 1), a - double(low_a)), eta, k);
}

}  // namespace skywave
