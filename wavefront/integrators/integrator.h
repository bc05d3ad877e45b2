// The integrators: each one flat stage order over the tables of a worker. These functions are the
// documentation of what is computed; the stages say how.
#pragma once

#include "wavefront/film/film.h"
#include "wavefront/frame.h"
#include "wavefront/stages/path_stages.h"
#include "wavefront/stages/stages.h"
#include "wavefront/worker.h"

namespace skywave {

struct PhotonList;
struct PhotonLists;
struct WantedPhotons;

// By the integrator of the frame's options, whose tables the worker has.
void RenderWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film);

// Unidirectional path tracing (T 4.2.3, P 3): one light sample a bounce, BSDF sampling, both
// combined by multiple importance sampling, Russian roulette from the fourth bounce on, at most
// max_depth surfaces a path.
void RenderPathWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film);

// Path tracing from a bounce on: rays [0, n) of worker.rays[0] arrive at `bounce`, coming from
// `first`. Returns the bounce at which the last path ended. `film`: keeps what KeepAovs says of
// paths that begin at the camera; null for others.
std::uint32_t FollowPaths(const FrameView& frame, const Departure& first, std::uint32_t n,
                          std::uint32_t bounce, Worker& worker, Film* film, StageClock& clock);

// Path tracing that splits (T fig. 8.26, the integrator PT2): at the first surface that is no
// mirror or glass a path takes all its direct light, light_samples light samples, and goes on as
// `split` continuations, whose mean is its indirect light. Continuations are paths like those of
// RenderPathWave; their light samples are of the frame's strategy for continuations.
void RenderSplitWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film);

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
// (kernels/light_paths/bidirectional.h). At most max_depth surfaces over both; roulette as in path
// tracing. Vertex connection and merging (Georgiev, Krivanek, Davidovic and Slusallek 2012) is the
// same with one way more at every surface of the eye: it is merged with the light vertices near it,
// those of a first pass (photons of the frame), where frame.merged is not 0.
void RenderBdptWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film);

// Photon mapping (Jensen 1996, T 4.3), second pass: direct light as in RenderDirectWave; at the
// surfaces that take light samples, caustics by the caustic map, and other light by the indirect
// map: looked up there, or where the rays of a final gather meet the next ones. BSDFs with a
// density, however narrow their lobe, count as diffuse; mirrors and glass as specular. At most
// max_depth surfaces on both sides of a photon together.
void RenderPhotonWave(const FrameView& frame, const WaveRange& range, Worker& worker, Film& film);

// Its first pass: light paths [first, first + count) of the frame, stored at surfaces with a
// density in the lists that `wishes` names, in the order (path, surface).
void TracePhotonWave(const FrameView& frame, std::uint64_t first, std::uint32_t count,
                     const WantedPhotons& wanted, Worker& worker, PhotonLists& lists);

// The first pass of vertex connection and merging: the vertices with a density of light sub-paths
// [first, first + count) of the frame, in the order (path, surface), with what weights need.
void TraceVertexWave(const FrameView& frame, std::uint64_t first, std::uint32_t count,
                     Worker& worker, PhotonList& list);

}  // namespace skywave
