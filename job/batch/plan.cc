#include "job/batch/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <set>
#include <unordered_map>
#include <utility>

#include "base/error.h"
#include "base/files.h"
#include "job/batch/axes.h"
#include "job/batch/job_file.h"
#include "job/batch/output_name.h"
#include "job/map_sequence.h"

namespace skywave {
namespace {

constexpr std::size_t kMostJobFileBytes = std::size_t{16} << 20;

struct OutputPattern {
  std::vector<NamePiece> pieces;
  std::string text;
  std::size_t line = 0;
};

[[noreturn]] void RefuseLine(const std::string& path, std::size_t line, const std::string& reason) {
  throw InputError(InputPosition::Line(path, line), reason);
}

// Returns the table `name` of a job file, or null where there is none.
const JobEntry* TableCalled(const std::string& path, const JobValue& file, std::string_view name) {
  const JobEntry* const entry = Find(file, name);
  if (entry != nullptr && entry->value.kind != JobValue::Kind::kTable) {
    RefuseLine(path, entry->line, fmt::format("'{0}' is a table: write [{0}]", name));
  }
  return entry;
}

// Returns the text of `name` in a table of the job file, or null where there is none.
const JobEntry* TextCalled(const std::string& path, const JobEntry& table, std::string_view name) {
  const JobEntry* const entry = Find(table.value, name);
  if (entry != nullptr && entry->value.kind != JobValue::Kind::kText) {
    RefuseLine(path, entry->line, fmt::format("'{}' of [{}] is a text", name, table.name));
  }
  return entry;
}

OutputPattern ReadOutput(const std::string& path, const JobValue& file) {
  const JobEntry* const table = TableCalled(path, file, "output");
  if (table == nullptr) {
    throw InputError(InputPosition::File(path),
                     "has no [output] with the path of the pictures, such as "
                     "path = \"out/{scene}_{index:04}.exr\"");
  }
  CheckNames(path, table->value, {"path"}, "key of [output]");
  const JobEntry* const entry = TextCalled(path, *table, "path");
  if (entry == nullptr) RefuseLine(path, table->line, "[output] has no path");
  OutputPattern output = {.pieces = {}, .text = entry->value.text, .line = entry->line};
  const std::string problem = ParseNamePattern(output.text, output.pieces);
  if (!problem.empty()) RefuseLine(path, entry->line, fmt::format("path {}", problem));
  if (!output.text.ends_with(".exr")) {
    RefuseLine(path, entry->line,
               "the pictures are EXR files, so path has to end in .exr; each gets a PNG as well");
  }
  return output;
}

std::uint64_t ReadMemory(const std::string& path, const JobValue& file) {
  const JobEntry* const table = TableCalled(path, file, "batch");
  if (table == nullptr) return 0;
  CheckNames(path, table->value, {"memory"}, "key of [batch]");
  const JobEntry* const memory = TextCalled(path, *table, "memory");
  if (memory == nullptr) return 0;
  const std::uint64_t bytes = ParseBytes(memory->value.text);
  if (bytes == 0) {
    RefuseLine(
        path, memory->line,
        fmt::format("memory: '{}' is not a size; write it like \"4GiB\"", memory->value.text));
  }
  return bytes;
}

// Returns the number of pictures of all groups crossed.
std::size_t CountPictures(const std::string& path, const std::vector<AxisGroup>& groups) {
  std::size_t count = 1;
  for (const AxisGroup& group : groups) {
    const std::size_t values = group.axes.front().choices.size();
    if (values > kMostPictures / count) {
      RefuseLine(path, group.line,
                 fmt::format("with '{}' there are more than {} pictures", group.axes.front().name,
                             kMostPictures));
    }
    count *= values;
  }
  return count;
}

std::vector<BatchDimension> DimensionsOf(const std::vector<AxisGroup>& groups) {
  std::vector<BatchDimension> dimensions;
  for (const AxisGroup& group : groups) {
    BatchDimension dimension;
    dimension.labels.resize(group.axes.front().choices.size());
    for (const Axis& axis : group.axes) {
      const std::string separator = dimension.name.empty() ? "" : ", ";
      dimension.name += separator + axis.name;
      for (std::size_t i = 0; i < axis.choices.size(); ++i) {
        dimension.labels[i] += separator + axis.choices[i].label;
      }
      if (group.drawn) break;
    }
    dimensions.push_back(std::move(dimension));
  }
  return dimensions;
}

// Returns the picture at `index` of all groups crossed, without its output.
BatchPicture PictureAt(const std::vector<AxisGroup>& groups, const std::vector<PictureOption>& base,
                       std::size_t index) {
  BatchPicture picture = {.index = index, .options = base};
  picture.place.resize(groups.size());
  std::size_t rest = index;
  for (std::size_t g = groups.size(); g-- > 0;) {
    const std::size_t count = groups[g].axes.front().choices.size();
    picture.place[g] = rest % count;
    rest /= count;
  }
  for (std::size_t g = 0; g < groups.size(); ++g) {
    for (const Axis& axis : groups[g].axes) {
      const AxisChoice& choice = axis.choices[picture.place[g]];
      picture.axes.push_back({axis.name, choice.label});
      picture.options.insert(picture.options.end(), choice.options.begin(), choice.options.end());
    }
  }
  return picture;
}

// Returns what stands in a place of the pattern.
std::optional<std::string> ValueIn(const BatchPicture& picture, const std::string& name) {
  if (name == "index") return fmt::format("{}", picture.index);
  for (const AxisValue& value : picture.axes) {
    if (value.axis == name) return value.label;
  }
  for (const PictureOption& option : picture.options) {
    if (option.name == name) return LabelOf(name, option.text);
  }
  return std::nullopt;
}

// Throws for a place of the pattern that a picture has no value for.
void CheckPlaces(const BatchPlan& plan, const OutputPattern& pattern, const BatchPicture& picture) {
  std::vector<std::string_view> known = {"index"};
  for (const AxisValue& value : picture.axes) known.push_back(value.axis);
  for (const PictureOption& option : picture.options) known.push_back(option.name);
  for (const NamePiece& piece : pattern.pieces) {
    if (!piece.place || ValueIn(picture, piece.text)) continue;
    const std::string nearest = NearestName(piece.text, known);
    RefuseLine(
        plan.path, pattern.line,
        fmt::format("path has {{{}}}, which is neither an axis nor an option of picture {}{}",
                    piece.text, picture.index,
                    nearest.empty() ? "" : fmt::format("; did you mean {{{}}}?", nearest)));
  }
}

std::string OutputOf(const BatchPlan& plan, const OutputPattern& pattern, const std::string& folder,
                     const BatchPicture& picture) {
  CheckPlaces(plan, pattern, picture);
  std::string name;
  const std::string problem = FillName(
      pattern.pieces, [&](const std::string& place) { return ValueIn(picture, place); }, name);
  if (!problem.empty()) RefuseLine(plan.path, pattern.line, "path " + problem);
  if (std::filesystem::path(name).stem().empty() || name.ends_with("/.exr")) {
    RefuseLine(plan.path, pattern.line,
               fmt::format("picture {} would be '{}', which is not a name", picture.index, name));
  }
  return (std::filesystem::path(folder) / name).lexically_normal().string();
}

[[noreturn]] void RefuseSameName(const BatchPlan& plan, const OutputPattern& pattern,
                                 const BatchPicture& first, const BatchPicture& second) {
  std::string advice;
  for (std::size_t i = 0; i < first.axes.size(); ++i) {
    const std::string& axis = first.axes[i].axis;
    const auto is_place = [&](const NamePiece& piece) { return piece.place && piece.text == axis; };
    const bool in_name = std::any_of(pattern.pieces.begin(), pattern.pieces.end(), is_place);
    if (first.axes[i].label != second.axes[i].label && !in_name) {
      advice = fmt::format("they differ in '{0}', so path needs {{{0}}}", axis);
      break;
    }
  }
  if (advice.empty()) {
    advice = "their values are written alike; give them a label, or add {index} to path";
  }
  RefuseLine(plan.path, pattern.line,
             fmt::format("pictures {} and {} would both be {}: {}", first.index, second.index,
                         second.output, advice));
}

void CheckNamesDiffer(const BatchPlan& plan, const OutputPattern& pattern) {
  std::unordered_map<std::string_view, const BatchPicture*> seen;
  for (const BatchPicture& picture : plan.pictures) {
    const auto [earlier, added] = seen.emplace(picture.output, &picture);
    if (!added) RefuseSameName(plan, pattern, *earlier->second, picture);
  }
}

std::string CommonFolder(const std::vector<BatchPicture>& pictures) {
  std::filesystem::path common = std::filesystem::path(pictures.front().output).parent_path();
  for (const BatchPicture& picture : pictures) {
    const std::filesystem::path folder = std::filesystem::path(picture.output).parent_path();
    std::filesystem::path shared;
    auto a = common.begin();
    for (auto b = folder.begin(); a != common.end() && b != folder.end() && *a == *b; ++a, ++b) {
      shared /= *a;
    }
    common = shared;
  }
  return common.string();
}

// Throws where options of a picture exclude or need each other. That depends on which ones there
// are, and most pictures have the same.
void CheckCombinations(const BatchPlan& plan) {
  std::set<std::vector<std::string>> checked;
  for (const BatchPicture& picture : plan.pictures) {
    std::vector<std::string> names;
    for (const PictureOption& option : picture.options) names.push_back(option.name);
    if (checked.insert(std::move(names)).second) RequestOf(plan.path, picture.options);
  }
}

// Throws where a frame of a map that moves is not there.
void CheckMapsOfFrames(const BatchPlan& plan) {
  for (const BatchPicture& picture : plan.pictures) {
    const auto is_sequence = [](const PictureOption& option) {
      return option.name == "env" && IsMapSequence(option.text);
    };
    if (std::none_of(picture.options.begin(), picture.options.end(), is_sequence)) continue;
    try {
      const JobRequest job = RequestOf(plan.path, picture.options).job;
      const std::string file = MapFile(job);
      std::error_code ignored;
      if (std::filesystem::is_regular_file(file, ignored)) continue;
      throw OptionError("frame", fmt::format("{}", *job.read.frame),
                        fmt::format("its map is missing: there is no file {}", file));
    } catch (const OptionError& error) {
      throw AtOption(plan.path, picture.options, error);
    }
  }
}

void CheckScenes(const BatchPlan& plan) {
  for (const BatchPicture& picture : plan.pictures) {
    if (ValueIn(picture, "scene")) continue;
    throw InputError(
        InputPosition::File(plan.path),
        fmt::format("picture {} has no scene; [base] should have one, or an axis", picture.index));
  }
}

}  // namespace

BatchPlan ReadBatchPlan(const std::string& path, const std::string& output_folder) {
  return ParseBatchPlan(path, ReadFile(path, kMostJobFileBytes), output_folder);
}

BatchPlan ParseBatchPlan(const std::string& path, std::string bytes,
                         const std::string& output_folder) {
  BatchPlan plan = {.path = path, .bytes = std::move(bytes)};
  const JobValue file = ParseJobFile(path, plan.bytes);
  CheckNames(path, file, {"base", "axes", "zip", "random", "output", "batch"},
             "table of a job file");
  const OutputPattern pattern = ReadOutput(path, file);
  plan.memory_bytes = ReadMemory(path, file);
  const AxisReader reader(path);
  std::vector<PictureOption> base;
  if (const JobEntry* const table = TableCalled(path, file, "base")) {
    base = reader.ReadBase(table->value);
  }
  const std::vector<AxisGroup> groups =
      reader.ReadGroups(Find(file, "axes"), Find(file, "zip"), Find(file, "random"), base);
  plan.all_pictures = CountPictures(path, groups);
  plan.dimensions = DimensionsOf(groups);

  const std::string folder =
      output_folder.empty() ? std::filesystem::path(path).parent_path().string() : output_folder;
  plan.pictures.reserve(plan.all_pictures);
  for (std::size_t index = 0; index < plan.all_pictures; ++index) {
    plan.pictures.push_back(PictureAt(groups, base, index));
  }
  CheckScenes(plan);
  for (BatchPicture& picture : plan.pictures) {
    picture.output = OutputOf(plan, pattern, folder, picture);
  }
  CheckNamesDiffer(plan, pattern);
  CheckCombinations(plan);
  CheckMapsOfFrames(plan);
  plan.folder = CommonFolder(plan.pictures);
  return plan;
}

BatchPlan ShareOf(BatchPlan plan, const BatchShare& share) {
  std::erase_if(plan.pictures, [&](const BatchPicture& picture) {
    return picture.index % share.count != share.number - 1;
  });
  return plan;
}

std::string RelativeName(const std::string& folder, const std::string& file) {
  const std::filesystem::path from = folder.empty() ? "." : folder;
  const std::filesystem::path to = std::filesystem::path(file).lexically_normal();
  const std::filesystem::path base = from.lexically_normal();
  // A relative name with nothing before it is relative to "." already.
  return base == "." ? to.string() : to.lexically_relative(base).string();
}

std::string ReportName(const BatchPlan& plan, const BatchShare& share, const std::string& ending) {
  std::string name = std::filesystem::path(plan.path).stem().string() + ".batch";
  if (share.count > 1) name += fmt::format(".{}of{}", share.number, share.count);
  return (std::filesystem::path(plan.folder) / (name + ending)).string();
}

void CheckUnchanged(const BatchPlan& plan) {
  std::string now;
  try {
    now = ReadFile(plan.path, kMostJobFileBytes);
  } catch (const InputError&) {
    // A file that is gone has changed too.
  }
  if (now == plan.bytes) return;
  throw InputError(InputPosition::File(plan.path),
                   "has changed while the batch ran; run it again to go on with the new one");
}

std::uint64_t ParseBytes(const std::string& text) {
  double number = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || !(number > 0)) return 0;
  std::string_view unit(stop, std::size_t(end - stop));
  if (unit.starts_with(' ')) unit.remove_prefix(1);
  constexpr std::pair<std::string_view, double> kUnits[] = {
      {"", 1},      {"B", 1},        {"KB", 1e3},     {"MB", 1e6},     {"GB", 1e9},
      {"TB", 1e12}, {"KiB", 0x1p10}, {"MiB", 0x1p20}, {"GiB", 0x1p30}, {"TiB", 0x1p40}};
  for (const auto& [name, factor] : kUnits) {
    const double bytes = std::floor(number * factor);
    if (unit == name && bytes >= 1 && bytes < 0x1p63) return std::uint64_t(bytes);
  }
  return 0;
}

}  // namespace skywave
