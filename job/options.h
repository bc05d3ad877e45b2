// The options of a job, each described once, in one table: flags, help, job files, the merging of
// request and scene file, the command that a picture records and the reference walk it.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "job/request.h"
#include "wavefront/option.h"

namespace skywave {

struct JobOption : OptionOf<JobRequest> {
  // Writes the value that counts, the request's, else the scene file's, else the default, into both
  // the request and its RenderOptions. Null where scene_may_set is false. Options are resolved in
  // the order of the table. Throws InputError.
  std::function<void(JobRequest&, const SceneDefaults&)> resolve;
};

// In the order of help texts: groups of common options come before those of rare ones.
std::span<const JobOption> JobOptions();

// `request` with a value for every option: its own, else the scene file's, else the default;
// request.options is complete then. Appends to `notes` what was changed. A pure function. Throws
// InputError for options that do not go together.
JobRequest ResolveRequest(JobRequest request, const RenderSettings& settings,
                          std::vector<std::string>& notes);

// Prints and parses "WxH+X+Y".
Codec<CropWindow> Crops();

// An option as a picture records it.
struct RecordedOption {
  std::string name;
  std::string words;  // of a command, with a blank before each; may be empty
  bool is_input;      // names a file or how it is read: the same picture may come from another name
};

// The options of a resolved request that decide the picture, in the order of the table.
std::vector<RecordedOption> RecordedOptions(const JobRequest& resolved);

// The same as the words of a command. Those named in `without` are left out.
std::string PictureOptions(const JobRequest& resolved,
                           std::span<const std::string_view> without = {});

}  // namespace skywave
