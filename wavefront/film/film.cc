#include "wavefront/film/film.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "kernels/accumulate.h"

namespace skywave {
namespace {

constexpr double kSampleUnits = 0x1p52;  // doubles count units exactly up to here
constexpr double kHeadroom = 64;         // range of a sample over the brightest texel

// Cuts the values of the picture out of those of all pixels.
template <class T>
std::vector<T> CutPicture(const FilmArea& area, const std::vector<T>& values,
                          std::size_t per_pixel) {
  const CropWindow& picture = area.picture;
  std::vector<T> cut;
  cut.reserve(std::size_t(picture.width) * picture.height * per_pixel);
  for (int y = 0; y < picture.height; ++y) {
    const std::size_t first = std::size_t(picture.y + y) * area.width + picture.x;
    const auto row = values.begin() + std::ptrdiff_t(first * per_pixel);
    cut.insert(cut.end(), row, row + std::ptrdiff_t(picture.width * per_pixel));
  }
  return cut;
}

}  // namespace

Film::Film(const FilmArea& area, float brightest_radiance, AovSet aovs, float world_extent,
           bool shared, std::vector<std::string> light_groups)
    : area_(area), sums_(std::size_t(area.width) * area.height * 3), shared_(shared) {
  int exponent = 0;
  if (brightest_radiance > 0) std::frexp(brightest_radiance * kHeadroom, &exponent);
  unit_ = std::ldexp(1 / kSampleUnits, std::max(exponent, 20));
  if (aovs != 0) aovs_.emplace(aovs, sums_.size() / 3, world_extent, std::move(light_groups));
}

FilmScale Film::scale() const { return {.units = 1 / unit_, .limit = float(unit_ * kSampleUnits)}; }

void Film::Count(const FilmCounts& counts, RenderStats& stats) {
  stats.clamped_samples += counts.clamped;
  stats.invalid_samples += counts.invalid;
}

void Film::Add(const PathColumns& paths, std::uint32_t n, RenderStats& stats) {
  Count(AddToFilm(paths, n, scale(), sums_.data(), shared_), stats);
  if (aovs_) aovs_->AddRadiance(paths, n, scale());
}

void Film::AddSplats(const LightColumns& splats, const std::uint32_t* pixel, std::uint32_t n,
                     float factor, RenderStats& stats) {
  assert(shared_);
  Count(AddSplatsToFilm(splats, pixel, n, factor, scale(), sums_.data()), stats);
}

void Film::AddFirstHits(const FirstHits& hits) {
  if (aovs_) aovs_->AddFirstHits(hits);
}

void Film::AddDirect(const PathColumns& paths, std::uint32_t n) {
  if (aovs_) aovs_->AddDirect(paths, n, scale());
}

void Film::AddToGroups(const PathColumns& paths, const std::uint32_t* rows, std::uint32_t n,
                       const GroupColumns& given) {
  if (aovs_) aovs_->AddToGroups(paths, rows, n, scale(), given);
}

void Film::Merge(const Film& other) {
  assert(sums_.size() == other.sums_.size() && unit_ == other.unit_);
  assert(has_aovs() == other.has_aovs());
  std::transform(sums_.begin(), sums_.end(), other.sums_.begin(), sums_.begin(),
                 SaturatingSum<std::uint64_t>);
  if (aovs_) aovs_->Merge(*other.aovs_);
}

std::vector<NamedChannel> Film::ResolveAovs(std::uint64_t samples) const {
  if (!aovs_) return {};
  std::vector<NamedChannel> channels = aovs_->Resolve(sums_, scale(), samples);
  for (NamedChannel& channel : channels) channel.values = CutPicture(area_, channel.values, 1);
  return channels;
}

std::span<const std::uint64_t> Film::light_group_sums() const {
  if (!aovs_) return {};
  return aovs_->light_group_sums();
}

Image Film::Resolve(std::uint64_t samples) const {
  Image image(area_.picture.width, area_.picture.height);
  const double scale = unit_ / double(std::max<std::uint64_t>(samples, 1));
  const std::vector<std::uint64_t> sums = CutPicture(area_, sums_, 3);
  std::transform(sums.begin(), sums.end(), image.rgb.begin(),
                 [&](std::uint64_t sum) { return float(double(sum) * scale); });
  return image;
}

}  // namespace skywave
