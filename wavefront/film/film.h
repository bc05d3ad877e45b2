// Paths end in the film, whose sums do not depend on the order of addition.
//
// A channel of a pixel is a 64-bit fixed-point number. Integer addition is associative, so any
// number of threads, any wave size and any split of the samples gives the same bits. The unit is a
// power of two chosen from the scene's brightest radiance: a sample holds 2^52 units, 64 times the
// brightest texel or more; brighter samples are clamped and counted. A sum saturates at 2^64 units,
// which stays order-free because nothing is ever subtracted.
//
// Samples may be negative with a control variate (kernels/lights/irradiance.h) and with a pixel
// filter that has negative weights. Then sums are signed numbers in two's complement, a sample
// holds 2^42 units, and they do not saturate: that would take 2^27 samples as bright as the
// brightest texel.
//
// Splats, the contributions of light paths to pixels of their choice, go to the same sums in the
// same unit: a splat is divided by the number of light paths per sample of every pixel, so that a
// pixel gets some splats per sample, each about as bright as what is seen there. Films that get
// them are shared: every addition is atomic.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "image/image.h"
#include "kernels/accumulate.h"
#include "kernels/columns.h"
#include "wavefront/film/aov_film.h"
#include "wavefront/film/film_area.h"
#include "wavefront/film/film_column.h"
#include "wavefront/film/film_memory.h"
#include "wavefront/stats.h"

namespace skywave {

// What a film is made for.
struct FilmLayout {
  FilmArea area;
  float brightest_radiance = 0;                // [scene radiance]
  AovSet aovs = 0;                             // kept in addition to radiance
  float world_extent = 0;                      // see AovFilm
  bool shared = false;                         // gets splats
  std::vector<std::string> light_groups = {};  // see AovFilm
  bool has_signs = false;                      // samples may be negative
  std::shared_ptr<const Mattes> mattes = {};   // of a film that keeps mattes
};

// The memory of a pixel of a film [bytes].
struct PixelBytes {
  std::size_t kept = 0;      // of all its sums
  std::size_t at_first = 0;  // of those that are in use before the first sample
};

// Sums over pixels and channels, from which noise is estimated [units, squared].
struct NoiseSums {
  double variance = 0;          // of a sample
  double variance_of_mean = 0;  // of the picture
  double mean = 0;
  double values = 0;  // their number
};

class Film {
 public:
  explicit Film(FilmLayout layout);
  // Makes a film that is all picture.
  Film(int width, int height, float brightest_radiance, AovSet aovs = 0, float world_extent = 0,
       bool shared = false)
      : Film({{width, height, {0, 0, width, height}},
              brightest_radiance,
              aovs,
              world_extent,
              shared}) {}

  const FilmLayout& layout() const { return layout_; }
  // Returns the memory of a pixel of such a film, which need not be made for that.
  static PixelBytes BytesOfPixel(FilmLayout layout);

  // Adds the radiance of paths [0, n) to their pixels. Two threads must not add to the same pixel,
  // unless the film is shared. Samples brighter than the range are clamped; NaN and, without signs,
  // negative channels count as 0; both are counted in `stats`, once per sample.
  void Add(const PathColumns& paths, std::uint32_t n, RenderStats& stats);

  // Adds the contributions of rows [0, n) to pixel[row], `factor` times r, g, b, if their ray
  // arrived (t_far >= 0). They are clamped and counted as samples are. The film is shared.
  void AddSplats(const LightColumns& splats, const std::uint32_t* pixel, std::uint32_t n,
                 float factor, RenderStats& stats);

  // True if the film keeps more than radiance; if not, these need not be called.
  bool has_aovs() const { return aovs_.has_value(); }
  void AddFirstHits(const FirstHits& hits);
  // Adds the radiance of paths [0, n) when all their direct light is in it.
  void AddDirect(const PathColumns& paths, std::uint32_t n);
  // Adds the gain of paths rows[0, n) to the groups of lights; see AovFilm.
  void AddToGroups(const PathColumns& paths, const std::uint32_t* rows, std::uint32_t n,
                   const GroupColumns& given);

