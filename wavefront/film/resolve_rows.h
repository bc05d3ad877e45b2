// The picture of a film is resolved row by row, by many threads.
#pragma once

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cstddef>

#include "wavefront/film/film_area.h"

namespace skywave {

// Calls f(to, from, n) for the rows [first, end) of n pixels of the picture of a film, on the
// threads of the arena: a row begins at pixel `to` of the picture and at pixel `from` of the film.
template <class F>
void ResolveRows(const FilmArea& area, int first, int end, F f) {
  const CropWindow& picture = area.picture;
  // A worker that shows a tile waits here. It must not begin another tile meanwhile.
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(first, end, [&](int y) {
      f(std::size_t(y) * std::size_t(picture.width),
        std::size_t(picture.y + y) * std::size_t(area.width) + std::size_t(picture.x),
        std::size_t(picture.width));
    });
  });
}

}  // namespace skywave
