// Implements skywave denoise: a clean picture from the layers of a noisy one.

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <iterator>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/arena.h"
#include "base/error.h"
#include "base/files.h"
#include "cli/commands.h"
#include "cli/parse.h"
#include "cli/print.h"
#include "cli/progress.h"
#include "job/denoise/catchers.h"
#include "job/denoise/denoise.h"
#include "job/denoise/frames.h"
#include "job/denoise/groups.h"
#include "job/exposure.h"
#include "job/picture.h"

namespace skywave {
namespace {

struct DenoiseFlags {
  std::vector<std::string> inputs;
  std::string output;
  Denoiser by = Denoiser::kStatistics;
  int steady = 0;  // frames before and after each
  ExposureRequest exposure;
  ReadLimits limits;
  ProgressFlags progress;
  int threads = 0;
};

constexpr char kAlpha[] = "A";

// A picture to be cleaned, with the layers that are read of it.
struct NoisyPicture {
  std::string path, output;
  LayeredImage picture;
  std::vector<float> alpha;
  Metadata metadata;
};

// Returns the names of the layers that are read of a picture: those of the denoiser, and others
// that it may have.
std::vector<std::string> LayersOfNoisy(const std::string& path, const DenoiseFlags& flags) {
  const std::vector<std::string> names = ReadLayerNames(path, flags.limits);
  if (std::any_of(names.begin(), names.end(), IsOfDenoiser)) {
    throw InputError(InputPosition::File(path), "this picture was denoised already");
  }
  const auto has = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  const AovSet of_catchers = AovsOf(AovSum::kShadow) | AovsOf(AovSum::kDifference);
  const bool shows_catchers = has("difference.R");
  if (shows_catchers && flags.steady > 0) {
    throw InputError(InputPosition::File(path),
                     "shows catchers, and frames of those are not steadied yet: leave `steady` out",
                     kExitUsage);
  }
  std::vector<std::string> wanted =
      ChannelsOf(DenoiserLayers({}) | (shows_catchers ? of_catchers | PartAovs() : 0));
  const auto missing = std::find_if_not(wanted.begin(), wanted.end(), has);
  if (missing != wanted.end()) throw MissingLayer(path, *missing);
  std::vector<std::string> others = flags.steady > 0 ? FlowChannels() : std::vector<std::string>();
  others.emplace_back(kAlpha);
  if (flags.steady == 0 && !shows_catchers) {
    std::copy_if(names.begin(), names.end(), std::back_inserter(others), IsOfLightGroup);
  }
  if (shows_catchers) {
    // A picture that shows its background has alpha and foreground as layers.
    for (std::string& other : ChannelsOf(CatcherAovs() & ~of_catchers)) {
      others.push_back(std::move(other));
    }
  }
  for (std::string& other : others) {
    if (has(other)) wanted.push_back(std::move(other));
  }
  return wanted;
}

NoisyPicture ReadNoisy(const DenoiseFlags& flags, const std::string& path,
                       const std::string& output) {
  NoisyPicture noisy = {.path = path,
                        .output = output,
                        .picture = ReadOwnColors(path, LayersOfNoisy(path, flags), flags.limits),
                        .alpha = {},
                        .metadata = ReadExrMetadata(path, flags.limits)};
  noisy.alpha = TakeLayer(kAlpha, noisy.picture.layers);
  if (IsStraight(noisy.metadata)) Premultiply(noisy.alpha, noisy.picture.image);
  return noisy;
}

// Writes a picture that was cleaned, and returns what is to be said of it.
std::vector<std::string> WriteClean(const DenoiseFlags& flags, Denoiser by, NoisyPicture cleaned,
                                    Cleaning cleaning) {
  Picture picture = {.image = std::move(cleaned.picture.image),
                     .alpha = std::move(cleaned.alpha),
                     .layers = std::move(cleaned.picture.layers),
                     .notes = std::move(cleaning.notes),
                     .metadata = OfDerived(cleaned.metadata, "noisyCommand"),
                     .placement = cleaned.picture.placement,
                     .space = cleaned.picture.space};
  if (IsStraight(cleaned.metadata)) picture.format.alpha = AlphaForm::kStraight;
  picture.metadata.emplace_back("denoiser", ToString(by));
  if (!cleaning.oidn.empty()) picture.metadata.emplace_back(kOidnVersion, cleaning.oidn);
  if (flags.steady > 0) picture.metadata.emplace_back("steady", std::to_string(flags.steady));
  Expose(ExposureOfDerived(flags.exposure, picture.metadata), picture);
  // The others are noisy.
  const std::vector<std::string> clean = ChannelsOf(CatcherAovs());
  std::erase_if(picture.layers, [&](const NamedChannel& layer) {
    return !IsOfLightGroup(layer.name) &&
           std::find(clean.begin(), clean.end(), layer.name) == clean.end();
  });
  for (NamedChannel& channel : cleaning.error) picture.layers.push_back(std::move(channel));
  WriteExrAndPng(cleaned.output, picture);
  return picture.notes;
}

// Returns the names of the clean pictures: that of the output, or those of the noisy ones in it.
std::vector<std::string> OutputsOf(const DenoiseFlags& flags) {
  const std::filesystem::path output = flags.output;
  const auto refuse = [&](const std::string& why) {
    return InputError(InputPosition::File("--output " + flags.output), why, kExitUsage);
  };
  if (flags.inputs.size() == 1) {
    if (output.extension() == ".exr") return {flags.output};
    if (output.has_filename() && !std::filesystem::is_directory(output)) {
      throw refuse("the picture is an EXR file, so its name has to end in .exr");
    }
  } else if (output.extension() == ".exr") {
    throw refuse(fmt::format("{} pictures need a folder, in which they keep their names",
                             flags.inputs.size()));
  }
  std::vector<std::string> outputs;
  std::set<std::string> seen;
  for (const std::string& input : flags.inputs) {
    const std::filesystem::path path = input;
    if (path.extension() != ".exr") {
      throw InputError(InputPosition::File(input), "is not an EXR file", kExitUsage);
    }
    outputs.push_back((output / path.filename()).string());
    if (!seen.insert(outputs.back()).second) {
      throw refuse(fmt::format("two of the pictures are called {}", path.filename().string()));
    }
  }
  return outputs;
}

void CheckAll(const DenoiseFlags& flags, const std::vector<std::string>& outputs) {
  std::vector<std::string> files;
  for (const std::string& output : outputs) {
    files.push_back(output), files.push_back(PngBeside(output));
  }
  for (const std::string& input : flags.inputs) LayersOfNoisy(input, flags);
  if (outputs.front() != flags.output) {
    std::error_code error;
    std::filesystem::create_directories(flags.output, error);
    if (error) {
      throw InputError(InputPosition::File(flags.output),
                       "this folder cannot be made: " + error.message(), kExitIo);
    }
  }
  CheckOutputs(files, flags.inputs);
}

// Shows progress and says what was done.
class DenoiseReport {
 public:
  explicit DenoiseReport(const DenoiseFlags& flags)
      : flags_(flags), display_(flags.progress, flags.inputs.size()) {}

