// All that one call of `tribotrack bench` measured, on one page: who wins where, then a section for each
// part, then what the figures depend on.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "apps/bench/comparison.h"
#include "apps/bench/coverage.h"
#include "apps/bench/laboratory.h"
#include "apps/bench/model.h"
#include "apps/figures/figure.h"
#include "apps/text/json.h"

namespace tribotrack::bench {

// The benchmarks' rows as tables: each column is described once, and printed as CSV, as text and on the page.

/// What one call of `tribotrack bench` measured; empty: not run.
struct BenchResults {
  std::vector<Comparison> comparisons;
  std::vector<ExtremeRow> extremes;
  std::vector<OmissionRow> omissions;
  std::vector<CoverageRow> coverage;
  std::vector<LaboratoryRow> laboratory;
};

struct Cell {
  std::string text;        ///< for people
  std::string exact = {};  ///< in the CSV, all digits; quoted there where it is no number
  bool number = false;
};

template <class Row>
struct Column {
  std::string name;     ///< in the CSV; empty: not there
  std::string heading;  ///< for people; empty: in the CSV only
  std::function<Cell(const Row&)> cell;
};

struct Table {
  std::string name;   ///< of the file, and of the table on the page
  std::string title;  ///< above the text
  std::vector<std::string> names, headings;
  std::vector<std::vector<Cell>> rows;

  template <class Row>
  Table(std::string of_file, std::string above, const std::vector<Row>& from,
        const std::vector<Column<Row>>& columns)
      : name(std::move(of_file)), title(std::move(above)) {
    for (const Column<Row>& column : columns) {
      names.push_back(column.name);
      headings.push_back(column.heading);
    }
    for (const Row& row : from) {
      rows.emplace_back();
      for (const Column<Row>& column : columns) rows.back().push_back(column.cell(row));
    }
  }
  std::string csv() const;
  std::string text() const;
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

/// In the order in which they are printed, without the summary.
std::vector<Table> tables_of(const BenchResults& results);

/// Of each comparison error against run time, a panel for each group of scenes.
std::vector<apps::Figure> figures_of(const BenchResults& results);

/// A self-contained HTML page.
std::string page_of(const BenchResults& results, const Circumstances& circumstances);

/// bench.json: circumstances, references, and for each part how many rows.
apps::Json json_of(const BenchResults& results, const Circumstances& circumstances);

}  // namespace tribotrack::bench
