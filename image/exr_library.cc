#include "image/exr_library.h"

#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfRgbaFile.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <stdexcept>

#include "base/confined.h"
#include "base/error.h"
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

// Where the pixels go: three channels of colours, and planes of layers.
struct Planes {
  float* rgb;
  std::vector<float*> layers;
};

// `source` is a file or a part of one.
template <class Source>
void Read(Source& source, const ExrBox& box, const ExrRequest& request, const Planes& planes) {
  const Imath::Box2i window({box.x_min, box.y_min}, {box.x_max, box.y_max});
  if (source.header().dataWindow() != window) {
    throw std::runtime_error("two different data windows");
  }
  constexpr std::size_t kPixelStride = 3 * sizeof(float);
  Imf::FrameBuffer frame;
  for (std::size_t c = 0; c < request.names.size(); ++c) {
    frame.insert(request.names[c],
                 Imf::Slice::Make(Imf::FLOAT, planes.rgb + c, window, kPixelStride));
  }
  for (std::size_t i = 0; i < request.layers.size(); ++i) {
    frame.insert(request.layers[i], Imf::Slice::Make(Imf::FLOAT, planes.layers[i], window));
  }
  source.setFrameBuffer(frame);
  source.readPixels(window.min.y, window.max.y);
}

// The library interpolates chroma and makes colours of it.
void ReadChroma(MemoryInput& stream, const ExrBox& box, const Planes& planes) {
  Imf::RgbaInputFile file(stream, kNoExrThreads);
  const auto width = std::size_t(box.width());
  std::vector<Imf::Rgba> row(width);
  for (std::int32_t y = box.y_min; y <= box.y_max; ++y) {
    // The frame begins at the row, and at the column of the origin.
    file.setFrameBuffer(row.data() - box.x_min, 1, 0);
    file.readPixels(y);
    float* const to = planes.rgb + std::size_t(y - box.y_min) * width * 3;
    for (std::size_t x = 0; x < width; ++x) {
      to[3 * x] = row[x].r, to[3 * x + 1] = row[x].g, to[3 * x + 2] = row[x].b;
    }
  }
}

void Decode(const std::string& path, std::string_view bytes, const ExrHeader& header,
            const ExrRequest& request, const Planes& planes) {
  MemoryInput stream(path, bytes);
  if (request.interpolate_chroma) return ReadChroma(stream, header.data_window, planes);
  if (header.multi_part) {
    Imf::MultiPartInputFile file(stream, kNoExrThreads);
    Imf::InputPart part(file, header.part);
    Read(part, header.data_window, request, planes);
  } else {
    Imf::InputFile file(stream, kNoExrThreads);
    Read(file, header.data_window, request, planes);
  }
}

void Allocate(const ExrHeader& header, const ExrRequest& request, LayeredImage& picture) {
  picture.image = Image(int(header.data_window.width()), int(header.data_window.height()));
  for (const std::string& name : request.layers) {
    picture.layers.push_back({.name = name, .values = {}});
    ResizeLarge(picture.layers.back().values, picture.image.rgb.size() / 3);
  }
}

// The library's own needs, and a second copy of all pixels of the file.
ConfinedLimits LimitsOf(const ExrHeader& header, std::size_t pixels) {
  constexpr std::size_t kOwn = std::size_t{1} << 30;
  return {.memory_bytes = kOwn + 4 * pixels * std::size_t(header.pixel_bytes()),
          .seconds = 20 + int(pixels * header.channels.size() / 2'000'000)};
}

// Decodes in a process of its own. What the pixels take is had from the system as they are written,
// so a file that claims too many does no harm.
void DecodeConfined(const std::string& path, std::string_view bytes, const ExrHeader& header,
                    const ExrRequest& request, LayeredImage& picture) {
  const auto width = int(header.data_window.width()), height = int(header.data_window.height());
  const std::size_t pixels = std::size_t(width) * std::size_t(height);
  const std::size_t layers = request.layers.size();
  const SharedMemory shared((3 + layers) * pixels * sizeof(float));
  auto* const values = reinterpret_cast<float*>(shared.data());
  Planes planes = {.rgb = values, .layers = {}};
  for (std::size_t i = 0; i < layers; ++i) planes.layers.push_back(values + (3 + i) * pixels);
  RunConfined(LimitsOf(header, pixels), [&] { Decode(path, bytes, header, request, planes); });
  Allocate(header, request, picture);
  std::copy_n(planes.rgb, 3 * pixels, picture.image.rgb.begin());
  for (std::size_t i = 0; i < layers; ++i) {
    std::copy_n(planes.layers[i], pixels, picture.layers[i].values.begin());
  }
}

void DecodeHere(const std::string& path, std::string_view bytes, const ExrHeader& header,
                const ExrRequest& request, LayeredImage& picture) {
  Allocate(header, request, picture);
  Planes planes = {.rgb = picture.image.rgb.data(), .layers = {}};
  for (NamedChannel& layer : picture.layers) planes.layers.push_back(layer.values.data());
  Decode(path, bytes, header, request, planes);
}

}  // namespace

LayeredImage DecodeByLibrary(const std::string& path, std::string_view bytes,
                             const ReadLimits& limits, const ExrHeader& header,
                             const ExrRequest& request) {
  LayeredImage picture;
  const auto decode = header.risky() && !limits.trust_input ? DecodeConfined : DecodeHere;
  try {
    decode(path, bytes, header, request, picture);
  } catch (const CannotConfine& error) {
    throw InputError(InputPosition::File(path),
                     fmt::format("such files of OpenEXR need a process of their own, and {}; "
                                 "--trust-input decodes them without",
                                 error.what()));
  } catch (const std::exception& error) {
    throw InputError(InputPosition::File(path),
                     fmt::format("cannot be decoded as OpenEXR: {}", error.what()));
  }
  if (request.names.size() == 1) SpreadGrey(picture.image);
  return picture;
}

}  // namespace skywave
