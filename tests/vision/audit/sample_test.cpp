#include "vision/audit/sample.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace tribotrack::vision {
namespace {

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
