// An AovFilm holds the sums behind the layers of a picture (wavefront/film/aovs.h). Like those of
// the film they do not depend on the order of addition: means are sums of signed fixed-point
// numbers with 2^38 units at the end of their range, so that 2^24 samples cannot overflow; the
// sample nearest to a pixel's centre is the minimum of a key; squares are exact.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "image/image.h"
#include "kernels/accumulate.h"
#include "kernels/columns.h"
#include "kernels/light_paths/camera_connection.h"
#include "wavefront/film/aovs.h"
#include "wavefront/film/film_column.h"
#include "wavefront/film/film_memory.h"
#include "wavefront/film/light_groups.h"
#include "wavefront/film/mattes.h"

namespace skywave {

// These are the camera rays of a wave and their hits.
struct FirstHits {
  FirstSurfaces first;
  PathColumns paths;
  HitColumns hits;
  UniformColumns film;  // position of a path in the pixel's filter
  FilterView filter;
  std::uint32_t rays;  // rows of the last three
};

// What the noise of a kind of light is estimated from, three values per pixel.
struct SampleMoments {
  FilmValues<Uint128> squares;       // of all samples [1 / scale.units^2]
  FilmValues<std::uint64_t> half;    // of the second halves [1 / scale.units]
  FilmValues<Uint128> half_squares;  // likewise
};

class AovFilm {
 public:
  // No position or depth is larger than `world_extent`. `light_groups` are the names of the groups.
  // `has_signs` is that of the film; `mattes` are the names of its mattes.
  AovFilm(AovSet aovs, std::size_t pixels, float world_extent,
          std::vector<std::string> light_groups, bool has_signs = false,
          std::shared_ptr<const Mattes> mattes = nullptr);

  void AddFirstHits(const FirstHits& hits);
  // These add the radiance of paths [0, n) when all of it is there, and when all direct light is.
  void AddRadiance(const PathColumns& paths, std::uint32_t n, const FilmScale& scale);
  void AddDirect(const PathColumns& paths, std::uint32_t n, const FilmScale& scale);
  // Adds the radiance that paths rows[0, n) have in excess of `given` to the light groups
  // given.group[0, n), and brings `given` up to date.
  void AddToGroups(const PathColumns& paths, const std::uint32_t* rows, std::uint32_t n,
                   const FilmScale& scale, const GroupColumns& given);

  // Adds the radiance of paths [0, n) to a part of the light, if it is kept. That of kChange has
  // signs.
  void AddLightPart(LightPart part, const PathColumns& paths, std::uint32_t n,
                    const FilmScale& scale);

  std::span<const std::uint64_t> light_group_sums() const { return lit_; }

  // Calls f(values_of, column) for each FilmColumn: values_of(film) are its values in a film like
  // this one. The keys of the nearest samples come last.
  template <class F>
  void ForEachColumn(F f) const {
    for (std::size_t k = 0; k < layers_.size(); ++k) {
      const std::size_t channels = layers_[k].aov->channels.size();
      f(
          [k](auto& film) -> auto& { return film.layers_[k].sums; }, FilmColumn{channels});
      f(
          [k](auto& film) -> auto& { return film.layers_[k].values; },
          FilmColumn{.per_pixel = channels,
                     .of_nearest = true,
                     .starts_filled = layers_[k].aov->background != 0});
    }
    f(
        [](auto& film) -> auto& { return film.hits_; }, FilmColumn{});
    f(
        [](auto& film) -> auto& { return film.beauty_.squares; }, FilmColumn{3});
    f(
        [](auto& film) -> auto& { return film.half_samples_; }, FilmColumn{});
    f(
        [](auto& film) -> auto& { return film.beauty_.half; }, FilmColumn{3});
    f(
        [](auto& film) -> auto& { return film.beauty_.half_squares; }, FilmColumn{3});
    f(
        [](auto& film) -> auto& { return film.direct_; }, FilmColumn{3});
    f(
        [](auto& film) -> auto& { return film.lit_; }, FilmColumn{3, light_groups_.size()});
    f(
        [](auto& film) -> auto& { return film.weights_; }, FilmColumn{3});
    for (std::size_t part = 0; part < light_parts_.size(); ++part) {
      const FilmColumn column = {.per_pixel = 3, .has_signs = HasSigns(LightPart(part))};
      f(
          [part](auto& film) -> auto& { return film.light_parts_[part]; }, column);
    }
    for (std::size_t part = 0; part < part_moments_.size(); ++part) {
      const FilmColumn column = {.per_pixel = 3, .has_signs = HasSigns(LightPart(part))};
      f(
          [part](auto& film) -> auto& { return film.part_moments_[part].squares; }, FilmColumn{3});
      f(
          [part](auto& film) -> auto& { return film.part_moments_[part].half; }, column);
      f(
          [part](auto& film) -> auto& { return film.part_moments_[part].half_squares; },
          FilmColumn{3});
    }
    for (std::size_t k = 0; k < mattes_.size(); ++k) {
      const FilmColumn column = {.planes = mattes_[k].slots, .of_matte = true};
      f(
          [k](auto& film) -> auto& { return film.mattes_[k].ids; }, column);
      f(
          [k](auto& film) -> auto& { return film.mattes_[k].weights; }, column);
    }
    f(
        [](auto& film) -> auto& { return film.nearest_; },
        FilmColumn{.of_nearest = true, .starts_filled = true});
  }
  // Adds what the mattes of another film like this one hold of a pixel.
  void AddMattes(const AovFilm& other, std::size_t from_pixel, std::size_t to_pixel);
  // Returns the variance of a sample [1 / scale.units^2] in value `i`, channel i % 3 of pixel i /
  // 3, whose `samples` samples have this sum. The layer variance is kept.
  double VarianceOf(std::size_t i, std::uint64_t sum, std::uint64_t samples) const;
  // Returns the keys of the nearest samples, by pixel; empty where no layer asks for them.
  std::span<const std::uint64_t> nearest() const { return nearest_; }

