#include "apps/bench/comparison.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "fit/prediction.h"

namespace tribotrack::bench {

using namespace fit;

namespace {

TEST(FitBench, QuickRunComparesTheMethodsAtOneMinimum) {
  const auto rows = bench_fit({.quick = true}).rows;
  ASSERT_EQ(rows.size(), 5u);
  EXPECT_EQ(rows[0].method, "tribotrack");
  EXPECT_EQ(rows[0].at("off_minimum_sd"), 0);
  // Good differences come to the same minimum, another implementation of it all.
  for (const std::size_t k : {0u, 1u, 2u}) EXPECT_TRUE(rows[k].arrived) << rows[k].method;
  EXPECT_LT(rows[0].error, 0.1);
}

}  // namespace
}  // namespace tribotrack::bench
