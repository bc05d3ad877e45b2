#include "job/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

#include "base/arena.h"
#include "base/error.h"
#include "base/files.h"
#include "base/version.h"
#include "image/primaries.h"
#include "job/backplate.h"
#include "job/denoise/catchers.h"
#include "job/denoise/denoise.h"
#include "job/denoise/oidn.h"

namespace skywave {
namespace {

// The names, or the beginnings of names, of options that give pixels different numbers of samples.
constexpr std::string_view kAdaptive = "adaptive";

// An attribute of the EXR: the stops of an automatic exposure.
constexpr std::string_view kPngExposure = "pngExposure";

// The options that distinguish a part from the whole.
bool IsOfPart(const RecordedOption& option) {
  return option.name == "crop" || option.name == "sample-range";
}

const RecordedOption* Find(const std::vector<RecordedOption>& options, const std::string& name) {
  const auto found =
      std::find_if(options.begin(), options.end(),
                   [&](const RecordedOption& option) { return option.name == name; });
  return found != options.end() ? &*found : nullptr;
}

// Returns the words of the option `name` of `table` with the value of `request`.
template <class Options, class Request>
std::string WordsOf(const Options& table, std::string_view name, const Request& request) {
  const auto option = std::find_if(table.begin(), table.end(),
                                   [&](const auto& candidate) { return candidate.name == name; });
  return CommandWords(*option, request);
}

// Returns the exposure of the PNG that a picture records.
ExposureRequest ExposureOf(const PictureIdentity& identity) {
  const auto exposure = std::make_shared<ExposureRequest>();
  std::vector<BoundOption> bound;
  for (const OptionOf<ExposureRequest>& option : ExposureOptions()) {
    bound.push_back(Bind(option, exposure));
    for (const RecordedOption& recorded : identity.options) {
      if (recorded.name != option.name || recorded.words.empty()) continue;
      SetOption(bound, recorded.name, ValueOf(recorded));
    }
  }
  return *exposure;
}

// Returns whether a channel is one of `layers`.
bool IsOfLayers(std::string_view channel, AovSet layers) {
  for (std::size_t k = 0; k < Aovs().size(); ++k) {
    const Aov& aov = Aovs()[k];
    const std::string name = LayerName(aov, "");
    if ((layers >> k & 1) == 0 || !channel.starts_with(name)) continue;
    const bool of_many = aov.sum == AovSum::kLightGroups || aov.sum == AovSum::kMatte;
    if (of_many || channel[name.size()] == '.') return true;
  }
  return false;
}

// Replaces the picture by a clean one, by the layers that the denoiser reads, and adds the layer
// "error" and, where the picture is to keep what it is made from, "noisy".
void Clean(Denoiser by, const std::string& scene, bool keeps_noisy, Picture& picture) {
  if (!CanDenoise(picture.image, picture.layers)) {
    picture.notes.push_back(
        fmt::format("not denoised: pixels have fewer than {} samples, or too few in one half",
                    kFewestDenoiserSamples));
    return;
  }
  std::vector<NamedChannel> noisy;
  if (keeps_noisy) noisy = AsLayer("noisy", picture.image);
  Cleaning cleaning;
  try {
    cleaning = CleanPicture(by, scene, picture.image, picture.alpha, picture.layers);
  } catch (const OidnError& error) {
    // The rays have been traced, and their picture is worth more than none.
    picture.notes.push_back(fmt::format("not denoised: {}", error.what()));
    return;
  }
  for (NamedChannel& channel : noisy) picture.layers.push_back(std::move(channel));
  for (NamedChannel& channel : cleaning.error) picture.layers.push_back(std::move(channel));
  for (std::string& note : cleaning.notes) picture.notes.push_back(std::move(note));
  if (!cleaning.oidn.empty()) picture.metadata.emplace_back(kOidnVersion, cleaning.oidn);
}

// Returns what is behind a picture with alpha: the photograph, or the layer of the map on the
// ground and on a dome. Its image is empty where there is nothing.
Backplate BehindPicture(const PictureIdentity& identity, const Picture& picture) {
  if (picture.alpha.empty()) return {};
  if (!identity.backplate.empty()) {
    return ReadBackplate(identity.backplate, identity.film.width, identity.film.height,
                         picture.space);
  }
  Backplate behind;
  std::size_t c = 0;
  for (const NamedChannel& layer : picture.layers) {
    if (!layer.name.starts_with("backdrop.")) continue;
    if (c == 0) behind.image = Image(picture.image.width, picture.image.height);
    for (std::size_t i = 0; i < layer.values.size(); ++i) {
      behind.image.rgb[3 * i + c] = layer.values[i];
    }
    ++c;
  }
  return behind;
}

// Exposes the picture and puts it over what is behind it. A photograph for screens has the colours
// of the PNG without a tone curve: the exposure that multiplies all of the composite there is taken
// from it.
void ExposeAndCompose(const PictureIdentity& identity, const CropWindow& part, Picture& picture) {
  const Backplate behind = BehindPicture(identity, picture);
  const auto compose = [&](float factor) {
    const CropWindow here = {0, 0, picture.image.width, picture.image.height};
    const CropWindow& window = identity.backplate.empty() ? here : part;
    picture.composite = PutOver(picture.image, picture.alpha, behind, window, factor);
  };
  const bool is_there = !behind.image.rgb.empty();
  if (is_there && !behind.of_screen) compose(1);
  Expose(ExposureOf(identity), picture);
  if (is_there && behind.of_screen) compose(std::exp2(-picture.tone.exposure_stops));
}

// Makes the picture one to put over another one, by its layers.
void MakeTransparent(Picture& picture) {
  picture.alpha = TakeLayer("alpha.A", picture.layers);
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<float> values =
        TakeLayer(fmt::format("foreground.{}", "RGB"[c]), picture.layers);
    for (std::size_t i = 0; i < values.size(); ++i) picture.image.rgb[3 * i + c] = values[i];
  }
}

// Says where the layer of hidden objects may lack some.
void NoteHiddenObjects(Picture& picture) {
  const std::string last = fmt::format("hidden-id.{}", kHiddenObjects);
  for (const NamedChannel& channel : picture.layers) {
    if (channel.name != last) continue;
    const auto full = std::count_if(channel.values.begin(), channel.values.end(),
                                    [](float mesh) { return mesh > 0; });
    if (full == 0) continue;
    picture.notes.push_back(
        fmt::format("layer hidden-id: {} pixels have {} meshes behind the first one, the most that "
                    "it holds; what is behind those is not in it",
                    full, kHiddenObjects));
  }
}

}  // namespace

