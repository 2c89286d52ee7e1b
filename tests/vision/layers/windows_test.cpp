#include "vision/layers/windows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <vector>

#include "vision/analytic_scene.h"

namespace tribotrack::vision {
namespace {

constexpr int kWidth = 160, kHeight = 90;
constexpr double kReach = 20, kHidden = 12;

double ground_level(int x, int y) {
  return 70 + 5 * std::sin(0.4 * x) * std::cos(0.3 * y);
}

/// A bright part on the ground in every frame.
test::RenderedSource source_of(const std::vector<FirstPassFrame>& frames, int width = kWidth,
                               int height = kHeight, bool crossed = false) {
  return {width, height, frames.back().index + 1, [=](std::int64_t k) {
            Picture out(width, height);
            const auto at = std::ranges::find(frames, k, &FirstPassFrame::index);
            for (int y = 0; y < height; ++y)
              for (int x = 0; x < width; ++x) {
                out.at(x, y) = static_cast<float>(ground_level(x, y));
                if (at != frames.end() && std::hypot(x - at->centre.x, y - at->centre.y) < 10)
                  out.at(x, y) = 150;
                // A bar that has crossed the picture at the end.
                if (crossed && std::abs(x - static_cast<int>(k)) < 8) out.at(x, y) = 30;
              }
            return out;
          }};
}

/// Mostly at rest, where it is found to within a tenth of a pixel; from frame `start` on a pixel per frame.
std::vector<FirstPassFrame> started_late(std::int64_t frames, std::int64_t start) {
  std::vector<FirstPassFrame> out;
  for (std::int64_t k = 0; k < frames; ++k) {
    FirstPassFrame f;
    f.index = k;
    f.centre = {30 + 0.1 * std::sin(static_cast<double>(7 * k)) +
                    static_cast<double>(std::max<std::int64_t>(0, k - start)),
                45};
    f.theta = 0.01 * static_cast<double>(k);
    out.push_back(f);
  }
  return out;
}

LayeredOptions options_of(const std::vector<FirstPassFrame>& frames) {
  LayeredOptions options;
  options.noise_variance = 0.1;
  options.total = frames.back().index + 1;
  return options;
}

std::vector<KeptWindow> windows_of(const std::vector<FirstPassFrame>& frames) {
  test::RenderedSource source = source_of(frames);
  const LayeredOptions options = options_of(frames);
  LearningFrames learning(source, frames, options, kReach, kHidden);
  GroundPicture ground(learning.region());
  return learning.read(ground);
}

std::int64_t widest_gap(const std::vector<KeptWindow>& windows) {
  std::int64_t gap = 0;
  for (std::size_t k = 1; k < windows.size(); ++k)
    gap = std::max(gap, windows[k].frame - windows[k - 1].frame);
  return gap;
}

TEST(LearningFrames, ShortRecordingIsKeptWhole) {
  const std::vector<FirstPassFrame> frames = started_late(60, 20);
  test::RenderedSource source = source_of(frames);
  const LayeredOptions options = options_of(frames);
  LearningFrames learning(source, frames, options, kReach, kHidden);
  EXPECT_EQ(learning.count(), 60);
  GroundPicture ground(learning.region());
  const std::vector<KeptWindow> windows = learning.read(ground);
  ASSERT_EQ(windows.size(), 60);
  for (std::size_t k = 0; k < windows.size(); ++k) {
    const KeptWindow& w = windows[k];
    ASSERT_EQ(w.frame, frames[k].index);
    ASSERT_EQ(w.state.centre.x, frames[k].centre.x);
    ASSERT_EQ(w.state.theta, frames[k].theta);
    ASSERT_EQ(w.state.gain, 1);
    ASSERT_EQ(w.state.ground_gain, 1);
    // The window is the frame's, the part with a margin in it.
    ASSERT_LE(w.x, w.state.centre.x - kReach + 1);
    ASSERT_GE(w.x + w.picture.width() - 1, w.state.centre.x + kReach - 1);
    const Picture whole = source.FrameSource::read(w.frame);
    for (int y = 0; y < w.picture.height(); ++y)
      for (int x = 0; x < w.picture.width(); ++x) ASSERT_EQ(w.picture.at(x, y), whole.at(w.x + x, w.y + y));
    ASSERT_NEAR(w.spline.value(5, 6), w.picture.at(5, 6), 1e-3);
  }
  // The ground the part has left, and that it has not come to yet; noise draws it a little to the mean.
  for (const int x : {35, 50, 65})
    EXPECT_NEAR(ground.mean() + ground.spline().value(x - ground.region().x, 45 - ground.region().y),
                ground_level(x, 45), 3e-3);
}

// Half of them spread over the time, half over the way: where the part moves for a tenth of the time.
TEST(LearningFrames, AreSpreadOverTimeAndWay) {
  const std::vector<KeptWindow> windows = windows_of(started_late(1000, 900));
  EXPECT_EQ(windows.size(), 128);
  EXPECT_TRUE(std::ranges::is_sorted(windows, {}, &KeptWindow::frame));
  std::set<std::int64_t> frames;
  for (const KeptWindow& w : windows) frames.insert(w.frame);
  EXPECT_EQ(frames.size(), 128);
  EXPECT_LE(*frames.begin(), 16);
  EXPECT_GE(*frames.rbegin(), 999 - 16);
  // 64 over the time leave gaps of 16, rounded to the frames that were kept in the cache.
  EXPECT_LE(widest_gap(windows), 24);
  // 64 over the way and 6 over the time, less those that are both.
  const auto moving = std::ranges::count_if(frames, [](std::int64_t frame) { return frame >= 900; });
  EXPECT_GE(moving, 60);
  EXPECT_LE(moving, 80);
}

TEST(LearningFrames, OfAPartAtRestAreSpreadOverTheTime) {
  const std::vector<KeptWindow> windows = windows_of(started_late(1000, 1000));
  EXPECT_EQ(windows.size(), 128);
  EXPECT_LE(widest_gap(windows), 17);
}

TEST(LearningFrames, FitIntoMemory) {
  constexpr int kSize = 1200;
  const std::vector<FirstPassFrame> frames = started_late(300, 200);
  test::RenderedSource source = source_of(frames, kSize, kSize);
  const LayeredOptions options = options_of(frames);
  constexpr double kPad = QuinticSpline::kPad;
  double before = 129;
  for (const double reach : {30.0, 200.0, 300.0, 500.0}) {
    const LearningFrames learning(source, frames, options, reach, reach);
    // A window and its spline, and the ground's pictures. Sixteen windows are kept whatever they take.
    const double window = 4 * (std::pow(2 * reach + 1, 2) + std::pow(2 * reach + 1 + 2 * kPad, 2));
    const double ground = 40.0 * learning.region().width * learning.region().height;
    const auto count = static_cast<double>(learning.count());
    EXPECT_LE(count, before);
    EXPECT_LT(count * window + ground, reach < 400 ? 140e6 : 220e6);
    EXPECT_GE(count, 16);
    if (count < 128 && count > 16) {
      EXPECT_GT((count + 2) * window + ground, 140e6);
    }
    before = count;
  }
  EXPECT_EQ(before, 16);
}

TEST(LearningFrames, GroundIsWhatMostFramesShow) {
  const std::vector<FirstPassFrame> frames = started_late(128, 30);
  test::RenderedSource source = source_of(frames, kWidth, kHeight, true);
  const LayeredOptions options = options_of(frames);
  LearningFrames learning(source, frames, options, kReach, kHidden);
  GroundPicture ground(learning.region());
  learning.read(ground);
  const auto worst = [&] {
    double off = 0;
    for (int y = ground.region().y; y < 30; ++y)
      for (int x = 20; x < 110; ++x)
        off = std::max(off, std::abs(ground.mean() +
                                     ground.spline().value(x - ground.region().x, y - ground.region().y) -
                                     ground_level(x, y)));
    return off;
  };
  EXPECT_GT(ground.unrest(), 2 * options.noise_variance);
  EXPECT_GT(worst(), 3);
  learning.read_uncrossed(ground);
  EXPECT_LT(ground.unrest(), 0.01);
  EXPECT_LT(worst(), 0.1);
  EXPECT_LT(ground.held_share(), 0.95);
}

// Ground that has moved by 5 px shows places that lay so far outside the picture.
TEST(Swath, HoldsThePathWithItsMarginAndWhatThePictureShowsOfThePlatform) {
  std::vector<FirstPassFrame> frames(2);
  frames[0].centre = {50, 40};
  frames[1].centre = {70, 44};
  const Rect still = swath(frames, 10, {0, 0, 100, 90});
  EXPECT_TRUE(still.contains({40, 30, 41, 25}));
  EXPECT_LE(still.width, 20 + 2 * (10 + 4) + 2);
  frames[1].ground = {3, 4};
  const Rect moved = swath(frames, 10, {0, 0, 100, 90});
  EXPECT_EQ(moved.x, still.x - 10);  // twice the 5 px
  EXPECT_EQ(moved.x + moved.width, 95);
  const Rect wide = swath(frames, 60, {0, 0, 100, 90});
  EXPECT_TRUE(wide.contains({-5, -5, 110, 100}));
  EXPECT_TRUE((Rect{-5, -5, 110, 100}).contains(wide));
}

}  // namespace
}  // namespace tribotrack::vision
