#include "lights/light_sets/clustering.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/error.h"

namespace skywave {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A cluster has a nearest partner by some measure.
struct Partner {
  double measure = kInfinity;
  std::size_t other = 0;
};

// Samples without frequency count as this much of the largest: they merge first and move no other,
// but still go to their nearest.
constexpr double kLeastFrequency = 1e-12;

// Holds the clusters that are left, contiguously; a merged one is replaced by the last. Each knows
// its partner of least error among those of more frequency and, if separation matters, its nearest
// in space; both are kept exact. If partners were sought among all, one sample of little frequency
// would be the partner of all others, and merging it would make all of them search again.
class PairwiseMerger {
 public:
  PairwiseMerger(std::span<const Vector3> samples, std::span<const double> frequencies,
                 bool track_distance)
      : track_distance_(track_distance),
        centre_(samples.begin(), samples.end()),
        frequency_(frequencies.begin(), frequencies.end()),
        identity_(samples.size()),
        error_partner_(samples.size()),
        near_partner_(samples.size()),
        members_(samples.size()) {
    if (samples.empty()) return;
    const double largest = *std::ranges::max_element(frequency_);
    const double least = largest > 0 ? kLeastFrequency * largest : 1;
    for (double& frequency : frequency_) frequency = std::max(frequency, least);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      identity_[i] = std::uint32_t(i);
      members_[i] = {std::uint32_t(i)};
      for (std::size_t j = 0; j < i; ++j) UpdatePartners(i, j);
    }
  }

  std::size_t size() const { return centre_.size(); }

  double LeastChordSquare() const {
    double least = kInfinity;
    for (const Partner& partner : near_partner_) least = std::min(least, partner.measure);
    return least;
  }

  void MergeBest() {
    std::size_t best = 0;
    for (std::size_t i = 1; i < size(); ++i) {
      if (error_partner_[i].measure < error_partner_[best].measure) best = i;
    }
    const std::size_t other = error_partner_[best].other;
    Merge(std::min(best, other), std::max(best, other));
  }

  Clustering Result(std::span<const double> frequencies) const {
    std::vector<std::size_t> order(size());
    for (std::size_t i = 0; i < size(); ++i) order[i] = i;
    const auto lowest = [&](std::size_t i) { return *std::ranges::min_element(members_[i]); };
    std::ranges::sort(order, {}, lowest);
    Clustering result;
    result.cluster_of_sample.resize(frequencies.size());
    for (std::size_t i : order) {
      double sum = 0;
      for (std::uint32_t member : members_[i]) {
        sum += frequencies[member];
        result.cluster_of_sample[member] = std::uint32_t(result.directions.size());
      }
      result.directions.push_back(centre_[i]);
      result.frequencies.push_back(sum);
    }
    return result;
  }

 private:
  static double ChordSquare(const Vector3& a, const Vector3& b) {
    const Vector3 apart = a - b;
    return Dot(apart, apart);
  }

  // Returns the error of merging i and j, or some number > bound if it is above that. The chord is
  // below the angle, which spares most of the arc sines.
  double Error(std::size_t i, std::size_t j, double chord_square, double bound) const {
    const double sum = frequency_[i] + frequency_[j];
    const double weight = frequency_[i] / sum * frequency_[j];
    const double least = weight * chord_square;
    if (least > bound) return least;
    const double angle = 2 * std::asin(std::min(std::sqrt(chord_square) / 2, 1.0));
    return weight * angle * angle;
  }

  // Makes i and j each other's partners if they are better than the present ones.
  void UpdatePartners(std::size_t i, std::size_t j) {
    const double chord_square = ChordSquare(centre_[i], centre_[j]);
    const bool i_is_lighter = frequency_[i] != frequency_[j] ? frequency_[i] < frequency_[j]
                                                             : identity_[i] < identity_[j];
    const std::size_t lighter = i_is_lighter ? i : j;
    Partner& partner = error_partner_[lighter];
    const double error = Error(i, j, chord_square, partner.measure);
    if (error < partner.measure) partner = {error, i + j - lighter};
    if (!track_distance_) return;
    if (chord_square < near_partner_[i].measure) near_partner_[i] = {chord_square, j};
    if (chord_square < near_partner_[j].measure) near_partner_[j] = {chord_square, i};
  }

  void SearchAgain(std::size_t i) {
    for (std::size_t j = 0; j < size(); ++j) {
      if (j != i) UpdatePartners(i, j);
    }
  }

