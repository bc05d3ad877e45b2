#include "wavefront/film/aov_film.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "wavefront/film/resolve_rows.h"

namespace skywave {
namespace {

constexpr std::uint32_t kRows = kHiddenObjectRows;  // of the wave at a time, on the stack
constexpr double kRangeUnits = 0x1p38;              // units at the end of a range
constexpr double kWeightUnits = 0x1p20;             // of a weight of 1
// What camera rays meet first, as their weights are kept.
enum First : std::size_t { kObjects, kCatchers, kNothing, kFirsts };
constexpr std::uint64_t kNoSample = ~std::uint64_t{0};

double RangeEnd(AovRange range, float world_extent) {
  switch (range) {
    case AovRange::kUnit:
      return 2;
    case AovRange::kColor:
      return 1024;  // textures hold up to 511
    case AovRange::kWorld:
      return std::exp2(std::ceil(std::log2(std::max(world_extent, 1e-30f))) + 1);
  }
  return 1;
}

std::int64_t ToUnits(float value, double unit) {
  if (std::isnan(value)) return 0;
  return std::llrint(std::clamp(value / unit, -kRangeUnits, kRangeUnits));
}

// Orders the samples of a pixel by their distance from its centre, counted in quantiles of the
// filter. No two have the same key, so the least one does not depend on the order of arrival.
std::uint64_t NearnessKey(const FirstHits& hits, std::uint32_t path) {
  const float x = hits.film.u[path] - 0.5f, y = hits.film.v[path] - 0.5f;
  return std::uint64_t{std::bit_cast<std::uint32_t>(x * x + y * y)} << 32 | hits.paths.sample[path];
}

// Returns the variance of samples x with these sums: (sum of x^2 - (sum of x)^2 / n) / (n - 1),
// exact but for the last division.
double Variance(Uint128 squares, std::uint64_t sum, std::uint64_t samples) {  // |sum|
  if (samples < 2) return 0;
  const Uint128 of_mean = Uint128{sum} * sum / samples;
  return squares > of_mean ? double(squares - of_mean) / double(samples - 1) : 0;
}

std::uint64_t Magnitude(std::uint64_t sum, bool has_signs) {
  return has_signs && std::int64_t(sum) < 0 ? -sum : sum;
}

void ResizeHalf(std::size_t pixels, SampleMoments& moments) {
  moments.half.resize(pixels * 3);
  moments.half_squares.resize(pixels * 3);
}

// Adds paths [0, n) to those moments that are kept. The number of samples in second halves is that
// of all kinds of light, so one of them counts.
void AddMoments(const PathColumns& paths, std::uint32_t n, const FilmScale& scale,
                std::uint32_t* half_samples, SampleMoments& moments) {
  if (moments.squares.empty() && moments.half.empty()) return;
  const auto kept = [](auto& sums) { return sums.empty() ? nullptr : sums.data(); };
  const bool counts = half_samples != nullptr && !moments.half.empty();
  AddMomentsToFilm(paths, n, scale,
                   {.squares = kept(moments.squares),
                    .half_samples = counts ? half_samples : nullptr,
                    .half = kept(moments.half),
                    .half_squares = kept(moments.half_squares)});
}

float ToFloat(double value) {
  return float(std::min(value, double(std::numeric_limits<float>::max())));
}

}  // namespace

AovFilm::AovFilm(AovSet aovs, std::size_t pixels, float world_extent,
                 std::vector<std::string> light_groups, bool has_signs,
                 std::shared_ptr<const Mattes> mattes)
    : pixels_(pixels),
      has_signs_(has_signs),
      light_groups_(std::move(light_groups)),
      matte_names_(std::move(mattes)) {
  for (std::size_t i = 0; i < Aovs().size(); ++i) {
    const Aov& aov = Aovs()[i];
    if ((aovs >> i & 1) == 0 || aov.read == nullptr) continue;
    HitLayer layer = {.aov = &aov, .unit = RangeEnd(aov.range, world_extent) / kRangeUnits};
    const std::size_t values = pixels * aov.channels.size();
    if (aov.sum == AovSum::kMeanOfHits) layer.sums.resize(values);
    if (aov.sum == AovSum::kNearestHit) {
      layer.values.resize(values);
      // Zeros are there already.
      if (aov.background != 0) std::fill(layer.values.begin(), layer.values.end(), aov.background);
    }
    layers_.push_back(std::move(layer));
  }
  if (ReadsHits(aovs)) hits_.resize(pixels);
  if (Sums(aovs, AovSum::kNearestHit)) nearest_.resize(pixels, kNoSample);
  if (Sums(aovs, AovSum::kVariance)) beauty_.squares.resize(pixels * 3);
  for (std::size_t i = 0; i < Aovs().size(); ++i) {
    const Aov& aov = Aovs()[i];
    if ((aovs >> i & 1) == 0) continue;
    if (aov.part && aov.sum == AovSum::kVariance) {
      part_moments_[std::size_t(*aov.part)].squares.resize(pixels * 3);
    }
    if (aov.sum != AovSum::kHalf && aov.sum != AovSum::kHalfVariance) continue;
    half_samples_.resize(pixels);
    ResizeHalf(pixels, beauty_);  // which counts them
    if (aov.part) ResizeHalf(pixels, part_moments_[std::size_t(*aov.part)]);
  }
  if (Sums(aovs, AovSum::kLightGroups)) lit_.resize(light_groups_.size() * pixels * 3);
  if (Sums(aovs, AovSum::kAlpha) || Sums(aovs, AovSum::kMatte)) weights_.resize(pixels * kFirsts);
  for (std::size_t i = 0; i < Aovs().size(); ++i) {
    if ((aovs >> i & 1) == 0 || Aovs()[i].sum != AovSum::kMatte) continue;
    const auto of = std::size_t(Aovs()[i].matte);
    MatteSums& sums = mattes_[of];
    sums.slots = SlotsOf((*matte_names_)[of]);
    sums.ids.resize(sums.slots * pixels);
    sums.weights.resize(sums.slots * pixels);
  }
  if ((aovs & (CatcherAovs() | PartAovs()) & ~AovsOf(AovSum::kAlpha)) != 0) {
    for (std::size_t part = 0; part < kPartsOfCatchers; ++part) {
      light_parts_[part].resize(pixels * 3);
    }
    if (weights_.empty()) weights_.resize(pixels * kFirsts);
  }
  if (Sums(aovs, AovSum::kBackdrop)) {
    light_parts_[std::size_t(LightPart::kBackdrop)].resize(pixels * 3);
  }
  if (Sums(aovs, AovSum::kDirect) || Sums(aovs, AovSum::kIndirect)) direct_.resize(pixels * 3);
}

bool AovFilm::BecomesNearest(std::uint32_t pixel, std::uint64_t key) {
  if (key >= nearest_[pixel]) return false;
  nearest_[pixel] = key;
  return true;
}

std::uint32_t AovFilm::ObjectOf(const FirstSurfaces& first, std::uint32_t i) const {
  const std::uint32_t mesh = first.geometry.MeshOf(first.surfaces.triangle[i]);
  if (first.geometry.instance_count() == 0 || first.surfaces.instance[i] == 0) return mesh;
  const std::vector<std::uint32_t>& ids = (*matte_names_)[std::size_t(MatteOf::kObjects)].ids;
  const std::size_t number = first.geometry.mesh_count() + first.surfaces.instance[i] - 1;
  return number < ids.size() && ids[number] != 0 ? std::uint32_t(number) : mesh;
}

void AovFilm::AddWeights(const FirstHits& hits) {
  const auto add = [&](std::uint32_t path, std::size_t plane) {
    const double weight = hits.filter.WeightAt(hits.film.u[path], hits.film.v[path]);
    const auto units = std::uint64_t(std::llrint(weight * kWeightUnits));
    weights_[kFirsts * hits.paths.pixel[path] + plane] += units;
    return units;
  };
  for (std::uint32_t path = 0; path < hits.rays; ++path) {
    if (hits.hits.geom[path] == kNoHit) add(path, kNothing);
  }
  const SurfaceColumns& surfaces = hits.first.surfaces;
  for (std::uint32_t i = 0; i < hits.first.count; ++i) {
    const bool caught = hits.first.geometry.IsCatcher(surfaces.triangle[i]);
    const std::uint64_t weight = add(surfaces.path[i], caught ? kCatchers : kObjects);
    for (std::size_t of = 0; of < kMattes; ++of) {
      if (mattes_[of].ids.empty()) continue;
      const std::uint32_t number = MatteOf(of) == MatteOf::kObjects
                                       ? ObjectOf(hits.first, i)
                                       : surfaces.material[i] & kMaterialMask;
      AddToMatte(hits.paths.pixel[surfaces.path[i]], (*matte_names_)[of].ids[number], weight,
                 mattes_[of]);
    }
  }
}

void AovFilm::AddMattes(const AovFilm& other, std::size_t from_pixel, std::size_t to_pixel) {
  for (std::size_t of = 0; of < kMattes; ++of) {
    const MatteSums& from = other.mattes_[of];
    const std::size_t end = from.ids.size();
    for (std::size_t at = from_pixel; at < end && from.ids[at] != 0; at += other.pixels_) {
      AddToMatte(to_pixel, from.ids[at], from.weights[at], mattes_[of]);
    }
  }
}

double AovFilm::WeightOf(std::size_t pixel) const {
  double all = 0;
  for (std::size_t first = 0; first < kFirsts; ++first) {
    all += SumValue(weights_[kFirsts * pixel + first], has_signs_);
  }
  return all;
}

double AovFilm::ShareOf(std::size_t pixel, std::size_t first) const {
  const double all = WeightOf(pixel);
  return all > 0 ? SumValue(weights_[kFirsts * pixel + first], has_signs_) / all : 0;
}

void AovFilm::AddLightPart(LightPart part, const PathColumns& paths, std::uint32_t n,
                           const FilmScale& scale) {
  FilmValues<std::uint64_t>& sums = light_parts_[std::size_t(part)];
  if (sums.empty()) return;
  FilmScale of_part = scale;
  if (HasSigns(part) && !scale.has_signs) of_part.has_signs = true, of_part.limit *= 0.5f;
  AddToFilm(paths, n, of_part, sums.data());
  if (std::size_t(part) >= kPartsOfCatchers) return;
  AddMoments(paths, n, of_part, nullptr, part_moments_[std::size_t(part)]);
}

CaughtLight AovFilm::CaughtLightOf(std::size_t pixel) const {
  CaughtLight light = {};
  for (std::size_t c = 0; c < 3 && !light_parts_[0].empty(); ++c) {
    light.clean[c] = LightOf(LightPart::kClean, 3 * pixel + c);
    light.change[c] = LightOf(LightPart::kChange, 3 * pixel + c);
  }
  return light;
}

void AovFilm::AddFirstHits(const FirstHits& hits) {
  if (!weights_.empty()) AddWeights(hits);
  if (hits_.empty()) return;
  for (std::uint32_t i = 0; i < hits.rays && !nearest_.empty(); ++i) {
    const std::uint32_t pixel = hits.paths.pixel[i];
    if (hits.hits.geom[i] != kNoHit || !BecomesNearest(pixel, NearnessKey(hits, i))) continue;
    for (HitLayer& layer : layers_) {
      if (layer.values.empty()) continue;
      const std::size_t channels = layer.aov->channels.size();
      std::fill_n(&layer.values[pixel * channels], channels, layer.aov->background);
    }
  }
  for (std::uint32_t begin = 0; begin < hits.first.count; begin += kRows) {
    AddRows(hits, begin, std::min(begin + kRows, hits.first.count));
  }
}

void AovFilm::AddRows(const FirstHits& hits, std::uint32_t begin, std::uint32_t end) {
  FirstSurfaces rows = hits.first;
  rows.surfaces = Slice(hits.first.surfaces, begin);
  rows.count = end - begin;
  std::uint32_t pixel[kRows];
  bool nearest[kRows];
  for (std::uint32_t i = 0; i < rows.count; ++i) {
    const std::uint32_t path = rows.surfaces.path[i];
    pixel[i] = hits.paths.pixel[path];
    ++hits_[pixel[i]];
    nearest[i] = !nearest_.empty() && BecomesNearest(pixel[i], NearnessKey(hits, path));
  }
  rows.nearest = nearest;
  float columns[kMaxAovChannels][kRows];
  AovColumns out;
  for (std::uint32_t c = 0; c < kMaxAovChannels; ++c) out[c] = columns[c];
  for (HitLayer& layer : layers_) {
    layer.aov->read(rows, out);
    const std::size_t channels = layer.aov->channels.size();
    for (std::size_t c = 0; c < channels; ++c) {
      for (std::uint32_t i = 0; i < rows.count; ++i) {
        const std::size_t at = pixel[i] * channels + c;
        if (layer.aov->sum == AovSum::kMeanOfHits) {
          layer.sums[at] += ToUnits(columns[c][i], layer.unit);
        } else if (nearest[i]) {
          layer.values[at] = columns[c][i];
        }
      }
    }
  }
}

void AovFilm::AddRadiance(const PathColumns& paths, std::uint32_t n, const FilmScale& scale) {
  AddMoments(paths, n, scale, half_samples_.data(), beauty_);
}

void AovFilm::AddDirect(const PathColumns& paths, std::uint32_t n, const FilmScale& scale) {
  if (!direct_.empty()) AddToFilm(paths, n, scale, direct_.data());
}

void AovFilm::AddToGroups(const PathColumns& paths, const std::uint32_t* rows, std::uint32_t n,
                          const FilmScale& scale, const GroupColumns& given) {
  // This rounds as AddToFilm does.
  const float lowest = has_signs_ ? -scale.limit : 0;
  const auto units = [&](float value) {
    const double kept = value > lowest ? double(std::min(value, scale.limit)) : double(lowest);
    return std::uint64_t(std::llrint(std::isnan(value) ? 0 : kept * scale.units));
  };
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t path = rows[i];
    const std::size_t at = (given.group[i] * pixels_ + paths.pixel[path]) * 3;
    const float now[3] = {paths.r[path], paths.g[path], paths.b[path]};
    float* const before[3] = {&given.r[path], &given.g[path], &given.b[path]};
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint64_t all = units(now[c]), old = units(*before[c]);
      if (has_signs_) {
        lit_[at + c] += all - old;
      } else if (all > old) {
        lit_[at + c] = SaturatingSum(lit_[at + c], all - old);
      }
      *before[c] = now[c];
    }
  }
}

