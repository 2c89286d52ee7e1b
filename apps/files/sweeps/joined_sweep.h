// A sweep from its parts.
#pragma once

#include <filesystem>
#include <vector>

#include "apps/files/parts/work_part.h"

namespace tribotrack::apps {

/// Byte for byte what one `sweep` writes. Objects of `--json` tell no part from another: they are joined in
/// the order given, and have no meta file (null). Throws InvalidInput naming the file.
JoinedTable joined_sweep(const std::vector<std::filesystem::path>& parts);

}  // namespace tribotrack::apps
