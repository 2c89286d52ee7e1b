// All that one call of `tribotrack bench` measured, on one page: who wins where, then a section for each
// part, then what the figures depend on.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "apps/bench/tables.h"
#include "apps/figures/figure.h"
#include "apps/text/json.h"

namespace tribotrack::bench {

/// Machine, build and load, by name; the loads are those of the last 1, 5 and 15 minutes before and after.
struct Circumstances {
  std::string program, cpu, compiler, compiler_flags;
  std::vector<std::string> missing;  ///< libraries this build was made without
  std::string load_before, load_after;
};
/// Of this process now; the load afterwards is still to come.
Circumstances circumstances_here();
std::string load_average();

/// The lines of the table on top: comparisons, extremes, coverage.
std::vector<SummaryLine> summary_of(const BenchResults& results);

/// In the order in which they are printed, without the summary.
std::vector<Table> tables_of(const BenchResults& results);

/// Of each comparison error against run time, a panel for each group of scenes; axes are settled.
std::vector<apps::Figure> figures_of(const BenchResults& results);

/// A self-contained HTML page.
std::string page_of(const BenchResults& results, const Circumstances& circumstances);

/// bench.json: circumstances, references, and for each part how many rows.
apps::Json json_of(const BenchResults& results, const Circumstances& circumstances);

}  // namespace tribotrack::bench