std::string ValueOf(const RecordedOption& option) {
  if (option.words.empty()) return "not given";
  const std::size_t end_of_name = option.words.find_first_of(" =", 3);
  if (end_of_name == std::string::npos) return option.words.substr(1);  // a switch
  return option.words.substr(end_of_name + 1);
}

PictureIdentity IdentityOf(const RenderJob& job, const ExposureRequest& wanted, bool repeatable,
                           const RenderLimits& limits) {
  const JobRequest& request = job.request();
  const ExposureRequest exposure = ResolveExposure(wanted, request);
  PictureIdentity identity = {.software = fmt::format("skywave {}", Version()),
                              .scene = request.scene,
                              .scene_hash = job.scene_hash(),
                              .map_hash = job.map_hash(),
                              .film = {0, 0, *request.width, *request.height},
                              .samples = job.options().samples_per_pixel,
                              .seed = job.options().seed,
                              .repeatable = repeatable,
                              .options = RecordedOptions(request),
                              .backplate = request.backplate};
  for (RecordedOption& option : identity.options) {
    if (IsOfPart(option)) option.words.clear();
  }
  identity.options.push_back({.name = "sample-range", .words = "", .is_input = false});
  static const ExposureRequest defaults;
  for (const OptionOf<ExposureRequest>& option : ExposureOptions()) {
    const bool given = option.get(exposure) != option.get(defaults);
    identity.options.push_back({.name = std::string(option.name),
                                .words = given ? CommandWords(option, exposure) : "",
                                .is_input = false});
  }
  for (const OptionOf<RenderLimits>& option : LimitOptions()) {
    if (limits.adaptive <= 0 || !option.name.starts_with(kAdaptive)) continue;
    identity.options.push_back({.name = std::string(option.name),
                                .words = CommandWords(option, limits),
                                .is_input = false});
  }
  return identity;
}

