// Writes OpenEXR pictures with the OpenEXR library, strip by strip.

#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <half.h>
#include <tbb/parallel_pipeline.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>
#include <exception>
#include <stdexcept>

#include "base/arena.h"
#include "base/error.h"
#include "base/files.h"
#include "base/granted.h"
#include "image/exr_header.h"
#include "image/exr_strip.h"
#include "image/image.h"
#include "image/primaries.h"

namespace skywave {
namespace {

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

// The precision of 16 bits is enough for colours, but perhaps not for quantities in other units,
// not for what is subtracted from a colour, and not for the numbers of Cryptomatte.
bool MayBeHalf(const std::string& name) {
  const std::size_t dot = name.rfind('.');
  const std::string letter = dot == std::string::npos ? name : name.substr(dot + 1);
  const bool is_color = letter == "R" || letter == "G" || letter == "B" || name == "A";
  for (const std::string_view exact : {"variance.", "half.", "half-variance.", "crypto_"}) {
    if (name.starts_with(exact)) return false;
  }
  return is_color;
}

Imf::Header HeaderOf(const Image& image, const Metadata& metadata,
                     const std::vector<WrittenChannel>& channels, const ExrFormat& format) {
  const Placement& place = format.placement;
  const Imath::Box2i data({place.x, place.y},
                          {place.x + image.width - 1, place.y + image.height - 1});
  Imf::Header header(image.width, image.height);
  if (place.width > 0) {
    header = Imf::Header(Imath::Box2i({0, 0}, {place.width - 1, place.height - 1}), data);
  }
  header.compression() = Imf::Compression(format.compression);
  for (const auto& [name, text] : metadata) {
    if (name.size() > 255) throw std::runtime_error("an attribute name of over 255 bytes");
    header.insert(name, Imf::StringAttribute(text));
  }
  const RgbPrimaries& primaries = PrimariesOf(format.space);
  const auto place_of = [](const glm::dvec2& c) { return Imath::V2f(float(c.x), float(c.y)); };
  Imf::addChromaticities(header,
                         Imf::Chromaticities(place_of(primaries.red), place_of(primaries.green),
                                             place_of(primaries.blue), place_of(primaries.white)));
  header.insert("colorInteropID", Imf::StringAttribute(std::string(InteropId(format.space))));
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
    const Imf::OutputFile file(stream, header, kNoExrThreads);
    size = stream.tellp();
  }
  return stream.bytes().substr(0, size);
}

// Returns the chunks of the rows [first, last) of a picture.
std::string ChunksOf(const std::string& path, Imf::Header header,
                     const std::vector<WrittenChannel>& channels, int first, int last) {
  Imath::Box2i& window = header.dataWindow();
  const int top = window.min.y;
  window.min.y = top + first, window.max.y = top + last - 1;
  const std::size_t width = std::size_t(window.max.x - window.min.x) + 1;
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
    Imf::OutputFile file(stream, header, kNoExrThreads);
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
  ArenaOf(threads).execute([&] {
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

}  // namespace

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
    header = HeaderOf(image, metadata, channels, format);
    start = StartOf(path, header);
  } catch (const std::exception& error) {
    throw failed(error);
  }
  const auto encode = [&](std::size_t i) {
    const int y = int(i) * rows, end = std::min(y + rows, image.height);
    if (CanEncodeStrip(format.compression)) {
      return EncodeStrip(format.compression, channels, image.width, y, end, format.placement.y);
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

}  // namespace skywave
