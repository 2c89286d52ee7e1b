#include "vision/camera/frame_cache.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "vision/io/levels.h"
#include "vision/layered_scenes.h"
#include "vision/tracker.h"

namespace tribotrack::vision {
namespace {

using test::SceneSource;
using test::SlidingScene;

/// Frames whose levels tell their place; counts what is decoded: each change of frame.
class Counting : public FrameSource {
 public:
  explicit Counting(double scale, bool decoded = true) : scale_(scale) {
    info_.path = "counting";
    info_.width = 40;
    info_.height = 30;
    info_.frame_count = 100;
    info_.decoded = decoded;
  }
  void fill(std::int64_t index, const Rect& window, Picture& picture) override {
    ++reads;
    for (int y = 0; y < window.height; ++y)
      for (int x = 0; x < window.width; ++x) picture.at(x, y) = level(index, window.x + x, window.y + y);
  }
  float level(std::int64_t index, int x, int y) const {
    return static_cast<float>(scale_ * static_cast<double>((index * 31 + x * 7 + y * 13) % 256));
  }
  int reads = 0;

 private:
  double scale_;
};

void expect_right(const Counting& source, std::int64_t index, const Rect& w, const Picture& picture) {
  ASSERT_EQ(picture.width(), w.width);
  ASSERT_EQ(picture.height(), w.height);
  for (int y = 0; y < w.height; ++y)
    for (int x = 0; x < w.width; ++x)
      ASSERT_EQ(picture.at(x, y), source.level(index, w.x + x, w.y + y)) << x << ' ' << y;
}

TEST(FrameCache, WhatIsKeptComesBackBitForBitWithoutTheSource) {
  for (const double scale : {1.0, 257.0, 0.299, 300.0}) {  // bytes, words, fractions, beyond words
    Counting source(scale);
    FrameCache frames(source);
    const Rect kept{3, 5, 20, 17}, within{8, 6, 11, 9};
    for (const std::int64_t k : {0, 7, 99}) frames.keep(k, kept);
    const int reads = source.reads;
    Picture picture;
    for (const std::int64_t k : {99, 0, 7})
      for (const Rect& w : {kept, within}) {
        frames.read(k, w, picture);
        expect_right(source, k, w, picture);
      }
    EXPECT_EQ(source.reads, reads) << scale;
    const std::int64_t bytes = frames.kept_bytes();
    EXPECT_EQ(bytes, 3 * 20 * 17 * (scale == 1 ? 1 : scale == 257 ? 2 : 4));
    frames.keep(7, within);
    EXPECT_EQ(frames.kept_bytes(), bytes) << "kept already";
  }
}

TEST(FrameCache, NothingIsKeptOfWhatCostsNothingToReadAgain) {
  Counting source(1, false);
  FrameCache frames(source);
  frames.keep(4, frames.bounds());
  EXPECT_EQ(source.reads, 0);
  EXPECT_EQ(frames.kept_bytes(), 0);
}

TEST(FrameCache, WhatIsMoreThanItMayHoldIsReadFromTheSource) {
  Counting source(1);
  FrameCache frames(source, 250);
  Picture picture;
  for (std::int64_t k = 0; k < 5; ++k) frames.keep(k, {0, 0, 10, 10});
  EXPECT_EQ(frames.kept_bytes(), 200);
  for (std::int64_t k = 0; k < 5; ++k) {
    frames.read(k, {0, 0, 10, 10}, picture);
    expect_right(source, k, {0, 0, 10, 10}, picture);
  }
}

/// Our nameless temporary file, by the name the system gives open ones; empty where it tells none.
std::filesystem::path open_temporary_file() {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", error)) {
    const auto target = std::filesystem::read_symlink(entry.path(), error);
    if (target.string().find("tribotrack-frames-") != std::string::npos) return entry.path();
  }
  return {};
}

TEST(FrameCache, AFileThatShrinksIsNoLossButTime) {
  Counting source(1);
  FrameCache frames(source);
  for (std::int64_t k = 0; k < 4; ++k) frames.keep(k, {0, 0, 10, 10});
  const auto file = open_temporary_file();
  if (file.empty()) GTEST_SKIP() << "the system does not name open files";
  std::filesystem::resize_file(file, 250);
  Picture picture;
  for (const std::int64_t k : {0, 2, 3, 1}) {
    frames.read(k, {0, 0, 10, 10}, picture);
    expect_right(source, k, {0, 0, 10, 10}, picture);
  }
}

/// A scene that costs its decoding: how often does the frame in hand change?
class Decoding : public FrameSource {
 public:
  explicit Decoding(SceneSource& scene, bool decoded) : scene_(scene) {
    info_ = scene.info();
    info_.decoded = decoded;
  }
  void fill(std::int64_t index, const Rect& window, Picture& picture) override {
    decodings += index != held_;
    held_ = index;
    scene_.read(index, window, picture);
  }
  std::int64_t decodings = 0;

 private:
  SceneSource& scene_;
  std::int64_t held_ = -1;
};

TEST(FrameCache, ARecordingIsDecodedOnceAndTrackedAsIfItWereNotDecoded) {
  SlidingScene s;
  s.frames = 160;
  SceneSource scene(s);
  TrackOptions options;
  options.marker.kind = MarkerChoice::Kind::circle;
  const MarkerAppearance& marker = *s.scene.marker;
  options.marker.circle = {marker.position.x + s.circle_px, marker.position.y, marker.radius_px};
  Decoding decoded(scene, true), rows(scene, false);
  const TrackResult a = track(decoded, options), b = track(rows, options);
  ASSERT_TRUE(a.summary.layered);
  EXPECT_GT(rows.decodings, 2 * s.frames);
  EXPECT_EQ(decoded.decodings, s.frames);
  ASSERT_EQ(a.track.points.size(), b.track.points.size());
  for (std::size_t k = 0; k < a.track.points.size(); ++k) {
    EXPECT_EQ(a.track.points[k].x, b.track.points[k].x);
    EXPECT_EQ(a.track.points[k].y, b.track.points[k].y);
    EXPECT_EQ(a.track.points[k].sigma_x, b.track.points[k].sigma_x);
  }
}

}  // namespace
}  // namespace tribotrack::vision