double AovFilm::VarianceOf(std::size_t i, std::uint64_t sum, std::uint64_t samples) const {
  return Variance(beauty_.squares[i], Magnitude(sum, has_signs_), samples);
}

std::vector<NamedChannel> AovFilm::Channels(AovSet wanted, std::size_t pixels) const {
  std::vector<NamedChannel> channels;
  ForEachChannel(
      wanted, light_groups_.size(), [&](const Aov& aov, std::size_t group, std::size_t c) {
        const std::string of_group =
            aov.sum == AovSum::kLightGroups ? light_groups_[group] : fmt::format("{:02}", group);
        channels.push_back(
            {.name = LayerName(aov, of_group) + "." + aov.channels[c], .values = {}});
        ResizeLarge(channels.back().values, pixels);
      });
  return channels;
}

Metadata AovFilm::Attributes(AovSet wanted) const {
  Metadata attributes;
  for (std::size_t i = 0; i < Aovs().size(); ++i) {
    const Aov& aov = Aovs()[i];
    if ((wanted >> i & 1) == 0 || aov.sum != AovSum::kMatte) continue;
    for (auto& attribute :
         MatteAttributes(LayerName(aov, ""), (*matte_names_)[std::size_t(aov.matte)])) {
      attributes.push_back(std::move(attribute));
    }
  }
  return attributes;
}

