// Pictures with catchers, made clean: the light of objects, that of catchers without the objects,
// and what objects change of it (wavefront/film/light_parts.h) are cleaned one by one, each with
// its own noise, and the layers are made of the three as the film makes them of means. So where
// objects change nothing, noisy catchers do not become shadows.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "image/image.h"
#include "job/denoise/denoiser.h"

namespace skywave {

// Returns whether a picture has catchers, by the names of its channels.
bool ShowsCatchers(std::span<const NamedChannel> layers);

// What is to be known of a picture that was cleaned.
struct Cleaning {
  std::vector<NamedChannel> error;  // see Denoised
  std::vector<std::string> notes;   // see NotesOf
  std::string oidn;                 // see Denoised
};

// Replaces a picture by a clean one; see Denoise for errors. `layers` are the channels of
// DenoiserLayers. Of one with catchers the layers shadow, difference, alpha and foreground are
// replaced as well, as far as they are there: with `alpha`, the image is the foreground. Without
// catchers those of groups of lights are (job/denoise/groups.h). What
// objects change has both signs, which Open Image Denoise does not know, so statistics clean that
// whatever the method is.
Cleaning CleanPicture(Denoiser by, const std::string& name, Image& image, std::vector<float>& alpha,
                      std::vector<NamedChannel>& layers);

}  // namespace skywave
