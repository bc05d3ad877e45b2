// Reads OpenEXR pictures: exr_header.h first checks the headers, then exr_scan_lines.h or, for
// rarer files, exr_library.h decodes the very same bytes from memory.

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "base/files.h"
#include "image/exr_header.h"
#include "image/exr_library.h"
#include "image/exr_scan_lines.h"
#include "image/formats.h"
#include "image/placement.h"

namespace skywave {
namespace {

// The channels of a picture: red, green and blue; or one for all three; or luminance (Y) and what
// red and blue have above it (RY, BY), each over it.
struct PictureChannels {
  std::vector<std::string> names;
  bool by_luminance = false;
};

// Finds the picture among the channels of a file: R, G, B, also in small letters; or Y, alone or
// with RY and BY; or R without G and B; or, in the files of programs that name all their layers,
// the only one of them that has a colour, or the one that Blender calls Combined.
std::optional<PictureChannels> FindPicture(const std::vector<ExrChannel>& channels) {
  const auto has = [&](const std::string& name) {
    return std::any_of(channels.begin(), channels.end(),
                       [&](const ExrChannel& channel) { return channel.name == name; });
  };
  const auto colors = [&](const std::string& layer) -> std::optional<PictureChannels> {
    for (const std::string_view letters : {"RGB", "rgb"}) {
      PictureChannels found;
      for (const char letter : letters) found.names.push_back(layer + letter);
      if (std::all_of(found.names.begin(), found.names.end(), has)) return found;
    }
    return std::nullopt;
  };
  if (auto found = colors("")) return found;
  if (has("Y") && has("RY") && has("BY")) return PictureChannels{{"RY", "Y", "BY"}, true};
  if (has("Y")) return PictureChannels{{"Y"}};
  std::vector<std::string> layers;  // with their colours
  for (const ExrChannel& channel : channels) {
    const std::size_t dot = channel.name.rfind('.');
    if (dot == std::string::npos || !colors(channel.name.substr(0, dot + 1))) continue;
    const std::string layer = channel.name.substr(0, dot + 1);
    if (layers.empty() || layers.back() != layer) layers.push_back(layer);
  }
  const auto combined = std::find_if(layers.begin(), layers.end(), [](const std::string& layer) {
    return layer.ends_with("Combined.");
  });
  if (combined != layers.end()) return colors(*combined);
  if (layers.size() == 1) return colors(layers[0]);
  if (has("R") && !has("G") && !has("B")) return PictureChannels{{"R"}};
  return std::nullopt;
}

// Finds the picture that a layer is: its colours, or a channel for all three.
std::optional<PictureChannels> FindLayer(const std::vector<ExrChannel>& channels,
                                         const std::string& layer) {
  std::vector<ExrChannel> within;
  for (const ExrChannel& channel : channels) {
    if (channel.name == layer) return PictureChannels{{layer}};
    if (!channel.name.starts_with(layer + ".")) continue;
    within.push_back(channel);
    within.back().name = channel.name.substr(layer.size() + 1);
  }
  std::optional<PictureChannels> found = FindPicture(within);
  if (!found && within.size() == 1) found = {{within[0].name}};
  if (found) {
    for (std::string& name : found->names) name = layer + "." + name;
  }
  return found;
}

// Returns the name of a part; the only one of a file may have none.
std::string NameOf(const ExrHeader& part) {
  for (const auto& [name, text] : part.strings) {
    if (name == "name") return text;
  }
  return "";
}

// Returns what of a part is the layer, which may be the part itself.
std::optional<PictureChannels> FindLayer(const ExrHeader& part, const std::string& layer) {
  if (part.deep) return std::nullopt;
  if (layer.empty()) return FindPicture(part.channels);
  if (NameOf(part) != layer) return FindLayer(part.channels, layer);
  std::optional<PictureChannels> whole = FindPicture(part.channels);
  if (!whole && part.channels.size() == 1) whole = {{part.channels[0].name}};
  return whole ? whole : FindLayer(part.channels, layer);
}

PictureChannels ChooseChannels(const std::string& path, const std::vector<ExrChannel>& channels) {
  if (auto found = FindPicture(channels)) return *std::move(found);
  if (channels.size() == 1) return {{channels[0].name}};  // a depth or a height, say
  std::string names;
  for (const ExrChannel& channel : channels) names += (names.empty() ? "" : ", ") + channel.name;
  throw InputError(InputPosition::File(path),
                   "an EXR needs channels R, G, B or Y, or one layer that has them; this "
                   "one has " +
                       names);
}

// Turns luminance and chroma into colours of these primaries.
void ColorsOfLuminance(const RgbPrimaries& primaries, Image& image) {
  const glm::dmat3 xyz = XyzFromRgb(primaries);
  const double red = xyz[0].y, green = xyz[1].y, blue = xyz[2].y;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    float* const pixel = &image.rgb[i];
    const double y = pixel[1], r = (pixel[0] + 1) * y, b = (pixel[2] + 1) * y;
    pixel[0] = float(r), pixel[1] = float((y - r * red - b * blue) / green), pixel[2] = float(b);
  }
}

// Returns where the data window lies in the display window.
Placement PlacementOf(const ExrHeader& header) {
  const ExrBox &data = header.data_window, &display = header.display_window;
  const Placement place = {data.x_min - display.x_min, data.y_min - display.y_min,
                           int(display.width()), int(display.height())};
  const bool same = place.x == 0 && place.y == 0 && data.width() == display.width() &&
                    data.height() == display.height();
  return same ? Placement() : place;
}

// Puts a picture where it belongs in the display window: what a crop or a region leaves out is
// black, and what lies beyond the window is dropped.
void PlaceInWindow(const std::string& path, const ReadLimits& limits, LayeredImage& picture) {
  if (picture.placement.width == 0) return;
  const PixelBox whole = WholeOf(picture), part = PartOf(picture);
  const InputPosition position = InputPosition::File(path);
  CheckSize(position, whole.width, whole.height, limits);
  // A small file must not take much memory.
  constexpr std::int64_t kMuchLarger = 256, kFewPixels = 1 << 22;
  const std::int64_t pixels = whole.width * whole.height;
  if (pixels > kFewPixels && pixels / kMuchLarger > part.width * part.height) {
    throw InputError(position, "the display window is over 256 times as large as the picture");
  }
  CutTo(whole, picture);
  picture.placement = {};
}

// Returns the channels of the file that are not among `picture`.
std::vector<std::string> LayersBeside(const std::vector<std::string>& picture,
                                      const ExrHeader& header) {
  std::vector<std::string> layers;
  for (const ExrChannel& channel : header.channels) {
    if (std::find(picture.begin(), picture.end(), channel.name) == picture.end()) {
      layers.push_back(channel.name);
    }
  }
  return layers;
}

// Throws unless each of `wanted` is among `there`.
void RequireLayers(const std::string& path, const std::vector<std::string>& wanted,
                   const std::vector<std::string>& there) {
  for (const std::string& name : wanted) {
    if (std::find(there.begin(), there.end(), name) != there.end()) continue;
    std::string list;
    for (const std::string& other : there) list += (list.empty() ? "" : ", ") + other;
    throw InputError(InputPosition::File(path),
                     "has no layer " + name +
                         (list.empty() ? "; it has none at all" : "; its layers are " + list));
  }
}

// Returns the names of parts and layers that may be asked for.
std::string LayersOf(const std::vector<ExrHeader>& parts) {
  std::set<std::string> names;
  for (const ExrHeader& part : parts) {
    if (part.multi_part) names.insert(NameOf(part));
    for (const ExrChannel& channel : part.channels) {
      const std::size_t dot = channel.name.rfind('.');
      if (dot != std::string::npos) names.insert(channel.name.substr(0, dot));
    }
  }
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

// The part of a file in which a picture is, and its channels.
struct ChosenPicture {
  ExrHeader header;
  PictureChannels channels;
};

// Returns the layer, or without one the picture of the first flat part that has one, or else of the
// first part.
ChosenPicture ChoosePicture(const std::string& path, std::string_view bytes,
                            const ReadLimits& limits, const std::string& layer) {
  std::vector<ExrHeader> parts = ParseExrHeaders(path, bytes, limits);
  auto chosen = std::find_if(parts.begin(), parts.end(), [&](const ExrHeader& part) {
    return FindLayer(part, layer).has_value();
  });
  if (chosen == parts.end() && !layer.empty()) {
    const std::string list = LayersOf(parts);
    throw InputError(
        InputPosition::File(path),
        "has no layer " + layer + (list.empty() ? "; it has none at all" : "; there are " + list));
  }
  if (chosen == parts.end()) chosen = parts.begin();
  CheckSize(InputPosition::File(path), chosen->data_window.width(), chosen->data_window.height(),
            limits);
  PictureChannels channels =
      layer.empty() ? ChooseChannels(path, chosen->channels) : *FindLayer(*chosen, layer);
  return {std::move(*chosen), std::move(channels)};
}

// Throws if the file is too small for its pixels: such files must not take much memory.
void RequireBytes(const std::string& path, std::string_view bytes, const ExrHeader& header) {
  constexpr std::int64_t kMostPixelsOfByte = 4096;
  const std::int64_t pixels = header.data_window.width() * header.data_window.height();
  if (pixels / kMostPixelsOfByte <= std::int64_t(bytes.size())) return;
  throw InputError(InputPosition::File(path),
                   "the file is too small for its " + std::to_string(header.data_window.width()) +
                       " x " + std::to_string(header.data_window.height()) + " pixels");
}

// Returns whether some channels of those names have fewer samples than there are pixels.
bool AreSubSampled(const std::vector<ExrChannel>& channels, const std::vector<std::string>& names) {
  return std::any_of(channels.begin(), channels.end(), [&](const ExrChannel& channel) {
    return channel.sub_sampled &&
           std::find(names.begin(), names.end(), channel.name) != names.end();
  });
}

}  // namespace

std::vector<std::string> ExrLayerNames(const std::string& path, std::string_view bytes,
                                       const ReadLimits& limits, const std::string& layer) {
  const ChosenPicture chosen = ChoosePicture(path, bytes, limits, layer);
  return LayersBeside(chosen.channels.names, chosen.header);
}

LayeredImage DecodeExrColors(const std::string& path, std::string_view bytes,
                             const ReadLimits& limits, const std::vector<std::string>& layers,
                             const std::string& layer) {
  const auto [header, chosen] = ChoosePicture(path, bytes, limits, layer);
  const std::vector<std::string>& names = chosen.names;
  RequireLayers(path, layers, LayersBeside(names, header));
  const bool few_samples = std::any_of(header.channels.begin(), header.channels.end(),
                                       [](const ExrChannel& c) { return c.sub_sampled; });
  const bool interpolate = chosen.by_luminance && AreSubSampled(header.channels, names);
  if (AreSubSampled(header.channels, layers) ||
      (!interpolate && AreSubSampled(header.channels, names)) ||
      (interpolate && (header.multi_part || !layers.empty()))) {
    throw InputError(InputPosition::File(path),
                     "channels that are sub-sampled are read as RY and BY beside Y only, without "
                     "other layers");
  }
  LayeredImage picture;
  if (ExrScanLines lines(header, names, layers); lines.can_decode() && !few_samples) {
    CheckExrChunks(path, bytes, header, [&](auto... chunk) { return lines.Take(chunk...); });
    picture = lines.Picture();
  } else {
    if (header.deep || few_samples) {
      RequireBytes(path, bytes, header);
    } else {
      CheckExrChunks(path, bytes, header);
    }
    picture = DecodeByLibrary(path, bytes, limits, header, {names, layers, interpolate});
  }
  if (chosen.by_luminance && !interpolate) {
    ColorsOfLuminance(header.primaries.value_or(kRec709), picture.image);
  }
  if (header.primaries) {
    if (const std::optional<RgbSpace> space = SpaceOf(*header.primaries)) {
      picture.space = *space;
    } else {
      ConvertToRec709(*header.primaries, picture.image);
    }
  }
  picture.placement = PlacementOf(header);
  return picture;
}

LayeredImage DecodeExrPart(const std::string& path, std::string_view bytes,
                           const ReadLimits& limits, const std::vector<std::string>& layers,
                           const std::string& layer) {
  LayeredImage picture = DecodeExrColors(path, bytes, limits, layers, layer);
  ConvertToRec709(PrimariesOf(std::exchange(picture.space, RgbSpace::kRec709)), picture.image);
  return picture;
}

LayeredImage DecodeExr(const std::string& path, std::string_view bytes, const ReadLimits& limits,
                       const std::vector<std::string>& layers, const std::string& layer) {
  LayeredImage picture = DecodeExrPart(path, bytes, limits, layers, layer);
  PlaceInWindow(path, limits, picture);
  return picture;
}

Metadata ReadExrMetadata(const std::string& path, const ReadLimits& limits) {
  return ParseExrHeaders(path, ReadFile(path), limits).front().strings;
}

}  // namespace skywave
