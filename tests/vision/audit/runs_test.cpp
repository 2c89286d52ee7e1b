#include "vision/audit/runs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

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

AuditFrame frame_at(std::int64_t index) {
  return {index, {}, Eigen::Matrix2d::Identity()};
}

TEST(AuditSample, AShortTrackWholeAndALongOneInRunsAllOverIt) {
  for (const std::int64_t total : {5, 256, 257, 3000, 40'000}) {
    AuditSample sample;
    std::int64_t asked = 0;
    for (std::int64_t k = 0; k < total; ++k) {
      asked += sample.wanted();
      sample.seen(sample.wanted() ? std::optional(frame_at(k)) : std::nullopt);
    }
    const auto count = static_cast<std::int64_t>(sample.frames().size());
    if (total <= kAuditFrames) {
      EXPECT_EQ(count, total);
      continue;
    }
    EXPECT_LE(count, kAuditFrames);
    EXPECT_GE(count, kAuditFrames / 2 - kAuditRun);
    EXPECT_LE(asked, kAuditFrames * (1 + std::ilogb(total / kAuditFrames) / 2.0 + 1));
    std::map<std::int64_t, int> runs;
    for (const AuditFrame& f : sample.frames()) ++runs[f.index / kAuditRun];
    const std::int64_t spacing = std::next(runs.begin())->first;
    std::int64_t expected = 0;
    for (const auto& [run, frames] : runs) {
      EXPECT_EQ(run, expected);
      if (run != runs.rbegin()->first) {
        EXPECT_EQ(frames, kAuditRun);
      }
      expected += spacing;
    }
    EXPECT_GT((runs.rbegin()->first + spacing + 1) * kAuditRun, total);
  }
}

/// A frame whose halves could not be compared counts as seen, too.
TEST(AuditSample, WhatCannotBeComparedIsLeftOut) {
  AuditSample sample;
  for (std::int64_t k = 0; k < 20; ++k) sample.seen(k == 3 ? std::nullopt : std::optional(frame_at(k)));
  ASSERT_EQ(sample.frames().size(), 19U);
  EXPECT_EQ(sample.frames()[3].index, 4);
}

}  // namespace
}  // namespace tribotrack::vision
