#include "job/batch/axes.h"

#include <fmt/format.h>
#include <glob.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>

#include "base/error.h"
#include "base/files.h"
#include "job/batch/draws.h"
#include "job/batch/number_list.h"
#include "job/camera_file.h"
#include "job/map_sequence.h"
#include "job/options.h"
#include "scene/builtin/builtin.h"
#include "scene/reader.h"

namespace skywave {
namespace {

bool IsBuiltinScene(const std::string& name) {
  const auto scenes = BuiltinScenes();
  return std::any_of(scenes.begin(), scenes.end(),
                     [&](const BuiltinSceneInfo& scene) { return scene.name == name; });
}

// Whether `text` is meant as a list of numbers.
bool LooksLikeNumberList(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789-,: \t") == std::string::npos;
}

// Only * and ? are special in patterns of job files.
std::string GlobPattern(const std::string& pattern) {
  std::string escaped;
  for (const char c : pattern) {
    if (c == '[' || c == '\\') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

// Returns the files that match, sorted by name.
std::vector<std::string> GlobFiles(const std::string& pattern) {
  const auto free = [](glob_t* found) { globfree(found); };
  glob_t found = {};
  const std::unique_ptr<glob_t, decltype(free)> owner(&found, free);
  std::vector<std::string> files;
  if (glob(GlobPattern(pattern).c_str(), GLOB_NOSORT, nullptr, &found) != 0) return files;
  for (std::size_t i = 0; i < found.gl_pathc; ++i) {
    std::error_code ignored;
    if (!std::filesystem::is_directory(found.gl_pathv[i], ignored)) {
      files.emplace_back(found.gl_pathv[i]);
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

bool NamesFile(std::string_view option) {
  const auto options = JobOptions();
  return std::any_of(options.begin(), options.end(), [&](const JobOption& candidate) {
    return candidate.name == option && candidate.of_file;
  });
}

std::string LabelOf(const std::string& option, const std::string& text) {
  if (!NamesFile(option)) return text;
  const auto [path, layer] = SplitFileName(text);
  std::string label = std::filesystem::path(path).stem().string();
  if (!layer.empty()) label += "_" + layer;
  if (option == "env" && IsMapSequence(text)) {
    std::erase(label, '#');
    label.erase(label.find_last_not_of("_.-") + 1);
  }
  return label;
}

AxisReader::AxisReader(const std::string& path)
    : path_(path),
      folder_(std::filesystem::path(path).parent_path().string()),
      options_(BindAll(PictureOptions(), std::make_shared<PictureRequest>())) {}

void AxisReader::Refuse(std::size_t line, const std::string& reason) const {
  throw InputError(InputPosition::Line(path_, line), reason);
}

bool AxisReader::IsOption(const std::string& name) const {
  return std::any_of(options_.begin(), options_.end(),
                     [&](const BoundOption& option) { return option.info.name == name; });
}

// Returns what is wrong with an option and its value, or nothing.
std::string AxisReader::Problem(const std::string& name, const std::string& text) const {
  try {
    SetOption(options_, name, text);
    return "";
  } catch (const OptionError& error) {
    return error.what();
  }
}

void AxisReader::CheckOption(const PictureOption& option) const {
  const std::string problem = Problem(option.name, option.text);
  if (!problem.empty()) Refuse(option.line, problem);
}

// Returns the name of the file of an option as the program opens it.
std::string AxisReader::FileNamed(const PictureOption& option) const {
  const std::string file =
      (std::filesystem::path(folder_) / option.text).lexically_normal().string();
  std::error_code ignored;
  const std::string path = SplitFileName(file).path;
  if (std::filesystem::is_regular_file(path, ignored)) {
    if (::access(path.c_str(), R_OK) != 0) Refuse(option.line, path + " cannot be read");
    return file;
  }
  if (option.name == "scene" && IsBuiltinScene(option.text)) return option.text;
  // Its files are checked once the frames are known.
  if (option.name == "env" && IsMapSequence(file)) return file;
  Refuse(option.line,
         fmt::format("{}: there is no file {}{}", option.name, file,
                     option.name == "scene" ? ", and no built-in scene of that name" : ""));
}

std::vector<std::string> AxisReader::FilesLike(const PictureOption& option) const {
  if (option.text.find_first_of("*?") == std::string::npos) return {FileNamed(option)};
  const std::string pattern =
      (std::filesystem::path(folder_) / option.text).lexically_normal().string();
  std::vector<std::string> files = GlobFiles(pattern);
  if (files.empty())
    Refuse(option.line, fmt::format("{}: no file is like {}", option.name, pattern));
  return files;
}

// Reads an option of [base] or of a table of options: one value.
PictureOption AxisReader::ReadOption(const JobEntry& entry) const {
  PictureOption option = {entry.name, entry.value.text, entry.line};
  if (IsOption(entry.name) && !entry.value.is_scalar()) {
    Refuse(entry.line,
           fmt::format("{} takes one value here; what varies belongs in [axes]", entry.name));
  }
  if (NamesFile(entry.name)) option.text = FileNamed(option);
  CheckOption(option);
  return option;
}

std::vector<PictureOption> AxisReader::ReadBase(const JobValue& base) const {
  std::vector<PictureOption> options;
  for (const JobEntry& entry : base.table) options.push_back(ReadOption(entry));
  return options;
}

// Adds the choices for which a text stands: itself, the files of a pattern, or numbers of a list.
void AxisReader::AppendText(const PictureOption& option, Axis& axis) const {
  const auto add = [&](const std::string& text) {
    const PictureOption checked = {option.name, text, option.line};
    CheckOption(checked);
    axis.choices.push_back({LabelOf(option.name, text), {checked}});
  };
  if (NamesFile(option.name)) {
    for (const std::string& file : FilesLike(option)) add(file);
    return;
  }
  if (!LooksLikeNumberList(option.text) || Problem(option.name, option.text).empty()) {
    return add(option.text);
  }
  std::vector<std::int64_t> numbers;
  const std::string problem = ParseNumberList(option.text, kMostPictures, numbers);
  if (!problem.empty()) Refuse(option.line, fmt::format("{}: {}", option.name, problem));
  for (const std::int64_t number : numbers) add(fmt::format("{}", number));
}

// Adds `steps` numbers in equal steps, from `from` on and without `to`.
void AxisReader::AppendRange(const JobValue& range, Axis& axis) const {
  CheckNames(path_, range, {"from", "to", "steps"},
             fmt::format("key of '{}', which has from, to and steps", axis.name));
  const auto number = [&](const char* name) -> const JobValue& {
    const JobEntry* const entry = Find(range, name);
    if (entry == nullptr) Refuse(range.line, fmt::format("{}: '{}' is missing", axis.name, name));
    if (entry->value.kind != JobValue::Kind::kWhole && entry->value.kind != JobValue::Kind::kReal) {
      Refuse(entry->line, fmt::format("{}: '{}' is not a number", axis.name, name));
    }
    return entry->value;
  };
  const double from = number("from").number, to = number("to").number;
  const JobValue& steps = number("steps");
  if (steps.kind != JobValue::Kind::kWhole || steps.number < 1 || steps.number > kMostPictures) {
    Refuse(steps.line,
           fmt::format("{}: 'steps' is not a whole number from 1 to {}", axis.name, kMostPictures));
  }
  for (double i = 0; i < steps.number; ++i) {
    const std::string text = NumberText(from + (to - from) * i / steps.number);
    const PictureOption option = {axis.name, text, range.line};
    CheckOption(option);
    axis.choices.push_back({text, {option}});
  }
}

// Adds one choice: a table of options with a label.
void AxisReader::AppendTable(const JobValue& table, Axis& axis) const {
  AxisChoice choice;
  for (const JobEntry& entry : table.table) {
    if (entry.name == "label") {
      if (!entry.value.is_scalar()) Refuse(entry.line, "a label is a text");
      choice.label = entry.value.text;
      continue;
    }
    choice.options.push_back(ReadOption(entry));
    if (entry.name == axis.name && choice.label.empty()) {
      choice.label = LabelOf(entry.name, choice.options.back().text);
    }
  }
  if (choice.label.empty()) {
    Refuse(table.line,
           fmt::format("this value of '{}' needs a label, which names it in outputs", axis.name));
  }
  axis.choices.push_back(std::move(choice));
}

void AxisReader::AppendChoices(const JobValue& value, Axis& axis) const {
  if (value.kind == JobValue::Kind::kTable) {
    const bool range = Find(value, "from") || Find(value, "to") || Find(value, "steps");
    if (!range) return AppendTable(value, axis);
  }
  if (!IsOption(axis.name)) {
    Refuse(axis.line, Problem(axis.name, "") +
                          "; axes of other names are lists of tables with a label and options");
  }
  if (value.kind == JobValue::Kind::kTable) return AppendRange(value, axis);
  if (!value.is_scalar()) {
    Refuse(value.line, fmt::format("a value of '{}' is a text, a number or a switch", axis.name));
  }
  AppendText({axis.name, value.text, value.line}, axis);
}

Axis AxisReader::ReadAxis(const JobEntry& entry, const std::vector<PictureOption>& base) const {
  Axis axis = {.name = entry.name, .line = entry.line, .choices = {}};
  if (entry.value.kind == JobValue::Kind::kList) {
    for (const JobValue& value : entry.value.list) AppendChoices(value, axis);
  } else {
    AppendChoices(entry.value, axis);
  }
  if (axis.choices.empty()) Refuse(entry.line, fmt::format("'{}' has no value", entry.name));
  ExpandCameras(base, axis);
  ExpandPhotographs(base, axis);
  return axis;
}

// Reads a table of [[zip]]: axes in step.
AxisGroup AxisReader::ReadZip(const JobValue& zip, const std::vector<PictureOption>& base) const {
  AxisGroup group = {.axes = {}, .line = zip.line};
  for (const JobEntry& entry : zip.table) {
    group.axes.push_back(ReadAxis(entry, base));
    const Axis &axis = group.axes.back(), &first = group.axes.front();
    if (axis.choices.size() != first.choices.size()) {
      Refuse(axis.line,
             fmt::format("'{}' has {} values, and '{}' in line {} has {}; axes of a [[zip]] go in "
                         "step",
                         axis.name, axis.choices.size(), first.name, first.line,
                         first.choices.size()));
    }
  }
  if (group.axes.empty()) Refuse(zip.line, "this [[zip]] has no axis");
  return group;
}

// Puts the names of all cameras in place of "*": those of the photographs of `base`, or those of
// its scene.
void AxisReader::ExpandCameras(const std::vector<PictureOption>& base, Axis& axis) const {
  const auto is_all = [](const AxisChoice& choice) { return choice.label == "*"; };
  const auto all = std::find_if(axis.choices.begin(), axis.choices.end(), is_all);
  if (axis.name != "scene-camera" || all == axis.choices.end()) return;
  const JobRequest job = RequestOf(path_, base).job;
  const std::string& file = job.camera.from.empty() ? job.scene : job.camera.from;
  if (file.empty()) {
    Refuse(axis.line, "all cameras: [base] has no scene, whose cameras these would be");
  }
  const std::size_t line = all->options.front().line;
  std::vector<AxisChoice> cameras;
  if (job.camera.from.empty()) {
    for (const NamedCamera& camera : ReadScene(job.scene, job.read).cameras) {
      cameras.push_back({camera.name, {{axis.name, camera.name, line}}});
    }
  } else {
    for (const std::string& name : PhotographsOfFile(job.camera.from)) {
      cameras.push_back({LabelOfPhotograph(name), {{axis.name, name, line}}});
    }
  }
  if (cameras.empty()) Refuse(line, fmt::format("{} has no camera with a name", file));
  axis.choices.insert(axis.choices.erase(all), cameras.begin(), cameras.end());
}

// Puts all photographs of each file of an axis of cameras in place of the file, unless the base
// says which one is meant.
void AxisReader::ExpandPhotographs(const std::vector<PictureOption>& base, Axis& axis) const {
  if (axis.name != "camera-from") return;
  for (const PictureOption& option : base) {
    if (option.name == "scene-camera") return;
  }
  std::vector<AxisChoice> choices;
  for (const AxisChoice& file : axis.choices) {
    const PictureOption& from = file.options.front();
    const std::vector<std::string> names = PhotographsOfFile(from.text);
    if (names.empty()) choices.push_back(file);
    for (const std::string& name : names) {
      choices.push_back({LabelOfPhotograph(name), {from, {"scene-camera", name, from.line}}});
    }
  }
  axis.choices = std::move(choices);
}

// Returns a whole number of [random]; 0 if it is not there.
std::uint64_t AxisReader::NumberCalled(const JobValue& table, std::string_view name,
                                       double most) const {
  const JobEntry* const entry = Find(table, name);
  if (entry == nullptr) return 0;
  const JobValue& value = entry->value;
  if (value.kind != JobValue::Kind::kWhole || value.number < 0 || value.number > most) {
    Refuse(entry->line, fmt::format("{} is a whole number of at most {:.0f}", name, most));
  }
  return std::uint64_t(value.number);
}

// Reads [random]: axes that go in step, whose values are drawn.
AxisGroup AxisReader::ReadRandom(const JobEntry& random) const {
  const JobValue& table = random.value;
  if (table.kind != JobValue::Kind::kTable) Refuse(random.line, "[random] is a table");
  CheckNames(path_, table, {"pictures", "seed", "draw"}, "key of [random]");
  const std::uint64_t pictures = NumberCalled(table, "pictures", double(kMostPictures));
  const std::uint64_t seed = NumberCalled(table, "seed", 0x1p53);
  const JobEntry* const draw = Find(table, "draw");
  if (pictures == 0) Refuse(random.line, "[random] says of how many pictures, as pictures = 100");
  if (draw == nullptr || draw->value.kind != JobValue::Kind::kTable) {
    Refuse(random.line, "[random.draw] says what is drawn, as env-rotate = { from = 0, to = 360 }");
  }
  AxisGroup group = {.axes = {{.name = random.name, .line = random.line, .choices = {}}},
                     .line = random.line,
                     .drawn = true};
  for (std::uint64_t i = 0; i < pictures; ++i) {
    group.axes.front().choices.push_back({fmt::format("{}", i), {}});
  }
  for (const JobEntry& entry : draw->value.table) {
    if (!IsOption(entry.name)) Refuse(entry.line, Problem(entry.name, ""));
    const Distribution distribution =
        ReadDistribution(path_, entry, [&](const JobValue& text) -> std::vector<std::string> {
          if (!NamesFile(entry.name)) return {text.text};
          return FilesLike({entry.name, text.text, text.line});
        });
    Axis axis = {.name = entry.name, .line = entry.line, .choices = {}};
    for (std::uint64_t i = 0; i < pictures; ++i) {
      DrawNumbers numbers(seed, i, entry.name);
      const PictureOption option = {entry.name, distribution(numbers), entry.line};
      CheckOption(option);
      axis.choices.push_back({LabelOf(option.name, option.text), {option}});
    }
    group.axes.push_back(std::move(axis));
  }
  return group;
}

std::vector<AxisGroup> AxisReader::ReadGroups(const JobEntry* axes, const JobEntry* zip,
                                              const JobEntry* random,
                                              const std::vector<PictureOption>& base) const {
  std::vector<AxisGroup> groups;
  if (axes != nullptr) {
    if (axes->value.kind != JobValue::Kind::kTable) Refuse(axes->line, "[axes] is a table");
    for (const JobEntry& entry : axes->value.table) {
      groups.push_back({.axes = {ReadAxis(entry, base)}, .line = entry.line});
    }
  }
  if (zip != nullptr) {
    if (zip->value.kind != JobValue::Kind::kList) {
      Refuse(zip->line, "zip is an array of tables: write [[zip]]");
    }
    for (const JobValue& table : zip->value.list) {
      if (table.kind != JobValue::Kind::kTable) Refuse(table.line, "a zip is a table of axes");
      groups.push_back(ReadZip(table, base));
    }
  }
  if (random != nullptr) groups.push_back(ReadRandom(*random));
  std::stable_sort(groups.begin(), groups.end(),
                   [](const AxisGroup& a, const AxisGroup& b) { return a.line < b.line; });

  // The line that gives an option, or an axis, first.
  std::map<std::string, std::size_t> given;
  for (const PictureOption& option : base) given.emplace(option.name, option.line);
  for (const AxisGroup& group : groups) {
    for (const Axis& axis : group.axes) {
      std::map<std::string, std::size_t> own = {{axis.name, axis.line}};
      for (const AxisChoice& choice : axis.choices) {
        for (const PictureOption& option : choice.options) own.emplace(option.name, option.line);
      }
      for (const auto& [name, line] : own) {
        const auto [earlier, added] = given.emplace(name, line);
        if (!added) {
          Refuse(line, fmt::format("'{}' is given in line {} already", name, earlier->second));
        }
      }
    }
  }
  return groups;
}

}  // namespace skywave
