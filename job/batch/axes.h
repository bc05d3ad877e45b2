// The axes of a job file: what varies from picture to picture.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "job/batch/job_file.h"
#include "job/batch/picture_options.h"

namespace skywave {

// More pictures, or more values of an axis, are probably a mistake and are refused before any is
// made.
inline constexpr std::size_t kMostPictures = 100'000;

// One value of an axis: its name in outputs and tables, and the options that it sets.
struct AxisChoice {
  std::string label;
  std::vector<PictureOption> options;
};

struct Axis {
  std::string name;
  std::size_t line = 0;
  std::vector<AxisChoice> choices;
};

// Axes that go in step have equally many values, the others are in groups of their own.
struct AxisGroup {
  std::vector<Axis> axes;
  std::size_t line = 0;
  bool drawn = false;  // by [random]: the first axis is the number of the draw
};

// Reads options and axes of the job file `path`. Names of files in it are relative to its folder.
class AxisReader {
 public:
  explicit AxisReader(const std::string& path);

  // Returns the options of [base].
  std::vector<PictureOption> ReadBase(const JobValue& base) const;
  // Returns the groups of [axes], [[zip]] and [random] in the order of the file. Each may be null.
  // Throws InputError with the line for invalid values, and where an option is given twice, by two
  // axes or by an axis and the base.
  std::vector<AxisGroup> ReadGroups(const JobEntry* axes, const JobEntry* zip,
                                    const JobEntry* random,
                                    const std::vector<PictureOption>& base) const;

 private:
  [[noreturn]] void Refuse(std::size_t line, const std::string& reason) const;
  bool IsOption(const std::string& name) const;
  std::string Problem(const std::string& name, const std::string& text) const;
  void CheckOption(const PictureOption& option) const;
  std::string FileNamed(const PictureOption& option) const;
  std::vector<std::string> FilesLike(const PictureOption& option) const;
  PictureOption ReadOption(const JobEntry& entry) const;
  void AppendText(const PictureOption& option, Axis& axis) const;
  void AppendRange(const JobValue& range, Axis& axis) const;
  void AppendTable(const JobValue& table, Axis& axis) const;
  void AppendChoices(const JobValue& value, Axis& axis) const;
  void ExpandCameras(const std::vector<PictureOption>& base, Axis& axis) const;
  void ExpandPhotographs(const std::vector<PictureOption>& base, Axis& axis) const;
  std::uint64_t NumberCalled(const JobValue& table, std::string_view name, double most) const;
  AxisGroup ReadRandom(const JobEntry& random) const;
  Axis ReadAxis(const JobEntry& entry, const std::vector<PictureOption>& base) const;
  AxisGroup ReadZip(const JobValue& zip, const std::vector<PictureOption>& base) const;

  std::string path_, folder_;
  std::vector<BoundOption> options_;
};

// Returns whether the value of an option is the name of a file to read.
bool NamesFile(std::string_view option);

// Returns what stands for the value `text` of an option in names of outputs: the stem of a file, or
// the text itself.
std::string LabelOf(const std::string& option, const std::string& text);

}  // namespace skywave
