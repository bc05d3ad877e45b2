#include "kernels/bsdf/coat_tables.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "kernels/bsdf/material.h"
#include "kernels/bsdf/pack.h"
#include "kernels/bsdf/visible_normals.h"

namespace skywave {
namespace {

constexpr int kTurns = 16, kHeights = 32;  // visible normals of each cosine
constexpr double kSmoothCoat = 2e-3;       // narrower facets are a plane
constexpr double kLeastCosine = 1e-4;

using Vector = std::vector<double>;

// A linear operator on functions of the cosine: row i gives the value at place i as a sum over
// nodes.
class Operator {
 public:
  Operator(std::size_t rows, std::size_t columns)
      : rows_(rows), columns_(columns), values_(rows * columns) {}
  double& at(std::size_t row, std::size_t column) { return values_[row * columns_ + column]; }
  double at(std::size_t row, std::size_t column) const { return values_[row * columns_ + column]; }
  std::size_t rows() const { return rows_; }

  Vector operator*(const Vector& v) const {
    Vector out(rows_);
    for (std::size_t i = 0; i < rows_; ++i) {
      for (std::size_t k = 0; k < columns_; ++k) out[i] += at(i, k) * v[k];
    }
    return out;
  }
  Operator operator*(const Operator& other) const {
    Operator out(rows_, other.columns_);
    for (std::size_t i = 0; i < rows_; ++i) {
      for (std::size_t j = 0; j < columns_; ++j) {
        const double factor = at(i, j);
        for (std::size_t k = 0; k < other.columns_; ++k) out.at(i, k) += factor * other.at(j, k);
      }
    }
    return out;
  }
  Operator& operator+=(const Operator& other) {
    for (std::size_t i = 0; i < values_.size(); ++i) values_[i] += other.values_[i];
    return *this;
  }
  double Largest() const { return *std::max_element(values_.begin(), values_.end()); }

 private:
  std::size_t rows_, columns_;
  Vector values_;
};

// The cosines inside the coat at which functions are known; they are linear in between.
struct Nodes {
  Vector cosines;

  // The critical angle, where the interface begins to reflect everything, is a node, and nodes lie
  // densely above it.
  explicit Nodes(double ior) {
    constexpr int kBelow = 24, kAbove = 40;
    const double critical = ior > 1.001 ? std::sqrt(1 - 1 / (ior * ior)) : 0;
    for (int i = 0; critical > 0 && i < kBelow; ++i) cosines.push_back(critical * i / kBelow);
    for (int i = 0; i <= kAbove; ++i) {
      const double s = double(i) / kAbove;
      cosines.push_back(critical + (1 - critical) * s * s);
    }
    cosines.front() = kLeastCosine;
  }
  std::size_t size() const { return cosines.size(); }

