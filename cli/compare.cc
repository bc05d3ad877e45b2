// Implements skywave compare: the difference between two pictures.
#include <fmt/format.h>

#include <memory>

#include "base/files.h"
#include "cli/commands.h"
#include "image/compare.h"
#include "measure/json_reports.h"

namespace skywave {
namespace {

struct CompareFlags {
  std::string image, reference, map, json;
  double full_scale = 1;
};

int CompareMain(const CompareFlags& flags) {
  for (const std::string& path : {flags.map, flags.json}) {
    if (path.empty()) continue;
    CheckNotInput(path, flags.image), CheckNotInput(path, flags.reference);
    CheckWritable(path);
  }
  const Image image = ReadImage(flags.image), reference = ReadImage(flags.reference);
  const ImageDifference d = Compare(image, reference);
  const nlohmann::ordered_json json = Json(d);
  for (const auto& [name, value] : json.items()) {
    if (value.is_number_float()) fmt::print("{:<18}{:.8g}\n", name, value.get<double>());
  }
  fmt::print("{:<18}{}, {}\n", "max_at", d.max_x, d.max_y);
  fmt::print("{:<18}{} of {}\n", "different_pixels", d.different_pixels,
             std::size_t(image.width) * image.height);
  if (!flags.map.empty()) {
    WritePng(flags.map, image.width, image.height, ErrorMap(image, reference, flags.full_scale));
    fmt::print("wrote {}\n", flags.map);
  }
  if (!flags.json.empty()) WriteFileAtomically(flags.json, json.dump(2) + "\n");
  return 0;
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<CompareFlags>> Options() {
  constexpr OptionMaker<CompareFlags> option = {};
  // clang-format off
  return {
    option({.name = "image", .help = "EXR, HDR or PFM", .scope = OptionScope::kInput, .positional = true, .required = true}, FIELD(image), Texts("IMAGE")),
    option({.name = "reference", .help = "picture of the same size", .scope = OptionScope::kInput, .positional = true, .required = true}, FIELD(reference), Texts("REFERENCE")),
    option({.name = "map", .help = "write the relative error as a false-colour PNG"}, FIELD(map), Texts("PNG")),
    option({.name = "full-scale", .help = "relative error that is shown brightest"}, FIELD(full_scale), Doubles(1e-30, 1e30)),
    option({.name = "json", .help = "write the measures as JSON"}, FIELD(json), Texts("JSON")),
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
