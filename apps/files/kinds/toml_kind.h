// The TOML files that the commands read, told from each other by their tables.
#pragma once

#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

enum class TomlKind { campaign, scenario, scene };

/// Throws InvalidInput where the file is of another kind than `wanted`, naming the command that takes it.
void require_kind(const StrictTable& top, TomlKind wanted, const std::string& file);

}  // namespace tribotrack::apps
