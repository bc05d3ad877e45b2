#include "scene/pbrt/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "base/error.h"
#include "base/files.h"
#include "base/gzip.h"
#include "scene/instances.h"
#include "scene/pbrt/state.h"

namespace skywave {
namespace {

namespace fs = std::filesystem;

std::unique_ptr<PbrtSource> MakeSource(PbrtReader& reader, std::string path, std::string text) {
  auto source = std::make_unique<PbrtSource>();
  source->main_path = reader.sources.empty() ? path : reader.sources.front()->path;
  source->path = std::move(path);
  source->text = std::move(text);
  RefuseUtf16(source->text, source->path);
  if (source->text.starts_with(kByteOrderMark)) {
    source->text.replace(0, kByteOrderMark.size(), kByteOrderMark.size(), ' ');
  }
  if (reader.v3) source->lenient = &reader.warnings;
  return source;
}

void OpenInclude(PbrtReader& reader, const PbrtToken& word) {
  PbrtSource& source = *reader.sources.back();
  const InputPosition position = PositionOf(source, word);
  const bool imported = word.text == "Import";
  if (imported && !reader.in_world) {
    throw InputError(position, "Import has to come after WorldBegin");
  }
  const std::string name = ExpectString(source, "the name of a file");
  // A part that is missing leaves the rest, as in pbrt-v3.
  std::string path, text;
  try {
    path = ResolvePbrtPath(reader, name, position);
    text = Gunzip(ReadFile(path), path);
  } catch (const InputError& error) {
    AddMissing(reader.warnings, position, word.text, error, "left out");
    return;
  }
  for (const auto& open : reader.sources) {
    std::error_code ignored;
    if (fs::equivalent(open->path, path, ignored)) {
      throw InputError(position, fmt::format("{} includes itself", path));
    }
  }
  if (reader.sources.size() > kMaxPbrtIncludeDepth) {
    throw InputError(position,
                     fmt::format("includes are nested more than {} deep", kMaxPbrtIncludeDepth));
  }
  if (++reader.includes > kMaxPbrtIncludes) {
    throw InputError(position, fmt::format("more than {} includes", kMaxPbrtIncludes));
  }
  if (imported) OpenPbrtScope(reader, source, word);
  reader.sources.push_back(MakeSource(reader, path, std::move(text)));
  reader.sources.back()->imported = imported;
  if (!imported) reader.sources.back()->includer = &source;
}

void EndSource(PbrtReader& reader, const PbrtToken& end) {
  const PbrtSource& source = *reader.sources.back();
  if (source.imported) {
    if (const PbrtScope& open = reader.scopes.back(); open.begin != "Import") {
      throw InputError(open.position, open.begin + " is never closed in the imported file");
    }
    reader.state = ClosePbrtScope(reader, source, end, "Import");
  }
  reader.sources.pop_back();
}

PbrtHandler RequireHandler(const PbrtSource& source, const PbrtToken& word) {
  PbrtHandler handler = nullptr;
  if (word.kind == PbrtTokenKind::kWord) {
    handler = FindPbrtWorldDirective(word.text);
    if (!handler) handler = FindPbrtTransformDirective(word.text);
    if (!handler) handler = FindPbrtOptionDirective(word.text);
  }
  if (!handler) {
    const bool is_word = word.kind == PbrtTokenKind::kWord;
    throw InputError(
        PositionOf(source, word),
        (is_word ? "unknown directive " : "a directive is expected, not ") + Describe(word));
  }
  return handler;
}

void ReadDirectives(PbrtReader& reader) {
  while (!reader.sources.empty()) {
    PbrtSource& source = *reader.sources.back();
    const PbrtToken word = NextToken(source);
    if (word.kind == PbrtTokenKind::kEnd) {
      EndSource(reader, word);
    } else if (reader.ended) {
      AddWarning(reader.warnings, PositionOf(source, word), "everything after WorldEnd is ignored");
      return;
    } else if (word.kind == PbrtTokenKind::kWord &&
               (word.text == "Include" || word.text == "Import")) {
      OpenInclude(reader, word);
    } else {
      RequireHandler(source, word)(reader, source, word);
    }
  }
}

void ScaleLight(float factor, Scene& scene) {
  for (EnvironmentLight& light : scene.environments) light.scale *= factor;
  for (PunctualLight& light : scene.lights) light.emission *= factor;
  for (Material& material : scene.materials) material.emission *= factor;
}

// Returns whether a file has the directive WorldEnd, which version 4 has no longer. It may have the
// word in comments and strings.
bool HasWorldEnd(std::string_view text) {
  constexpr std::string_view kWord = "WorldEnd";
  for (std::size_t at = text.rfind(kWord); at != text.npos;) {
    const std::size_t newline = text.find_last_of("\r\n", at);
    const std::size_t line = newline == text.npos ? 0 : newline + 1;
    const std::string_view before = text.substr(line, at - line);
    const bool quoted = std::count(before.begin(), before.end(), '"') % 2 != 0;
    if (!quoted && before.find('#') == before.npos) return true;
    if (at == 0) return false;
    at = text.rfind(kWord, at - 1);
  }
  return false;
}

// Fills in what a file leaves to pbrt's own defaults.
void SetPbrtDefaults(bool v3, RenderSettings& settings) {
  settings.width = settings.width.value_or(1280);
  settings.height = settings.height.value_or(720);
  settings.filter = settings.filter.value_or(v3 ? PixelFilter::kBox : PixelFilter::kGaussian);
}

}  // namespace

std::string ResolvePbrtPath(const PbrtReader& reader, const std::string& name,
                            const InputPosition& position) {
  const std::string path = FindPbrtFile(*reader.sources.back(), name);
  if (!path.empty()) return path;
  throw InputError::NoSuchFile(position, name);
}

void Warn(PbrtReader& reader, const PbrtParameters& parameters, const std::string& text) {
  AddWarning(reader.warnings, parameters.position, parameters.directive + ": " + text);
}

PbrtHandler FindPbrtDirective(std::span<const PbrtDirective> directives, std::string_view word) {
  for (const PbrtDirective& directive : directives) {
    if (directive.word == word) return directive.handler;
  }
  return nullptr;
}

PbrtParameters ReadParametersAndAttributes(PbrtReader& reader, PbrtSource& source,
                                           const InputPosition& position, std::string_view kind,
                                           const std::string& directive) {
  PbrtParameters parameters = ReadParameters(source, position, directive, reader.warnings);
  parameters.color_space = reader.state.color_space;
  if (!reader.state.attributes) return parameters;
  const auto given = reader.state.attributes->find(kind);
  if (given == reader.state.attributes->end()) return parameters;
  const std::size_t own = parameters.list.size();
  for (const PbrtParameter& parameter : given->second) {
    const auto end = parameters.list.begin() + std::ptrdiff_t(own);
    if (std::none_of(parameters.list.begin(), end,
                     [&](const PbrtParameter& other) { return other.name == parameter.name; })) {
      parameters.list.push_back(parameter);
    }
  }
  return parameters;
}

Scene ParsePbrt(std::string text, const std::string& path, const ReadOptions& options) {
  PbrtReader reader;
  reader.options = options;
  reader.warnings = MakeWarnings(options);
  reader.scene.left_handed = true;
  reader.scene.materials.push_back({.name = "default"});
  reader.state.material = 0;
  reader.v3 = HasWorldEnd(text);
  reader.sources.push_back(MakeSource(reader, path, std::move(text)));
  ReadDirectives(reader);
  if (!reader.scopes.empty()) {
    const PbrtScope& open = reader.scopes.back();
    if (!reader.v3) throw InputError(open.position, open.begin + " is never closed");
    AddWarning(reader.warnings, open.position, open.begin + " is never closed");
  }
  SetPbrtDefaults(reader.v3, reader.scene.settings);
  PlacePbrtLens(reader);
  const float gain = reader.film_gain * reader.exposure_time;
  if (gain != 1) ScaleLight(gain, reader.scene);
  ResolveInstances(options, path, reader.scene);
  SetRemarks(reader.warnings, reader.scene);
  return std::move(reader.scene);
}

Scene ReadPbrt(const std::string& path, const ReadOptions& options) {
  return ParsePbrt(Gunzip(ReadFile(path), path), path, options);
}

}  // namespace skywave
