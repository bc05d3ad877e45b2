#include "job/denoise/catchers.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string_view>
#include <utility>

#include "job/denoise/denoise.h"
#include "job/denoise/input.h"
#include "wavefront/film/light_parts.h"

namespace skywave {
namespace {

constexpr double kBrightest = double(std::numeric_limits<float>::max());
// Shares of the pixels.
constexpr char kObjectsShare[] = "objects.A", kCatchersShare[] = "clean.A";

// Returns channels R, G and B of a layer as a picture.
Image PictureOfLayer(const std::string& name, std::span<const NamedChannel> layers,
                     std::string_view layer, int width, int height) {
  Image image(width, height);
  for (std::size_t c = 0; c < 3; ++c) {
    const std::span<const float> values =
        FindChannel(name, image.rgb.size() / 3, layers, fmt::format("{}.{}", layer, "RGB"[c]));
    for (std::size_t i = 0; i < values.size(); ++i) image.rgb[3 * i + c] = values[i];
  }
  return image;
}

std::vector<NamedChannel> EmptyLayer(std::string_view name, std::size_t pixels) {
  std::vector<NamedChannel> layer;
  for (const char channel : {'R', 'G', 'B'}) {
    layer.push_back({fmt::format("{}.{}", name, channel), std::vector<float>(pixels)});
  }
  return layer;
}

// Returns the squared error of a part, in value i of pixel i / 3; 0 where it is not estimated.
double SquaredError(const Denoised& part, std::size_t i) {
  if (part.error.empty()) return 0;
  const double error = double(part.error[i % 3].values[i / 3]);
  return error * error;
}

// The clean layers of a picture with catchers.
struct CleanCatchers {
  Denoised foreground;  // with its error
  std::vector<float> alpha;
  std::vector<NamedChannel> shadow, difference;  // R, G and B each
  std::vector<std::string> notes;
};

CleanCatchers DenoiseCatchers(Denoiser by, const std::string& name, int width, int height,
                              std::span<const NamedChannel> layers) {
  const auto clean_part = [&](Denoiser method, const std::string& layer, const char* share) {
    const Image noisy = PictureOfLayer(name, layers, layer, width, height);
    return Denoise(method, name, noisy, layers, {layer + "-", share});
  };
  CleanCatchers result;
  Denoised objects = clean_part(by, "objects", kObjectsShare);
  const Denoised place = clean_part(by, "clean", kCatchersShare);
  const Denoised change = clean_part(Denoiser::kStatistics, "difference", kCatchersShare);
  const auto tell = [&](const char* what, const Denoised& part) {
    for (const std::string& note : NotesOf(part)) {
      result.notes.push_back(fmt::format("{}: {}", what, note));
    }
  };
  tell("objects", objects), tell("the place", place), tell("what objects change of it", change);
  const std::size_t pixels = objects.image.rgb.size() / 3;
  const std::span<const float> of_objects = FindChannel(name, pixels, layers, kObjectsShare);
  const std::span<const float> of_catchers = FindChannel(name, pixels, layers, kCatchersShare);
  result.alpha.resize(pixels);
  result.shadow = EmptyLayer("shadow", pixels);
  result.difference = EmptyLayer("difference", pixels);
  tbb::parallel_for(std::size_t{0}, pixels, [&](std::size_t pixel) {
    CaughtLight light = {};
    for (std::size_t c = 0; c < 3 && of_catchers[pixel] > 0; ++c) {
      light.clean[c] = double(place.image.rgb[3 * pixel + c]);
      // Objects take no more than there is, though the errors of both may say otherwise.
      light.change[c] =
          std::max(double(change.image.rgb[3 * pixel + c]), -std::max(light.clean[c], 0.0));
    }
    const double kept = KeptShare(light);
    result.alpha[pixel] =
        float(double(of_objects[pixel]) + (1 - kept) * double(of_catchers[pixel]));
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t i = 3 * pixel + c;
      result.shadow[c].values[pixel] = float(std::min(ShadowOf(light, c), kBrightest));
      result.difference[c].values[pixel] = float(light.change[c]);
      if (!(of_objects[pixel] > 0)) objects.image.rgb[i] = 0;
      objects.image.rgb[i] += float(std::max(AddedLight(light, kept, c), 0.0));
      if (objects.error.empty()) continue;
      // By the errors of what AddedLight adds, with the share as it is.
      const double squared = SquaredError(objects, i) + SquaredError(change, i) +
                             (1 - kept) * (1 - kept) * SquaredError(place, i);
      objects.error[c].values[pixel] = float(std::sqrt(squared));
    }
  });
  result.foreground = std::move(objects);
  return result;
}

// Writes channels over those of the same names.
void Replace(std::vector<NamedChannel> channels, std::vector<NamedChannel>& layers) {
  for (NamedChannel& layer : layers) {
    for (NamedChannel& channel : channels) {
      if (channel.name == layer.name) layer.values = std::move(channel.values);
    }
  }
}

}  // namespace

bool ShowsCatchers(std::span<const NamedChannel> layers) {
  return std::any_of(layers.begin(), layers.end(),
                     [](const NamedChannel& layer) { return layer.name == "difference.R"; });
}

Cleaning CleanPicture(Denoiser by, const std::string& name, Image& image, std::vector<float>& alpha,
                      std::vector<NamedChannel>& layers) {
  Denoised clean;
  std::vector<std::string> notes;
  const bool catchers = ShowsCatchers(layers), has_alpha = !alpha.empty();
  if (catchers) {
    CleanCatchers caught = DenoiseCatchers(by, name, image.width, image.height, layers);
    notes = std::move(caught.notes);
    Replace(std::move(caught.shadow), layers);
    Replace(std::move(caught.difference), layers);
    if (has_alpha) {
      clean = std::move(caught.foreground);
      alpha = std::move(caught.alpha);
    } else {
      Replace(AsLayer("foreground", caught.foreground.image), layers);
      Replace({{"alpha.A", std::move(caught.alpha)}}, layers);
    }
  }
  if (!catchers || !has_alpha) {
    clean = Denoise(by, name, image, layers);
    if (!catchers) Replace(std::move(clean.groups), layers);
    const std::vector<std::string> more = NotesOf(clean);
    notes.insert(notes.end(), more.begin(), more.end());
  }
  image = std::move(clean.image);
  return {std::move(clean.error), std::move(notes), std::move(clean.oidn)};
}

}  // namespace skywave