  // Returns one entry per channel of every layer of `wanted`, which are kept, with room for so many
  // pixels.
  std::vector<NamedChannel> Channels(AovSet wanted, std::size_t pixels) const;
  // Returns what the header of a picture says of these layers.
  Metadata Attributes(AovSet wanted) const;
  // Writes rows [first, end) of the picture of `area` to those channels, which are of the whole
  // picture. `radiance` holds the film's own sums, three per pixel [1 / scale.units].
  void Resolve(AovSet wanted, const FilmArea& area, int first, int end,
               std::span<const std::uint64_t> radiance, const FilmScale& scale,
               const SampleCounts& samples, std::vector<NamedChannel>& channels) const;

 private:
  // A layer of first hits has its values at [pixel * channels + channel] of `sums` or `values`.
  struct HitLayer {
    const Aov* aov;
    double unit = 0;                // unit of the sums
    FilmValues<std::int64_t> sums;  // kMeanOfHits
    FilmValues<float> values;       // kNearestHit
  };
  // Returns true if a sample with this key is nearer to the centre than all before, and makes it
  // the nearest.
  bool BecomesNearest(std::uint32_t pixel, std::uint64_t key);
  void AddWeights(const FirstHits& hits);
  // Returns the number in MatteNames of what surface i is of.
  std::uint32_t ObjectOf(const FirstSurfaces& first, std::uint32_t i) const;
  bool HasSigns(LightPart part) const { return has_signs_ || part == LightPart::kChange; }
  double LightOf(LightPart part, std::size_t i) const {
    return SumValue(light_parts_[std::size_t(part)][i], HasSigns(part));
  }
  // Returns the light of catchers [1 / scale.units]; none where it is not kept.
  CaughtLight CaughtLightOf(std::size_t pixel) const;
  // Returns the share of the weights of a pixel of samples that meet this first (aov_film.cc).
  double ShareOf(std::size_t pixel, std::size_t first) const;
  void AddRows(const FirstHits& hits, std::uint32_t begin, std::uint32_t end);
  // Returns the weights of all samples of a pixel together.
  double WeightOf(std::size_t pixel) const;
  void ResolveMatte(MatteOf matte, const FilmArea& area, int first, int end,
                    std::span<NamedChannel> channels) const;

  std::size_t pixels_;
  bool has_signs_;
  std::vector<HitLayer> layers_;
  FilmValues<std::uint32_t> hits_;          // samples that hit something, by pixel
  FilmValues<std::uint64_t> nearest_;       // key of the sample nearest to the centre, by pixel
  FilmValues<std::uint32_t> half_samples_;  // in second halves, by pixel
  SampleMoments beauty_;
  FilmValues<std::uint64_t> direct_;  // three per pixel [1 / scale.units]
  std::vector<std::string> light_groups_;
  FilmValues<std::uint64_t> lit_;  // three per pixel and group, group by group [1 / scale.units]
  // The filter's weights of samples whose first surface is of an object, of a catcher, and of those
  // that have none: three per pixel.
  FilmValues<std::uint64_t> weights_;
  // Three per pixel, by LightPart [1 / scale.units].
  std::array<FilmValues<std::uint64_t>, kLightParts> light_parts_;
  std::array<SampleMoments, kPartsOfCatchers> part_moments_;
  std::shared_ptr<const Mattes> matte_names_;
  std::array<MatteSums, kMattes> mattes_;  // by MatteOf
};

}  // namespace skywave
