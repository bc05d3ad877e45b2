#include "job/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "base/arena.h"
#include "base/clock.h"
#include "base/error.h"
#include "base/granted.h"

namespace skywave {
namespace {

// What a session knows while it renders.
struct Session {
  const RenderJob& job;
  const PictureIdentity& identity;
  const SessionRequest& request;
  PicturePart part;
  Film film;
  RenderState state = {};
  double seconds_before = 0;  // spent by sessions that this one goes on from
  Clock::time_point start = Clock::now();
  Clock::time_point last_checkpoint = start;
  bool checkpoint_due = false, snapshot_due = false;  // for the next pause
  SampleCounts of_step = 0;                           // in the tiles that it has finished
  bool forgets = false;               // the film frees the rows that the request has received
  std::vector<NoiseSums> noise = {};  // by row of the picture, of a film that frees rows
  // Pixels of a row that are to come, by the first rows of tiles.
  std::unique_ptr<std::atomic<int>[]> missing = {};
  std::vector<std::string> notes = {};

  double seconds() const { return seconds_before + SecondsSince(start); }
};

// Returns the frame with the samples of the part, of which the whole picture has more.
FrameView FrameOf(const Session& session) {
  FrameView frame = session.job.frame();
  frame.options.picture_samples = {0, session.identity.samples};
  frame.options.first_sample = session.part.samples.first;
  frame.options.samples_per_pixel = session.part.samples.count();
  return frame;
}

void SaveCheckpoint(Session& session) {
  session.last_checkpoint = Clock::now();  // also of one that fails
  WriteFilm(session.request.checkpoint.path,
            {.identity = session.identity,
             .window = session.part.window,
             .holds = {},
             .layers = session.job.options().aovs,
             .seconds = session.seconds(),
             .is_checkpoint = true,
             .samples = session.part.samples,
             .state = session.state},
            session.film);
}

// If this checkpoint cannot be written, the one before stays.
void SaveCheckpointOnTheWay(Session& session) {
  try {
    SaveCheckpoint(session);
  } catch (const InputError& error) {
    const std::string note = error.what();
    std::vector<std::string>& notes = session.notes;
    if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(note);
  }
}

// Saves what was rendered before an error, if anything; does not throw.
void SaveCheckpointAfterError(Session& session) {
  const RenderState& state = session.state;
  const bool is_empty = state.step.first == session.part.samples.first &&
                        std::all_of(state.rows.begin(), state.rows.end(),
                                    [](std::uint64_t rows) { return rows == 0; });
  if (!is_empty) SaveCheckpointOnTheWay(session);
}

// Returns whether the rows of a state are those of the tiles of its step.
bool Fits(const RenderState& state, const FrameView& frame, const SampleRange& samples) {
  if (state.step.first < samples.first || state.step.end > samples.end) return false;
  if (!state.ended.empty() && state.ended.size() != CountBlocks(frame.camera)) return false;
  for (const std::uint32_t end : state.ended) {
    if (end != 0 && (end <= samples.first || end > state.step.first)) return false;
  }
  if (state.rows.empty()) return true;
  if (state.tile_side % 8 != 0 || state.tile_side == 0) return false;
  const std::vector<TileOfStep> tiles = CutStep(frame.camera, state);
  if (tiles.size() != state.rows.size()) return false;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    if (state.rows[i] > tiles[i].rows || state.rows[i] % kBeamRays != 0) return false;
  }
  return true;
}

// Puts a checkpoint into the session, if there is one.
void Resume(Session& session) {
  const std::string& path = session.request.checkpoint.path;
  if (!session.request.checkpoint.resume || !std::filesystem::exists(path)) return;
  const FilmInFile saved = ReadFilm(path);
  const auto refuse = [&](const std::string& why) {
    return InputError(InputPosition::File(path),
                      "this checkpoint is of something else: " + why + "; remove it to begin anew");
  };
  if (!saved.file.is_checkpoint) throw refuse("it is a finished film");
  const std::string difference = Difference(session.identity, saved.file.identity);
  if (!difference.empty()) throw refuse(difference);
  if (saved.file.window != session.part.window) throw refuse("it shows another part of the film");
  if (saved.file.samples != session.part.samples) {
    throw refuse(fmt::format("it is to have samples {}, not {}",
                             SampleRanges().print(saved.file.samples),
                             SampleRanges().print(session.part.samples)));
  }
  if (saved.film.packed_bytes() != session.film.packed_bytes()) {
    throw refuse(
        "it keeps other layers; with `noise` and `adaptive` a film keeps the variance too");
  }
  if (!Fits(saved.file.state, FrameOf(session), session.part.samples)) {
    throw refuse("its position does not exist in this render");
  }
  session.film.UnpackPicture(saved.film.PackPicture());
  session.state = saved.file.state;
  session.seconds_before = saved.file.seconds;
}

// Returns whether nobody needs rows that have all of their samples.
bool MayForget(const SessionRequest& request, const FilmLayout& layout) {
  return request.on_rows && request.checkpoint.path.empty() && !request.limits.end_early() &&
         !layout.shared;
}

// Throws InputError if a film, as far as it is kept, and its picture, of which `layers` are
// resolved, need more memory than the process may use.
void CheckMemory(const std::string& scene, const FilmLayout& layout, bool forgets, AovSet layers) {
  const double film_pixels = double(layout.area.width) * layout.area.height;
  const double pixels = double(layout.area.picture.width) * layout.area.picture.height;
  const PixelBytes bytes = Film::BytesOfPixel(layout);
  const double film = film_pixels * double(forgets ? bytes.at_first : bytes.kept);
  const std::size_t channels = 3 + ChannelCount(layers, layout.light_groups.size());
  const double needed = film + pixels * double(channels * sizeof(float));
  const double granted = double(GrantedHere().memory_bytes);
  if (needed <= granted) return;
  throw InputError(
      InputPosition::File(scene),
      fmt::format("a film of {} x {} pixels and its picture need {:.0f} MiB, and this process may "
                  "use {:.0f} MiB ({}); render it in parts or with fewer layers",
                  layout.area.picture.width, layout.area.picture.height, needed / (1 << 20),
                  granted / (1 << 20), GrantedHere().memory_from));
}

bool KeepsVariance(const Session& session) {
  return Sums(session.film.layout().aovs, AovSum::kVariance);
}

// Called by the thread that has finished a tile of the last step. The last of the tiles side by
// side passes on their rows.
void FinishTile(Session& session, const Tile& tile, const SampleCounts& samples) {
  const int width = int(tile.width), first = int(tile.y), end = first + int(tile.height);
  if (session.missing[tile.y].fetch_sub(width) != width) return;
  const CropWindow& picture = session.film.layout().area.picture;
  const int first_row = std::max(first - picture.y, 0);
  const int end_row = std::min(end - picture.y, picture.height);
  if (first_row < end_row) {
    session.request.on_rows(session.film, samples, first_row, end_row);
    if (KeepsVariance(session)) {
      const std::vector<NoiseSums> rows = session.film.NoiseOfRows(samples, first_row, end_row);
      std::copy(rows.begin(), rows.end(), session.noise.begin() + first_row);
    }
  }
  session.film.Forget(first, end);
}

// Called by the rendering thread while all others rest.
void Pause(Session& session) {
  if (std::exchange(session.snapshot_due, false)) {
    session.request.show(session.film, SamplesByPixel(FrameOf(session), session.state));
  }
  if (std::exchange(session.checkpoint_due, false)) SaveCheckpointOnTheWay(session);
}

// Called by the watching thread: requests a pause if there is something to do.
void AskForPause(Session& session, Progress& progress) {
  if (progress.pause) return;  // the last one is not over
  const SessionRequest& request = session.request;
  if (request.wants_snapshot && request.wants_snapshot()) session.snapshot_due = true;
  if (request.checkpoint.seconds > 0 &&
      SecondsSince(session.last_checkpoint) >= request.checkpoint.seconds) {
    session.checkpoint_due = true;
  }
  if (session.snapshot_due || session.checkpoint_due) progress.pause = true;
}

// Has finished tiles reported once the film holds all samples before `end`.
void CountSamplesOfStep(Session& session, const FrameView& frame, std::uint32_t end) {
  if (!session.request.on_tile) return;
  session.of_step = SamplesByPixel(
      frame, {.step = {end, end}, .tile_side = 0, .rows = {}, .ended = session.state.ended});
}

// Has blocks of the render end apart.
void SampleAdaptively(Session& session, const FrameView& frame, Progress& progress,
                      RenderControl& control) {
  const std::uint64_t all = std::uint64_t(frame.options.width) *
                            std::uint64_t(frame.options.height) * frame.options.samples_per_pixel;
  control.end_blocks = [&session, &frame, &progress, all](RenderState& state) {
    const double spared =
        EndBlocks(session.request.limits, session.part.samples, frame, session.film, state);
    progress.spared = std::uint64_t(spared * double(all));
  };
  control.next_stop = [&session, &frame, rule = control.next_stop](std::uint32_t done) {
    const std::uint32_t stop = rule(done);
    CountSamplesOfStep(session, frame, stop);
    return stop;
  };
  CountSamplesOfStep(session, frame, session.state.step.end);  // of a step that goes on
}

// Renders what is missing, watched by the calling thread.
FrameResult Render(Session& session) {
  const SessionRequest& request = session.request;
  const FrameView frame = FrameOf(session);
  const auto seconds = [&] { return session.seconds(); };
  Progress progress;
  RenderControl control = {.progress = &progress,
                           .at_pause = [&](const RenderState&) { Pause(session); }};
  if (request.limits.end_early()) {
    control.next_stop = StopRule(request.limits, session.part.samples, session.film, seconds);
  }
  const bool adaptive = request.limits.adaptive > 0;
  if (adaptive) SampleAdaptively(session, frame, progress, control);
  if (session.forgets) {
    const FilmArea& area = session.film.layout().area;
    session.noise.resize(std::size_t(area.picture.height));
    session.missing = std::make_unique<std::atomic<int>[]>(std::size_t(area.height));
    for (int y = 0; y < area.height; ++y) session.missing[std::size_t(y)] = area.width;
  }
  if (request.on_tile || session.forgets) {
    control.on_tile = [&](const Tile& tile, std::uint32_t done) {
      const SampleCounts all = done - session.part.samples.first;
      if (request.on_tile) request.on_tile(session.film, tile, adaptive ? session.of_step : all);
      if (session.forgets && done == session.part.samples.end) FinishTile(session, tile, all);
    };
  }
  FrameResult result;
  const auto work = [&](Progress&) {
    result = RenderFrame(frame, session.film, session.state, control);
  };
  const RenderOptions& options = frame.options;
  const bool asks = request.wants_snapshot || request.checkpoint.seconds > 0;
  const Teller tell = [&](double done) {
    AskForPause(session, progress);
    return !request.tell || request.tell(done);
  };
  Watch(progress,
        std::uint64_t(options.width) * std::uint64_t(options.height) * options.samples_per_pixel,
        work, asks || request.tell ? tell : Teller());
  return result;
}

}  // namespace

