// The benchmarks' rows as CSV, as tables for people, and as plots.
#pragma once

#include <string>
#include <vector>

#include "apps/bench/claims/claims.h"
#include "apps/bench/fit/bench.h"
#include "apps/bench/fit/coverage.h"
#include "apps/bench/model/batch.h"
#include "apps/bench/model/bench.h"
#include "apps/bench/model/plan.h"
#include "apps/bench/vision/bench.h"
#include "apps/bench/vision/decoding.h"
#include "apps/bench/vision/limit.h"

namespace tribotrack::apps {

struct BenchTable {
  std::string csv, text, svg;  ///< svg empty where there is nothing to draw
};

BenchTable table_of(const std::vector<model::ModelBenchRow>& rows);
BenchTable table_of(const std::vector<model::ModelExtremeRow>& rows);
BenchTable table_of(const std::vector<model::PlanBenchRow>& rows);
BenchTable table_of(const std::vector<model::BatchBenchRow>& rows);
BenchTable table_of(const std::vector<model::PaperClaim>& claims);
BenchTable table_of(const std::vector<vision::VisionBenchRow>& rows);
BenchTable table_of(const std::vector<vision::VisionLimitRow>& rows);
BenchTable table_of(const std::vector<vision::VisionDecodingRow>& rows);
BenchTable table_of(const std::vector<fit::FitBenchRow>& rows);
BenchTable table_of(const std::vector<fit::CoverageRow>& rows);

}  // namespace tribotrack::apps