// Writes the layers of a matte to its channels: an id as the bits of a float, then its share of the
// weights of the pixel, rank by rank.
void AovFilm::ResolveMatte(MatteOf matte, const FilmArea& area, int first, int end,
                           std::span<NamedChannel> channels) const {
  const MatteSums& sums = mattes_[std::size_t(matte)];
  ResolveRows(area, first, end, [&](std::size_t to, std::size_t from, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
      const double all = WeightOf(from + i);
      const std::array<MatteShare, kMatteRanks> ranks = RanksOf(sums, from + i);
      for (std::size_t rank = 0; rank < kMatteRanks; ++rank) {
        channels[2 * rank].values[to + i] = std::bit_cast<float>(ranks[rank].id);
        channels[2 * rank + 1].values[to + i] =
            all > 0 ? float(std::max(ranks[rank].weight / all, 0.0)) : 0;
      }
    }
  });
}

void AovFilm::Resolve(AovSet wanted, const FilmArea& area, int first, int end,
                      std::span<const std::uint64_t> radiance, const FilmScale& scale,
                      const SampleCounts& samples, std::vector<NamedChannel>& channels) const {
  const double unit = 1 / scale.units;
  // Value i of a layer is channel c = i % channels of pixel i / channels.
  const auto value = [&](const Aov& aov, const HitLayer* layer, std::size_t group,
                         std::size_t pixel, std::size_t i) -> double {
    const double n = double(std::max<std::uint64_t>(samples[pixel], 1));
    const double unit_of_mean = unit / n;
    const std::size_t c = i - pixel * aov.channels.size();
    const std::span<const std::uint64_t> sums =
        aov.part ? std::span<const std::uint64_t>(light_parts_[std::size_t(*aov.part)]) : radiance;
    const SampleMoments& moments = aov.part ? part_moments_[std::size_t(*aov.part)] : beauty_;
    const bool has_signs = aov.part ? HasSigns(*aov.part) : has_signs_;
    switch (aov.sum) {
      case AovSum::kMeanOfHits:
        if (hits_[pixel] == 0) return aov.background;
        return double(layer->sums[i]) * layer->unit / hits_[pixel];
      case AovSum::kNearestHit:
        return double(layer->values[i]);
      case AovSum::kCoverage:
        return hits_[pixel] / n;
      case AovSum::kSampleCount:
        return double(samples[pixel]);
      case AovSum::kVariance:
        return Variance(moments.squares[i], Magnitude(sums[i], has_signs), samples[pixel]) * unit *
               unit;
      case AovSum::kHalf: {
        const std::uint32_t count = half_samples_[pixel];
        if (c == 3) return double(count);
        return SumValue(moments.half[3 * pixel + c], has_signs) * unit / std::max(count, 1u);
      }
      case AovSum::kHalfVariance:
        return Variance(moments.half_squares[i], Magnitude(moments.half[i], has_signs),
                        half_samples_[pixel]) *
               unit * unit;
      case AovSum::kDirect:
        return SumValue(direct_[i], has_signs_) * unit_of_mean;
      case AovSum::kIndirect:
        if (has_signs_) return SumValue(radiance[i] - direct_[i], true) * unit_of_mean;
        return double(radiance[i] - std::min(radiance[i], direct_[i])) * unit_of_mean;
      case AovSum::kAlpha:
        return ShareOf(pixel, kObjects) +
               (1 - KeptShare(CaughtLightOf(pixel))) * ShareOf(pixel, kCatchers);
      case AovSum::kShadow:
        return ShadowOf(CaughtLightOf(pixel), c);
      case AovSum::kDifference:
        return LightOf(LightPart::kChange, i) * unit_of_mean;
      case AovSum::kForeground: {
        const CaughtLight caught = CaughtLightOf(pixel);
        const double more = AddedLight(caught, KeptShare(caught), c);
        const double added = has_signs_ ? more : std::max(more, 0.0);
        return (LightOf(LightPart::kObjects, i) + added) * unit_of_mean;
      }
      case AovSum::kPart:
        if (c == 3) return ShareOf(pixel, *aov.part == LightPart::kObjects ? kObjects : kCatchers);
        return SumValue(sums[3 * pixel + c], has_signs) * unit_of_mean;
      case AovSum::kBackdrop:
        return LightOf(LightPart::kBackdrop, i) * unit_of_mean;
      case AovSum::kLightGroups:
        return SumValue(lit_[group * pixels_ * 3 + i], has_signs_) * unit_of_mean;
      case AovSum::kMatte:
        break;  // ResolveMatte
    }
    return 0;
  };
  struct Source {
    const Aov& aov;
    const HitLayer* layer;
    std::size_t group, channel;
  };
  std::vector<Source> sources;
  ForEachChannel(
      wanted, light_groups_.size(), [&](const Aov& aov, std::size_t group, std::size_t c) {
        const auto layer =
            std::find_if(layers_.begin(), layers_.end(),
                         [&](const HitLayer& candidate) { return candidate.aov == &aov; });
        sources.push_back({aov, layer != layers_.end() ? &*layer : nullptr, group, c});
      });
  ResolveRows(area, first, end, [&](std::size_t to, std::size_t from, std::size_t n) {
    for (std::size_t k = 0; k < sources.size(); ++k) {
      const Source& source = sources[k];
      if (source.aov.sum == AovSum::kMatte) continue;
      const std::size_t per_pixel = source.aov.channels.size();
      for (std::size_t i = 0; i < n; ++i) {
        const std::size_t pixel = from + i;
        channels[k].values[to + i] = ToFloat(value(source.aov, source.layer, source.group, pixel,
                                                   pixel * per_pixel + source.channel));
      }
    }
  });
  for (std::size_t k = 0; k < sources.size(); ++k) {
    const Source& source = sources[k];
    if (source.aov.sum != AovSum::kMatte || source.group != 0 || source.channel != 0) continue;
    ResolveMatte(source.aov.matte, area, first, end,
                 std::span(channels).subspan(k, 2 * kMatteRanks));
  }
}

}  // namespace skywave
