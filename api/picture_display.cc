#include "api/picture_display.h"

#include <algorithm>

namespace skywave {
namespace {

// Returns the values of all channels, channel by channel.
std::vector<float> Planes(const Image& image, const std::vector<NamedChannel>& layers) {
  std::vector<float> values;
  values.reserve(image.rgb.size() / 3 * (3 + layers.size()));
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = c; i < image.rgb.size(); i += 3) values.push_back(image.rgb[i]);
  }
  for (const NamedChannel& channel : layers) {
    values.insert(values.end(), channel.values.begin(), channel.values.end());
  }
  return values;
}

std::vector<std::string> ChannelNames(const std::vector<NamedChannel>& layers) {
  std::vector<std::string> names = {"R", "G", "B"};
  for (const NamedChannel& channel : layers) names.push_back(channel.name);
  return names;
}

}  // namespace

PictureDisplay::PictureDisplay(const ViewerAddress& viewer, const std::string& name, AovSet layers)
    : viewer_(viewer), name_(name), layers_(layers) {}

void PictureDisplay::Show(const CropWindow& picture, const DisplayWindow& window,
                          const Image& image, const std::vector<NamedChannel>& layers) {
  std::call_once(begun_, [&] {
    display_ = std::make_unique<TevDisplay>(viewer_, name_, picture.width, picture.height,
                                            ChannelNames(layers));
  });
  if (display_->watched()) display_->Update(window, Planes(image, layers));
}

void PictureDisplay::ShowTile(const Film& film, const Tile& tile, const SampleCounts& samples) {
  const CropWindow& picture = film.layout().area.picture;
  const CropWindow window =
      Intersection({int(tile.x), int(tile.y), int(tile.width), int(tile.height)}, picture);
  if (window.width == 0 || window.height == 0) return;
  const Film cut = film.Cut(window);
  const SampleCounts counts = samples.Cut(window, film.layout().area.width);
  Show(picture, {window.x - picture.x, window.y - picture.y, window.width, window.height},
       cut.Resolve(counts), cut.ResolveAovs(counts, layers_));
}

std::string PictureDisplay::End(const Picture& picture) {
  const int width = picture.image.width, height = picture.image.height;
  // The viewer has the layers that tiles have. A denoiser appends its own to them.
  std::vector<NamedChannel> layers = picture.layers;
  std::erase_if(layers, [](const NamedChannel& channel) { return IsOfDenoiser(channel.name); });
  Show({0, 0, width, height}, {0, 0, width, height}, picture.image, layers);
  return display_->Finish();
}

}  // namespace skywave
