// An RGB picture in memory, and the files it comes from and goes to.
//
// Pixels are linear RGB (Rec. 709 primaries) [radiance, relative unless a scene says otherwise],
// three floats a pixel, rows from the top, no padding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace skywave {

struct Image {
  int width = 0;
  int height = 0;
  std::vector<float> rgb;  // width * height * 3

  Image() = default;
  Image(int w, int h) : width(w), height(h), rgb(std::size_t(w) * h * 3) {}
  float* Pixel(int x, int y) { return &rgb[(std::size_t(y) * width + x) * 3]; }
  const float* Pixel(int x, int y) const { return &rgb[(std::size_t(y) * width + x) * 3]; }
};

// What a reader accepts. Sizes are checked against the header, before anything is decoded.
struct ReadLimits {
  int max_width = 32768;
  int max_height = 32768;
  std::size_t max_pixels = std::size_t{1} << 28;
  // Also decode what Debian's OpenEXR 3.1.5 has known holes in (deep, multi-part, DWA, B44, PXR24).
  bool trust_input = false;
};

// Reads OpenEXR, Radiance RGBE or PFM, told apart by their first bytes, never by name. Grey images
// become three equal channels; alpha and other layers are left out. Values are as stored: NaN, Inf
// and negative ones included (see RepairRadiance), the exposure of RGBE and the scale of PFM not
// applied. Of an EXR the data window is read. Throws InputError with the byte offset; a file that
// is cut short or contradicts itself never gives a picture.
Image ReadImage(const std::string& path, const ReadLimits& limits = {});

// What the numbers of a PNG or JPEG stand for: sRGB colours, or numbers in [0, 1] as they are. Or,
// of a PNG, its alpha channel alone in place of all three: 1 if it has none.
enum class Encoding { kSrgb, kLinear, kAlpha };
// Reads a picture that is used as a texture: PNG (8 bits a channel, deeper ones are rounded), JPEG
// (baseline and progressive), or one of the formats of ReadImage. An alpha channel is left out,
// but for kAlpha; alpha of other files than PNG counts as 1. Errors as for ReadImage.
Image ReadTexture(const std::string& path, Encoding encoding, const ReadLimits& limits = {});
// The same from memory; `name` is for messages.
Image DecodeTexture(const std::string& name, std::string_view bytes, Encoding encoding,
                    const ReadLimits& limits = {});

// Name and text of header attributes, in file order (which is that of the names, once OpenEXR has
// written them).
using Metadata = std::vector<std::pair<std::string, std::string>>;

// A channel of an EXR beside R, G and B, "layer.letter": as many values as the picture has pixels.
struct NamedChannel {
  std::string name;
  std::vector<float> values;
};
// Scan-line EXR, 32-bit float R, G, B and `layers`, ZIP. Identical input gives identical bytes.
void WriteExr(const std::string& path, const Image& image, const Metadata& metadata = {},
              const std::vector<NamedChannel>& layers = {});
// The string attributes of an EXR header.
Metadata ReadExrMetadata(const std::string& path, const ReadLimits& limits = {});
// Little-endian colour PFM (bit-exact) and run-length coded Radiance RGBE (nearest; negative values
// and NaN become 0, infinity the largest value).
void WritePfm(const std::string& path, const Image& image);
void WriteRgbe(const std::string& path, const Image& image);
// By the ending of `path`: .exr, .pfm or .hdr; the last two have no place for metadata. Throws
// InputError (kExitUsage) for other endings.
void WriteImage(const std::string& path, const Image& image, const Metadata& metadata = {});

// From scene-linear radiance to 8-bit sRGB.
enum class ToneCurve { kClip, kFilmic };  // kFilmic: ACES-like fit of Narkowicz 2015
struct ToneMapping {
  float exposure_stops = 0;  // radiance is multiplied by 2^exposure_stops
  ToneCurve curve = ToneCurve::kClip;
};
// A camera whose exposure decides what becomes white.
struct PhotographicExposure {
  float iso = 100;
  float shutter_seconds = 0;
  float f_number = 0;
};
// log2(N^2 / t * 100 / ISO).
float ExposureValue100(const PhotographicExposure& camera);
// Stops that bring the luminance that saturates the sensor to 1, if radiance is luminance [cd/m^2].
// The sensor gets H = q L t / N^2 [lux s] with q = 0.65, a usual lens, and is saturated by
// 78 / ISO (ISO 12232, saturation-based speed), so by L = 1.2 * 2^EV100 (Lagarde and de Rousiers
// 2014, "Moving Frostbite to Physically Based Rendering", Section 5.1).
float ExposureStops(const PhotographicExposure& camera);
// width * height * 3 bytes, rows from the top, rounded to the nearest; NaN is black.
std::vector<std::uint8_t> ToneMap(const Image& image, const ToneMapping& mapping);
// 8-bit RGB PNG, its bytes or a file of them. Identical input gives identical bytes.
std::string EncodePng(int width, int height, const std::vector<std::uint8_t>& rgb);
void WritePng(const std::string& path, int width, int height, const std::vector<std::uint8_t>& rgb);

// Pixels that are no radiance, by kind.
struct BadPixels {
  std::size_t nan = 0, infinite = 0, negative = 0;
  std::size_t total() const { return nan + infinite + negative; }
};
// Sets every NaN, infinite and negative channel to 0 and counts the pixels by their worst channel.
BadPixels RepairRadiance(Image& image);

// Rec. 709 luminance with the weights of the Debevec family, as the thesis uses them (T 5.2.2).
inline float Luminance(const float* rgb) {
  return 0.2125f * rgb[0] + 0.7154f * rgb[1] + 0.0721f * rgb[2];
}

}  // namespace skywave
