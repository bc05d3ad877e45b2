// Implements Renderer: one picture from the options to the film, and what is taken from it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "api/errors.h"
#include "api/picture_display.h"
#include "api/state.h"
#include "base/arena.h"
#include "base/clock.h"
#include "base/error.h"
#include "base/version.h"
#include "bench/measure/render_report.h"
#include "job/options.h"
#include "job/watch.h"
#include "scene/embree.h"

namespace skywave::api {
namespace {

// The alpha of the picture, which in a file is the channel A beside R, G and B.
constexpr char kAlphaLayer[] = "alpha";

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

// Returns the notes of the job and of the exposure.
std::vector<std::string> Notes(const RendererState& state) {
  std::vector<std::string> notes = state.job->notes();
  if (state.exposure.photo.shutter_seconds > 0) {
    notes.push_back(fmt::format("the PNG is exposed for EV100 {:.2f}: white is {:.4g} cd/m^2",
                                ExposureValue100(state.exposure.photo),
                                std::exp2(-Tone(state.exposure, {}).exposure_stops)));
  }
  return notes;
}

RenderReport Report(const RendererState& state) {
  return {.job = &*state.job,
          .frame = state.finished().frame,
          .write_seconds = state.write_seconds,
          .noise = state.finished().noise,
          .adaptive = state.limits.adaptive > 0};
}

// Returns the picture of the rows that have samples of `part`.
Picture PictureOf(const RendererState& state, LayeredImage rows, const PicturePart& part) {
  Picture picture = FinishPicture(std::move(rows), state.job->options().aovs, state.identity, part,
                                  state.job->options().threads);
  picture.format = state.format;
  picture.format.threads = state.job->options().threads;
  return picture;
}

}  // namespace

std::string Version() {
  return fmt::format("{} (Embree {})", skywave::Version(), RTC_VERSION_STRING);
}

OptionValue::OptionValue(bool value) : text_(value ? "true" : "false") {}
OptionValue::OptionValue(float value) : text_(fmt::format("{}", value)) {}
OptionValue::OptionValue(double value) : text_(fmt::format("{}", value)) {}

void SetOptions(const std::vector<BoundOption>& bound, const Options& options) {
  std::vector<std::pair<std::string, std::string>> texts;
  for (const auto& [name, value] : options) texts.emplace_back(name, value.text());
  skywave::SetOptions(bound, texts);
}

RenderJob MakeJob(const SceneState& scene, JobRequest request) {
  request.scene = scene.name();
  request.read = scene.read;
  request.camera.placed = scene.camera, request.camera.placed_at = scene.camera_at;
  if (request.environment.path.empty()) {
    request.environment.image = scene.environment;
    request.environment.image_hash = scene.environment_hash;
  }
  return RenderJob(scene.Share(), request, scene.load_seconds);
}

Renderer::Renderer(const Scene& scene, const Options& options)
    : state_(std::make_unique<RendererState>()) {
  Translated([&] {
    const auto request = std::make_shared<PictureRequest>();
    std::vector<BoundOption> bound;
    for (const OptionOf<PictureRequest>& option : PictureOptions()) {
      if (!option.positional && !option.of_reading) bound.push_back(Bind(option, request));
    }
    SetOptions(bound, options);
    state_->limits = request->limits;
    state_->format = request->format;
    state_->job.emplace(MakeJob(*scene.state_, request->job));
    CheckFormat(state_->format, state_->job->options().aovs);
    state_->exposure = ResolveExposure(request->exposure, state_->job->request());
    state_->identity =
        IdentityOf(*state_->job, state_->exposure, !scene.state_->changed, state_->limits);
    ChooseSamples(state_->limits, state_->identity.samples);
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
  return std::uint64_t(options.width) * std::uint64_t(options.height) *
         ChooseSamples(state_->limits, state_->identity.samples).count();
}
const std::vector<Layer>& Renderer::layers() const { return state_->layers; }
const std::vector<std::string>& Renderer::warnings() const { return state_->job->warnings(); }
const std::vector<std::string>& Renderer::notes() const { return state_->notes; }

void Renderer::Render(const RenderControl& control) {
  RendererState& state = *state_;
  state.rendered.reset();
  state.write_seconds = 0;
  Translated([&] {
    std::string snapshot;  // the name that was asked for last
    SessionRequest request = {.limits = state.limits,
                              .checkpoint = {.path = control.checkpoint,
                                             .seconds = control.checkpoint_seconds,
                                             .resume = control.resume},
                              .tell = control.progress};
    PictureRows rows(state.job->options().aovs, state.identity);
    if (!control.keep_film) {
      request.on_rows = [&](const Film& film, const SampleCounts& samples, int first, int end) {
        rows.Add(film, samples, first, end);
      };
    }
    if (control.snapshot) {
      request.wants_snapshot = [&] {
        snapshot = control.snapshot();
        return !snapshot.empty();
      };
      request.show = [&](const Film& film, const SampleCounts& samples) {
        const PicturePart part =
            PartOf(*state.job, ChooseSamples(state.limits, state.identity.samples));
        const Picture picture = PictureOf(state, rows.With(film, samples), part);
        try {
          skywave::WriteExrAndPng(snapshot, picture);
        } catch (const InputError& error) {
          state.notes.push_back(error.what());  // a look at a picture does not end its render
        }
      };
    }
    std::optional<PictureDisplay> display;
    if (!control.viewer.empty()) {
      const auto viewer = ParseViewerAddress(control.viewer);
      Require(viewer.has_value(), "viewer", "'" + control.viewer + "' is not HOST:PORT");
      display.emplace(*viewer, control.name_in_viewer, state.job->options().aovs);
      request.on_tile = [&](const Film& film, const Tile& tile, const SampleCounts& samples) {
        display->ShowTile(film, tile, samples);
      };
    }
    RenderedFilm rendered = RunSession(*state.job, state.identity, request);
    if (control.keep_film) {
      const int height = rendered.film.layout().area.picture.height;
      ArenaOf(state.job->options().threads).execute([&] {
        rows.Add(rendered.film, rendered.samples, 0, height);
      });
    }
    state.picture = PictureOf(state, rows.Take(), rendered.part);
    state.layers = LayersOf(state.picture.layers);
    if (!state.picture.alpha.empty()) state.layers.push_back({kAlphaLayer, "A"});
    state.notes.insert(state.notes.end(), state.picture.notes.begin(), state.picture.notes.end());
    if (display) {
      const std::string problem = display->End(state.picture);
      if (!problem.empty()) state.notes.push_back(problem);
    }
    state.notes.insert(state.notes.end(), rendered.notes.begin(), rendered.notes.end());
    state.rendered = std::move(rendered);
  });
}

const RenderedFilm& RendererState::finished() const {
  Require(rendered.has_value(), "Renderer", "there is no picture yet; call Render first");
  return *rendered;
}

void RendererState::Write(const std::function<void()>& write) {
  Translated([&] {
    finished();
    const Clock::time_point start = Clock::now();
    write();
    write_seconds += SecondsSince(start);
  });
}

void Renderer::CopyPicture(std::span<float> rgb) const {
  state_->finished();
  const std::vector<float>& picture = state_->picture.image.rgb;
  CheckSize(rgb, picture.size(), "rgb");
  std::copy(picture.begin(), picture.end(), rgb.begin());
}

void Renderer::CopyLayer(const std::string& name, std::span<float> values) const {
  state_->finished();
  const std::size_t pixels = state_->picture.image.rgb.size() / 3;
  const auto layer = std::find_if(state_->layers.begin(), state_->layers.end(),
                                  [&](const Layer& candidate) { return candidate.name == name; });
  Require(layer != state_->layers.end(), "layer",
          fmt::format("there is no '{}'; the option aovs asks for layers", name));
  const std::size_t channels = layer->channels.size();
  CheckSize(values, pixels * channels, "values");
  if (name == kAlphaLayer && !state_->picture.alpha.empty()) {
    std::copy(state_->picture.alpha.begin(), state_->picture.alpha.end(), values.begin());
    return;
  }
  for (std::size_t c = 0; c < channels; ++c) {
    const std::string wanted = name + '.' + layer->channels[c];
    const auto channel =
        std::find_if(state_->picture.layers.begin(), state_->picture.layers.end(),
                     [&](const NamedChannel& candidate) { return candidate.name == wanted; });
    for (std::size_t i = 0; i < pixels; ++i) values[i * channels + c] = channel->values[i];
  }
}

namespace {

std::vector<std::string> NamesOf(MatteOf what, const RenderJob& job) {
  if (job.names() == nullptr) return {};
  return (*job.names())[std::size_t(what)].names;
}

}  // namespace

std::vector<std::string> Renderer::ObjectNames() const {
  return NamesOf(MatteOf::kObjects, *state_->job);
}

std::vector<std::string> Renderer::MaterialNames() const {
  return NamesOf(MatteOf::kMaterials, *state_->job);
}

std::string Renderer::Statistics() const {
  return Translated([&] {
    state_->finished();
    return JsonText(Report(*state_)) + "\n";
  });
}

std::string Renderer::Summary() const {
  return Translated([&] {
    state_->finished();
    return Table(Report(*state_));
  });
}

void Renderer::WriteExr(const std::string& path) const {
  state_->Write([&] { skywave::WriteExr(path, state_->picture); });
}

void Renderer::WriteFilm(const std::string& path) const {
  state_->Write([&] {
    Require(state_->rendered->has_film, "WriteFilm",
            "the film was not kept; render with RenderControl::keep_film");
    skywave::WriteFilm(path, state_->identity, state_->job->options().aovs, *state_->rendered);
  });
}

void Renderer::WritePng(const std::string& path) const {
  state_->Write([&] { skywave::WritePng(path, state_->picture); });
}

void Renderer::WriteExrAndPng(const std::string& path) const {
  state_->Write([&] { skywave::WriteExrAndPng(path, state_->picture); });
}

std::string Renderer::EncodePng() const {
  return Translated([&] {
    state_->finished();
    return skywave::EncodePng(state_->picture);
  });
}

}  // namespace skywave::api