bool IsAdaptive(const PictureIdentity& identity) {
  return Find(identity.options, std::string(kAdaptive)) != nullptr;
}

PicturePart PartOf(const RenderJob& job, const SampleRange& samples) {
  const RenderOptions& options = job.options();
  return {{options.crop_x, options.crop_y, options.width, options.height}, samples};
}

std::string RepeatCommand(const PictureIdentity& identity, const PicturePart& part) {
  std::string command = "skywave render";
  for (const RecordedOption& option : identity.options) {
    if (option.name == "crop" && part.window != identity.film) {
      JobRequest request;
      request.crop = part.window;
      command += WordsOf(JobOptions(), "crop", request);
    } else if (option.name == "sample-range" && part.samples != SampleRange{0, identity.samples}) {
      command += WordsOf(LimitOptions(), "sample-range", RenderLimits{.samples = part.samples});
    } else {
      command += option.words;
    }
  }
  return command;
}

std::string Difference(const PictureIdentity& here, const PictureIdentity& there) {
  if (here.software != there.software) {
    return fmt::format("it is of {}, and this is {}", there.software, here.software);
  }
  for (const RecordedOption& option : here.options) {
    const RecordedOption* const other = Find(there.options, option.name);
    const bool same = option.is_input || (other != nullptr && other->words == option.words);
    if (same) continue;
    return fmt::format("`{}` is {} here and {} there", option.name, ValueOf(option),
                       other != nullptr ? ValueOf(*other) : "not given");
  }
  for (const RecordedOption& option : there.options) {
    if (option.is_input || Find(here.options, option.name) != nullptr) continue;
    return fmt::format("`{}` is {} there and not given here", option.name, ValueOf(option));
  }
  if (here.film != there.film) return "the films have different sizes";
  if (here.samples != there.samples) return "the pictures have different numbers of samples";
  if (here.map_hash != there.map_hash) return "the illumination maps differ";
  if (here.scene_hash != there.scene_hash) {
    return fmt::format("the scenes differ: {} here and {} there, or what belongs to them",
                       here.scene, there.scene);
  }
  return "";
}

bool IsOfDenoiser(std::string_view channel) {
  return channel.starts_with("noisy.") || channel.starts_with("error.");
}

Denoiser DenoiserOf(const PictureIdentity& identity) {
  const RecordedOption* const option = Find(identity.options, "denoise");
  if (option == nullptr || option->words.empty()) return Denoiser::kNone;
  return Parse<Denoiser>(ValueOf(*option)).value_or(Denoiser::kStatistics);  // the switch alone
}

RgbSpace SpaceOf(const PictureIdentity& identity) {
  const RecordedOption* const option = Find(identity.options, "working-space");
  if (option == nullptr) return RgbSpace::kRec709;  // of a film that knew no other one
  return Parse<RgbSpace>(ValueOf(*option)).value_or(RgbSpace::kRec709);
}

bool IsTransparent(const PictureIdentity& identity) {
  const RecordedOption* const option = Find(identity.options, "background");
  return option != nullptr && ValueOf(*option) == ToString(Background::kTransparent);
}

AovSet LayersToResolve(AovSet layers, const PictureIdentity& identity) {
  return layers | (DenoiserOf(identity) != Denoiser::kNone ? DenoiserLayers(layers) : 0) |
         (IsAutomatic(ExposureOf(identity)) ? MeteredLayers() : 0);
}

PictureRows::PictureRows(AovSet layers, const PictureIdentity& identity)
    : layers_(LayersToResolve(layers, identity)) {}

void PictureRows::Add(const Film& film, const SampleCounts& samples, int first, int end) {
  std::call_once(begun_, [&] {
    picture_ = film.EmptyPicture(layers_);
    is_there_.resize(std::size_t(picture_.image.height));
  });
  film.ResolveRows(samples, layers_, first, end, picture_);
  std::fill(is_there_.begin() + first, is_there_.begin() + end, true);
}

LayeredImage PictureRows::With(const Film& film, const SampleCounts& samples) const {
  LayeredImage all = is_there_.empty() ? film.EmptyPicture(layers_) : picture_;
  for (int y = 0; y < all.image.height; ++y) {
    const bool is_there = !is_there_.empty() && is_there_[std::size_t(y)];
    if (!is_there) film.ResolveRows(samples, layers_, y, y + 1, all);
  }
  return all;
}

