#include "apps/bench/model.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

namespace tribotrack::bench {
namespace {

const BenchOptions kQuick{.quick = true};

TEST(ModelBench, QuickRunComparesEveryMethodOnEveryScene) {
  const Comparison comparison = bench_model(kQuick, {library_peers().front()});
  std::map<std::string, std::set<std::string>> methods;
  for (const ComparedRow& row : comparison.rows) {
    methods[row.scene].insert(row.method);
    EXPECT_TRUE(row.arrived) << row.scene << " " << row.method;
    EXPECT_GT(row.time, 0);
    EXPECT_GE(row.at("repetitions"), 1);
    EXPECT_GT(row.at("steps"), 0);
    const double allowed = !row.ours ? 5e-5 : row.setting == "tolerance 1e-06" ? 1e-8 : 1e-16;
    EXPECT_LT(row.error, allowed) << row.scene << " " << row.method;
  }
  ASSERT_EQ(methods.size(), 4u);
  const std::set<std::string> all{"tribotrack", "paper's recipe", "odeint Dormand-Prince 5(4)",
                                  "Moreau-Jean"};
  for (const auto& [scene, seen] : methods) EXPECT_EQ(seen, all) << scene;
}

TEST(ModelBench, EveryExtremeCaseIsFiniteAndKeepsItsLaw) {
  const auto rows = bench_extremes(kQuick);
  EXPECT_GE(rows.size(), 136u);
  std::set<std::string> names;
  for (const ExtremeRow& row : rows) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name << " twice";
    EXPECT_EQ(row.failure, "") << row.name;
    EXPECT_TRUE(row.derivatives_finite) << row.name;
    EXPECT_TRUE(row.held) << row.name << ": " << row.law << " violated by " << row.violation;
    EXPECT_LE(row.violation, row.allowed) << row.name;
  }
  EXPECT_DOUBLE_EQ(rows.front().ratio_per_cycle, 1);
}

TEST(ModelBench, OmissionsLeaveTheMotionAsItIs) {
  const auto rows = bench_omissions(kQuick);
  EXPECT_GE(rows.size(), 12u);
  for (const OmissionRow& row : rows) {
    EXPECT_GT(row.time_with, 0) << row.omission;
    EXPECT_GT(row.time_without, 0) << row.omission;
    EXPECT_LT(row.error, 1e-15) << row.omission << ", " << row.scene;
  }
}

}  // namespace
}  // namespace tribotrack::bench
