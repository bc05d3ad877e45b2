// Reads OpenEXR pictures. Only this file and exr_writer.cc use the OpenEXR library: exr_header.h
// first checks a header, then exr_scan_lines.h or, for rarer files, the library decodes the very
// same bytes from memory.

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPartType.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <optional>
#include <stdexcept>

#include "base/files.h"
#include "image/exr_header.h"
#include "image/exr_scan_lines.h"
#include "image/formats.h"

namespace skywave {
namespace {

class MemoryInput : public Imf::IStream {
 public:
  MemoryInput(const std::string& path, std::string_view bytes)
      : Imf::IStream(path.c_str()), bytes_(bytes) {}

  bool read(char destination[], int count) override {
    if (count < 0 || position_ > bytes_.size() || bytes_.size() - position_ < std::size_t(count)) {
      throw std::runtime_error("the file ends too early");
    }
    std::memcpy(destination, bytes_.data() + position_, std::size_t(count));
    position_ += std::size_t(count);
    return position_ < bytes_.size();
  }
  std::uint64_t tellg() override { return position_; }
  void seekg(std::uint64_t position) override { position_ = position; }

 private:
  std::string_view bytes_;
  std::uint64_t position_ = 0;
};

// The channels of a picture: red, green and blue; or one for all three; or luminance (Y) and what
// red and blue have above it (RY, BY), each over it.
struct PictureChannels {
  std::vector<std::string> names;
  bool by_luminance = false;
};

// Finds the picture among the channels of a file: R, G, B, also in small letters; or Y, alone or
// with RY and BY; or R alone; or, in the files of programs that name all their layers, the only one
// of them that has a colour, or the one that Blender calls Combined.
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

PictureChannels ChooseChannels(const std::string& path, const std::vector<ExrChannel>& channels) {
  const InputPosition position = InputPosition::File(path);
  std::string names;
  for (const ExrChannel& channel : channels) {
    if (channel.sub_sampled) {
      throw InputError(position,
                       "EXR channel " + channel.name + " is sub-sampled, which is not supported");
    }
    names += (names.empty() ? "" : ", ") + channel.name;
  }
  if (auto found = FindPicture(channels)) return *std::move(found);
  throw InputError(position,
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

// Copies what is within both windows from values of the one to values of the other, which begin
// as zeros. A pixel has `step` values.
std::vector<float> Moved(const std::vector<float>& values, std::size_t step, const ExrBox& from,
                         const ExrBox& to) {
  std::vector<float> moved;
  ResizeLarge(moved, std::size_t(to.width()) * std::size_t(to.height()) * step);
  const int left = std::max(from.x_min, to.x_min), right = std::min(from.x_max, to.x_max);
  const auto at = [&](const ExrBox& box, int x, int y) {
    return (std::size_t(y - box.y_min) * std::size_t(box.width()) + std::size_t(x - box.x_min)) *
           step;
  };
  for (int y = std::max(from.y_min, to.y_min); y <= std::min(from.y_max, to.y_max); ++y) {
    if (left > right) break;
    std::copy_n(&values[at(from, left, y)], std::size_t(right - left + 1) * step,
                &moved[at(to, left, y)]);
  }
  return moved;
}

// Puts a picture where it belongs in the display window: what a crop or a region leaves out is
// black, and what lies beyond the window is dropped.
void PlaceInWindow(const std::string& path, const ExrHeader& header, const ReadLimits& limits,
                   LayeredImage& picture) {
  const ExrBox &data = header.data_window, &display = header.display_window;
  const bool same = data.x_min == display.x_min && data.y_min == display.y_min &&
                    data.x_max == display.x_max && data.y_max == display.y_max;
  if (same) return;
  const InputPosition position = InputPosition::File(path);
  CheckSize(position, display.width(), display.height(), limits);
  // A small file must not take much memory.
  constexpr std::int64_t kMuchLarger = 256, kFewPixels = 1 << 22;
  const std::int64_t pixels = display.width() * display.height();
  if (pixels > kFewPixels && pixels / kMuchLarger > data.width() * data.height()) {
    throw InputError(position, "the display window is over 256 times as large as the picture");
  }
  picture.image.rgb = Moved(picture.image.rgb, 3, data, display);
  picture.image.width = int(display.width()), picture.image.height = int(display.height());
  for (NamedChannel& layer : picture.layers) layer.values = Moved(layer.values, 1, data, display);
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

ExrBox BoxOf(const Imath::Box2i& window) {
  return {window.min.x, window.min.y, window.max.x, window.max.y};
}

// Files of rarer kinds, which the OpenEXR library decodes.
class Library {
 public:
  // Of a file of several parts, takes the first one that has a picture, and its channels and
  // windows for those of `header`.
  Library(const std::string& path, std::string_view bytes, const ReadLimits& limits,
          ExrHeader& header)
      : path_(path), stream_(path, bytes) {
    Try([&] {
      if (header.multi_part) {
        parts_.emplace(stream_, kNoExrThreads);
        ChoosePart(limits, header);
      } else {
        file_.emplace(stream_, kNoExrThreads);
      }
    });
  }

  LayeredImage Decode(const ExrBox& box, const std::vector<std::string>& names,
                      const std::vector<std::string>& layers) {
    LayeredImage picture = {Image(int(box.width()), int(box.height())), {}};
    Try([&] {
      if (parts_) {
        Imf::InputPart part(*parts_, part_);
        Read(part, box, names, layers, picture);
      } else {
        Read(*file_, box, names, layers, picture);
      }
    });
    return picture;
  }

 private:
  template <class F>
  void Try(const F& f) {
    try {
      f();
    } catch (const InputError&) {
      throw;
    } catch (const std::exception& error) {
      throw InputError(InputPosition::Byte(path_, stream_.tellg()),
                       std::string("cannot be decoded as OpenEXR: ") + error.what());
    }
  }

  void ChoosePart(const ReadLimits& limits, ExrHeader& header) {
    for (int part = 0; part < parts_->parts(); ++part) {
      const Imf::Header& of_part = parts_->header(part);
      if (of_part.hasType() && Imf::isDeepData(of_part.type())) continue;
      std::vector<ExrChannel> channels;
      const Imf::ChannelList& list = of_part.channels();
      for (auto it = list.begin(); it != list.end(); ++it) {
        const Imf::Channel& channel = it.channel();
        channels.push_back({.name = it.name(),
                            .bytes = channel.type == Imf::HALF ? 2 : 4,
                            .sub_sampled = channel.xSampling != 1 || channel.ySampling != 1,
                            .is_whole = channel.type == Imf::UINT});
      }
      if (!FindPicture(channels)) continue;
      part_ = part;
      header.channels = std::move(channels);
      header.data_window = BoxOf(of_part.dataWindow());
      header.display_window = BoxOf(of_part.displayWindow());
      CheckSize(InputPosition::File(path_), header.data_window.width(), header.data_window.height(),
                limits);
      return;
    }
  }

  // `source` is a file or a part of one.
  template <class Source>
  static void Read(Source& source, const ExrBox& box, const std::vector<std::string>& names,
                   const std::vector<std::string>& layers, LayeredImage& picture) {
    const Imath::Box2i window({box.x_min, box.y_min}, {box.x_max, box.y_max});
    if (source.header().dataWindow() != window) {
      throw std::runtime_error("two different data windows");
    }
    Image& image = picture.image;
    constexpr std::size_t kPixelStride = 3 * sizeof(float);
    Imf::FrameBuffer frame;
    for (std::size_t c = 0; c < names.size(); ++c) {
      frame.insert(names[c], Imf::Slice::Make(Imf::FLOAT, &image.rgb[c], window, kPixelStride));
    }
    picture.layers.reserve(layers.size());
    for (const std::string& name : layers) {
      picture.layers.push_back({.name = name, .values = {}});
      NamedChannel& layer = picture.layers.back();
      ResizeLarge(layer.values, image.rgb.size() / 3);
      frame.insert(name, Imf::Slice::Make(Imf::FLOAT, layer.values.data(), window));
    }
    source.setFrameBuffer(frame);
    source.readPixels(window.min.y, window.max.y);
    if (names.size() == 1) SpreadGrey(image);
  }

  const std::string& path_;
  MemoryInput stream_;
  std::optional<Imf::InputFile> file_;  // or
  std::optional<Imf::MultiPartInputFile> parts_;
  int part_ = 0;
};

}  // namespace

std::vector<std::string> ExrLayerNames(const std::string& path, std::string_view bytes,
                                       const ReadLimits& limits) {
  const ExrHeader header = ParseExrHeader(path, bytes, limits);
  return LayersBeside(ChooseChannels(path, header.channels).names, header);
}

LayeredImage DecodeExr(const std::string& path, std::string_view bytes, const ReadLimits& limits,
                       const std::vector<std::string>& layers) {
  ExrHeader header = ParseExrHeader(path, bytes, limits);
  std::optional<Library> library;
  if (header.multi_part) library.emplace(path, bytes, limits, header);
  const PictureChannels chosen = ChooseChannels(path, header.channels);
  const std::vector<std::string>& names = chosen.names;
  RequireLayers(path, layers, LayersBeside(names, header));
  LayeredImage picture;
  if (ExrScanLines lines(header, names, layers); lines.can_decode()) {
    CheckExrChunks(path, bytes, header, [&](auto... chunk) { return lines.Take(chunk...); });
    picture = lines.Picture();
  } else {
    if (!header.deep && !header.multi_part) CheckExrChunks(path, bytes, header);
    if (!library) library.emplace(path, bytes, limits, header);
    picture = library->Decode(header.data_window, names, layers);
  }
  if (chosen.by_luminance) ColorsOfLuminance(header.primaries.value_or(kRec709), picture.image);
  if (header.primaries) ConvertToRec709(*header.primaries, picture.image);
  PlaceInWindow(path, header, limits, picture);
  return picture;
}

Metadata ReadExrMetadata(const std::string& path, const ReadLimits& limits) {
  return ParseExrHeader(path, ReadFile(path), limits).strings;
}

}  // namespace skywave