// Where results come from: what a run has read and written, each with its hash, in its run.json.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/files/run_folder.h"
#include "apps/text/input_file.h"
#include "apps/text/json.h"

namespace tribotrack::apps {

/// Program, commit and revision of each stage; the XXH3-128 of every input, and of what the folder holds of
/// these runs and of all together. Paths are relative to the folder, so that it can be moved with its
/// recordings.
Json manifest_of(const RunFolder& folder, const std::vector<std::string>& runs,
                 const std::vector<Input>& inputs);

/// Compares a folder that `run` has filled, or those of its parts, with its manifest; how many files there
/// are. Throws InvalidInput naming each that was changed since or is gone, where there is no manifest, and
/// where the folder is being written to.
std::size_t verify(const std::filesystem::path& folder);

}  // namespace tribotrack::apps