  // Adds weight * (the value of a function at `cosine`) to a row of an operator.
  void Add(double cosine, double weight, std::size_t row, Operator& to) const {
    const auto above = std::upper_bound(cosines.begin(), cosines.end(), cosine);
    const auto high = std::clamp<std::size_t>(std::size_t(above - cosines.begin()), 1, size() - 1);
    const double low = cosines[high - 1];
    const double share = std::clamp((cosine - low) / (cosines[high] - low), 0.0, 1.0);
    to.at(row, high - 1) += weight * (1 - share);
    to.at(row, high) += weight * share;
  }
  // Returns the mean of a function over the cosine-weighted hemisphere.
  double Mean(const Vector& values) const {
    double mean = 0;
    for (std::size_t i = 1; i < size(); ++i) {
      const double a = cosines[i - 1], b = cosines[i], width = b - a;
      mean += width * (values[i - 1] * (2 * a + b) + values[i] * (a + 2 * b)) / 3;
    }
    return mean;
  }
};

double ColumnCosine(std::size_t column) {
  const double root = double(column) / (kAlbedoColumns - 1);
  return std::max(root * root, kLeastCosine);
}

// This is FresnelConductor of the kernels.
double MetalReflectance(double c, double eta, double k) {
  const double c2 = c * c, s2 = 1 - c2, t0 = eta * eta - k * k - s2;
  const double ab = std::sqrt(t0 * t0 + 4 * eta * eta * k * k);
  const double a = std::sqrt(std::max(0.0, 0.5 * (ab + t0)));
  const double rs = (ab + c2 - 2 * a * c) / (ab + c2 + 2 * a * c);
  const double p = c2 * ab + s2 * s2, q = 2 * a * c * s2;
  return 0.5 * rs * (1 + (p - q + 1e-30) / (p + q + 1e-30));
}

// Calls f(cosine, weight, toward) for the reflections of light that comes at cosine mu.
template <class F>
void ForEachReflection(double alpha, double mu, const F& f) {
  const double out = GgxLambda(alpha, mu);
  ForEachVisibleFacet(alpha, mu, kTurns, kHeights, [&](const VisibleFacet& facet) {
    const double cosine = 2 * facet.toward * facet.z - mu;
    if (cosine <= 0 || facet.toward <= 0) return;
    const double in = GgxLambda(alpha, std::min(cosine, 1.0));
    f(std::min(cosine, 1.0), (1 + out) / (1 + out + in) / (kTurns * kHeights),
      std::min(facet.toward, 1.0));
  });
}

// Calls reflected(cosine, weight) and refracted(cosine, weight) for light that meets the interface
// at cosine mu.
template <class Reflected, class Refracted>
void MeetInterface(double alpha, double mu, double ratio, const Reflected& reflected,
                   const Refracted& refracted) {
  if (alpha <= kSmoothCoat) {
    const Split split = FresnelSplit(mu, ratio);
    reflected(mu, split.reflectance);
    if (split.reflectance < 1) refracted(split.cosine, 1 - split.reflectance);
    return;
  }
  ForEachReflection(alpha, mu, [&](double cosine, double weight, double toward) {
    reflected(cosine, weight * FresnelSplit(toward, ratio).reflectance);
  });
  const double out = GgxLambda(alpha, mu);
  ForEachVisibleFacet(alpha, mu, kTurns, kHeights, [&](const VisibleFacet& facet) {
    const Split split = FresnelSplit(std::clamp(facet.toward, 0.0, 1.0), ratio);
    const double cosine = ratio * mu - (ratio * facet.toward - split.cosine) * facet.z;
    if (cosine <= 0 || facet.toward <= 0) return;
    const double in = GgxLambda(alpha, std::min(cosine, 1.0));
    refracted(std::min(cosine, 1.0),
              (1 - split.reflectance) * (1 + out) / (1 + out + in) / (kTurns * kHeights));
  });
}

// The interface as light on both of its sides sees it.
struct Interface {
  Vector own;     // by column: albedo seen from outside
  Operator in;    // by column: from outside to the directions inside
  Operator back;  // from inside to inside
  Vector out;     // by node: share that leaves

  Interface(double alpha, double ior, const Nodes& nodes)
      : own(kAlbedoColumns),
        in(kAlbedoColumns, nodes.size()),
        back(nodes.size(), nodes.size()),
        out(nodes.size()) {
    for (std::size_t c = 0; c < kAlbedoColumns; ++c) {
      MeetInterface(
          alpha, ColumnCosine(c), 1 / ior, [&](double, double weight) { own[c] += weight; },
          [&](double cosine, double weight) { nodes.Add(cosine, weight, c, in); });
    }
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      MeetInterface(
          alpha, nodes.cosines[i], ior,
          [&](double cosine, double weight) { nodes.Add(cosine, weight, i, back); },
          [&](double, double weight) { out[i] += weight; });
    }
  }
};

// The medium from one of its sides to the same and to the other one.
struct Slab {
  Operator back, through;
};

// Returns the mean over azimuths of the phase function of Henyey and Greenstein between two cosines
// [1 / cosine].
double MeanPhase(double g, double a, double b) {
  constexpr int kSteps = 32;
  const double across = std::sqrt(std::max(0.0, (1 - a * a) * (1 - b * b)));
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double cosine = a * b + across * std::cos(std::numbers::pi * (i + 0.5) / kSteps);
    const double root = 1 + g * g - 2 * g * cosine;
    sum += (1 - g * g) / (root * std::sqrt(root));
  }
  return 0.5 * sum / kSteps;
}

