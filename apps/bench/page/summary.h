// The first screen of the benchmarks' page: each part in one line.
#pragma once

#include <string>
#include <vector>

#include "apps/bench/tables/results.h"

namespace tribotrack::bench {

/// Plain text.
struct SummaryLine {
  std::string measured, ours;
  std::string peer;  ///< the best of the others
  std::string who;   ///< wins where
};

std::vector<SummaryLine> summary_of(const BenchResults& results);
std::string summary_table(const std::vector<SummaryLine>& lines);

/// Methods of the model are set side by side at this error of the end point, m.
inline constexpr double kComparedError = 1e-8;

}  // namespace tribotrack::bench
