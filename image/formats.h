// Declares the decoders behind ReadImage, one per file format, and their shared helpers. For image/
// only. formats.cc also chooses among them.
//
// Each decoder takes the bytes of the whole file; `path` appears only in errors. Each throws
// InputError with the byte offset, checks the size with CheckSize before it allocates, and returns
// complete images only.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "image/compact_image.h"
#include "image/image.h"

namespace skywave {

// `layers` are the channels to read next to the picture, which is the layer or the part `layer`, or
// what the file shows if that is empty.
LayeredImage DecodeExr(const std::string& path, std::string_view bytes, const ReadLimits& limits,
                       const std::vector<std::string>& layers = {}, const std::string& layer = "");
// The same of the data window alone.
LayeredImage DecodeExrPart(const std::string& path, std::string_view bytes,
                           const ReadLimits& limits, const std::vector<std::string>& layers = {},
                           const std::string& layer = "");
// The same, where colours in an RgbSpace stay in it.
LayeredImage DecodeExrColors(const std::string& path, std::string_view bytes,
                             const ReadLimits& limits, const std::vector<std::string>& layers = {},
                             const std::string& layer = "");
// Returns the channels next to the picture, without decoding anything.
std::vector<std::string> ExrLayerNames(const std::string& path, std::string_view bytes,
                                       const ReadLimits& limits, const std::string& layer = "");
Image DecodeRgbe(const std::string& path, std::string_view bytes, const ReadLimits& limits);
Image DecodePfm(const std::string& path, std::string_view bytes, const ReadLimits& limits);
// 8-bit formats give linear light, or unconverted numbers in [0, 1].
CompactImage DecodePng(const std::string& path, std::string_view bytes, Encoding encoding,
                       const ReadLimits& limits);
CompactImage DecodeJpeg(const std::string& path, std::string_view bytes, Encoding encoding,
                        const ReadLimits& limits);
CompactImage DecodeTga(const std::string& path, std::string_view bytes, Encoding encoding,
                       const ReadLimits& limits);
CompactImage DecodeBmp(const std::string& path, std::string_view bytes, Encoding encoding,
                       const ReadLimits& limits);
CompactImage DecodeQoi(const std::string& path, std::string_view bytes, Encoding encoding,
                       const ReadLimits& limits);
CompactImage DecodeWebp(const std::string& path, std::string_view bytes, Encoding encoding,
                        const ReadLimits& limits);
// Gives the first picture of an animation.
CompactImage DecodeGif(const std::string& path, std::string_view bytes, Encoding encoding,
                       const ReadLimits& limits);

// `rgba` holds four bytes per pixel, rows from the top, of which the colour is taken or, for
// kAlpha, the last one.
CompactImage FromRgba(int width, int height, const std::uint8_t* rgba, Encoding encoding);

// The same from four numbers of 16 bits per pixel.
Image FromDeepRgba(int width, int height, const std::vector<std::uint16_t>& rgba,
                   Encoding encoding);

// Copies the red channel to the two others.
void SpreadGrey(Image& image);

// Returns the value of the decimal digits `text`, at most nine digits, or -1 for anything else,
// including signs, blanks and empty text.
std::int64_t ParseSize(std::string_view text);

// Throws InputError unless 1 <= width, height and all of `limits` hold.
void CheckSize(const InputPosition& position, std::int64_t width, std::int64_t height,
               const ReadLimits& limits);

}  // namespace skywave
