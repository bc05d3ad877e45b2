// A clean picture from the layers of a noisy one: by the statistics of its samples, without network
// and training, by Open Image Denoise, or by a mean of both. kernels/cross_filter.h has the filter
// of the first; here are the planes that all of them work on.
//
// The samples of a pixel come in two halves, which are cleaned one by one: the network sees one
// half alone, and the filter of statistics takes the weights of one half from the other one. So one
// half says how wrong the other one is. This is the error that every picture has, and by which
// means of pictures are weighted.
//
// What is filtered is the light that falls on surfaces: the picture divided by the albedo of what
// the pixel shows, so textures stay as they are. Outliers, single samples that are far too bright,
// are found by comparing the halves of the samples: one half has them, and the other half has
// nothing as bright in the pixels around. Their excess is spread over the surface around them, so
// energy is kept.
//
// Statistics are local: a pixel depends on those at most 28 pixels away, and near outliers on those
// at most 100 pixels away. Their bytes do not depend on threads, tiles or instruction sets, nor do
// those of Open Image Denoise on threads.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "image/image.h"
#include "job/denoise/denoised.h"
#include "job/denoise/denoiser.h"
#include "job/denoise/input.h"

namespace skywave {

// The attribute of a picture that has this version.
inline constexpr char kOidnVersion[] = "openImageDenoise";

// Returns kBest or kStatistics for kAuto, by what is there, and others as they are. Throws
// OptionError where Open Image Denoise is needed and not there.
Denoiser ResolveDenoiser(Denoiser by);

// Returns the clean picture by a method that is resolved. `layers` are channels by the names of
// DenoiserChannels, in any order, and may be others too; groups of lights are clean if the noise is
// that of the whole picture. Throws InputError about `name` if one is
// missing or has another size, if a value is not finite, or where a pixel has too few samples.
Denoised Denoise(Denoiser by, const std::string& name, const Image& image,
                 std::span<const NamedChannel> layers, const NoiseLayers& noise = {});

// Returns lines that say what was done with outliers, and where the best comes from.
std::vector<std::string> NotesOf(const Denoised& denoised);

}  // namespace skywave
