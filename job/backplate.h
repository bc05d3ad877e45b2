// The photograph that a picture with alpha is put over.
#pragma once

#include <string>
#include <vector>

#include "image/image.h"
#include "wavefront/film/film_area.h"

namespace skywave {

struct Backplate {
  Image image;             // of a whole film, linear
  bool of_screen = false;  // it was made for screens: its colours are those of a PNG
  std::string note;        // how it was fitted; empty: its size is that of the film
  bool has_alpha = false;  // it is not opaque, which is left out
};

// Reads a photograph and fits it to a film: it is scaled until it covers the film, and what is left
// over is cut off on both sides alike. Its colours are converted to the space. Throws InputError.
Backplate ReadBackplate(const std::string& path, int width, int height,
                        RgbSpace space = RgbSpace::kRec709);

// Returns `foreground`, whose colours are multiplied by `alpha`, over the pixels `window` of a
// backplate. `factor` is that of its colours.
Image PutOver(const Image& foreground, const std::vector<float>& alpha, const Backplate& backplate,
              const CropWindow& window, float factor);

}  // namespace skywave
