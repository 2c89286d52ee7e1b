// What one call of `tribotrack bench` measured.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/bench/tables/tables.h"

namespace tribotrack::bench {

struct ModelResults {
  std::vector<ModelBenchRow> rows;
  std::vector<ModelExtremeRow> extremes;
  std::vector<PlanBenchRow> omissions;
  std::vector<BatchBenchRow> batches;
  std::vector<PaperClaim> claims;
};

struct VisionResults {
  std::vector<VisionBenchRow> rows;
  std::vector<VisionLimitRow> limits;
  std::vector<VisionDecodingRow> decodings;
};

struct FitResults {
  std::vector<FitBenchRow> rows;
  std::vector<FilmingRow> filmed;
};

struct CoverageResults {
  std::vector<JudgedParameter> judged;
  std::vector<CoverageRow> rows;
  int campaigns = 0;  ///< of each design and level, at most
  std::uint64_t seed = 0;
};

/// Empty: not run.
struct BenchResults {
  std::optional<ModelResults> model;
  std::optional<VisionResults> vision;
  std::optional<std::vector<WholeCommandRow>> commands;
  std::optional<FitResults> fit;
  std::optional<CoverageResults> coverage;
  std::optional<std::vector<ScaleRow>> scale;
};

/// The tables of what was run, in the order in which they are printed. `missing`: as in tables.h.
std::vector<BenchTable> tables_of(const BenchResults& results, const std::vector<std::string>& missing);

}  // namespace tribotrack::bench
