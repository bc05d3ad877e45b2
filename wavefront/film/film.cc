#include "wavefront/film/film.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <type_traits>
#include <utility>

#include "kernels/accumulate.h"
#include "wavefront/film/resolve_rows.h"

namespace skywave {
namespace {

// Doubles count units exactly up to the first.
constexpr double kSampleUnits = 0x1p52, kSignedSampleUnits = 0x1p42;
constexpr double kHeadroom = 64;  // range of a sample over the brightest texel

// Returns the exponent of the range of a sample. Scenes of usual radiances share one, whatever
// their map; beyond these the range follows the brightest radiance.
int RangeExponent(float brightest) {
  constexpr int kUsual = 20, kLeastUsual = -10;
  if (!(brightest > 0)) return kUsual;
  int exponent = 0;
  std::frexp(brightest * kHeadroom, &exponent);
  return exponent < kLeastUsual ? exponent : std::max(exponent, kUsual);
}

}  // namespace

Film::Film(FilmLayout layout)
    : layout_(std::move(layout)),
      sums_(std::size_t(layout_.area.width) * std::size_t(layout_.area.height) * 3) {
  unit_ = std::ldexp(1 / sample_units(), RangeExponent(layout_.brightest_radiance));
  if (layout_.aovs != 0) {
    aovs_.emplace(layout_.aovs, sums_.size() / 3, layout_.world_extent, layout_.light_groups,
                  layout_.has_signs, layout_.mattes);
  }
}

template <class F>
void Film::ForEachColumn(F f) const {
  f(
      [](auto& film) -> auto& { return film.sums_; }, FilmColumn{3});
  if (!aovs_) return;
  aovs_->ForEachColumn([&](auto values_of, const FilmColumn& column) {
    if (values_of(*aovs_).empty()) return;
    f(
        [values_of](auto& film) -> auto& { return values_of(*film.aovs_); }, column);
  });
}

PixelBytes Film::BytesOfPixel(FilmLayout layout) {
  layout.area = {1, 1, {0, 0, 1, 1}};
  const Film pixel(std::move(layout));
  PixelBytes bytes;
  pixel.ForEachColumn([&](auto values_of, const FilmColumn& column) {
    const std::size_t of_column = column.planes * column.per_pixel * sizeof(values_of(pixel)[0]);
    bytes.kept += of_column;
    if (column.starts_filled) bytes.at_first += of_column;
  });
  return bytes;
}

double Film::sample_units() const { return layout_.has_signs ? kSignedSampleUnits : kSampleUnits; }

FilmScale Film::scale() const {
  return {
      .units = 1 / unit_, .limit = float(unit_ * sample_units()), .has_signs = layout_.has_signs};
}

void Film::Count(const FilmCounts& counts, RenderStats& stats) {
  stats.clamped_samples += counts.clamped;
  stats.invalid_samples += counts.invalid;
}

void Film::Add(const PathColumns& paths, std::uint32_t n, RenderStats& stats) {
  Count(AddToFilm(paths, n, scale(), sums_.data(), layout_.shared), stats);
  if (aovs_) aovs_->AddRadiance(paths, n, scale());
}

void Film::AddSplats(const LightColumns& splats, const std::uint32_t* pixel, std::uint32_t n,
                     float factor, RenderStats& stats) {
  assert(layout_.shared && !layout_.has_signs);
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

void Film::AddLightPart(LightPart part, const PathColumns& paths, std::uint32_t n) {
  if (aovs_) aovs_->AddLightPart(part, paths, n, scale());
}

bool Film::SumsLike(const Film& other) const {
  return unit_ == other.unit_ && layout_.has_signs == other.layout_.has_signs &&
         layout_.aovs == other.layout_.aovs && layout_.world_extent == other.layout_.world_extent &&
         layout_.light_groups == other.layout_.light_groups &&
         (layout_.mattes == other.layout_.mattes ||
          (layout_.mattes && other.layout_.mattes && *layout_.mattes == *other.layout_.mattes));
}

void Film::Merge(const Film& other) {
  assert(layout_.area.width == other.layout_.area.width);
  assert(layout_.area.height == other.layout_.area.height);
  AddWindow(other, {0, 0, layout_.area.width, layout_.area.height}, 0, 0);
}

void Film::AddPart(const Film& part, int x, int y) {
  AddWindow(part, part.layout_.area.picture, layout_.area.picture.x + x,
            layout_.area.picture.y + y);
}

// Adds the pixels `window` of `other` to those from (x, y) on.
void Film::AddWindow(const Film& other, const CropWindow& window, int x, int y) {
  assert(unit_ == other.unit_ && layout_.aovs == other.layout_.aovs);
  assert(x >= 0 && x + window.width <= layout_.area.width);
  assert(y >= 0 && y + window.height <= layout_.area.height);
  const std::size_t pixels = sums_.size() / 3, other_pixels = other.sums_.size() / 3;
  ForEachColumn([&](auto values_of, const FilmColumn& column) {
    if (column.of_matte) return;
    auto& to = values_of(*this);
    const auto& from = values_of(other);
    const bool has_signs = layout_.has_signs || column.has_signs;
    for (std::size_t plane = 0; plane < column.planes; ++plane) {
      const auto add = [&](std::size_t to_pixel, std::size_t from_pixel, std::size_t n) {
        auto* const sums = &to[(plane * pixels + to_pixel) * column.per_pixel];
        const auto* const more = &from[(plane * other_pixels + from_pixel) * column.per_pixel];
        for (std::size_t i = 0; i < n * column.per_pixel; ++i) {
          if (!column.of_nearest) {
            if constexpr (!std::is_same_v<decltype(more), const float* const>) {
              sums[i] = has_signs ? CombinedSigned(sums[i], more[i]) : Combined(sums[i], more[i]);
            }
          } else if (const std::size_t pixel = i / column.per_pixel;
                     other.aovs_->nearest()[from_pixel + pixel] <
                     aovs_->nearest()[to_pixel + pixel]) {
            sums[i] = more[i];
          }
        }
      };
      ForEachRun(window, other.layout_.area.width, x, y, layout_.area.width, add);
    }
  });
  if (!layout_.mattes) return;
  ForEachRun(window, other.layout_.area.width, x, y, layout_.area.width,
             [&](std::size_t to_pixel, std::size_t from_pixel, std::size_t n) {
               for (std::size_t i = 0; i < n; ++i) {
                 aovs_->AddMattes(*other.aovs_, from_pixel + i, to_pixel + i);
               }
             });
}

Film Film::Cut(const CropWindow& window) const {
  FilmLayout layout = layout_;
  layout.area = {window.width, window.height, {0, 0, window.width, window.height}};
  Film cut(std::move(layout));
  cut.AddWindow(*this, window, 0, 0);
  return cut;
}

std::size_t Film::packed_bytes() const {
  const CropWindow& picture = layout_.area.picture;
  return BytesOfPixel(layout_).kept * std::size_t(picture.width) * std::size_t(picture.height);
}

template <class Self, class F>
void Film::ForEachPictureRow(Self& self, F f) {
  const FilmArea& area = self.layout_.area;
  self.ForEachColumn([&](auto values_of, const FilmColumn& column) {
    auto& values = values_of(self);
    for (std::size_t plane = 0; plane < column.planes; ++plane) {
      const std::size_t first = plane * (self.sums_.size() / 3);
      ForEachRun(area.picture, area.width, 0, 0, area.width,
                 [&](std::size_t, std::size_t pixel, std::size_t n) {
                   f(&values[(first + pixel) * column.per_pixel],
                     n * column.per_pixel * sizeof values[0]);
                 });
    }
  });
}

void Film::PackPicture(const std::function<void(std::string_view row)>& take) const {
  ForEachPictureRow(*this, [&](const void* row, std::size_t size) {
    take({static_cast<const char*>(row), size});
  });
}

std::string Film::PackPicture() const {
  std::string bytes;
  bytes.reserve(packed_bytes());
  PackPicture([&](std::string_view row) { bytes += row; });
  return bytes;
}

void Film::UnpackPicture(std::string_view bytes) {
  assert(bytes.size() == packed_bytes());
  ForEachPictureRow(*this, [&](void* row, std::size_t size) {
    std::memcpy(row, bytes.data(), size);
    bytes.remove_prefix(size);
  });
}

std::vector<NamedChannel> Film::ResolveAovs(const SampleCounts& samples, AovSet wanted) const {
  if (!aovs_) return {};
  const FilmArea& area = layout_.area;
  auto channels =
      aovs_->Channels(wanted, std::size_t(area.picture.width) * std::size_t(area.picture.height));
  aovs_->Resolve(wanted, area, 0, area.picture.height, sums_, scale(), samples, channels);
  return channels;
}

LayeredImage Film::EmptyPicture(AovSet wanted) const {
  const CropWindow& picture = layout_.area.picture;
  LayeredImage empty = {Image(picture.width, picture.height)};
  if (aovs_) {
    empty.layers = aovs_->Channels(wanted, empty.image.rgb.size() / 3);
    empty.attributes = aovs_->Attributes(wanted);
  }
  return empty;
}

void Film::ResolveRows(const SampleCounts& samples, AovSet wanted, int first, int end,
                       LayeredImage& picture) const {
  ResolveImage(samples, first, end, picture.image);
  if (!aovs_) return;
  aovs_->Resolve(wanted, layout_.area, first, end, sums_, scale(), samples, picture.layers);
}

void Film::Forget(int first, int end) {
  const std::size_t pixels = sums_.size() / 3;
  const std::size_t width = std::size_t(layout_.area.width);
  ForEachColumn([&](auto values_of, const FilmColumn& column) {
    auto& values = values_of(*this);
    for (std::size_t plane = 0; plane < column.planes; ++plane) {
      const std::size_t before = plane * pixels + std::size_t(first) * width;
      GiveBack(std::span(&values[before * column.per_pixel],
                         std::size_t(end - first) * width * column.per_pixel));
    }
  });
}

std::span<const std::uint64_t> Film::light_group_sums() const {
  if (!aovs_) return {};
  return aovs_->light_group_sums();
}

NoiseSums Film::SumNoise(const CropWindow& window, const SampleCounts& samples) const {
  const CropWindow inside = Intersection(window, layout_.area.picture);
  NoiseSums sums = {.values = 3.0 * inside.width * inside.height};
  ForEachRun(inside, layout_.area.width, 0, 0, inside.width,
             [&](std::size_t, std::size_t pixel, std::size_t n) {
               for (std::size_t i = 3 * pixel; i < 3 * (pixel + n); ++i) {
                 const std::uint64_t count = samples[i / 3];
                 const double variance = aovs_->VarianceOf(i, sums_[i], count);
                 sums.variance += variance;
                 sums.variance_of_mean += variance / double(count);
                 sums.mean += value(i) / double(count);
               }
             });
  return sums;
}

std::vector<NoiseSums> Film::NoiseOfRows(const SampleCounts& samples, int first, int end) const {
  const CropWindow& picture = layout_.area.picture;
  std::vector<NoiseSums> rows;
  for (int y = first; y < end; ++y) {
    rows.push_back(SumNoise({picture.x, picture.y + y, picture.width, 1}, samples));
  }
  return rows;
}

double Film::Noise(std::span<const NoiseSums> rows) {
  NoiseSums sums;
  for (const NoiseSums& row : rows) {
    sums.variance_of_mean += row.variance_of_mean;
    sums.mean += row.mean;
    sums.values += row.values;
  }
  if (!(sums.mean > 0)) return 0;
  return std::sqrt(sums.variance_of_mean / sums.values) / (sums.mean / sums.values);
}

double Film::Noise(const SampleCounts& samples) const {
  return Noise(NoiseOfRows(samples, 0, layout_.area.picture.height));
}

Image Film::Resolve(const SampleCounts& samples) const {
  const CropWindow& picture = layout_.area.picture;
  Image image(picture.width, picture.height);
  ResolveImage(samples, 0, picture.height, image);
  return image;
}

void Film::ResolveImage(const SampleCounts& samples, int first, int end, Image& image) const {
  skywave::ResolveRows(
      layout_.area, first, end, [&](std::size_t to, std::size_t from, std::size_t n) {
        for (std::size_t i = 0; i < n; ++i) {
          const double count = double(std::max<std::uint64_t>(samples[from + i], 1));
          const double scale = unit_ / count;
          for (std::size_t c = 0; c < 3; ++c) {
            image.rgb[(to + i) * 3 + c] = float(value((from + i) * 3 + c) * scale);
          }
        }
      });
}

}  // namespace skywave
