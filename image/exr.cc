// Reads and writes OpenEXR pictures. Only this file uses the OpenEXR library: exr_header.h first
// checks a header, then exr_scan_lines.h or, for rarer files, the library decodes the very same
// bytes from memory.

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfOutputFile.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>
#include <half.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <exception>
#include <optional>
#include <stdexcept>

#include "base/files.h"
#include "base/granted.h"
#include "image/byte_cursor.h"
#include "image/exr_header.h"
#include "image/exr_scan_lines.h"
#include "image/exr_strip.h"
#include "image/formats.h"

namespace skywave {
namespace {

// Files ask for no threads. OpenEXR's global number of them is zero by default and is left alone,
// because it belongs to the program that uses the library.
constexpr int kNoThreads = 0;

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

// Everything is written to memory first, because Imf::OutputFile writes its chunk table in the
// destructor, where it cannot report a full disk.
class MemoryOutput : public Imf::OStream {
 public:
  explicit MemoryOutput(const std::string& path) : Imf::OStream(path.c_str()) {}

  void write(const char source[], int count) override {
    const std::size_t end = position_ + std::size_t(count);
    if (end > bytes_.size()) bytes_.resize(end);
    std::memcpy(bytes_.data() + position_, source, std::size_t(count));
    position_ = end;
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = position; }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
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

// The precision of 16 bits is enough for colours, but perhaps not for quantities in other units,
// and not for what is subtracted from a colour.
bool MayBeHalf(const std::string& name) {
  const std::size_t dot = name.rfind('.');
  const std::string letter = dot == std::string::npos ? name : name.substr(dot + 1);
  const bool is_color = letter == "R" || letter == "G" || letter == "B";
  for (const std::string_view exact : {"variance.", "half.", "half-variance."}) {
    if (name.starts_with(exact)) return false;
  }
  return is_color;
}

Imf::Header HeaderOf(const Image& image, const Metadata& metadata,
                     const std::vector<WrittenChannel>& channels, ExrCompression compression) {
  Imf::Header header(image.width, image.height);
  header.compression() = Imf::Compression(compression);
  for (const auto& [name, text] : metadata) {
    if (name.size() > 255) throw std::runtime_error("an attribute name of over 255 bytes");
    header.insert(name, Imf::StringAttribute(text));
  }
  for (const WrittenChannel& channel : channels) {
    header.channels().insert(channel.name, Imf::Channel(channel.half ? Imf::HALF : Imf::FLOAT));
  }
  return header;
}

// Returns the header of a file and a chunk table of zeros.
std::string StartOf(const std::string& path, const Imf::Header& header) {
  MemoryOutput stream(path);
  std::uint64_t size = 0;
  {
    const Imf::OutputFile file(stream, header, kNoThreads);
    size = stream.tellp();
  }
  return stream.bytes().substr(0, size);
}

// Returns the chunks of the rows [first, last) of a picture.
std::string ChunksOf(const std::string& path, Imf::Header header,
                     const std::vector<WrittenChannel>& channels, int first, int last) {
  Imath::Box2i& window = header.dataWindow();
  window.min.y = first, window.max.y = last - 1;
  const std::size_t width = std::size_t(window.max.x) + 1;
  const std::size_t before = std::size_t(first) * width, pixels = std::size_t(last - first) * width;
  std::vector<std::vector<half>> halves;
  Imf::FrameBuffer frame;
  for (const WrittenChannel& channel : channels) {
    const float* const values = channel.values + before * channel.stride;
    if (!channel.half) {
      // The library only reads through the slices of an output file, so the cast is safe.
      frame.insert(channel.name, Imf::Slice::Make(Imf::FLOAT, const_cast<float*>(values), window,
                                                  channel.stride * sizeof(float)));
      continue;
    }
    std::vector<half>& converted = halves.emplace_back(pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
      converted[i].setBits(HalfBits(values[i * channel.stride]));
    }
    frame.insert(channel.name, Imf::Slice::Make(Imf::HALF, converted.data(), window));
  }
  MemoryOutput stream(path);
  std::uint64_t begin = 0;
  {
    Imf::OutputFile file(stream, header, kNoThreads);
    begin = stream.tellp();
    file.setFrameBuffer(frame);
    file.writePixels(last - first);
  }
  return stream.bytes().substr(begin);
}

// Appends the offsets of the chunks of a strip that begins `before` bytes after the start of a
// file. A chunk is its first row and its size, 4 bytes each, and as many bytes.
void AppendOffsets(std::string_view strip, std::uint64_t before,
                   std::vector<std::uint64_t>& offsets) {
  for (std::size_t at = 0; at < strip.size();) {
    offsets.push_back(before + at);
    std::int32_t size = 0;
    std::memcpy(&size, &strip[at + 4], sizeof size);
    at += 8 + std::size_t(size);
  }
}

// Calls encode(i) for all i of [0, count) on several threads, and write(encode(i)) in their order.
// Only a few results are held at a time.
template <class Encode, class Write>
void EncodeInOrder(std::size_t count, int threads, const Encode& encode, const Write& write) {
  std::size_t next = 0;
  tbb::task_arena arena(threads);
  arena.execute([&] {
    tbb::parallel_pipeline(
        2 * std::size_t(threads),
        tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order,
                                            [&](tbb::flow_control& control) {
                                              if (next == count) control.stop();
                                              return next++;
                                            }) &
            tbb::make_filter<std::size_t, std::string>(tbb::filter_mode::parallel, encode) &
            tbb::make_filter<std::string, void>(tbb::filter_mode::serial_in_order, write));
  });
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
        parts_.emplace(stream_, kNoThreads);
        ChoosePart(limits, header);
      } else {
        file_.emplace(stream_, kNoThreads);
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

void WriteExr(const std::string& path, const Image& image, const Metadata& metadata,
              const std::vector<NamedChannel>& layers, const ExrFormat& format,
              const std::function<void()>& before_rename) {
  assert(image.rgb.size() == std::size_t(image.width) * image.height * 3);
  std::vector<WrittenChannel> channels;
  const char* const kNames[] = {"R", "G", "B"};
  for (std::size_t c = 0; c < 3; ++c) channels.push_back({kNames[c], &image.rgb[c], 3, false});
  for (const NamedChannel& channel : layers) {
    assert(channel.values.size() * 3 == image.rgb.size());
    channels.push_back({channel.name, channel.values.data(), 1, false});
  }
  for (WrittenChannel& channel : channels) channel.half = format.half && MayBeHalf(channel.name);

  // Files have channels in the order of their names.
  std::sort(channels.begin(), channels.end(),
            [](const WrittenChannel& a, const WrittenChannel& b) { return a.name < b.name; });

  // Chunks are compressed in strips. The library compresses each strip as a file of its own in
  // memory, because a single file would compress them one after the other unless the whole program
  // had threads of OpenEXR's.
  const int rows = int(std::max<std::int64_t>(RowsPerChunk(format.compression), 16));
  const auto strips = std::size_t((image.height + rows - 1) / rows);
  const auto failed = [&](const std::exception& error) {
    return InputError(InputPosition::File(path),
                      std::string("cannot be written as OpenEXR: ") + error.what(), kExitIo);
  };
  Imf::Header header;
  std::string start;
  try {
    header = HeaderOf(image, metadata, channels, format.compression);
    start = StartOf(path, header);
  } catch (const std::exception& error) {
    throw failed(error);
  }
  const auto encode = [&](std::size_t i) {
    const int y = int(i) * rows, end = std::min(y + rows, image.height);
    if (CanEncodeStrip(format.compression)) {
      return EncodeStrip(format.compression, channels, image.width, y, end);
    }
    try {
      return ChunksOf(path, header, channels, y, end);
    } catch (const std::exception& error) {
      throw failed(error);
    }
  };
  const auto write = [&](const PieceWriter& out) {
    std::vector<std::uint64_t> offsets;
    std::uint64_t before = start.size();
    EncodeInOrder(strips, ThreadsFor(format.threads), encode, [&](const std::string& strip) {
      AppendOffsets(strip, before, offsets);
      before += strip.size();
      out(strip);
    });
    static_assert(std::endian::native == std::endian::little);
    const std::size_t bytes = offsets.size() * sizeof(std::uint64_t);
    std::memcpy(&start[start.size() - bytes], offsets.data(), bytes);
    return start;
  };
  WriteFileStartLast(path, start.size(), write, before_rename);
}

Metadata ReadExrMetadata(const std::string& path, const ReadLimits& limits) {
  return ParseExrHeader(path, ReadFile(path), limits).strings;
}

}  // namespace skywave
