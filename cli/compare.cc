// Implements skywave compare: the difference between two pictures.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.h"
#include "base/files.h"
#include "base/json.h"
#include "bench/measure/json_reports.h"
#include "bench/measure/picture_noise.h"
#include "cli/commands.h"
#include "cli/print.h"
#include "image/compare.h"
#include "image/flip.h"
#include "image/placement.h"

namespace skywave {

enum class MapMeasure { kRelative, kLog, kFlip };
template <>
inline constexpr auto kEnumNames<MapMeasure> = std::to_array<Named<MapMeasure>>(
    {{MapMeasure::kRelative, "relative"}, {MapMeasure::kLog, "log"}, {MapMeasure::kFlip, "flip"}});

namespace {

struct CompareFlags {
  std::string image, reference, map, json;
  MapMeasure measure = MapMeasure::kRelative;
  double full_scale = 1;
  double pixels_per_degree = kFlipPixelsPerDegree;
  ReadLimits limits;
};

struct ComparedPicture {
  LayeredImage picture;        // the layers say how noisy it is; none: it is taken to be exact
  bool of_screen = false;      // 8 bits per channel
  bool denoised = false;       // its noise is the layer error
  bool lacks_samples = false;  // it has the layer variance, but not the layer samples

  std::optional<PictureNoise> noise() const {
    if (picture.layers.empty()) return std::nullopt;
    return denoised ? NoiseOfErrors(picture.layers) : NoiseOf(picture.layers);
  }
};

ComparedPicture ReadCompared(const std::string& path, const ReadLimits& limits) {
  if (IsOfScreen(path)) {
    return {.picture = {ReadTexture(path, Encoding::kSrgb, limits)}, .of_screen = true};
  }
  // What the file says of noise is about its picture.
  if (!SplitFileName(path).layer.empty()) return {.picture = ReadDataWindow(path, {}, limits)};
  const std::vector<std::string> there = ReadLayerNames(path, limits);
  const auto has = [&](const std::vector<std::string>& wanted) {
    return std::all_of(wanted.begin(), wanted.end(), [&](const std::string& name) {
      return std::find(there.begin(), there.end(), name) != there.end();
    });
  };
  // The layer variance of a picture that was denoised is that of the noisy one.
  if (has(ErrorChannels())) {
    return {.picture = ReadDataWindow(path, ErrorChannels(), limits), .denoised = true};
  }
  if (has(NoiseChannels())) return {.picture = ReadDataWindow(path, NoiseChannels(), limits)};
  return {.picture = ReadDataWindow(path, {}, limits),
          .lacks_samples = has({NoiseChannels().front()})};
}

// Cuts two pictures to the pixels that both show; returns these, counted in the whole picture. A
// picture that does not say where it lies, as large as a part that does, is of the same pixels:
// such are the PNGs of crops.
PixelBox CutToCommonPixels(const CompareFlags& flags, LayeredImage& image,
                           LayeredImage& reference) {
  const auto take_place = [](LayeredImage& to, const LayeredImage& from) {
    const bool fits = to.image.width == from.image.width && to.image.height == from.image.height;
    if (to.placement.width == 0 && WholeOf(to) != WholeOf(from) && fits) {
      to.placement = from.placement;
    }
  };
  take_place(image, reference);
  take_place(reference, image);
  const PixelBox whole = WholeOf(reference);
  if (WholeOf(image) != whole) {
    throw InputError(
        InputPosition::File("compare"),
        fmt::format("the pictures have different sizes, {} x {} and {} x {}", WholeOf(image).width,
                    WholeOf(image).height, whole.width, whole.height));
  }
  const PixelBox both = Common(Common(PartOf(image), PartOf(reference)), whole);
  if (both.empty()) {
    throw InputError(InputPosition::File(flags.image),
                     fmt::format("shows other pixels of the picture than {}, none of which can be "
                                 "compared",
                                 flags.reference));
  }
  CutTo(both, image);
  CutTo(both, reference);
  return both;
}

void PrintNoise(const NoiseComparison& c, const ComparedPicture& image,
                const ComparedPicture& reference) {
  const bool has_noise = image.noise().has_value();
  Print(stdout, "noise by the layer variance, or error where it was denoised, of {}\n",
        has_noise && reference.noise() ? "both pictures"
        : has_noise                    ? "the image; the reference is taken to be exact"
                                       : "the reference; the image is taken to be exact");
  const char* const kNames[] = {"red", "green", "blue"};
  for (int i = 0; i < 3; ++i) {
    Print(stdout, "  {:<16}{:.4g}", fmt::format("mean {}", kNames[i]), c.mean_difference[i]);
    // Where a denoiser has averaged neighbours, their errors are correlated by an unknown amount.
    if (!image.denoised && !reference.denoised) Print(stdout, " +- {:.2g}", c.half_width[i]);
    Print(stdout, "\n");
  }
  Print(stdout, "  {:<16}{:.2f} % of {} values; at most 5 % if noise is all\n", "outside of 95 %",
        100 * c.exceeding, c.values);
  Print(stdout, "  {:<16}{:.4g}; at most 1 if noise is all\n", "mean z^2", c.mean_squared_z);
  Print(stdout, "  {:<16}{} values, of which {} differ\n", "no variance", c.exact_values,
        c.exact_that_differ);
}

int CompareMain(const CompareFlags& flags) {
  CheckOutputs(std::array{flags.map, flags.json}, std::array{flags.image, flags.reference});
  ComparedPicture a = ReadCompared(flags.image, flags.limits),
                  b = ReadCompared(flags.reference, flags.limits);
  const PixelBox compared = CutToCommonPixels(flags, a.picture, b.picture);
  const PixelBox whole = WholeOf(b.picture);
  const Image &image = a.picture.image, &reference = b.picture.image;
  const ImageDifference d = Compare(image, reference);
  const Flip flip =
      (a.of_screen || b.of_screen ? LdrFlip : HdrFlip)(image, reference, flags.pixels_per_degree);
  nlohmann::ordered_json json = Json(d, flip);
  for (const auto& [name, value] : json.items()) {
    if (value.is_number_float()) Print(stdout, "{:<20}{:.8g}\n", name, value.get<double>());
  }
  json["max_at"] = {compared.x + d.max_x, compared.y + d.max_y};
  Print(stdout, "{:<20}{}, {}\n", "max_at", compared.x + d.max_x, compared.y + d.max_y);
  Print(stdout, "{:<20}{} of {}\n", "different_pixels", d.different_pixels,
        std::size_t(image.width) * image.height);
  if (compared != whole) {
    json["window"] = {compared.x, compared.y, compared.width, compared.height};
    Print(stdout, "{:<20}{}x{}+{}+{}: the pixels that both pictures have\n", "window",
          compared.width, compared.height, compared.x, compared.y);
  }
  if (a.noise() || b.noise()) {
    const NoiseComparison noise = CompareNoise(image, a.noise(), reference, b.noise());
    json["noise"] = Json(noise);
    json["noise"]["of_image"] = a.noise().has_value();
    json["noise"]["of_reference"] = b.noise().has_value();
    PrintNoise(noise, a, b);
  }
  for (const auto& [picture, path] : {std::pair(&a, flags.image), std::pair(&b, flags.reference)}) {
    if (picture->lacks_samples) {
      Print(stdout, "{} has the layer variance, but not the layer samples, so it counts as exact\n",
            path);
    }
  }
  if (!flags.map.empty()) {
    WritePng(flags.map, image.width, image.height,
             flags.measure == MapMeasure::kFlip  ? FalseColors(flip.map, flags.full_scale)
             : flags.measure == MapMeasure::kLog ? LogErrorMap(image, reference, flags.full_scale)
                                                 : ErrorMap(image, reference, flags.full_scale));
    Print(stdout, "wrote {}\n", flags.map);
  }
  if (!flags.json.empty()) WriteFileAtomically(flags.json, JsonText(json, 2) + "\n");
  return 0;
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<CompareFlags>> Options() {
  constexpr OptionMaker<CompareFlags> option = {};
  // clang-format off
  return {
    option({.name = "image", .help = "EXR, HDR, PFM, PNG, JPEG, TGA, BMP, GIF, QOI or WebP", .scope = OptionScope::kInput, .positional = true, .required = true}, FIELD(image), Texts("IMAGE")),
    option({.name = "reference", .help = "picture of the same size, or another part of it", .scope = OptionScope::kInput, .positional = true, .required = true}, FIELD(reference), Texts("REFERENCE")),
    option({.name = "map", .help = "write the error of each pixel as a false-colour PNG"}, FIELD(map), Texts("PNG")),
    option({.name = "measure", .help = "the error that the map shows: relative to the reference, the logarithm of its square, or as it is seen"}, FIELD(measure), NamesOfEnum<MapMeasure>()),
    option({.name = "full-scale", .help = "error shown brightest"}, FIELD(full_scale), Doubles(1e-30, 1e30)),
    option({.name = "pixels-per-degree", .help = "pixels of the screen in one degree of the view, for FLIP"}, FIELD(pixels_per_degree), Doubles(1, 1000)),
    option({.name = "json", .help = "write the measures as JSON"}, FIELD(json), Texts("JSON")),
    option({.name = "trust-input", .help = "decode rare kinds of EXR in this process, not in a confined one", .scope = OptionScope::kInput}, FIELD(limits.trust_input), Switches()),
  };
  // clang-format on
}
#undef FIELD

}  // namespace

Command CompareCommand() {
  return CommandOf<CompareFlags>(
      {.name = "compare",
       .summary = "Error measures between two pictures",
       .footer = "Example:\n  skywave compare a.exr reference.exr --map error.png"},
      Options(), CompareMain);
}

}  // namespace skywave
