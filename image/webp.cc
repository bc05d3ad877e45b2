#include <webp/decode.h>

#include <cstdint>
#include <vector>

#include "image/formats.h"

namespace skywave {

CompactImage DecodeWebp(const std::string& path, std::string_view bytes, Encoding encoding,
                        const ReadLimits& limits) {
  const auto* const data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  WebPBitstreamFeatures features = {};
  if (WebPGetFeatures(data, bytes.size(), &features) != VP8_STATUS_OK) {
    throw InputError(InputPosition::Byte(path, 0), "is WebP with a header that makes no sense");
  }
  CheckSize(InputPosition::File(path), features.width, features.height, limits);
  if (features.has_animation != 0) {
    throw InputError(InputPosition::File(path), "is an animated WebP, which is not supported");
  }
  const int stride = 4 * features.width;
  std::vector<std::uint8_t> rgba(std::size_t(stride) * std::size_t(features.height));
  if (WebPDecodeRGBAInto(data, bytes.size(), rgba.data(), rgba.size(), stride) == nullptr) {
    throw InputError(InputPosition::Byte(path, bytes.size()),
                     "is WebP that is broken or truncated");
  }
  return FromRgba(features.width, features.height, rgba.data(), encoding);
}

}  // namespace skywave
