// A picture as files: what decides its bytes, the part of it that has been rendered, and the EXR
// and PNG with what they record of both.
#pragma once

#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "image/image.h"
#include "job/exposure.h"
#include "job/job.h"
#include "job/limits.h"
#include "job/options.h"

namespace skywave {

// Samples of the pixels of a window of the whole film.
struct PicturePart {
  CropWindow window;
  SampleRange samples;
};

// What decides the bytes of a picture. Two parts with the same identity belong together.
struct PictureIdentity {
  std::string software;          // "skywave 0.1.0"
  std::string scene;             // its name, for people
  std::uint64_t scene_hash = 0;  // with camera and lights
  std::uint64_t map_hash = 0;    // of the map alone
  CropWindow film;               // the whole film
  std::uint32_t samples = 0;     // per pixel of the whole picture
  std::uint32_t seed = 0;
  bool repeatable = true;               // a command makes the same picture
  std::vector<RecordedOption> options;  // in the order of the tables, without those of the part
  std::string backplate = "";           // the file that is behind the picture; empty: none
};

// Returns the identity of the picture of a job. If not repeatable, no file has its scene. Of the
// limits, those count that give pixels different numbers of samples.
PictureIdentity IdentityOf(const RenderJob& job, const ExposureRequest& wanted, bool repeatable,
                           const RenderLimits& limits = {});

// Returns whether pixels of the picture may have different numbers of samples.
bool IsAdaptive(const PictureIdentity& identity);

// Returns the part of the picture that the options of the job ask for, with these samples.
PicturePart PartOf(const RenderJob& job, const SampleRange& samples);

// Returns the command that renders a part of the picture, which has nothing that changes from run
// to run.
std::string RepeatCommand(const PictureIdentity& identity, const PicturePart& part);

// Returns the value in the words of an option, or "not given" where there are none.
std::string ValueOf(const RecordedOption& option);

// Returns half a sentence that says how two pictures differ, "`spp` is 4 here and 8 there", or
// nothing if they are the same. Names of files do not matter, what is in them does.
std::string Difference(const PictureIdentity& here, const PictureIdentity& there);

// Returns how the picture is denoised.
Denoiser DenoiserOf(const PictureIdentity& identity);

// Returns the space of its colours.
RgbSpace SpaceOf(const PictureIdentity& identity);

// Returns whether the picture has alpha.
bool IsTransparent(const PictureIdentity& identity);

// Returns the layers that are resolved where `layers` are shown: those, and what the denoiser and
// an automatic exposure read.
AovSet LayersToResolve(AovSet layers, const PictureIdentity& identity);

// Returns whether a channel is one that denoising adds to a picture: "error" or "noisy".
bool IsOfDenoiser(std::string_view channel);

struct Picture {
  Image image;
  // Share of what is behind each pixel that it hides; colours are multiplied by it. Empty: all.
  std::vector<float> alpha;
  Image composite;  // what the PNG shows: the picture over its backplate; empty: the picture
  std::vector<NamedChannel> layers;
  std::vector<std::string> notes;  // what was done to it, for the user
  Metadata metadata;
  Placement placement;                 // in the whole film, unless it shows all of that
  RgbSpace space = RgbSpace::kRec709;  // of all colours; those of the PNG are of Rec. 709
  ToneMapping tone;                    // of the PNG
  ExrFormat format;                    // its number of threads is that of the PNG, too
};

// Returns the picture that `film` holds. `part` names its samples; `samples` counts them. `layers`
// are those to show. A picture that is denoised has the layer "error" too, and "noisy" where
// `layers` have all that the denoiser reads; one of too few samples, such as a snapshot of a render
// that has only begun, stays noisy, with a note.
// `threads` are those of the denoiser; 0: as many as the process may use.
Picture ResolvePicture(const Film& film, const SampleCounts& samples, AovSet layers,
                       const PictureIdentity& identity, const PicturePart& part, int threads = 0);

// A picture whose rows are resolved one after the other, so that its film may free them.
class PictureRows {
 public:
  // `layers` are those to show.
  PictureRows(AovSet layers, const PictureIdentity& identity);
  // Resolves rows [first, end). Several threads may call this with different rows at the same time.
  void Add(const Film& film, const SampleCounts& samples, int first, int end);
  // Returns the current picture: the rows that are not there yet are those of `film`. Nothing may
  // be added meanwhile.
  LayeredImage With(const Film& film, const SampleCounts& samples) const;
  // Returns the picture when all rows are there.
  LayeredImage Take() { return std::move(picture_); }

 private:
  AovSet layers_;  // those to show, and those of the denoiser
  std::once_flag begun_;
  LayeredImage picture_;
  std::vector<char> is_there_;  // by row
};

// Returns what ResolvePicture returns, of rows that have been resolved.
Picture FinishPicture(LayeredImage resolved, AovSet layers, const PictureIdentity& identity,
                      const PicturePart& part, int threads = 0);

// Returns the metadata of a picture for another one that is made of it: its command, which does not
// repeat that, is called `command` there, and what is said of its other layers is left out.
Metadata OfDerived(Metadata metadata, std::string_view command);

// Sets the exposure of the PNG. An automatic exposure is recorded in notes and metadata, where
// ExposureOfDerived finds it.
void Expose(const ExposureRequest& resolved, Picture& picture);

// Returns the exposure of a picture that is made of one with this metadata: automatic where that of
// the other one was and the request says nothing else. Throws OptionError as ResolveExposure does.
ExposureRequest ExposureOfDerived(const ExposureRequest& request, const Metadata& metadata);

// Throws OptionError where the layers would not survive the compression of a format.
void CheckFormat(const ExrFormat& format, AovSet layers);

// Returns the options compression and half.
std::vector<OptionOf<ExrFormat>> ExrFormatOptions();

// Moves the values of a layer out of `layers`; none if it is not there.
std::vector<float> TakeLayer(std::string_view name, std::vector<NamedChannel>& layers);
// Whether the header of an EXR says that its colours are not multiplied by its alpha.
bool IsStraight(const Metadata& metadata);
// Multiplies colours by their alpha, as those of every Picture are; none where that is 0.
void Premultiply(std::span<const float> alpha, Image& image);

// Write the files of a picture. A file that exists is replaced.
void WriteExr(const std::string& path, const Picture& picture);
void WritePng(const std::string& path, const Picture& picture);
// Writes an EXR and the PNG beside it. If either cannot be written, both remain what they were. The
// EXR is replaced last: if it is there, the PNG is too. Where the folder lets the PNG be replaced
// but not the EXR (see WriteFileAtomically), the new PNG is beside the old EXR.
void WriteExrAndPng(const std::string& exr, const Picture& picture);

// Returns the bytes that WritePng writes.
std::string EncodePng(const Picture& picture);

// Returns the name of the PNG beside an EXR.
std::string PngBeside(const std::string& exr);
// The same of the checkpoint of a picture or film.
std::string CheckpointBeside(const std::string& output);

}  // namespace skywave