// A layer so thin that it scatters once is doubled until it has its thickness (van de Hulst 1980).
Slab MakeSlab(double thickness, double albedo, double g, const Nodes& nodes) {
  constexpr int kDoublings = 12, kSteps = 256, kMostSquares = 16;
  constexpr double kNegligible = 1e-9;
  const std::size_t n = nodes.size();
  const double thin = std::ldexp(thickness, -kDoublings);
  Slab slab = {Operator(n, n), Operator(n, n)};
  for (std::size_t i = 0; i < n; ++i) {
    const double mu = nodes.cosines[i], passes = std::exp(-thin / mu);
    double sum = 0;
    for (int k = 0; k < 2 * kSteps; ++k) {
      sum += MeanPhase(g, mu, (k + 0.5) / kSteps - 1);
    }
    for (int k = 0; k < kSteps; ++k) {
      const double cosine = (k + 0.5) / kSteps, share = albedo * (1 - passes) / sum;
      nodes.Add(cosine, share * MeanPhase(g, mu, cosine), i, slab.through);
      nodes.Add(cosine, share * MeanPhase(g, mu, -cosine), i, slab.back);
    }
    slab.through.at(i, i) += passes;
  }
  for (int doubling = 0; doubling < kDoublings; ++doubling) {
    // Light between two equal layers goes to and fro: 1 + R^2 + R^4 + ... = (1 + R^2) (1 + R^4) ...
    Operator power = slab.back * slab.back;
    Operator once = slab.through;
    for (int k = 0; k < kMostSquares && power.Largest() > kNegligible; ++k) {
      once += power * once;
      power = power * power;
    }
    const Operator across = slab.through * once;
    Operator back = slab.through * (slab.back * once);
    back += slab.back;
    slab = {std::move(back), across};
  }
  return slab;
}

// What light inside the coat is worth, by node: going down below the interface, and going up from
// what lies below.
struct Worth {
  Vector down, up;
};

// Light is worth 1 where it leaves times `escape`, and where it meets what lies below: `met` there
// and then, or what the reflected light is worth if there is a `base`.
Worth Follow(const Interface& interface, const Slab* slab, double escape, double met,
             const Operator* base) {
  const std::size_t n = interface.out.size();
  Worth worth = {Vector(n), Vector(n)};
  Vector below(n, met), upper(n);
  const auto sum = [](Vector a, const Vector& b) {
    for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
    return a;
  };
  for (int bounce = 0; bounce < 2000; ++bounce) {
    if (base != nullptr) below = *base * worth.up;
    worth.down = slab ? sum(slab->back * upper, slab->through * below) : below;
    Vector next = interface.back * worth.down;
    double change = 0;
    for (std::size_t i = 0; i < n; ++i) {
      next[i] += escape * interface.out[i];
      change = std::max(change, std::abs(next[i] - upper[i]));
    }
    upper = std::move(next);
    worth.up = slab ? sum(slab->through * upper, slab->back * below) : upper;
    if (bounce > 2 && change < 1e-7) break;
  }
  return worth;
}

using Column = std::array<double, kAlbedoColumns>;

Column AsColumn(const Vector& v) {
  Column column;
  std::copy_n(v.begin(), column.size(), column.begin());
  return column;
}
void Store(const Column& column, double factor, CoatColumn& to) {
  for (std::size_t c = 0; c <= kAlbedoColumns; ++c) {
    to[c] = float(factor * column[std::min<std::size_t>(c, kAlbedoColumns - 1)]);
  }
}

