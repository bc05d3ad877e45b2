// An RGB picture in memory, and functions that read and write it.
//
// Pixels are linear RGB (Rec. 709 primaries) [radiance, relative unless a scene defines units],
// three floats per pixel, rows from the top, no padding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/large_memory.h"
#include "base/names.h"
#include "image/rgb_space.h"

namespace skywave {

struct Image {
  int width = 0;
  int height = 0;
  std::vector<float> rgb;  // width * height * 3

  Image() = default;
  Image(int w, int h) : width(w), height(h) { ResizeLarge(rgb, std::size_t(w) * h * 3); }
  float* Pixel(int x, int y) { return &rgb[(std::size_t(y) * width + x) * 3]; }
  const float* Pixel(int x, int y) const { return &rgb[(std::size_t(y) * width + x) * 3]; }
};

// Limits of the readers. Sizes are checked against the header before anything is decoded.
struct ReadLimits {
  int max_width = 32768;
  int max_height = 32768;
  std::size_t max_pixels = std::size_t{1} << 28;
  // Kinds of EXR in which Debian's OpenEXR 3.1.5 has known vulnerabilities (deep, multi-part, DWA,
  // B44, PXR24) are decoded in this process, and not in a confined one of their own.
  bool trust_input = false;
};

// All functions that read pictures take names "FILE:LAYER" (SplitFileName) for OpenEXR; a layer is
// also a part of that name.

// Reads OpenEXR, Radiance RGBE or PFM, recognised by their first bytes, never by name. Grey images
// become three equal channels; alpha and other layers are left out. Colours of other primaries,
// which a header gives, become those of Rec. 709; what a header of RGBE says the radiance was
// multiplied by is divided by, and the scale of PFM is a factor. Otherwise values are unchanged,
// including NaN, Inf and negative ones (see RepairRadiance). The picture of an EXR is that of its
// display window, black where there are no data. Throws InputError with the byte offset; a
// truncated or inconsistent file never gives a picture.
Image ReadImage(const std::string& path, const ReadLimits& limits = {});

// Returns whether a file holds 8-bit colours of a screen (PNG, JPEG, BMP, GIF, QOI or WebP by its
// first bytes, TGA by its name). Throws InputError if it cannot be read.
bool IsOfScreen(const std::string& path);
// Returns whether a PNG, QOI or OpenEXR file has channels from red to alpha. A palette or grey with
// alpha does not count. Errors are those of ReadImage.
bool IsRgba(const std::string& path, const ReadLimits& limits = {});
// Returns whether a file begins like PNG, JPEG or WebP.
bool IsGltfImage(std::string_view bytes);

// Interprets the numbers of a file of 8 bits as sRGB colours or as unconverted numbers in [0, 1].
// kAlpha replaces all three channels with the alpha channel, or 1 if there is none.
enum class Encoding { kSrgb, kLinear, kAlpha };
// Reads a picture for use as a texture: PNG (of 16 bits per channel at most), JPEG
// (baseline and progressive), WebP, TGA (the name ends in .tga), BMP, GIF (its
// first picture), or one of the formats of ReadImage. An alpha channel is left out, except for
// kAlpha; JPEG, Radiance RGBE and PFM have alpha 1. Errors are those of ReadImage.
Image ReadTexture(const std::string& path, Encoding encoding, const ReadLimits& limits = {});
// The same from memory; `name` appears in messages, and may end in .tga.
Image DecodeTexture(const std::string& name, std::string_view bytes, Encoding encoding,
                    const ReadLimits& limits = {});

// Names and texts of header attributes, in file order (OpenEXR writes them sorted by name).
using Metadata = std::vector<std::pair<std::string, std::string>>;

// Where a picture lies within a larger one, of which it is a part.
struct Placement {
  int x = 0, y = 0;           // its top left corner [pixels]
  int width = 0, height = 0;  // of the larger one; 0: it is a picture of its own
};

// An extra EXR channel next to R, G and B, "layer.letter", with one value per pixel.
struct NamedChannel {
  std::string name;
  std::vector<float> values;
};
// Returns the colours of an image as channels NAME.R, NAME.G and NAME.B; none of an empty one.
std::vector<NamedChannel> AsLayer(std::string_view name, const Image& image);

// The values are those in a file. PXR24, B44 and DWA lose digits. The names are those of what can
// be written; B44 would leave floats uncompressed.
enum class ExrCompression : std::uint8_t {
  kNone,
  kRle,
  kZips,
  kZip,
  kPiz,
  kPxr24,
  kB44,
  kB44a,
  kDwaa,
  kDwab
};
template <>
inline constexpr auto kEnumNames<ExrCompression> =
    std::to_array<Named<ExrCompression>>({{ExrCompression::kZip, "zip"},
                                          {ExrCompression::kZips, "zips"},
                                          {ExrCompression::kRle, "rle"},
                                          {ExrCompression::kPiz, "piz"},
                                          {ExrCompression::kPxr24, "pxr24"},
                                          {ExrCompression::kDwaa, "dwaa"},
                                          {ExrCompression::kDwab, "dwab"},
                                          {ExrCompression::kNone, "none"}});
// How colours go with alpha.
enum class AlphaForm : std::uint8_t { kPremultiplied, kStraight };
template <>
inline constexpr auto kEnumNames<AlphaForm> = std::to_array<Named<AlphaForm>>(
    {{AlphaForm::kPremultiplied, "premultiplied"}, {AlphaForm::kStraight, "straight"}});
struct ExrFormat {
  ExrCompression compression = ExrCompression::kZip;
  AlphaForm alpha = AlphaForm::kPremultiplied;
  // Colours (R, G, B, alone or of a layer) become 16-bit floats, rounded to nearest; finite values
  // beyond 65504 become 65504. The layer "variance" and what is no colour keep 32 bits.
  bool half = false;
  int threads = 0;  // 0: as many as the process may use
  // The larger picture is the display window, and the part that is written the data window.
  Placement placement = {};
  RgbSpace space = RgbSpace::kRec709;  // that of the colours, which the header says
};
// Writes a scan-line EXR with R, G, B and `layers`, all of them 32-bit floats unless `format` says
// otherwise. Identical input gives identical bytes for any number of threads. `before_rename`: as
// in WriteFileAtomically.
void WriteExr(const std::string& path, const Image& image, const Metadata& metadata = {},
              const std::vector<NamedChannel>& layers = {}, const ExrFormat& format = {},
              const std::function<void()>& before_rename = {});
// A picture with channels next to it.
struct LayeredImage {
  Image image;
  std::vector<NamedChannel> layers = {};
  Metadata attributes = {};  // what the header has to say of the layers
  Placement placement = {};
  RgbSpace space = RgbSpace::kRec709;  // of picture and layers, see ReadOwnColors
};
// Reads a picture as ReadImage does, and the channels `layers` next to it ("variance.R"), each of
// them named once, in the order of `layers`. Throws InputError also for a channel that the file
// does not have, with its name and those of the channels that are there.
LayeredImage ReadLayeredImage(const std::string& path, const std::vector<std::string>& layers,
                              const ReadLimits& limits = {});
// The same of the data window alone: its placement says where it lies, and nothing around it is
// made up.
LayeredImage ReadDataWindow(const std::string& path, const std::vector<std::string>& layers = {},
                            const ReadLimits& limits = {});
// The same without conversion of colours that are in an RgbSpace: they go with the layers, of which
// nothing knows whether they are colours.
LayeredImage ReadOwnColors(const std::string& path, const std::vector<std::string>& layers = {},
                           const ReadLimits& limits = {});
// Returns the names of the channels next to the picture in the order of the file, which are none
// unless it is an EXR.
std::vector<std::string> ReadLayerNames(const std::string& path, const ReadLimits& limits = {});
// Returns the string attributes of an EXR header.
Metadata ReadExrMetadata(const std::string& path, const ReadLimits& limits = {});
// Write little-endian colour PFM (bit-exact) and run-length coded Radiance RGBE (rounded to
// nearest; negative values and NaN become 0, infinity the largest value).
void WritePfm(const std::string& path, const Image& image);
void WriteRgbe(const std::string& path, const Image& image);
// Chooses the format by the extension of `path`: .exr, .pfm or .hdr; the last two cannot hold
// metadata. Throws InputError (kExitUsage) for other extensions.
void WriteImage(const std::string& path, const Image& image, const Metadata& metadata = {});

// The curve from scene-linear radiance to 8-bit sRGB.
enum class ToneCurve {
  kClip,
  kFilmic,    // a fit to ACES, channel by channel (Narkowicz 2015)
  kAces,      // a fit to ACES with its matrices, which fades bright colours to white (Hill 2016)
  kReinhard,  // of luminance; 4 becomes white (Reinhard et al. 2002, Equation 4)
  kAgx,       // of stops, in the primaries of Rec. 2020, as Blender has it (Wrensch 2023)
  kNeutral,   // keeps colours up to white paper (Khronos PBR Neutral 2024)
  kContrast   // steep about middle grey, so that noise is seen (after Naka and Rushton 1966)
};
template <>
inline constexpr auto kEnumNames<ToneCurve> =
    std::to_array<Named<ToneCurve>>({{ToneCurve::kClip, "clip"},
                                     {ToneCurve::kFilmic, "filmic"},
                                     {ToneCurve::kAces, "aces"},
                                     {ToneCurve::kReinhard, "reinhard"},
                                     {ToneCurve::kAgx, "agx"},
                                     {ToneCurve::kNeutral, "neutral"},
                                     {ToneCurve::kContrast, "contrast"}});
struct ToneMapping {
  float exposure_stops = 0;  // radiance is multiplied by 2^exposure_stops
  ToneCurve curve = ToneCurve::kClip;
};
// A camera whose exposure determines the white level.
struct PhotographicExposure {
  float iso = 100;
  float shutter_seconds = 0;
  float f_number = 0;
};
// Returns log2(N^2 / t * 100 / ISO).
float ExposureValue100(const PhotographicExposure& camera);
// Returns the stops that map the sensor's saturation luminance to 1, if radiance is luminance
// [cd/m^2]. The sensor receives H = q L t / N^2 [lux s] with q = 0.65, a typical lens, and
// saturates at 78 / ISO (ISO 12232, saturation-based speed), hence at L = 1.2 * 2^EV100 (Lagarde
// and de Rousiers 2014, "Moving Frostbite to Physically Based Rendering", Section 5.1).
float ExposureStops(const PhotographicExposure& camera);
// Returns the stops by which a picture of unknown scale is shown: the median luminance of the
// pixels of which objects cover half (`coverage`, a share for each pixel) becomes 0.18, the grey
// that light meters are made for; of all pixels if none is covered or nothing is known. Where that
// lifts more than a twentieth of the picture above 0.9, it is darker, by two stops at most. Pixels
// that are black, NaN or infinite do not count, and a black picture has 0. The result is a multiple
// of 1/16 in [-100, 100], so it can be written down and given again.
float AutomaticExposureStops(const Image& image, std::span<const float> coverage = {});
// Returns width * height * 3 bytes, rows from the top, rounded to nearest; NaN is black.
std::vector<std::uint8_t> ToneMap(const Image& image, const ToneMapping& mapping);
// Returns shares in [0, 1] as bytes, rounded to nearest; NaN is 0.
std::vector<std::uint8_t> ToBytes(std::span<const float> shares);
// Encode or write an 8-bit PNG of RGB, or of RGBA where there is alpha. Identical input gives
// identical bytes.
std::string EncodePng(int width, int height, const std::vector<std::uint8_t>& rgb,
                      const std::vector<std::uint8_t>& alpha = {});
void WritePng(const std::string& path, int width, int height, const std::vector<std::uint8_t>& rgb);

// Counts of pixels with invalid radiance, by kind.
struct BadPixels {
  std::size_t nan = 0, infinite = 0, negative = 0;
  std::size_t total() const { return nan + infinite + negative; }
};
// Sets every NaN and negative channel to 0, an infinite one to the largest finite one of the
// picture or to 65504, the largest of 16 bits, if that is more: where light is brighter than a file
// can hold, it is the sun. Counts the pixels by their worst channel.
BadPixels RepairRadiance(Image& image);
// Says how many pixels of each kind there were, and what became of them.
std::string Describe(const BadPixels& bad);

// Returns the Rec. 709 luminance with the weights of the Debevec family, as the thesis uses them (T
// 5.2.2).
inline float Luminance(const float* rgb) {
  return 0.2125f * rgb[0] + 0.7154f * rgb[1] + 0.0721f * rgb[2];
}

}  // namespace skywave
