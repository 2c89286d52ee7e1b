#include "vision/audit/runs.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace tribotrack::vision {
namespace {

TEST(AuditRuns, AShortRecordingIsAuditedWhole) {
  const auto runs = audit_runs(7, 256);
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs[0].first, 7);
  EXPECT_EQ(runs[0].last, 262);
  EXPECT_TRUE(audit_runs(7, 0).empty());
}

TEST(AuditRuns, ALongOneInRunsFromItsFirstToItsLastFrame) {
  for (const std::int64_t total : {257, 1000, 99'999}) {
    const auto runs = audit_runs(40, total);
    ASSERT_EQ(runs.size(), 32U);
    EXPECT_EQ(runs.front().first, 40);
    EXPECT_EQ(runs.back().last, 40 + total - 1);
    std::int64_t frames = 0;
    for (std::int64_t k = 0; k < 40 + total + 10; ++k) {
      const bool inside = std::any_of(runs.begin(), runs.end(),
                                      [&](const AuditRun& r) { return r.first <= k && k <= r.last; });
      EXPECT_EQ(in_audit(runs, k), inside) << k;
      frames += inside;
    }
    EXPECT_EQ(frames, 256);
    for (std::size_t k = 1; k < runs.size(); ++k) EXPECT_EQ(runs[k].last - runs[k].first + 1, kAuditRun);
  }
}

}  // namespace
}  // namespace tribotrack::vision
