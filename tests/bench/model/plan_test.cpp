#include "apps/bench/model/plan.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tribotrack::bench {
namespace {

TEST(PlanBench, EveryOmissionIsMeasuredAndAddsNoErrorBeyondItsBound) {
  ModelBenchOptions options;
  options.quick = true;
  const auto rows = bench_plan(options);
  EXPECT_GE(rows.size(), 12u);
  for (const PlanBenchRow& row : rows) {
    EXPECT_GT(row.time_with, 0) << row.omission;
    EXPECT_GT(row.time_without, 0) << row.omission;
    if (!std::isnan(row.error)) {
      EXPECT_LT(row.error, row.error_bound + 1e-16) << row.omission << ", " << row.scene;
    }
  }
}

}  // namespace
}  // namespace tribotrack::bench
