#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>

#include "vision/audit/halves.h"
#include "vision/audit/synthetic_track.h"

namespace tribotrack::vision {
namespace {

using test::halves_of;
using test::kSigma;
using test::white;

/// A first-order autoregression per component with this correlation from frame to frame.
class Drift {
 public:
  Drift(double sd, double correlation) : sd_(sd), correlation_(correlation) {}
  double at(std::int64_t frame, int component, std::mt19937& random) {
    State& s = states_[static_cast<std::size_t>(component)];
    if (s.frame < 0) s.value = white(random, sd_);
    for (; s.frame < frame; ++s.frame)
      if (s.frame >= 0)
        s.value = correlation_ * s.value + white(random, sd_ * std::sqrt(1 - correlation_ * correlation_));
    return s.value;
  }

 private:
  struct State {
    std::int64_t frame = -1;
    double value = 0;
  };
  double sd_, correlation_;
  std::array<State, 6> states_{};
};

TEST(HalvesOverTheRecording, WhiteNoiseAboutAConstantIsRight) {
  double total = 0, spread = 0, claimed = 0;
  int slow = 0;
  constexpr int kTrials = 200;
  for (unsigned seed = 1; seed <= kTrials; ++seed) {
    const auto found =
        halves_found(halves_of(5000, seed, [](auto, int, std::mt19937& r) { return white(r); }));
    ASSERT_TRUE(found);
    total += found->total.value / kTrials;
    spread += std::pow(found->total.value - 1, 2) / kTrials;
    claimed += found->total.scatter / kTrials;
    slow += found->slow_frames > 0;
    EXPECT_NEAR(found->left_right, 1, 0.15);
    EXPECT_NEAR(found->unit, kSigma * kSigma, 1e-12);
  }
  EXPECT_NEAR(total, 1, 0.01);
  EXPECT_NEAR(std::sqrt(spread), 0.036, 0.006);  // sqrt(2 / 1530)
  EXPECT_NEAR(claimed / std::sqrt(spread), 1, 0.2);
  EXPECT_LE(slow, 3);  // one-sided three standard deviations
}

TEST(HalvesOverTheRecording, ASlowPartIsToldFromTheWhiteOne) {
  double white_part = 0, total = 0, spread = 0, claimed = 0, frames = 0;
  constexpr int kTrials = 100;
  constexpr double kCorrelation = 0.98;  // integral: 0.5 + 0.98 / 0.02 = 49.5 frames
  for (unsigned seed = 1; seed <= kTrials; ++seed) {
    Drift drift(kSigma, kCorrelation);
    const auto found = halves_found(halves_of(
        5000, seed, [&](std::int64_t k, int c, std::mt19937& r) { return white(r) + drift.at(k, c, r); }));
    ASSERT_GT(found->slow_frames, 0);
    white_part += found->white.value / kTrials;
    total += found->total.value / kTrials;
    frames += found->slow_frames / kTrials;
    spread += std::pow(found->total.value - 2, 2) / kTrials;
    claimed += found->total.scatter / kTrials;
  }
  // That of 32 independent runs of 6 numbers, not of 256 frames.
  EXPECT_GT(std::sqrt(spread), 0.08);
  EXPECT_NEAR(claimed / std::sqrt(spread), 1, 0.25);
  EXPECT_NEAR(white_part, 1 + (1 - kCorrelation), 0.04);
  EXPECT_NEAR(total, 2, 0.1);
  EXPECT_GT(frames, 20);
  EXPECT_LT(frames, 150);
}

TEST(HalvesOverTheRecording, ErrorsThatAlternateAreNotTakenForTwice) {
  const auto found = halves_found(halves_of(200, 3, [](std::int64_t k, int, std::mt19937& r) {
    return (k % 2 == 0 ? 2 : -2) * kSigma + white(r, 0.1 * kSigma);
  }));
  EXPECT_NEAR(found->white.value, 4, 0.2);
  EXPECT_EQ(found->slow_frames, 0);
}

TEST(HalvesOverTheRecording, SingleBadFramesDoNotCount) {
  const auto found = halves_found(halves_of(200, 3, [](std::int64_t k, int, std::mt19937& r) {
    return white(r) + (k % 50 == 7 ? 100 * kSigma : 0);
  }));
  EXPECT_NEAR(found->total.value, 1, 0.15);
}

TEST(HalvesOverTheRecording, FewFramesTellNothing) {
  EXPECT_FALSE(halves_found(halves_of(15, 1, [](auto, int, std::mt19937& r) { return white(r); })));
}

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
