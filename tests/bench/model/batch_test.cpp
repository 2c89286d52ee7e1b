#include "apps/bench/model/batch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "model/processor/instruction_set.h"

namespace tribotrack::bench {

using namespace model;

namespace {

TEST(BatchBench, QuickRunComparesEverySweepInEveryInstructionSet) {
  ModelBenchOptions options;
  options.quick = true;
  int last = 0, of = 0;
  options.progress = [&](int done, int total) {
    EXPECT_EQ(done, last + 1);
    last = done;
    of = total;
  };
  const auto set = model::internal::instruction_set();
  const auto rows = bench_batch(options);
  EXPECT_EQ(model::internal::instruction_set(), set);
  EXPECT_EQ(last, of);
  ASSERT_EQ(rows.size(), 6 * model::internal::available_instruction_sets().size() + 1);
  std::set<std::string> kinds;
  for (std::size_t k = 0; k + 1 < rows.size(); ++k) {
    const BatchBenchRow& row = rows[k];
    EXPECT_TRUE(kinds.insert(row.sweep + row.wanted + row.instruction_set).second);
    EXPECT_GT(row.in_lanes, 0.9);
    EXPECT_GT(row.full, 0);
    EXPECT_LE(row.full, 1);
    EXPECT_GT(row.time_lanes, 0);
    EXPECT_DOUBLE_EQ(row.speedup, row.time_scalar / row.time_lanes);
    EXPECT_DOUBLE_EQ(row.million, row.time_lanes * 5e5);
    // Of 20 cycles, in amplitudes of the drive.
    EXPECT_LT(row.difference, 1e-10);
  }
  EXPECT_EQ(rows.back().scenarios, 400u);
  EXPECT_GT(rows.back().million, 0);
  EXPECT_TRUE(std::isnan(rows.back().speedup));
}

}  // namespace
}  // namespace tribotrack::bench
