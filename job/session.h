// A session renders a job to the end that its limits give. It keeps checkpoints, from which another
// session goes on to the same bytes, and shows snapshots on the way.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "job/film_file.h"
#include "job/job.h"
#include "job/limits.h"
#include "job/picture.h"
#include "job/watch.h"

namespace skywave {

struct CheckpointRequest {
  std::string path;     // empty: no checkpoints are kept
  double seconds = 0;   // between two of them; 0: only when the session is stopped
  bool resume = false;  // go on from `path` if it exists
};

struct SessionRequest {
  RenderLimits limits;
  CheckpointRequest checkpoint;
  // Called about ten times a second by the thread that runs the session. If it returns false or
  // throws, the session saves a checkpoint, if it keeps any, and throws RenderCanceled or that.
  Teller tell;
  // Called as often. If it returns true, `show` gets the current film, with all threads at rest.
  std::function<bool()> wants_snapshot;
  std::function<void(const Film& film, const SampleCounts& samples)> show;
  // Called by the thread that has finished a tile of a step, of which `film` then holds `samples`
  // (RenderControl::on_tile).
  std::function<void(const Film& film, const Tile& tile, const SampleCounts& samples)> on_tile;
  // If set, gets all rows [first, end) of the picture once, when they have all of their samples,
  // from any thread. If nothing else needs them, the film then frees them.
  std::function<void(const Film& film, const SampleCounts& samples, int first, int end)> on_rows;
};

// What a session has rendered.
struct RenderedFilm {
  Film film;
  bool has_film = true;  // else the film has freed its rows
  PicturePart part;
  SampleCounts samples;  // of the pixels of the film; those of the part are the most
  FrameResult frame;
  double seconds = 0;              // of rendering, sessions before this one included
  std::vector<std::string> notes;  // what went wrong without ending the render, for the user
  std::optional<double> noise;     // Film::Noise, if the film keeps the variance
};

// Renders. `identity` is that of the job's picture. A checkpoint that exists at the end stays until
// the caller has written what was rendered. Throws InputError for a checkpoint of something else,
// and RenderCanceled. If a checkpoint cannot be written, that is a note while rendering and the
// error at a stop; after an error, that error is thrown instead.
RenderedFilm RunSession(const RenderJob& job, const PictureIdentity& identity,
                        const SessionRequest& request);

// Writes the film of a session, which it has, as a part of its picture. Throws InputError for one
// whose blocks were to end apart: what it holds is no part.
void WriteFilm(const std::string& path, const PictureIdentity& identity, AovSet layers,
               const RenderedFilm& rendered);

}  // namespace skywave
