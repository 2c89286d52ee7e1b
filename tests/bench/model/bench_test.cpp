#include "apps/bench/model/bench.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace tribotrack::bench {

using namespace model;

namespace {

TEST(ModelBench, QuickRunComparesEveryMethodOnEveryScene) {
  ModelBenchOptions options;
  options.quick = true;
  options.peers = {{"another", [](const Scenario& s, double tolerance, long) {
                      return dormand_prince(s, segmented_dormand_prince(s, tolerance));
                    }}};
  int last = 0, total = 0;
  options.progress = [&](int done, int of) {
    EXPECT_EQ(done, last + 1);
    last = done;
    total = of;
  };
  const auto rows = bench_model(options);
  EXPECT_EQ(last, total);
  std::map<std::string, std::set<std::string>> methods;
  for (const ModelBenchRow& row : rows) {
    methods[row.scene].insert(row.method);
    EXPECT_TRUE(row.finished) << row.scene << " " << row.method;
    EXPECT_GT(row.time, 0);
    EXPECT_GE(row.repetitions, 1);
    EXPECT_GT(row.steps, 0);
    EXPECT_FALSE(row.reference.empty());
    EXPECT_EQ(row.ours, std::isnan(row.time_over_ours));
    const double allowed = !row.ours ? 5e-5 : row.tolerance > 1e-10 ? 1e-8 : 1e-16;
    EXPECT_LT(row.error, allowed) << row.scene << " " << row.method;
    EXPECT_GE(row.path_error, row.error);
    EXPECT_LT(row.path_error, allowed) << row.scene << " " << row.method;
  }
  ASSERT_EQ(methods.size(), 4u);
  const std::set<std::string> all{"tribotrack",     "tribotrack (every cycle)",
                                  "paper's recipe", "Dormand-Prince segmented",
                                  "Moreau-Jean",    "another"};
  for (const auto& [scene, seen] : methods) EXPECT_EQ(seen, all) << scene;
}

TEST(ModelBench, TimeOverOursIsAgainstTheFastestOfOursThatIsAsAccurate) {
  ModelBenchOptions options;
  options.quick = true;
  const auto rows = bench_model(options);
  for (const ModelBenchRow& row : rows) {
    if (row.ours) continue;
    double best = INFINITY;
    for (const ModelBenchRow& other : rows)
      if (other.ours && !other.leaves_out && other.scene == row.scene && other.error <= row.error)
        best = std::min(best, other.time);
    EXPECT_DOUBLE_EQ(row.time_over_ours, row.time / best);
  }
}

TEST(ModelBench, EveryExtremeCaseIsFiniteAndKeepsItsLaw) {
  ModelBenchOptions options;
  options.quick = true;
  const auto rows = bench_model_extremes(options);
  EXPECT_GE(rows.size(), 140u);
  std::set<std::string> names;
  for (const ModelExtremeRow& row : rows) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name << " twice";
    EXPECT_EQ(row.failure, "") << row.name;
    EXPECT_TRUE(row.finite) << row.name;
    EXPECT_TRUE(row.derivatives_finite) << row.name;
    EXPECT_TRUE(row.held) << row.name << ": " << row.invariant << " violated by " << row.violation;
    EXPECT_LE(row.violation, row.allowed) << row.name;
  }
  EXPECT_DOUBLE_EQ(rows.front().ratio_per_cycle, 1);
}

}  // namespace
}  // namespace tribotrack::bench
