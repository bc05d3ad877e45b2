// Implements skywave denoise: a clean picture from the layers of a noisy one.
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "base/error.h"
#include "base/files.h"
#include "cli/commands.h"
#include "cli/parse.h"
#include "denoise/denoise.h"
#include "job/exposure.h"
#include "job/picture.h"

namespace skywave {
namespace {

struct DenoiseFlags {
  std::string input, output;
  ExposureRequest exposure;
  bool quiet = false;
};

int DenoiseMain(const DenoiseFlags& flags) {
  if (std::filesystem::path(flags.output).extension() != ".exr") {
    throw InputError(InputPosition::File("--output " + flags.output),
                     "the picture is an EXR file, so its name has to end in .exr", kExitUsage);
  }
  for (const std::string& path : {flags.output, PngBeside(flags.output)}) {
    CheckNotInput(path, flags.input);
    CheckWritable(path);
  }
  LayeredImage noisy = ReadLayeredImage(flags.input, DenoiserChannels());
  Denoised clean = Denoise(flags.input, noisy.image, noisy.layers);
  Picture picture = {.image = std::move(clean.image),
                     .layers = std::move(clean.error),
                     .metadata = ReadExrMetadata(flags.input)};
  if (const std::string note = OutlierNote(clean); !note.empty()) picture.notes.push_back(note);
  ExposureRequest exposure = flags.exposure;
  if (!exposure.exposure && exposure.photo.shutter_seconds <= 0 &&
      IsExposedAutomatically(picture.metadata)) {
    exposure.exposure = ExposureChoice{.automatic = true};
  }
  Expose(exposure, picture);
  WritePng(PngBeside(flags.output), picture);
  WriteExr(flags.output, picture);
  if (!flags.quiet) {
    for (const std::string& note : picture.notes) {
      fmt::print(stderr, "note: {}\n", SpellFlags(note));
    }
    fmt::print("wrote {} and {}\n", flags.output, PngBeside(flags.output));
  }
  return 0;
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<DenoiseFlags>> DenoiseOptions() {
  constexpr OptionMaker<DenoiseFlags> option = {};
  // clang-format off
  return {
    option({.name = "input", .help = "EXR with the layers of --aovs denoiser", .scope = OptionScope::kInput, .metavar = "EXR", .positional = true, .required = true}, FIELD(input), Texts("EXR")),
    option({.name = "output", .help = "EXR file with the layer error, and a PNG of the same name", .metavar = "EXR", .letter = 'o', .required = true}, FIELD(output), Texts("EXR")),
    option({.name = "quiet", .help = "print errors only", .letter = 'q'}, FIELD(quiet), Switches()),
  };
  // clang-format on
}
#undef FIELD

}  // namespace

Command DenoiseCommand() {
  const auto flags = std::make_shared<DenoiseFlags>();
  Command command = {.name = "denoise",
                     .summary = "Make a clean picture from the layers of a noisy one",
                     .footer =
                         "Example:\n"
                         "  skywave render gallery --aovs denoiser -o noisy.exr\n"
                         "  skywave denoise noisy.exr -o clean.exr",
                     .run = [flags](const GivenOptions&) { return DenoiseMain(*flags); }};
  AddOptions(command, DenoiseOptions(), flags);
  AddOptions(command, ExposureOptions(), std::shared_ptr<ExposureRequest>(flags, &flags->exposure));
  return command;
}

}  // namespace skywave
