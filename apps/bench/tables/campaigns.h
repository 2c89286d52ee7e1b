// Simulated campaigns, one by one, as a file: what parts of a benchmark hand to the whole.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/bench/fit/coverage.h"

namespace tribotrack::bench {

/// A row for each parameter of each campaign, all digits.
std::string csv_of(const std::vector<JudgedParameter>& judged);

/// In the order of JudgedParameter. Throws apps::InvalidInput naming file and line.
std::vector<JudgedParameter> read_campaigns(const std::filesystem::path& path, std::string csv);

}  // namespace tribotrack::bench
