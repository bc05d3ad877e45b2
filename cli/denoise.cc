// Implements skywave denoise: a clean picture from the layers of a noisy one.

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>

#include "base/arena.h"
#include "base/error.h"
#include "base/files.h"
#include "cli/commands.h"
#include "cli/parse.h"
#include "cli/print.h"
#include "job/denoise/denoise.h"
#include "job/exposure.h"
#include "job/picture.h"

namespace skywave {
namespace {

struct DenoiseFlags {
  std::string input, output;
  Denoiser by = Denoiser::kStatistics;
  ExposureRequest exposure;
  ReadLimits limits;
  int threads = 0;
  bool quiet = false;
};

constexpr char kAlpha[] = "A";

// Returns the names of the layers that are read of a picture: those of the denoiser, and its alpha.
std::vector<std::string> LayersOfNoisy(const std::string& path, const ReadLimits& limits) {
  const std::vector<std::string> names = ReadLayerNames(path, limits);
  if (std::any_of(names.begin(), names.end(), IsOfDenoiser)) {
    throw InputError(InputPosition::File(path), "this picture was denoised already");
  }
  std::vector<std::string> wanted = DenoiserChannels();
  if (std::find(names.begin(), names.end(), kAlpha) != names.end()) wanted.emplace_back(kAlpha);
  return wanted;
}

int DenoiseMain(const DenoiseFlags& flags) {
  if (std::filesystem::path(flags.output).extension() != ".exr") {
    throw InputError(InputPosition::File("--output " + flags.output),
                     "the picture is an EXR file, so its name has to end in .exr", kExitUsage);
  }
  CheckOutputs(std::array{flags.output, PngBeside(flags.output)}, std::array{flags.input});
  const std::vector<std::string> layers = LayersOfNoisy(flags.input, flags.limits);
  const Denoiser by = ResolveDenoiser(flags.by);
  LayeredImage noisy = ReadOwnColors(flags.input, layers, flags.limits);
  const Metadata metadata = ReadExrMetadata(flags.input, flags.limits);
  std::vector<float> alpha = TakeLayer(kAlpha, noisy.layers);
  const bool straight = IsStraight(metadata);
  if (straight) Premultiply(alpha, noisy.image);
  Denoised clean = ArenaOf(flags.threads).execute([&] {
    return Denoise(by, flags.input, noisy.image, noisy.layers);
  });
  Picture picture = {.image = std::move(clean.image),
                     .alpha = std::move(alpha),
                     .layers = noisy.layers,
                     .metadata = OfDerived(metadata, "noisyCommand"),
                     .placement = noisy.placement,
                     .space = noisy.space};
  if (straight) picture.format.alpha = AlphaForm::kStraight;
  for (std::string& note : NotesOf(clean)) picture.notes.push_back(std::move(note));
  picture.metadata.emplace_back("denoiser", ToString(by));
  if (!clean.oidn.empty()) picture.metadata.emplace_back(kOidnVersion, clean.oidn);
  Expose(ExposureOfDerived(flags.exposure, picture.metadata), picture);
  picture.layers = std::move(clean.error);
  WriteExrAndPng(flags.output, picture);
  if (!flags.quiet) {
    for (const std::string& note : picture.notes) {
      Print(stderr, "note: {}\n", SpellFlags(note));
    }
    Print(stdout, "wrote {} and {}\n", flags.output, PngBeside(flags.output));
  }
  return 0;
}

// Returns the names of denoisers but that of none.
Codec<Denoiser> Methods() {
  Codec<Denoiser> codec = NamesOfEnum<Denoiser>();
  codec.values = std::string("statistics|") + kDenoiserWords;
  codec.parse = [parse = codec.parse](const std::string& text) -> std::optional<Denoiser> {
    const std::optional<Denoiser> by = parse(text);
    return by == Denoiser::kNone ? std::nullopt : by;
  };
  return codec;
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<DenoiseFlags>> DenoiseOptions() {
  constexpr OptionMaker<DenoiseFlags> option = {};
  // clang-format off
  return {
    option({.name = "input", .help = "EXR with the layers of --aovs denoiser", .scope = OptionScope::kInput, .metavar = "EXR", .positional = true, .required = true}, FIELD(input), Texts("EXR")),
    option({.name = "output", .help = "EXR file with the layer error (not by quick), and a PNG of the same name", .metavar = "EXR", .letter = 'o', .required = true}, FIELD(output), Texts("EXR")),
    option({.name = "by", .help = "statistics of the samples, Open Image Denoise (oidn), quick, the same without its error in a third of the time, best, by a mean of both that is weighted by their errors, or auto, by both if it is installed", .scope = OptionScope::kPixels}, FIELD(by), Methods()),
    option({.name = "threads", .help = "0: as many as the process may use", .scope = OptionScope::kSpeed}, FIELD(threads), Numbers(0, 4096)),
    option({.name = "trust-input", .help = "decode rare kinds of EXR in this process, not in a confined one", .scope = OptionScope::kInput}, FIELD(limits.trust_input), Switches()),
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
  OptionCalled(command, "exposure").printed_default =
      "auto if that of the noisy picture was, else 0";
  return command;
}

}  // namespace skywave