RenderedFilm RunSession(const RenderJob& job, const PictureIdentity& identity,
                        const SessionRequest& request) {
  const AovSet more = LayersForLimits(request.limits, job.options().integrator);
  const AovSet resolved = LayersToResolve(job.options().aovs, identity);
  const FilmLayout layout = job.LayoutOfFilm(job.options().integrator, more | resolved);
  const bool forgets = MayForget(request, layout);
  CheckMemory(identity.scene, layout, forgets, resolved);
  Session session = {.job = job,
                     .identity = identity,
                     .request = request,
                     .part = PartOf(job, ChooseSamples(request.limits, identity.samples)),
                     .film = Film(layout),
                     .forgets = forgets};
  Resume(session);
  FrameResult frame;
  try {
    frame = Render(session);
  } catch (const RenderCanceled&) {
    if (!request.checkpoint.path.empty()) SaveCheckpoint(session);
    throw;
  } catch (...) {
    // Whatever ended the render, the state describes what the film holds.
    if (!request.checkpoint.path.empty()) SaveCheckpointAfterError(session);
    throw;
  }
  SampleCounts samples = frame.samples_per_pixel;
  if (request.limits.adaptive > 0) samples = SamplesByPixel(FrameOf(session), session.state);
  session.part.samples.end = session.part.samples.first + frame.samples_per_pixel;
  std::optional<double> noise;
  if (KeepsVariance(session)) {
    noise = session.forgets ? Film::Noise(session.noise) : session.film.Noise(samples);
  }
  if (request.on_rows && !session.forgets) {
    ArenaOf(job.options().threads).execute([&] {
      request.on_rows(session.film, samples, 0, layout.area.picture.height);
    });
  }
  return {.film = std::move(session.film),
          .has_film = !session.forgets,
          .part = session.part,
          .samples = std::move(samples),
          .frame = frame,
          .seconds = session.seconds(),
          .notes = std::move(session.notes),
          .noise = noise};
}

void WriteFilm(const std::string& path, const PictureIdentity& identity, AovSet layers,
               const RenderedFilm& rendered) {
  assert(rendered.has_film);
  if (IsAdaptive(identity)) {
    throw InputError(InputPosition::File(path),
                     "films are added where all pixels have the same samples, so none is kept with "
                     "`adaptive`");
  }
  WriteFilm(path,
            {.identity = identity,
             .window = rendered.part.window,
             .holds = {rendered.part},
             .layers = layers,
             .seconds = rendered.seconds},
            rendered.film);
}

}  // namespace skywave
