// Implements skywave merge: films of parts become a picture, or a film of a larger part.
#include <array>
#include <filesystem>
#include <memory>

#include "base/error.h"
#include "base/files.h"
#include "cli/commands.h"
#include "cli/parse.h"
#include "cli/print.h"
#include "job/limits.h"
#include "job/merge_films.h"

namespace skywave {
namespace {

struct MergeFlags {
  MergeRequest request;
  std::string output;
  bool quiet = false;
  ExrFormat format;
};

int MergeMain(const MergeFlags& flags) {
  const std::string ending = std::filesystem::path(flags.output).extension().string();
  if (ending != ".exr" && ending != ".film") {
    throw InputError(InputPosition::File("--output " + flags.output),
                     "is a picture, whose name ends in .exr, or a film, whose name ends in .film",
                     kExitUsage);
  }
  const bool to_film = ending == ".film";
  CheckOutputs(std::array{flags.output, to_film ? std::string() : PngBeside(flags.output)},
               flags.request.films);
  const MergedFilm merged = MergeFilms(flags.request);
  if (to_film) {
    WriteFilm(flags.output, merged.file, merged.film);
  } else {
    CheckFormat(flags.format, merged.file.layers);
    Picture picture = ResolveMerged(merged);
    picture.format = flags.format;
    for (const std::string& note : picture.notes) {
      if (!flags.quiet) Print(stderr, "note: {}\n", SpellFlags(note));
    }
    WriteExrAndPng(flags.output, picture);
  }
  if (!flags.quiet) {
    Print(stdout, "merged {} film{}, {:.1f} s of rendering; wrote {}{}\n",
          flags.request.films.size(), flags.request.films.size() == 1 ? "" : "s",
          merged.file.seconds, flags.output, to_film ? "" : " and " + PngBeside(flags.output));
  }
  return 0;
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<MergeFlags>> MergeOptions() {
  constexpr OptionMaker<MergeFlags> option = {};
  // clang-format off
  return {
    option({.name = "films", .help = "films of parts of one picture, in any order (skywave render --film)", .scope = OptionScope::kInput, .metavar = "FILM ...", .positional = true, .required = true, .most_values = 1 << 20}, FIELD(request.films), Texts("films")),
    option({.name = "output", .help = "EXR file, with a PNG of the same name; or, ending in .film, a film of what there is", .metavar = "EXR|FILM", .letter = 'o', .required = true}, FIELD(output), Texts("EXR")),
    option({.name = "crop", .help = "expect the parts to make this part of the film", .default_text = "all of it"}, FIELD(request.window), Crops()),
    option({.name = "sample-range", .help = "expect the parts to make these samples", .default_text = "all"}, FIELD(request.samples), SampleRanges()),
    option({.name = "quiet", .help = "print errors only", .letter = 'q'}, FIELD(quiet), Switches()),
  };
  // clang-format on
}
#undef FIELD

}  // namespace

Command MergeCommand() {
  const auto flags = std::make_shared<MergeFlags>();
  Command command = {.name = "merge",
                     .summary = "Add films of parts of a picture: the bytes of one render",
                     .footer =
                         "Examples:\n"
                         "  skywave render gallery --spp 64 --sample-range 0:32 --film a.film\n"
                         "  skywave render gallery --spp 64 --sample-range 32:64 --film "
                         "b.film\n"
                         "  skywave merge a.film b.film -o gallery.exr\n",
                     .run = [flags](const GivenOptions&) { return MergeMain(*flags); }};
  AddOptions(command, MergeOptions(), flags);
  AddOptions(command, ExrFormatOptions(), std::shared_ptr<ExrFormat>(flags, &flags->format));
  return command;
}

}  // namespace skywave
