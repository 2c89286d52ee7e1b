// All that one call of `tribotrack bench` measured, on one page: who wins where, then a section for each
// part, then what the figures depend on.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "apps/bench/tables.h"
#include "apps/figures/figure.h"
#include "apps/text/json.h"

namespace tribotrack::bench {

/// What the figures depend on, by the keys of bench.json: program, cpu, compiler, compiler_flags, clock,
/// peers_missing, load_average (of the last 1, 5 and 15 minutes).
using Circumstances = std::vector<std::pair<std::string, std::string>>;
Circumstances circumstances_here();

/// The lines of the table on top: comparisons, extremes, coverage.
std::vector<SummaryLine> summary_of(const BenchResults& results);

/// In the order in which they are printed, without the summary.
std::vector<Table> tables_of(const BenchResults& results);

/// Of each comparison error against run time, a panel for each group of scenes.
std::vector<apps::Figure> figures_of(const BenchResults& results);

/// A self-contained HTML page.
std::string page_of(const BenchResults& results, const Circumstances& circumstances);

/// bench.json: circumstances, references, and for each part how many rows.
apps::Json json_of(const BenchResults& results, const Circumstances& circumstances);

}  // namespace tribotrack::bench
