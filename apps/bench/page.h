// All that one call of `tribotrack bench` measured, on one page: who wins where, then a section for each
// part, then what the figures depend on.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "apps/bench/comparison.h"
#include "apps/bench/coverage.h"
#include "apps/bench/laboratory.h"
#include "apps/bench/model.h"
#include "apps/figures/figure.h"
#include "apps/text/csv_table.h"
#include "apps/text/json.h"

namespace tribotrack::bench {

/// What one call of `tribotrack bench` measured; empty: not run.
struct BenchResults {
  std::vector<Comparison> comparisons;
  std::vector<ExtremeRow> extremes;
  std::vector<OmissionRow> omissions;
  std::vector<CoverageRow> coverage;
  std::vector<LaboratoryRow> laboratory;
};

struct Table {
  std::string name;  ///< of the file, and of the table on the page
  /// An object each: cells by the names of their columns.
  std::vector<apps::Json> rows;

  std::string csv() const { return apps::csv_of(rows); }
  /// Headings are the names of the columns, numbers have four digits.
  std::string html() const;
};

Table table_of(const Comparison& comparison);
Table table_of(const std::vector<ExtremeRow>& rows);
Table table_of(const std::vector<OmissionRow>& rows);
Table table_of(const std::vector<CoverageRow>& rows);
Table table_of(const std::vector<LaboratoryRow>& rows);
Table table_of(const std::vector<SummaryLine>& lines);

/// What the figures depend on, by the keys of bench.json: program, cpu, compiler, compiler_flags, clock,
/// peers_missing, load_average (of the last 1, 5 and 15 minutes).
using Circumstances = std::vector<std::pair<std::string, std::string>>;
Circumstances circumstances_here();

/// The lines of the table on top: comparisons, extremes, coverage, the laboratory.
std::vector<SummaryLine> summary_of(const BenchResults& results);

/// Without the summary.
std::vector<Table> tables_of(const BenchResults& results);

/// Of each comparison error against run time, a panel for each group of scenes.
std::vector<apps::Figure> figures_of(const BenchResults& results);

/// A self-contained HTML page.
std::string page_of(const BenchResults& results, const Circumstances& circumstances);

/// bench.json: circumstances, references, and for each part how many rows.
apps::Json json_of(const BenchResults& results, const Circumstances& circumstances);

}  // namespace tribotrack::bench