// The body is diffuse: with reflectance r it shows through(o) through(i) r / (1 - r returned).
void OverDiffuse(const Interface& interface, const Slab* slab, const Nodes& nodes, std::size_t c,
                 CoatTable& table) {
  const Worth meets = Follow(interface, slab, 0, 1, nullptr);
  const Worth leaves = Follow(interface, slab, 1, 0, nullptr);
  const Column through = AsColumn(interface.in * meets.down);
  const double mean = MeanOverCosine(through), escapes = nodes.Mean(leaves.up);
  const double factor = std::sqrt(escapes / std::max(mean, 1e-9) / std::numbers::pi);
  Store(through, factor, table.through[c]);
  table.returned[c] = float(nodes.Mean(meets.up));
  table.mean_through[c] = float(mean * factor);
}

// Returns the operator from column to column that is the mean of the metal's lobe as the kernels
// have it, through a smooth coat.
Operator MetalThroughCoat(double alpha, double ior, double eta, double k) {
  Operator lobe(kAlbedoColumns, kAlbedoColumns);
  for (std::size_t c = 0; c < kAlbedoColumns; ++c) {
    const double outside = ColumnCosine(c);
    const double inside2 = 1 - (1 - outside * outside) / (ior * ior);
    if (!(inside2 > 0)) continue;
    ForEachReflection(alpha, std::sqrt(inside2), [&](double cosine, double weight, double toward) {
      const double leaves2 = 1 - (1 - cosine * cosine) * ior * ior;
      if (!(leaves2 > 0)) return;
      const double at = std::sqrt(std::sqrt(leaves2)) * (kAlbedoColumns - 1);
      const auto low = std::min(std::size_t(at), std::size_t(kAlbedoColumns - 2));
      const double value = weight * MetalReflectance(toward, eta, k), share = at - double(low);
      lobe.at(c, low) += value * (1 - share);
      lobe.at(c, low + 1) += value * share;
    });
  }
  return lobe;
}

// Finds the factors w for which w(o) * sum of lobe(o, i) w(i) is `wanted` (Sinkhorn and Knopp 1967,
// for a symmetric lobe).
Column Balance(const Operator& lobe, const Column& wanted) {
  Column factors;
  factors.fill(1);
  for (int step = 0; step < 400; ++step) {
    for (std::size_t c = 0; c < factors.size(); ++c) {
      double sum = 0;
      for (std::size_t i = 0; i < factors.size(); ++i) sum += lobe.at(c, i) * factors[i];
      const double exact = sum > 1e-9 ? std::max(wanted[c], 0.0) / sum : 0;
      factors[c] = std::sqrt(factors[c] * exact);
    }
  }
  return factors;
}

void OverMetal(const Material& material, const Interface& interface, const Slab* slab,
               const Nodes& nodes, int c, CoatTable& table) {
  const double eta = double(material.eta[c]) / material.ior,
               k = double(material.k[c]) / material.ior;
  Operator metal(nodes.size(), nodes.size());
  const double alpha = MicrofacetWidth(material.alpha);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    ForEachReflection(alpha, nodes.cosines[i], [&](double cosine, double weight, double toward) {
      nodes.Add(cosine, weight * MetalReflectance(toward, eta, k), i, metal);
    });
  }
  const Vector all = interface.in * Follow(interface, slab, 1, 0, &metal).down;
  Column wanted = AsColumn(all);
  if (slab != nullptr) {
    const Vector medium = interface.in * Follow(interface, slab, 1, 0, nullptr).down;
    for (std::size_t i = 0; i < wanted.size(); ++i) wanted[i] -= medium[i];
  }
  const double width = WidthUnderCoat(material.alpha, material.coat_alpha, material.ior);
  const Column factors = Balance(MetalThroughCoat(width, material.ior, eta, k), wanted);
  Store(factors, 1, table.through[c]);
}

bool IsMetal(const Material& material) { return material.bsdf == BsdfKind::kCoatedConductor; }