Picture ResolvePicture(const Film& film, const SampleCounts& samples, AovSet layers,
                       const PictureIdentity& identity, const PicturePart& part, int threads) {
  PictureRows rows(layers, identity);
  ArenaOf(threads).execute([&] { rows.Add(film, samples, 0, film.layout().area.picture.height); });
  return FinishPicture(rows.Take(), layers, identity, part, threads);
}

Picture FinishPicture(LayeredImage resolved, AovSet layers, const PictureIdentity& identity,
                      const PicturePart& part, int threads) {
  Metadata metadata = {{"software", identity.software},
                       {"samples", fmt::format("{}", part.samples.count())},
                       {"seed", fmt::format("{}", identity.seed)},
                       {"sceneHash", fmt::format("{:016x}", identity.scene_hash)}};
  if (identity.repeatable) metadata.emplace_back("command", RepeatCommand(identity, part));
  Picture picture;
  picture.space = SpaceOf(identity);
  picture.metadata = std::move(metadata);
  picture.metadata.insert(picture.metadata.end(), resolved.attributes.begin(),
                          resolved.attributes.end());
  if (part.window != identity.film) {
    picture.placement = {part.window.x, part.window.y, identity.film.width, identity.film.height};
  }
  picture.image = std::move(resolved.image);
  picture.layers = std::move(resolved.layers);
  NoteHiddenObjects(picture);
  if (IsTransparent(identity)) MakeTransparent(picture);
  if (const Denoiser by = DenoiserOf(identity); by != Denoiser::kNone) {
    ArenaOf(threads).execute(
        [&] { Clean(by, identity.scene, HasDenoiserLayers(layers), picture); });
  }
  ExposeAndCompose(identity, part.window, picture);
  std::erase_if(picture.layers, [&](const NamedChannel& channel) {
    return !IsOfLayers(channel.name, layers) && !IsOfDenoiser(channel.name);
  });
  for (NamedChannel& channel : AsLayer("composite", picture.composite)) {
    picture.layers.push_back(std::move(channel));
  }
  return picture;
}

Metadata OfDerived(Metadata metadata, std::string_view command) {
  std::erase_if(metadata, [](const auto& text) { return IsOfMatte(text.first); });
  for (auto& [name, text] : metadata) {
    if (name == "command") name = command;
  }
  return metadata;
}

void Expose(const ExposureRequest& resolved, Picture& picture) {
  picture.tone = picture.composite.rgb.empty()
                     ? Tone(resolved, InRec709(picture.image, picture.space), picture.layers)
                     : Tone(resolved, InRec709(picture.composite, picture.space));
  std::erase_if(picture.metadata, [](const auto& text) { return text.first == kPngExposure; });
  if (!IsAutomatic(resolved)) return;
  const std::string stops = fmt::format("{}", picture.tone.exposure_stops);
  picture.metadata.emplace_back(kPngExposure, stops);
  picture.notes.push_back(fmt::format("the PNG has an automatic `exposure` of {} stops", stops));
}

ExposureRequest ExposureOfDerived(const ExposureRequest& request, const Metadata& metadata) {
  ExposureRequest exposure = ResolveExposure(request, JobRequest());
  const bool was_automatic = std::any_of(metadata.begin(), metadata.end(), [](const auto& text) {
    return text.first == kPngExposure;
  });
  if (was_automatic && !exposure.exposure && exposure.photo.shutter_seconds <= 0) {
    exposure.exposure = ExposureChoice{.automatic = true};
  }
  return exposure;
}

