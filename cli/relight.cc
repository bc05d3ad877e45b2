// Implements skywave relight: a picture by other weights of its lights.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <utility>

#include "base/arena.h"
#include "base/error.h"
#include "base/files.h"
#include "cli/commands.h"
#include "cli/parse.h"
#include "cli/print.h"
#include "cli/progress.h"
#include "job/exposure.h"
#include "job/map_sequence.h"
#include "job/relight.h"

namespace skywave {
namespace {

struct RelightFlags {
  std::string input, output, table;
  std::vector<LightWeight> weights;
  ExposureRequest exposure;
  ExrFormat format;
  ReadLimits limits;
  int threads = 0;
  ProgressFlags progress;
};

// Returns the picture with the image `relit`, and the weights that made it in its metadata.
Picture RelitPicture(const LitPicture& lit, Image relit, const std::vector<LightWeight>& weights,
                     const RelightFlags& flags) {
  Picture picture = lit.picture;
  picture.image = std::move(relit);
  std::string words;
  for (const LightWeight& weight : weights) {
    words += (words.empty() ? "" : ",") + LightWeights().print(weight);
  }
  picture.metadata = OfDerived(std::move(picture.metadata), "lightsCommand");
  picture.metadata.emplace_back("lightWeights", words);
  picture.notes.clear();
  Expose(ExposureOfDerived(flags.exposure, picture.metadata), picture);
  picture.format = flags.format;
  picture.format.threads = flags.threads;
  return picture;
}

// Writes a picture for each row of the table, some at the same time: files take longer than sums.
void RelightByTable(const LitPicture& lit, const RelightFlags& flags) {
  constexpr std::size_t kAtOnce = 8;
  const auto rows = ReadWeightTable(flags.table);
  ProgressDisplay progress(flags.progress);
  progress.Begin(flags.output, 0);
  for (std::size_t begin = 0; begin < rows.size(); begin += kAtOnce) {
    const auto some = std::span(rows).subspan(begin, std::min(kAtOnce, rows.size() - begin));
    std::vector<Image> relit = RelitAll(lit, some);
    tbb::parallel_for(std::size_t{0}, some.size(), [&](std::size_t i) {
      WriteExrAndPng(NumberedFile(flags.output, std::int64_t(begin + i)),
                     RelitPicture(lit, std::move(relit[i]), some[i], flags));
    });
    progress.Show(double(begin + some.size()) / double(rows.size()));
  }
  progress.End();
}

void RelightAll(const RelightFlags& flags) {
  const LitPicture lit = ReadLitPicture(flags.input, flags.limits);
  if (!flags.table.empty()) {
    RelightByTable(lit, flags);
    return;
  }
  const Picture picture = RelitPicture(lit, Relit(lit, flags.weights), flags.weights, flags);
  WriteExrAndPng(flags.output, picture);
  if (flags.progress.quiet) return;
  for (const std::string& note : picture.notes) Print(stderr, "note: {}\n", SpellFlags(note));
}

int RelightMain(const RelightFlags& flags) {
  const auto refuse = [&](const std::string& why) {
    return InputError(InputPosition::File("--output " + flags.output), why, kExitUsage);
  };
  if (std::filesystem::path(flags.output).extension() != ".exr") {
    throw refuse("the picture is an EXR file, so its name has to end in .exr");
  }
  if (!flags.table.empty() && !HasNumber(flags.output)) {
    throw refuse("each row of the table is a picture: # in its name stands for the row's number");
  }
  CheckOutputs(std::array{flags.output, PngBeside(flags.output)},
               std::array{flags.input, flags.table});
  ArenaOf(flags.threads).execute([&] { RelightAll(flags); });
  if (!flags.progress.quiet) {
    Print(stdout, "wrote {} and {}\n", flags.output, PngBeside(flags.output));
  }
  return 0;
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<RelightFlags>> RelightOptions() {
  constexpr OptionMaker<RelightFlags> option = {};
  // clang-format off
  return {
    option({.name = "input", .help = "EXR or film with the layers of --aovs lights", .scope = OptionScope::kInput, .metavar = "EXR|FILM", .positional = true, .required = true}, FIELD(input), Texts("EXR")),
    option({.name = "output", .help = "EXR file, and a PNG of the same name", .metavar = "EXR", .letter = 'o', .required = true}, FIELD(output), Texts("EXR")),
    option({.name = "weights", .help = "factors of groups of lights; those that are not named keep 1", .scope = OptionScope::kPixels, .default_text = "1", .most_values = 1000, .delimiter = ','}, FIELD(weights), LightWeights()),
    option({.name = "sky", .help = "CSV of weights, whose first row names groups: each row is a picture", .scope = OptionScope::kInput, .excludes = "weights"}, FIELD(table), Texts("CSV")),
    option({.name = "threads", .help = "0: as many as the process may use", .scope = OptionScope::kSpeed}, FIELD(threads), skywave::Numbers(0, 4096)),
    option({.name = "trust-input", .help = "decode rare kinds of EXR in this process, not in a confined one", .scope = OptionScope::kInput}, FIELD(limits.trust_input), Switches()),
    option({.name = "quiet", .help = "print errors only", .letter = 'q'}, FIELD(progress.quiet), Switches()),
    ProgressOption<RelightFlags>(),
  };
  // clang-format on
}
#undef FIELD

}  // namespace

Command RelightCommand() {
  const auto flags = std::make_shared<RelightFlags>();
  Command command = {.name = "relight",
                     .summary = "Give the lights of a picture other weights and colours",
                     .footer =
                         "Examples:\n"
                         "  skywave render lamps --aovs lights -o lamps.exr\n"
                         "  skywave relight lamps.exr --weights red=2,blue=0.5/0.6/1 -o mix.exr\n"
                         "  skywave relight day.film --sky weights.csv -o hour_####.exr",
                     .run = [flags](const GivenOptions&) { return RelightMain(*flags); }};
  AddOptions(command, RelightOptions(), flags);
  AddOptions(command, ExposureOptions(), std::shared_ptr<ExposureRequest>(flags, &flags->exposure));
  AddOptions(command, ExrFormatOptions(), std::shared_ptr<ExrFormat>(flags, &flags->format));
  OptionCalled(command, "exposure").printed_default = "auto if that of the picture was, else 0";
  return command;
}

}  // namespace skywave
