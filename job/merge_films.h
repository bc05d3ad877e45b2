// Adds films of parts of a picture, rendered anywhere, to the picture: any split, in any order,
// gives the same bytes as one render.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "job/film_file.h"

namespace skywave {

struct MergeRequest {
  std::vector<std::string> films;
  std::optional<CropWindow> window;    // of the picture that is wanted; unset: the whole film
  std::optional<SampleRange> samples;  // of it; unset: all
};

// A picture that is being put together.
struct MergedFilm {
  FilmFile file;
  Film film;
  PicturePart wanted;
  std::vector<PicturePart> missing;  // parts of what is wanted that no film holds
};

// Reads the films one after the other and adds them. Throws InputError for a film that is of
// another picture, that is a checkpoint, that holds what another one holds too, or that is not all
// within what is wanted; it names both films and the difference.
MergedFilm MergeFilms(const MergeRequest& request);

// Returns the picture of a film of which nothing is missing. Throws InputError that names what is
// missing.
Picture ResolveMerged(const MergedFilm& merged);

// Returns "crop 64x64+0+0 sample-range 0:16", as flags of skywave render would ask for the part.
std::string ToString(const PicturePart& part);

// Returns what is left of `parts`, which are disjoint, without `taken`.
std::vector<PicturePart> Without(const std::vector<PicturePart>& parts, const PicturePart& taken);

}  // namespace skywave