void CheckFormat(const ExrFormat& format, AovSet layers) {
  if (format.compression < ExrCompression::kPxr24 || !Sums(layers, AovSum::kMatte)) return;
  throw OptionError("compression", std::string(ToString(format.compression)),
                    fmt::format("loses digits, and those of the layers {} are names: use zip, piz "
                                "or another one that keeps them",
                                ToString(layers & AovsOf(AovSum::kMatte))));
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<ExrFormat>> ExrFormatOptions() {
  const auto option = [](OptionInfo info, auto field, auto codec) {
    info.group = "Format of the EXR";
    return MakeOption<ExrFormat>(info, field, codec);
  };
  // clang-format off
  return {
    option({.name = "compression", .help = "compression of the EXR; pxr24, dwaa and dwab lose digits"}, FIELD(compression), NamesOfEnum<ExrCompression>()),
    option({.name = "alpha", .help = "colours of an EXR with alpha: multiplied by it, or straight"}, FIELD(alpha), NamesOfEnum<AlphaForm>()),
    option({.name = "half", .help = "colours of the EXR with 16 bits"}, FIELD(half), Switches()),
  };
  // clang-format on
}
#undef FIELD

namespace {

constexpr char kAlphaForm[] = "alphaForm";  // in headers of pictures that are straight

// Returns the colours of the picture divided by its alpha, where it has any.
Image Straight(const Picture& picture) {
  Image image = picture.image;
  for (std::size_t i = 0; i < picture.alpha.size(); ++i) {
    if (picture.alpha[i] <= 0) continue;
    for (std::size_t c = 0; c < 3; ++c) image.rgb[3 * i + c] /= picture.alpha[i];
  }
  return image;
}

void WriteExr(const std::string& path, const Picture& picture,
              const std::function<void()>& before_rename) {
  ExrFormat format = picture.format;
  format.placement = picture.placement;
  format.space = picture.space;
  if (picture.alpha.empty()) {
    WriteExr(path, picture.image, picture.metadata, picture.layers, format, before_rename);
    return;
  }
  std::vector<NamedChannel> channels = picture.layers;
  channels.push_back({"A", picture.alpha});
  Metadata metadata = picture.metadata;
  std::erase_if(metadata, [](const auto& text) { return text.first == kAlphaForm; });
  const bool straight = format.alpha == AlphaForm::kStraight;
  if (straight) metadata.emplace_back(kAlphaForm, ToString(format.alpha));
  WriteExr(path, straight ? Straight(picture) : picture.image, metadata, channels, format,
           before_rename);
}

}  // namespace

std::vector<float> TakeLayer(std::string_view name, std::vector<NamedChannel>& layers) {
  const auto found = std::find_if(layers.begin(), layers.end(),
                                  [&](const NamedChannel& layer) { return layer.name == name; });
  if (found == layers.end()) return {};
  std::vector<float> values = std::move(found->values);
  layers.erase(found);
  return values;
}

bool IsStraight(const Metadata& metadata) {
  const std::pair said(std::string(kAlphaForm), std::string(ToString(AlphaForm::kStraight)));
  return std::find(metadata.begin(), metadata.end(), said) != metadata.end();
}

void Premultiply(std::span<const float> alpha, Image& image) {
  for (std::size_t i = 0; i < alpha.size(); ++i) {
    if (alpha[i] <= 0) continue;
    for (std::size_t c = 0; c < 3; ++c) image.rgb[3 * i + c] *= alpha[i];
  }
}

void WriteExr(const std::string& path, const Picture& picture) { WriteExr(path, picture, {}); }

std::string EncodePng(const Picture& picture) {
  const int width = picture.image.width, height = picture.image.height;
  const auto bytes_of = [&](const Image& image) {
    return ToneMap(InRec709(image, picture.space), picture.tone);
  };
  return ArenaOf(picture.format.threads).execute([&] {
    if (picture.alpha.empty()) return EncodePng(width, height, bytes_of(picture.image));
    if (!picture.composite.rgb.empty()) {
      return EncodePng(width, height, bytes_of(picture.composite));
    }
    return EncodePng(width, height, bytes_of(Straight(picture)), ToBytes(picture.alpha));
  });
}

void WritePng(const std::string& path, const Picture& picture) {
  WriteFileAtomically(path, EncodePng(picture));
}

void WriteExrAndPng(const std::string& exr, const Picture& picture) {
  WriteExr(exr, picture, [&] { WritePng(PngBeside(exr), picture); });
}

std::string PngBeside(const std::string& exr) {
  return std::filesystem::path(exr).replace_extension(".png").string();
}

std::string CheckpointBeside(const std::string& output) {
  return NameBeside(output, ".checkpoint");
}

}  // namespace skywave
