#include "kernels/bsdf/dielectric_tables.h"

#include <algorithm>
#include <array>

#include "kernels/bsdf/visible_normals.h"

namespace skywave {
namespace {

// Returns the share of light from wo that leaves after it has met one facet.
double Kept(double x_width, double y_width, const Facing& wo, double ratio) {
  constexpr int kTurns = 48, kHeights = 64;
  const double out = GgxLambda(x_width, y_width, wo);
  double kept = 0;
  const auto leave = [&](const Facing& wi, double share) {
    kept += share * (1 + out) / (1 + out + GgxLambda(x_width, y_width, wi));
  };
  ForEachVisibleFacet(x_width, y_width, wo, kTurns, kHeights, [&](const VisibleFacet& facet) {
    if (facet.toward <= 0) return;
    const double toward = std::min(facet.toward, 1.0);
    const Facing& n = facet.normal;
    const Split split = FresnelSplit(toward, ratio);
    const Facing reflected = {2 * toward * n.x - wo.x, 2 * toward * n.y - wo.y,
                              2 * toward * n.z - wo.z};
    if (reflected.z > 0) leave(reflected, split.reflectance);
    const double along = ratio * toward - split.cosine;
    const Facing refracted = {along * n.x - ratio * wo.x, along * n.y - ratio * wo.y,
                              along * n.z - ratio * wo.z};
    if (refracted.z < 0) leave(refracted, 1 - split.reflectance);
  });
  return kept / (kTurns * kHeights);
}

using Losses = std::array<double, kAlbedoColumns>;

// Returns what is lost by column on a side, where light comes from that azimuth (FacingAt).
Losses LossesOf(double along, double across, double y_share, double ratio) {
  Losses lost;
  for (std::size_t c = 0; c < kAlbedoColumns; ++c) {
    const double root = double(c) / (kAlbedoColumns - 1), mu = std::max(root * root, 1e-4);
    lost[c] = std::max(1 - Kept(along, across, FacingAt(mu, y_share), ratio), 0.0);
  }
  return lost;
}

void Store(const Losses& lost, float (&row)[kSideColumns]) {
  for (std::size_t c = 0; c < kSideColumns; ++c) {
    row[c] = float(lost[std::min<std::size_t>(c, kAlbedoColumns - 1)]);
  }
}

DielectricRow RowOf(double alpha, double ior) {
  DielectricRow row;
  for (const bool inside : {false, true}) {
    const Losses lost = LossesOf(alpha, alpha, 0, inside ? ior : 1 / ior);
    Store(lost, row.lost[inside]);
    row.mean[inside] = float(MeanOverCosine(lost));
  }
  return row;
}

}  // namespace

DielectricTable MakeDielectricTable(float alpha, float ior) {
  DielectricTable table;
  std::fill(std::begin(table.rows), std::end(table.rows), RowOf(alpha, ior));
  return table;
}

DielectricTable MakeDielectricTable(float along, float across, float ior) {
  DielectricTable table;
  for (const bool inside : {false, true}) {
    std::array<Losses, kAlbedoRows> rows;
    for (std::size_t r = 0; r < kAlbedoRows; ++r) {
      const double y_share = double(r) / (kAlbedoRows - 1);
      rows[r] = LossesOf(along, across, y_share, inside ? double(ior) : 1 / double(ior));
    }
    const double mean = MeanOverHemisphere<kAlbedoColumns>(
        kAlbedoRows, [&](std::size_t azimuth, std::size_t c) { return rows[azimuth][c]; });
    for (std::size_t r = 0; r <= kAlbedoRows; ++r) {
      Store(rows[std::min<std::size_t>(r, kAlbedoRows - 1)], table.rows[r].lost[inside]);
      table.rows[r].mean[inside] = float(mean);
    }
  }
  return table;
}

DielectricTable MakeDielectricTable(float ior) {
  DielectricTable table;
  for (std::uint32_t r = 0; r < kAlbedoRows; ++r) {
    const double root = double(r) / (kAlbedoRows - 1);
    table.rows[r] = RowOf(std::max(root * root, 1e-3), ior);
  }
  table.rows[kAlbedoRows] = table.rows[kAlbedoRows - 1];
  return table;
}

float DiffuseTransmittance(float ior) {
  // Total reflection would put a root into the integrand. As much light leaves the dense side as
  // enters it, and there is n^2 times as much.
  if (ior < 1) return ior * ior * DiffuseTransmittance(1 / ior);
  constexpr int kSteps = 1024;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double cosine = (i + 0.5) / kSteps;
    sum += 2 * cosine / kSteps * (1 - FresnelSplit(cosine, 1 / double(ior)).reflectance);
  }
  return float(sum);
}

}  // namespace skywave
