// A picture in a viewer while it is rendered: tiles and layers as they are finished.
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "api/display/tev.h"
#include "job/picture.h"
#include "wavefront/film/film.h"
#include "wavefront/stages/stages.h"

namespace skywave {

class PictureDisplay {
 public:
  // `name` is that of the picture in the viewer; `layers` are shown in addition to it.
  PictureDisplay(const ViewerAddress& viewer, const std::string& name, AovSet layers);

  // Shows a tile of `film` whose pixels hold `samples` samples. Any thread may call this, while
  // nobody adds samples to the tile.
  void ShowTile(const Film& film, const Tile& tile, const SampleCounts& samples);
  // Shows the picture and ends. Returns what went wrong with the viewer, or nothing.
  std::string End(const Picture& picture);

 private:
  // Sends a window of the picture, whose size is that of `picture`.
  void Show(const CropWindow& picture, const DisplayWindow& window, const Image& image,
            const std::vector<NamedChannel>& layers);

  ViewerAddress viewer_;
  std::string name_;
  AovSet layers_;
  std::once_flag begun_;  // with the first tile, which knows the names of all channels
  std::unique_ptr<TevDisplay> display_;
};

}  // namespace skywave
