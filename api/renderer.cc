// Implements Renderer: one picture from the options to the film, and what is taken from it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "api/errors.h"
#include "api/state.h"
#include "base/clock.h"
#include "base/version.h"
#include "job/options.h"
#include "job/watch.h"
#include "measure/render_report.h"
#include "scene/embree.h"

namespace skywave::api {
namespace {

// Returns the layers of channels named "albedo.R", "albedo.G", ..., in the order of the channels.
std::vector<Layer> LayersOf(const std::vector<NamedChannel>& channels) {
  std::vector<Layer> layers;
  for (const NamedChannel& channel : channels) {
    const std::size_t dot = channel.name.rfind('.');
    const std::string name = channel.name.substr(0, dot);
    if (layers.empty() || layers.back().name != name) layers.push_back({name, ""});
    layers.back().channels += channel.name.substr(dot + 1);
  }
  return layers;
}

void CheckSize(std::span<float> values, std::size_t needed, const std::string& name) {
  Require(values.size() == needed, name,
          fmt::format("has room for {} floats, and {} are needed", values.size(), needed));
}

// Returns the command that repeats the picture and its PNG. It has nothing that changes from run to
// run.
std::string RepeatCommand(const Renderer::State& state) {
  static const ExposureRequest defaults;
  std::string text = "skywave render" + PictureOptions(state.job->request());
  for (const OptionOf<ExposureRequest>& option : ExposureOptions()) {
    if (option.get(state.exposure) != option.get(defaults)) {
      text += CommandWords(option, state.exposure);
    }
  }
  return text;
}

Metadata Provenance(const Renderer::State& state) {
  const RenderJob& job = *state.job;
  Metadata metadata = {{"software", fmt::format("skywave {}", skywave::Version())},
                       {"samples", fmt::format("{}", job.options().samples_per_pixel)},
                       {"seed", fmt::format("{}", job.options().seed)},
                       {"sceneHash", fmt::format("{:016x}", job.scene_hash())}};
  if (state.repeatable) metadata.emplace_back("command", RepeatCommand(state));
  return metadata;
}

// Returns the notes of the job and of the exposure.
std::vector<std::string> Notes(const Renderer::State& state) {
  std::vector<std::string> notes = state.job->notes();
  if (state.exposure.photo.shutter_seconds > 0) {
    notes.push_back(fmt::format("the PNG is exposed for EV100 {:.2f}: white is {:.4g} cd/m^2",
                                ExposureValue100(state.exposure.photo),
                                std::exp2(-Tone(state.exposure).exposure_stops)));
  }
  return notes;
}

RenderReport Report(const Renderer::State& state) {
  return {.job = &*state.job, .frame = state.frame, .write_seconds = state.write_seconds};
}

}  // namespace

std::string Version() {
  return fmt::format("{} (Embree {})", skywave::Version(), RTC_VERSION_STRING);
}

std::vector<BoundOption> BindJobOptions(const std::shared_ptr<JobRequest>& request) {
  std::vector<BoundOption> bound;
  for (const JobOption& option : JobOptions()) {
    if (!option.positional && !IsReadOption(option)) bound.push_back(Bind(option, request));
  }
  return bound;
}

RenderJob MakeJob(Scene::State scene, JobRequest request) {
  request.scene = scene.name();
  request.read = scene.read;
  if (request.environment.path.empty()) request.environment.image = scene.environment;
  return RenderJob(std::move(scene.scene), request, scene.load_seconds);
}

Renderer::Renderer(Scene scene, const Options& options) : state_(std::make_unique<State>()) {
  Translated([&] {
    const auto request = std::make_shared<JobRequest>();
    const auto exposure = std::make_shared<ExposureRequest>();
    std::vector<BoundOption> bound = BindJobOptions(request);
    for (const OptionOf<ExposureRequest>& option : ExposureOptions()) {
      bound.push_back(Bind(option, exposure));
    }
    SetOptions(bound, options);
    state_->exposure = *exposure;
    state_->repeatable = !scene.state().changed;
    state_->job.emplace(MakeJob(std::move(scene.state()), *request));
    state_->notes = Notes(*state_);
  });
}

Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;
Renderer::~Renderer() = default;

int Renderer::width() const { return state_->job->options().width; }
int Renderer::height() const { return state_->job->options().height; }
std::uint64_t Renderer::samples() const {
  const RenderOptions& options = state_->job->options();
  return std::uint64_t(options.width) * std::uint64_t(options.height) * options.samples_per_pixel;
}
const std::vector<Layer>& Renderer::layers() const { return state_->layers; }
const std::vector<std::string>& Renderer::notes() const { return state_->notes; }

void Renderer::Render(const ProgressCallback& progress) {
  State& state = *state_;
  state.picture.reset();
  state.write_seconds = 0;
  Translated([&] {
    Film film = state.job->MakeFilm();
    const RenderOptions& options = state.job->options();
    Watch(
        samples(),
        [&](Progress& done) { state.frame = RenderFrame(state.job->frame(), film, &done); },
        progress);
    state.channels = film.ResolveAovs(options.samples_per_pixel);
    state.layers = LayersOf(state.channels);
    state.picture = film.Resolve(options.samples_per_pixel);
  });
}

const skywave::Image& Renderer::State::finished() const {
  Require(picture.has_value(), "Renderer", "there is no picture yet; call Render first");
  return *picture;
}

void Renderer::CopyPicture(std::span<float> rgb) const {
  const std::vector<float>& picture = state_->finished().rgb;
  CheckSize(rgb, picture.size(), "rgb");
  std::copy(picture.begin(), picture.end(), rgb.begin());
}

void Renderer::CopyLayer(const std::string& name, std::span<float> values) const {
  const std::size_t pixels = state_->finished().rgb.size() / 3;
  const auto layer = std::find_if(state_->layers.begin(), state_->layers.end(),
                                  [&](const Layer& candidate) { return candidate.name == name; });
  Require(layer != state_->layers.end(), "layer",
          fmt::format("there is no '{}'; the option aovs asks for layers", name));
  const std::size_t channels = layer->channels.size();
  CheckSize(values, pixels * channels, "values");
  for (std::size_t c = 0; c < channels; ++c) {
    const std::string wanted = name + '.' + layer->channels[c];
    const auto channel =
        std::find_if(state_->channels.begin(), state_->channels.end(),
                     [&](const NamedChannel& candidate) { return candidate.name == wanted; });
    for (std::size_t i = 0; i < pixels; ++i) values[i * channels + c] = channel->values[i];
  }
}

std::string Renderer::Statistics() const {
  return Translated([&] {
    state_->finished();
    return Json(Report(*state_)).dump(2) + "\n";
  });
}

std::string Renderer::Summary() const {
  return Translated([&] {
    state_->finished();
    return Table(Report(*state_));
  });
}

void Renderer::WriteExr(const std::string& path) const {
  Translated([&] {
    const Clock::time_point start = Clock::now();
    skywave::WriteExr(path, state_->finished(), Provenance(*state_), state_->channels);
    state_->write_seconds += SecondsSince(start);
  });
}

void Renderer::WritePng(const std::string& path) const {
  Translated([&] {
    const Clock::time_point start = Clock::now();
    const skywave::Image& picture = state_->finished();
    skywave::WritePng(path, picture.width, picture.height,
                      ToneMap(picture, Tone(state_->exposure)));
    state_->write_seconds += SecondsSince(start);
  });
}

std::string Renderer::EncodePng() const {
  return Translated([&] {
    const skywave::Image& picture = state_->finished();
    return skywave::EncodePng(picture.width, picture.height,
                              ToneMap(picture, Tone(state_->exposure)));
  });
}

}  // namespace skywave::api
