// The flags that say what to render, shared by the subcommands that render.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "job/job.h"

namespace skywave {

// The flags that say what a scene may be.
void AddReadFlags(CLI::App& command, ReadOptions& options);

// Adds the flags to `command`; they write to `request`, which must outlive the parse.
void AddJobFlags(CLI::App& command, JobRequest& request);

// The scene and those flags that decide the pixels, but for strategy and samples.
std::string SceneFlags(const JobRequest& request, const RenderOptions& options);

// The command that renders the same picture again: what decides the pixels and nothing else.
std::string RepeatCommand(const JobRequest& request, const RenderOptions& options);

}  // namespace skywave