  // Merges j into i < j.
  void Merge(std::size_t i, std::size_t j) {
    const double sum = frequency_[i] + frequency_[j];
    const double share = frequency_[i] / sum;
    const Vector3 heavier = frequency_[i] >= frequency_[j] ? centre_[i] : centre_[j];
    centre_[i] = NormalizeOr(share * centre_[i] + (1 - share) * centre_[j], 1, heavier);
    frequency_[i] = sum;
    members_[i].insert(members_[i].end(), members_[j].begin(), members_[j].end());

    const auto lost = [&](const Partner& p) {
      return p.measure < kInfinity && (p.other == i || p.other == j);
    };
    std::vector<std::uint8_t> lost_error(size()), lost_near(size());
    for (std::size_t k = 0; k < size(); ++k) {
      lost_error[k] = lost(error_partner_[k]);
      lost_near[k] = lost(near_partner_[k]);
    }
    const std::size_t last = size() - 1;
    lost_error[j] = lost_error[last];
    lost_near[j] = lost_near[last];
    Replace(j, last);
    error_partner_[i] = near_partner_[i] = {};
    std::vector<std::size_t> orphans;
    for (std::size_t k = 0; k < size(); ++k) {
      if (k == i) continue;
      // A partner no worse than the one that k has lost is the best possible: without this test,
      // clouds of equal samples would be searched again and again.
      const double error = error_partner_[k].measure, near = near_partner_[k].measure;
      if (lost_error[k]) error_partner_[k].measure = std::nextafter(error, kInfinity);
      if (lost_near[k]) near_partner_[k].measure = std::nextafter(near, kInfinity);
      UpdatePartners(k, i);
      if ((lost_error[k] && error_partner_[k].measure > error) ||
          (lost_near[k] && near_partner_[k].measure > near)) {
        orphans.push_back(k);
      }
    }
    for (std::size_t orphan : orphans) error_partner_[orphan] = near_partner_[orphan] = {};
    for (std::size_t orphan : orphans) SearchAgain(orphan);
  }

  // Puts the last cluster into the place of j.
  void Replace(std::size_t j, std::size_t last) {
    if (j != last) {
      centre_[j] = centre_[last];
      frequency_[j] = frequency_[last];
      identity_[j] = identity_[last];
      error_partner_[j] = error_partner_[last];
      near_partner_[j] = near_partner_[last];
      members_[j] = std::move(members_[last]);
      for (std::size_t k = 0; k < last; ++k) {
        if (error_partner_[k].other == last) error_partner_[k].other = j;
        if (near_partner_[k].other == last) near_partner_[k].other = j;
      }
    }
    centre_.pop_back();
    frequency_.pop_back();
    identity_.pop_back();
    error_partner_.pop_back();
    near_partner_.pop_back();
    members_.pop_back();
  }

  bool track_distance_;
  std::vector<Vector3> centre_;
  std::vector<double> frequency_;
  std::vector<std::uint32_t> identity_;                // decides between equal frequencies
  std::vector<Partner> error_partner_, near_partner_;  // measures: error, squared chord
  std::vector<std::vector<std::uint32_t>> members_;
};

}  // namespace

std::vector<double> Frequencies(std::span<const CellSums> cells, ClusterFrequency frequency) {
  std::vector<double> result;
  for (const CellSums& cell : cells) {
    switch (frequency) {
      case ClusterFrequency::kOne:
        result.push_back(1);
        break;
      case ClusterFrequency::kEnergy:
        result.push_back(cell.energy);
        break;
      case ClusterFrequency::kMeanLuminance:
        result.push_back(cell.solid_angle > 0 ? cell.energy / cell.solid_angle : 0);
        break;
    }
  }
  return result;
}

Clustering ClusterPairwise(std::span<const Vector3> samples, std::span<const double> frequencies,
                           const ClusterStop& stop) {
  assert(samples.size() == frequencies.size());
  if (stop.clusters < 0 || !(stop.separation >= 0)) {
    throw InputError({}, "the number of clusters and their separation must not be negative");
  }
  for (double frequency : frequencies) {
    if (!(frequency >= 0 && std::isfinite(frequency))) {
      throw InputError({}, "frequencies of samples must be finite and not negative");
    }
  }
  const double chord = stop.separation > std::numbers::pi ? std::numeric_limits<double>::infinity()
                                                          : 2 * std::sin(stop.separation / 2);
  PairwiseMerger merger(samples, frequencies, chord > 0);
  const std::size_t most = stop.clusters > 0 ? std::size_t(stop.clusters) : samples.size();
  while (merger.size() > 1 &&
         (merger.size() > most || (chord > 0 && merger.LeastChordSquare() < chord * chord))) {
    merger.MergeBest();
  }
  return merger.Result(frequencies);
}

}  // namespace skywave
