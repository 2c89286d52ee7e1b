#include <gtest/gtest.h>

#include <cmath>

#include "apps/bench/scale/scale.h"

namespace tribotrack::bench {
namespace {

ScaleExponent found(const std::vector<ScaleExponent>& all, const std::string& series,
                    const std::string& cost) {
  for (const ScaleExponent& one : all)
    if (one.series == series && one.cost == cost) return one;
  ADD_FAILURE() << series << ", " << cost << " is missing";
  return {};
}

TEST(ScaleExponents, ArePowersOfTheSize) {
  std::vector<ScaleRow> rows;
  for (const int size : {10, 100, 1000}) {
    rows.push_back({"runs", size, 3e-4 * std::pow(size, 1.5), 1, 2e6 * size, {}});
    rows.push_back({"frames", size, 2e-3, 1, 1e8, 40.0 * size * size});
  }
  const auto all = exponents(rows);
  EXPECT_NEAR(found(all, "runs", "cpu").exponent, 1.5, 1e-12);
  EXPECT_NEAR(found(all, "runs", "cpu").sd, 0, 1e-7);
  EXPECT_NEAR(found(all, "runs", "memory").exponent, 1, 1e-12);
  EXPECT_NEAR(found(all, "frames", "cpu").exponent, 0, 1e-12);
  EXPECT_NEAR(found(all, "frames", "file calls").exponent, 2, 1e-12);
  EXPECT_EQ(all.size(), 5U) << "nobody counted the file calls of the runs";
}

// What does not grow hides what does: 1 s to start, 1 ms a run.
TEST(ScaleExponents, LookAtTheThreeLargestSizes) {
  std::vector<ScaleRow> rows;
  for (const int size : {1, 10, 100'000, 300'000, 1'000'000})
    rows.push_back({"runs", size, 1 + 1e-3 * size, 1, 1e8, {}});
  const ScaleExponent cpu = found(exponents(rows), "runs", "cpu");
  EXPECT_NEAR(cpu.exponent, 1, 0.01);
  EXPECT_EQ(cpu.from, 100'000);
  EXPECT_EQ(cpu.to, 1'000'000);
}

TEST(ScaleExponents, NeedTwoSizes) {
  EXPECT_TRUE(exponents({{"runs", 10, 1, 1, 1e8, 5.0}}).empty());
}

}  // namespace
}  // namespace tribotrack::bench
