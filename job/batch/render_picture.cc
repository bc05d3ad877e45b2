#include "job/batch/render_picture.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <utility>

#include "base/clock.h"
#include "base/error.h"
#include "base/files.h"
#include "base/granted.h"
#include "base/spare_threads.h"
#include "image/formats.h"
#include "job/job.h"
#include "job/picture.h"
#include "job/session.h"
#include "wavefront/film/aovs.h"

namespace skywave {
namespace {

// Returns the words of the limits under which a render may end early; empty without any.
std::string LimitWords(const RenderLimits& limits) {
  std::string words;
  static const RenderLimits defaults;
  for (const OptionOf<RenderLimits>& option : LimitOptions()) {
    if (option.get(limits) != option.get(defaults)) words += CommandWords(option, limits);
  }
  return words;
}

std::string ValueOf(const Metadata& metadata, std::string_view name) {
  for (const auto& [key, text] : metadata) {
    if (key == name) return text;
  }
  return "";
}

// Returns whether the files of a picture are those that the job would make.
bool IsFinished(const std::string& exr, const RenderJob& job, const PictureIdentity& identity,
                const RenderLimits& limits) {
  if (!std::filesystem::exists(exr) || !std::filesystem::exists(PngBeside(exr))) return false;
  try {
    const Metadata metadata = ReadExrMetadata(exr, {.trust_input = true});
    SampleRange samples = ChooseSamples(limits, identity.samples);
    // A render under limits may have ended with any number of samples.
    if (limits.end_early()) {
      samples.end = samples.first + std::uint32_t(std::stoul(ValueOf(metadata, "samples")));
    }
    return ValueOf(metadata, "software") == identity.software &&
           ValueOf(metadata, "sceneHash") == fmt::format("{:016x}", identity.scene_hash) &&
           ValueOf(metadata, "limits") == LimitWords(limits) &&
           ValueOf(metadata, "command") == RepeatCommand(identity, PartOf(job, samples));
  } catch (const std::exception&) {
    return false;  // not a picture of this program
  }
}

std::string HashText(const std::string& bytes) {
  return fmt::format("{:016x}", XXH3_64bits(bytes.data(), bytes.size()));
}

// Writes both files and reads back the EXR, by which a finished picture is known. Returns its hash.
std::string WriteAndReadBack(const std::string& exr, const Picture& picture) {
  WriteExrAndPng(exr, picture);
  const std::string bytes = ReadFile(exr);
  DecodeExr(exr, bytes, {.trust_input = true});
  return HashText(bytes);
}

// One film, however large, may always be written while the next picture is rendered.
constexpr std::uint64_t kMostWritingBytes = std::uint64_t{1} << 28;

// A batch leaves most of the memory to others: pictures that follow each other have most in common.
std::uint64_t CacheBytes(const PictureSettings& settings) {
  if (settings.cache_bytes > 0) return settings.cache_bytes;
  return std::min<std::uint64_t>(GrantedHere().memory_bytes / 10, std::uint64_t{2} << 30);
}

}  // namespace

PictureRenderer::PictureRenderer(const BatchPlan& plan, const PictureSettings& settings)
    : plan_(plan), settings_(settings), cache_(CacheBytes(settings), CacheBytes(settings) / 4) {}

PictureRenderer::~PictureRenderer() {
  if (next_ready_.valid()) next_ready_.wait();
  std::unique_lock lock(room_mutex_);
  room_made_.wait(lock, [this] { return writing_bytes_ == 0; });
}

PictureRenderer::Ready PictureRenderer::Read(const BatchPicture& picture) try {
  const Clock::time_point start = Clock::now();
  Ready ready = {.request = RequestOf(plan_.path, picture.options)};
  const FilesRead inputs;
  ready.job = std::make_unique<RenderJob>(ready.request.job, &cache_);
  ready.inputs = inputs.names();
  ready.identity = IdentityOf(*ready.job, ready.request.exposure, true, ready.request.limits);
  ready.load_seconds = SecondsSince(start);
  return ready;
} catch (const OptionError& error) {
  throw AtOption(plan_.path, picture.options, error);
}

std::shared_ptr<void> PictureRenderer::TakeRoom(std::uint64_t bytes) {
  std::unique_lock lock(room_mutex_);
  room_made_.wait(
      lock, [&] { return writing_bytes_ == 0 || writing_bytes_ + bytes <= kMostWritingBytes; });
  writing_bytes_ += bytes;
  return {this, [bytes](PictureRenderer* renderer) {
            const std::lock_guard guard(renderer->room_mutex_);
            renderer->writing_bytes_ -= bytes;
            renderer->room_made_.notify_all();
          }};
}

std::future<PictureResult> PictureRenderer::Render(const BatchPicture& picture,
                                                   const BatchPicture* next,
                                                   const PictureWatcher& watcher) try {
  const Ready ready = next_ == &picture ? next_ready_.get() : Read(picture);
  if (next_ready_.valid()) next_ready_.wait();  // that of a picture that nobody has asked for
  next_ = next;
  if (next != nullptr) {
    next_ready_ = OnSpareThread([this, next] { return Read(*next); });
  }
  const RenderJob& job = *ready.job;
  const RenderLimits& limits = ready.request.limits;
  inputs_.insert(ready.inputs.begin(), ready.inputs.end());
  PictureResult result = {.status = PictureStatus::kSkipped, .load_seconds = ready.load_seconds};
  const std::string checkpoint = CheckpointBeside(picture.output);
  if (!settings_.force && IsFinished(picture.output, job, ready.identity, limits)) {
    // It was left by a run that was killed right after the picture was complete.
    std::filesystem::remove(checkpoint);
    result.hash = HashText(ReadFile(picture.output));
    return Known(std::move(result));
  }
  for (const std::string& output : {picture.output, PngBeside(picture.output)}) {
    for (const std::string& input : inputs_) CheckNotInput(output, input);
  }
  const RenderOptions& options = job.options();
  CheckFormat(ready.request.format, options.aovs);
  result.status = PictureStatus::kRendered;
  result.warnings = job.warnings(), result.notes = job.notes();
  if (watcher.begin) {
    const std::uint64_t samples = std::uint64_t(options.width) * std::uint64_t(options.height) *
                                  ChooseSamples(limits, options.samples_per_pixel).count();
    watcher.begin(limits.adaptive > 0 ? 0 : samples);  // their number is not known beforehand
  }
  RenderedFilm rendered = RunSession(
      job, ready.identity,
      {.limits = limits,
       .checkpoint = {.path = checkpoint, .seconds = settings_.checkpoint_seconds, .resume = true},
       .tell = watcher.tell});
  result.render_seconds = rendered.seconds;
  result.samples = rendered.frame.stats.samples;
  result.noise = rendered.noise;
  result.notes.insert(result.notes.end(), rendered.notes.begin(), rendered.notes.end());
  const std::size_t film_bytes = rendered.film.packed_bytes();
  auto write = [room = TakeRoom(film_bytes), result = std::move(result),
                rendered = std::move(rendered), identity = ready.identity, aovs = options.aovs,
                format = ready.request.format, threads = options.threads,
                limit_words = LimitWords(limits), exr = picture.output, checkpoint]() mutable {
    // The future would keep both until its result is taken.
    const std::shared_ptr<void> held = std::move(room);
    const RenderedFilm source = std::move(rendered);
    const Clock::time_point start = Clock::now();
    Picture resolved =
        ResolvePicture(source.film, source.samples, aovs, identity, source.part, threads);
    resolved.format = format;
    resolved.format.threads = threads;
    result.notes.insert(result.notes.end(), resolved.notes.begin(), resolved.notes.end());
    if (!limit_words.empty()) resolved.metadata.emplace_back("limits", limit_words);
    result.hash = WriteAndReadBack(exr, resolved);
    std::filesystem::remove(checkpoint);
    result.write_seconds = SecondsSince(start);
    return std::move(result);
  };
  return OnSpareThread(std::move(write));
} catch (const OptionError& error) {
  throw AtOption(plan_.path, picture.options, error);
}

}  // namespace skywave
