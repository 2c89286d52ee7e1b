// The benchmarks' rows as CSV, as tables for people, and as figures. One list of columns per table
// (columns.h).
#pragma once

#include <string>
#include <vector>

#include "apps/bench/claims/claims.h"
#include "apps/bench/fit/bench.h"
#include "apps/bench/fit/coverage.h"
#include "apps/bench/fit/filming.h"
#include "apps/bench/model/batch.h"
#include "apps/bench/model/bench.h"
#include "apps/bench/model/plan.h"
#include "apps/bench/scale/scale.h"
#include "apps/bench/vision/bench.h"
#include "apps/bench/vision/decoding.h"
#include "apps/bench/vision/limit.h"
#include "apps/bench/vision/whole_command.h"
#include "apps/figures/figure.h"

namespace tribotrack::bench {

struct BenchTable {
  std::string name;  ///< of the file, and of the table on the page
  std::string csv, text, html;
  std::vector<apps::Figure> figures = {};
};

/// `missing`: libraries this build was made without, named below the text (peers/library_peers.h).
BenchTable table_of(const std::vector<ModelBenchRow>& rows, const std::vector<std::string>& missing = {});
BenchTable table_of(const std::vector<ModelExtremeRow>& rows);
BenchTable table_of(const std::vector<PlanBenchRow>& rows);
BenchTable table_of(const std::vector<BatchBenchRow>& rows);
BenchTable table_of(const std::vector<PaperClaim>& claims);
BenchTable table_of(const std::vector<VisionBenchRow>& rows);
BenchTable table_of(const std::vector<VisionLimitRow>& rows);
/// What each recording says of the standard deviations found in it, beside what the truth says.
BenchTable audit_table_of(const std::vector<VisionLimitRow>& rows);
BenchTable table_of(const std::vector<VisionDecodingRow>& rows);
BenchTable table_of(const std::vector<WholeCommandRow>& rows);
BenchTable table_of(const std::vector<FitBenchRow>& rows);
BenchTable table_of(const std::vector<CoverageRow>& rows);
BenchTable table_of(const std::vector<FilmingRow>& rows);
BenchTable table_of(const std::vector<ScaleRow>& rows);
BenchTable table_of(const std::vector<ScaleExponent>& rows);

}  // namespace tribotrack::bench