  // Adds the radiance of paths [0, n), with the weights of the filter, to a part of the light.
  void AddLightPart(LightPart part, const PathColumns& paths, std::uint32_t n);

  // Returns whether the sums of both films are of the same kinds, in the same units.
  bool SumsLike(const Film& other) const;

  // Adds the sums of `other`, a film of the same size for the same brightest radiance that holds
  // other samples: afterwards it is as if all had been added to this one.
  void Merge(const Film& other);
  // The same with the picture of `part`, whose top left corner is pixel (x, y) of this picture.
  void AddPart(const Film& part, int x, int y);

  // Returns a film of the pixels `window` of this film, which is all picture.
  Film Cut(const CropWindow& window) const;

  // Serialises the sums of the picture's pixels, column by column and row by row, without the
  // border of the film; UnpackPicture restores them in a film of the same layout.
  void PackPicture(const std::function<void(std::string_view row)>& take) const;
  std::string PackPicture() const;
  std::size_t packed_bytes() const;  // of PackPicture
  void UnpackPicture(std::string_view bytes);

  // Returns what is known of the noise of the picture's pixels within a window of the film. The
  // film keeps the variance of samples.
  NoiseSums SumNoise(const CropWindow& window, const SampleCounts& samples) const;
  // Returns the noise of the picture: the root of the mean variance of its pixels and channels over
  // its mean.
  double Noise(const SampleCounts& samples) const;
  // Returns the sums of each of the rows [first, end) of the picture, and the noise of all of them
  // together.
  std::vector<NoiseSums> NoiseOfRows(const SampleCounts& samples, int first, int end) const;
  static double Noise(std::span<const NoiseSums> rows);

  // Returns the picture: the mean of the samples of every pixel.
  Image Resolve(const SampleCounts& samples) const;
  // Returns the channels of the layers `wanted`, all of which are kept, cut like the picture.
  std::vector<NamedChannel> ResolveAovs(const SampleCounts& samples, AovSet wanted) const;
  std::vector<NamedChannel> ResolveAovs(const SampleCounts& samples) const {
    return ResolveAovs(samples, layout_.aovs);
  }
  // Both for rows [first, end) of a picture that EmptyPicture has made.
  LayeredImage EmptyPicture(AovSet wanted) const;
  void ResolveRows(const SampleCounts& samples, AovSet wanted, int first, int end,
                   LayeredImage& picture) const;
  // Frees the memory of rows [first, end) of the film, which must not be read afterwards. No other
  // thread may use them.
  void Forget(int first, int end);

  // Returns the sums as they are kept, three per pixel of the film [units].
  std::span<const std::uint64_t> sums() const { return sums_; }
  // Returns those of the groups of lights, three per pixel of the film and group, group by group;
  // empty if not kept.
  std::span<const std::uint64_t> light_group_sums() const;
  double unit() const { return unit_; }  // [scene radiance], a power of two

 private:
  FilmScale scale() const;
  double sample_units() const;
  double value(std::size_t i) const { return SumValue(sums_[i], layout_.has_signs); }  // [units]
  static void Count(const FilmCounts& counts, RenderStats& stats);
  // Calls f(values_of, column) for each FilmColumn that has values; values_of(film) are those of a
  // film of the same layout.
  template <class F>
  void ForEachColumn(F f) const;
  // Calls f(values, bytes) for each row of the picture in each column of `self`.
  template <class Self, class F>
  static void ForEachPictureRow(Self& self, F f);
  void ResolveImage(const SampleCounts& samples, int first, int end, Image& image) const;
  void AddWindow(const Film& other, const CropWindow& window, int x, int y);

  FilmLayout layout_;
  double unit_;                     // [scene radiance]
  FilmValues<std::uint64_t> sums_;  // [units], three per pixel
  std::optional<AovFilm> aovs_;
};

}  // namespace skywave