Interface InterfaceOf(const Material& material, const Nodes& nodes) {
  const float alpha = IsMetal(material) ? material.coat_alpha : material.alpha;
  return {MicrofacetWidth(alpha), material.ior, nodes};
}

// Returns the medium of each channel, or nothing if there is none.
std::vector<Slab> MakeSlabs(const Material& material, const Nodes& nodes) {
  std::vector<Slab> slabs;
  const double asymmetry = std::clamp(material.coat_asymmetry, -0.95f, 0.95f);
  for (int c = 0; c < 3 && material.coat_thickness > 0; ++c) {
    slabs.push_back(MakeSlab(material.coat_thickness,
                             std::clamp(material.coat_albedo[c], 0.0f, 1.0f), asymmetry, nodes));
  }
  return slabs;
}

CoatTable MakeTable(const Material& material, const Interface& interface,
                    const std::vector<Slab>& slabs, const Nodes& nodes) {
  CoatTable table = {};
  Store(AsColumn(interface.own), 1, table.own);
  for (int c = 0; c < 3; ++c) {
    const auto channel = std::size_t(c);
    const Slab* const slab = slabs.empty() ? nullptr : &slabs[channel];
    if (slab != nullptr) {
      const Vector own = interface.in * Follow(interface, slab, 1, 0, nullptr).down;
      const double mean = MeanOverCosine(AsColumn(own));
      if (mean > 1e-9) {
        Store(AsColumn(own), 1 / std::sqrt(mean * std::numbers::pi), table.medium[c]);
      }
    }
    if (IsMetal(material)) {
      OverMetal(material, interface, slab, nodes, c, table);
    } else {
      OverDiffuse(interface, slab, nodes, channel, table);
    }
  }
  return table;
}

}  // namespace

float WidthUnderCoat(float alpha, float coat_alpha, float ior) {
  // A facet that is tilted turns the light that it refracts by (1 - 1 / ior) of that, and one that
  // reflects by twice.
  const float tilt = 0.5f * (1 - 1 / ior) * coat_alpha;
  const float own = MicrofacetWidth(alpha);
  return MicrofacetWidth(std::sqrt(own * own + 2 * tilt * tilt));
}

CoatKey CoatKeyOf(const Material& m) {
  const bool metal = IsMetal(m);
  // Tables of all widths do not depend on one.
  const bool varies = m.roughness_texture.has_value();
  CoatKey key = {metal ? 1.0f : 0.0f,   m.ior,
                 varies ? -1 : m.alpha, metal && !varies ? m.coat_alpha : 0,
                 m.coat_thickness,      m.coat_asymmetry,
                 m.coat_albedo.x,       m.coat_albedo.y,
                 m.coat_albedo.z};
  for (int c = 0; metal && c < 3; ++c) {
    key[std::size_t(9 + c)] = m.eta[c], key[std::size_t(12 + c)] = m.k[c];
  }
  return key;
}

CoatTable MakeCoatTable(const Material& material) {
  const Nodes nodes(material.ior);
  return MakeTable(material, InterfaceOf(material, nodes), MakeSlabs(material, nodes), nodes);
}

std::vector<CoatTable> MakeCoatTables(const Material& material) {
  const Nodes nodes(material.ior);
  const std::vector<Slab> slabs = MakeSlabs(material, nodes);
  const auto width = [](std::uint32_t row) {
    const float root = float(row) / (kCoatRows - 1);
    return MicrofacetWidth(root * root);
  };
  Material of_row = material;
  std::vector<CoatTable> tables;
  for (std::uint32_t row = 0; row < kCoatRows; ++row) {
    (IsMetal(material) ? of_row.coat_alpha : of_row.alpha) = width(row);
    const Interface interface = InterfaceOf(of_row, nodes);
    for (std::uint32_t metal = 0; metal < (IsMetal(material) ? kCoatRows : 1); ++metal) {
      if (IsMetal(material)) of_row.alpha = width(metal);
      tables.push_back(MakeTable(of_row, interface, slabs, nodes));
    }
  }
  return tables;
}

}  // namespace skywave
