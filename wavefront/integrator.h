// The integrators: each one flat stage order over the tables of a worker. These functions are the
// documentation of what is computed; the stages say how.
#pragma once

#include "wavefront/film.h"
#include "wavefront/frame.h"
#include "wavefront/stages.h"
#include "wavefront/worker.h"

namespace skywave {

// By the integrator of the frame's options, whose tables the worker has.
void RenderWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film);

// Unidirectional path tracing (T 4.2.3, P 3): one light sample a bounce, BSDF sampling, both
// combined by multiple importance sampling, Russian roulette from the fourth bounce on, at most
// max_depth surfaces a path.
void RenderPathWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film);

// Direct light (T 4.2.1): light_samples light samples at the first surface that is no mirror or
// glass, and one BSDF sample against them; mirrors and glass are followed up to max_depth surfaces.
void RenderDirectWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film);

// Light tracing (Arvo 1986; Dutre, Lafortune and Willems 1993): one light path a sample, every
// surface of which is connected to the camera and splatted. Camera rays see the sky and what shines
// itself, and go no further: nothing is seen through mirrors and glass. At most max_depth surfaces
// a path; roulette from the third one on.
void RenderLightWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film);

// Bidirectional path tracing (Lafortune and Willems 1993; Veach and Guibas 1995): each path has a
// sub-path from the camera and one from a light; all their vertices are connected with each other,
// with light samples and with the camera, and weighted by the power heuristic over all of that
// (kernels/bidirectional.h). At most max_depth surfaces over both; roulette as in path tracing.
void RenderBdptWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film);

}  // namespace skywave
