// The sums behind the layers of a picture (wavefront/film/aovs.h). Like those of the film they do
// not depend on the order of addition: means are sums of signed fixed-point numbers, of 2^38 units
// at the end of their range, so that 2^24 samples cannot overflow; the sample nearest to a pixel's
// centre is the minimum of a key; squares are exact.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "image/image.h"
#include "kernels/accumulate.h"
#include "kernels/columns.h"
#include "wavefront/film/aovs.h"
#include "wavefront/film/light_groups.h"

namespace skywave {

// The camera rays of a wave, and what they hit.
struct FirstHits {
  FirstSurfaces first;
  PathColumns paths;
  HitColumns hits;
  UniformColumns film;  // where in the pixel's filter a path lies
  std::uint32_t rays;   // rows of the last three
};

class AovFilm {
 public:
  // `world_extent`: no position or depth is larger. `light_groups`: their names.
  AovFilm(AovSet aovs, std::size_t pixels, float world_extent,
          std::vector<std::string> light_groups);

  void AddFirstHits(const FirstHits& hits);
  // The radiance of paths [0, n) when all of it is there, and when all direct light is.
  void AddRadiance(const PathColumns& paths, std::uint32_t n, const FilmScale& scale);
  void AddDirect(const PathColumns& paths, std::uint32_t n, const FilmScale& scale);
  // Gives what paths rows[0, n) have more than `given` to the light groups given.group[0, n).
  void AddToGroups(const PathColumns& paths, const std::uint32_t* rows, std::uint32_t n,
                   const FilmScale& scale, const GroupColumns& given);

  const std::vector<std::uint64_t>& light_group_sums() const { return lit_; }

  // Adds what `other` holds of other samples.
  void Merge(const AovFilm& other);

  // One entry a channel of every layer, of `samples` samples a pixel. `radiance`: the film's own
  // sums, three a pixel [1 / scale.units].
  std::vector<NamedChannel> Resolve(const std::vector<std::uint64_t>& radiance,
                                    const FilmScale& scale, std::uint64_t samples) const;

 private:
  // A layer of first hits: its values stand at [pixel * channels + channel] of one of the two.
  struct HitLayer {
    const Aov* aov;
    double unit = 0;                 // of sums
    std::vector<std::int64_t> sums;  // kMeanOfHits
    std::vector<float> values;       // kNearestHit
  };
  // Whether a sample with this key is nearer to the centre than all before, and now the nearest.
  bool BecomesNearest(std::uint32_t pixel, std::uint64_t key);
  void AddRows(const FirstHits& hits, std::uint32_t begin, std::uint32_t end);

  AovSet aovs_;
  std::size_t pixels_;
  std::vector<HitLayer> layers_;
  std::vector<std::uint32_t> hits_;     // samples that hit something, by pixel
  std::vector<std::uint64_t> nearest_;  // key of the sample nearest to the centre, by pixel
  std::vector<Uint128> squares_;        // of radiance, three a pixel [1 / scale.units^2]
  std::vector<std::uint64_t> direct_;   // three a pixel [1 / scale.units]
  std::vector<std::string> light_groups_;
  std::vector<std::uint64_t> lit_;  // three a pixel and group, group by group [1 / scale.units]
};

}  // namespace skywave