  void Begin(const std::string& path) {
    if (flags_.inputs.size() > 1) display_.Begin(path, 0);
  }
  void Wrote(const std::string& output, const std::vector<std::string>& notes) {
    if (flags_.inputs.size() > 1) display_.End();
    if (flags_.progress.quiet) return;
    display_.Clear();
    for (const std::string& note : notes) Print(stderr, "note: {}\n", SpellFlags(note));
    Print(stdout, "wrote {} and {}\n", output, PngBeside(output));
  }

 private:
  const DenoiseFlags& flags_;
  ProgressDisplay display_;
};

// Cleans each picture by itself.
void DenoiseEach(const DenoiseFlags& flags, Denoiser by, const std::vector<std::string>& outputs) {
  DenoiseReport report(flags);
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    report.Begin(flags.inputs[i]);
    NoisyPicture noisy = ReadNoisy(flags, flags.inputs[i], outputs[i]);
    Cleaning cleaning =
        CleanPicture(by, noisy.path, noisy.picture.image, noisy.alpha, noisy.picture.layers);
    report.Wrote(outputs[i], WriteClean(flags, by, std::move(noisy), std::move(cleaning)));
  }
}

// Returns what is to be said of all frames, by the first of them.
std::vector<std::string> NotesOfFrames(const DenoiseFlags& flags, const Metadata& metadata,
                                       const CleanFrame& frame) {
  std::vector<std::string> notes;
  if (frame.next.known.empty()) {
    notes.push_back(
        "the frames have no layers flow and flow-back, so what is not at the same place in all of "
        "them is not steadied: render them with `aovs denoiser,flow,flow-back`");
  }
  if (IsAutomatic(ExposureOfDerived(flags.exposure, metadata))) {
    notes.push_back(
        "the exposure of each PNG is that of its frame, so they flicker: give `exposure` a number");
  }
  return notes;
}

// Cleans the frames of an animation, which steady each other.
void DenoiseFrames(const DenoiseFlags& flags, const std::vector<std::string>& outputs) {
  DenoiseReport report(flags);
  const std::size_t around = std::size_t(flags.steady);
  std::deque<NoisyPicture> to_write;
  std::deque<CleanFrame> window;  // its last one has been read last
  std::size_t read = 0;           // frames
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    report.Begin(flags.inputs[i]);
    if (i > around) window.pop_front();
    for (; read < outputs.size() && read <= i + around; ++read) {
      NoisyPicture& noisy =
          to_write.emplace_back(ReadNoisy(flags, flags.inputs[read], outputs[read]));
      window.push_back(CleanFrameOf(noisy.path, noisy.picture.image, noisy.picture.layers));
    }
    std::vector<const CleanFrame*> frames;
    for (const CleanFrame& frame : window) frames.push_back(&frame);
    Denoised clean = Steady(frames, i - (read - window.size()));
    Cleaning cleaning = {std::move(clean.error), NotesOf(clean), ""};
    if (i == 0) {
      const std::vector<std::string> notes =
          NotesOfFrames(flags, to_write.front().metadata, window.front());
      cleaning.notes.insert(cleaning.notes.begin(), notes.begin(), notes.end());
    }
    to_write.front().picture.image = std::move(clean.image);
    const std::vector<std::string> notes =
        WriteClean(flags, Denoiser::kStatistics, std::move(to_write.front()), std::move(cleaning));
    to_write.pop_front();
    report.Wrote(outputs[i], notes);
  }
}

