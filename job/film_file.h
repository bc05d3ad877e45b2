// A film in a file: the whole numbers that it has summed, what picture they are of, which part of
// it, and, where a render was interrupted, how far it had come. Films of the same picture can be
// added (merge_films.h), and a render can go on from one (session.h).
//
// The file begins with the eight bytes "SKYWFILM", the length of a manifest as 64 bits, and the
// manifest, which is JSON. Then follow the sums (Film::PackPicture) and the XXH64 of everything
// before it. Numbers are little-endian.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "job/picture.h"
#include "wavefront/film/film.h"
#include "wavefront/render.h"

namespace skywave {

struct FilmFile {
  PictureIdentity identity;
  CropWindow window;               // of the pixels that the sums are of, in the whole film
  std::vector<PicturePart> holds;  // disjoint parts that the sums are complete for
  AovSet layers = 0;               // those to show; a film may keep more
  double seconds = 0;              // rendering time of all parts
  // A checkpoint holds no part completely, but what `state` says of the samples it was to render.
  bool is_checkpoint = false;
  SampleRange samples;
  RenderState state;
};

// Writes the file as a whole: under another name, synced, renamed, and its folder synced. Throws
// InputError.
void WriteFilm(const std::string& path, const FilmFile& file, const Film& film);

// Reads a manifest and its film, which is all picture. Throws InputError with the byte offset for a
// file that is torn, of another version of the format, or not what it says.
struct FilmInFile {
  FilmFile file;
  Film film;
};
FilmInFile ReadFilm(const std::string& path);

// The same from memory; `path` is for messages.
FilmInFile ParseFilm(std::string_view bytes, const std::string& path);

}  // namespace skywave
