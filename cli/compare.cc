// Implements skywave compare: the difference between two pictures.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "base/files.h"
#include "cli/commands.h"
#include "image/compare.h"

namespace skywave {
namespace {

struct CompareFlags {
  std::string image, reference, map, json;
  double full_scale = 1;
};

int CompareMain(const CompareFlags& flags) {
  for (const std::string& path : {flags.map, flags.json}) {
    if (!path.empty()) CheckWritable(path);
  }
  const Image image = ReadImage(flags.image), reference = ReadImage(flags.reference);
  const ImageDifference d = Compare(image, reference);
  const std::pair<const char*, double> rows[] = {
      {"mean_image", d.mean_a},
      {"mean_reference", d.mean_b},
      {"mse", d.mse},
      {"rmse", d.rmse},
      {"relative_mse", d.relative_mse},
      {"mean_absolute", d.mean_absolute},
      {"psnr_db", d.psnr},
      {"thesis_euclidean", d.thesis_euclidean},
      {"thesis_luminance", d.thesis_luminance},
      {"max_absolute", d.max_absolute},
  };
  nlohmann::ordered_json json;
  for (const auto& [name, value] : rows) {
    fmt::print("{:<18}{:.8g}\n", name, value);
    json[name] = value;
  }
  fmt::print("{:<18}{}, {}\n", "max_at", d.max_x, d.max_y);
  fmt::print("{:<18}{} of {}\n", "different_pixels", d.different_pixels,
             std::size_t(image.width) * image.height);
  json["max_at"] = {d.max_x, d.max_y};
  json["different_pixels"] = d.different_pixels;
  if (!flags.map.empty()) {
    WritePng(flags.map, image.width, image.height, ErrorMap(image, reference, flags.full_scale));
    fmt::print("wrote {}\n", flags.map);
  }
  if (!flags.json.empty()) WriteFileAtomically(flags.json, json.dump(2) + "\n");
  return 0;
}

}  // namespace

void AddCompareCommand(CLI::App& program, Run& run) {
  CLI::App* command = program.add_subcommand("compare", "Error measures between two pictures");
  const auto flags = std::make_shared<CompareFlags>();
  command->add_option("image", flags->image, "EXR, HDR or PFM")->required();
  command->add_option("reference", flags->reference, "of the same size")->required();
  command->add_option("--map", flags->map, "write the relative error as a false-colour PNG");
  command->add_option("--full-scale", flags->full_scale, "relative error shown brightest")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--json", flags->json, "write the measures as JSON");
  command->footer("Example:\n  skywave compare a.exr reference.exr --map error.png");
  command->callback([flags, &run] { run = [flags] { return CompareMain(*flags); }; });
}

}  // namespace skywave