int DenoiseMain(const DenoiseFlags& flags) {
  const std::vector<std::string> outputs = OutputsOf(flags);
  const auto refuse_steady = [&](const std::string& why) {
    return OptionError("steady", std::to_string(flags.steady), why);
  };
  if (flags.steady > 0 && flags.by != Denoiser::kStatistics) {
    throw refuse_steady("frames are steadied by statistics only; leave `by` out");
  }
  if (flags.steady > 0 && outputs.size() == 1) {
    throw refuse_steady("one picture has no frames around it; name all frames, in their order");
  }
  CheckAll(flags, outputs);
  const Denoiser by = ResolveDenoiser(flags.by);
  ArenaOf(flags.threads).execute([&] {
    if (flags.steady > 0) return DenoiseFrames(flags, outputs);
    DenoiseEach(flags, by, outputs);
  });
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
    option({.name = "inputs", .help = "EXR with the layers of --aovs denoiser; several: each, or the frames of an animation, in their order", .scope = OptionScope::kInput, .metavar = "EXR ...", .positional = true, .required = true, .most_values = 1 << 20}, FIELD(inputs), Texts("EXR")),
    option({.name = "output", .help = "EXR file with the layer error (not by quick), and a PNG of the same name; for several pictures a folder, in which they keep their names", .metavar = "EXR|FOLDER", .letter = 'o', .required = true}, FIELD(output), Texts("EXR")),
    option({.name = "by", .help = "statistics of the samples, Open Image Denoise (oidn), quick, the same without its error in a third of the time, best, by a mean of both that is weighted by their errors, or auto, by both if it is installed", .scope = OptionScope::kPixels}, FIELD(by), Methods()),
    option({.name = "steady", .help = "frames before and after each one by which it is steadied, where they show the same (--aovs denoiser,flow,flow-back)", .scope = OptionScope::kPixels}, FIELD(steady), Numbers(0, 8)),
    option({.name = "threads", .help = "0: as many as the process may use", .scope = OptionScope::kSpeed}, FIELD(threads), Numbers(0, 4096)),
    option({.name = "trust-input", .help = "decode rare kinds of EXR in this process, not in a confined one", .scope = OptionScope::kInput}, FIELD(limits.trust_input), Switches()),
    ProgressOption<DenoiseFlags>(),
    option({.name = "quiet", .help = "print errors only", .letter = 'q'}, FIELD(progress.quiet), Switches()),
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
                         "Examples:\n"
                         "  skywave render gallery --aovs denoiser -o noisy.exr\n"
                         "  skywave denoise noisy.exr -o clean.exr\n"
                         "  skywave denoise frames/*.exr --steady 2 -o clean/",
                     .run = [flags](const GivenOptions&) { return DenoiseMain(*flags); }};
  AddOptions(command, DenoiseOptions(), flags);
  AddOptions(command, ExposureOptions(), std::shared_ptr<ExposureRequest>(flags, &flags->exposure));
  OptionCalled(command, "exposure").printed_default =
      "auto if that of the noisy picture was, else 0";
  return command;
}

}  // namespace skywave
