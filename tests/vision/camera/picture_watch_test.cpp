#include "vision/duplicate_frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "vision/analytic_scene.h"
#include "vision/edge/radius.h"
#include "vision/recordings.h"

namespace tribotrack::vision {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

using Way = std::function<Point(double k)>;

Point round_about(double k) {
  return {48 + 5 * std::cos(0.26 * k), 40 + 5 * std::sin(0.26 * k)};
}

/// A disc on its way over a ground with a texture of its own, noise of one level.
Picture picture_at(double k, const Way& way, double noise = 1) {
  std::mt19937 random(static_cast<unsigned>(1 + 2 * k));
  test::TestScene scene;
  scene.height = 80;
  scene.ground_texture.waves = {{6, 0.9, 0.4, 0}, {6, -0.3, 1.1, 1}};
  const Point centre = way(k);
  scene.discs = {{.x = centre.x, .y = centre.y, .radius = 14}};
  return test::noisy(scene.render(), noise, random);
}

class PictureWatchTest : public RecordingTest {
 protected:
  RepeatedFrames look(const std::string& name, int crf, const std::vector<Picture>& pictures) {
    const auto sink = create_sink(file(name), {.width = 96, .height = 80, .frame_rate_hz = 240, .crf = crf});
    for (const Picture& picture : pictures) sink->write(picture);
    sink->close();
    return find_repeated_frames(*open_source(file(name)), 1000);
  }
};

TEST_F(PictureWatchTest, ACodedRepeatIsFoundAndAMotionThatTurnsRoundIsNone) {
  std::vector<Picture> twice, often, shaken;
  std::vector<std::int64_t> odd, later;
  for (int k = 0; k < 24; ++k) {
    twice.insert(twice.end(), 2, picture_at(k, round_about));
    odd.push_back(2 * k + 1);
    // 3, 4, 3, 4 times
    for (int n = 0; n < 3 + k % 2; ++n) {
      if (n > 0) later.push_back(std::ssize(often));
      often.push_back(twice.back());
    }
    // Its turns fall between two frames, on one, and at any place between.
    shaken.push_back(picture_at(
        k,
        [](double t) {
          return Point{48 + 6 * std::cos(0.27 * t + 0.1), 40};
        },
        0.3));
  }
  for (const auto& [name, crf] :
       {std::pair{"a.mp4", 12}, std::pair{"a.mp4", 26}, std::pair{"a.avi", 0}, std::pair{"a.mkv", 0}}) {
    SCOPED_TRACE(name + std::to_string(crf));
    EXPECT_EQ(look(name, crf, twice).repeated, odd);
    EXPECT_EQ(look(name, crf, often).repeated, later);
    EXPECT_THAT(look(name, crf, shaken).repeated, IsEmpty());
  }
}

TEST_F(PictureWatchTest, WeavedFieldsAreRecognised) {
  std::vector<Picture> weaved, progressive;
  for (int k = 0; k < 16; ++k) {
    progressive.push_back(picture_at(k, round_about));
    weaved.push_back(progressive.back());
    const Picture later = picture_at(k + 0.5, round_about);
    for (int y = 1; y < 80; y += 2) std::ranges::copy(later.row(y), weaved.back().row(y).begin());
  }
  EXPECT_TRUE(look("a.mkv", 0, weaved).weaved);
  EXPECT_FALSE(look("a.mkv", 0, progressive).weaved);
  EXPECT_TRUE(look("a.mp4", 20, weaved).weaved);
  EXPECT_FALSE(look("a.mp4", 20, progressive).weaved);
  TrackOptions options;
  options.target = {Target::Kind::disc, {53, 40, 14}, {}};
  look("a.mkv", 0, weaved);
  EXPECT_THAT(refusal_of([&] { track(*open_source(file("a.mkv")), options); }), HasSubstr("interlaced"));
}

/// Every picture once, or as `shown` says.
test::RenderedSource source_of(const std::vector<int>& shown) {
  return {96, 80, std::ssize(shown),
          [shown](std::int64_t k) { return picture_at(shown[static_cast<std::size_t>(k)], round_about); }};
}

TEST(EachPictureOnce, ARepeatIsARowWithoutAPosition) {
  TrackOptions options;
  options.target = {Target::Kind::disc, {53, 40, 14}, {}};
  auto plain = source_of({0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  auto repeating = source_of({0, 1, 2, 2, 3, 4, 5, 5, 5, 6, 7, 8, 9});
  repeating.number_from(-3);
  const TrackResult once = track(plain, options), result = track(repeating, options);
  EXPECT_EQ(result.summary.repeats, 3);
  EXPECT_EQ(result.summary.frames, 13);
  EXPECT_THAT(result.summary.warnings,
              Contains(HasSubstr("3 pictures repeat the one before: image 0, 4, 5;")));
  ASSERT_EQ(result.track.points.size(), 13u);
  std::size_t seen = 0;
  for (std::size_t k = 0; k < 13; ++k) {
    const TrackPoint& point = result.track.points[k];
    EXPECT_EQ(point.frame, static_cast<std::int64_t>(k) - 3);
    EXPECT_DOUBLE_EQ(point.time_s, 1e-3 * static_cast<double>(k));
    EXPECT_EQ(point.status == TrackStatus::repeat, k == 3 || k == 7 || k == 8);
    if (point.status == TrackStatus::repeat) continue;
    EXPECT_EQ(point.x, once.track.points[seen].x) << "as if it had not been stored twice";
    EXPECT_EQ(point.sigma_x, once.track.points[seen++].sigma_x);
  }
}

TEST(EachPictureOnce, EveryNthFrameHasItsOwnNumberAndTime) {
  TrackOptions options;
  options.target = {Target::Kind::disc, {round_about(2).x, round_about(2).y, 14}, {}};
  options.first_frame = 12;
  options.last_frame = 20;
  options.frame_step = 3;
  auto source = source_of({0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
  source.number_from(10);
  const auto points = track(source, options).track.points;
  ASSERT_EQ(points.size(), 3u);
  for (int k = 0; k < 3; ++k) {
    const TrackPoint& point = points[static_cast<std::size_t>(k)];
    EXPECT_EQ(point.frame, 12 + 3 * k);
    EXPECT_DOUBLE_EQ(point.time_s, 1e-3 * (2 + 3 * k));
    EXPECT_NEAR(point.x, round_about(2 + 3 * k).x, 0.1);
  }
}

TEST(Roundness, AnEllipseIsSaidAndADiscIsNot) {
  const auto seen = [](double ratio, double angle) {
    Picture picture(120, 110, 60);
    std::mt19937 random(5);
    for (int y = 0; y < 110; ++y)
      for (int x = 0; x < 120; ++x) {
        const double dx = x - 60.3, dy = 54.6 - y;
        const double u = std::cos(angle) * dx + std::sin(angle) * dy,
                     v = std::cos(angle) * dy - std::sin(angle) * dx;
        picture.at(x, y) += static_cast<float>(90 * test::disc_share(std::hypot(u / ratio, v), 25, 0.8));
      }
    return roundness_warning(test::noisy(picture, 2, random), {60.3, 54.6, 25 * std::sqrt(ratio)})
        .value_or("");
  };
  EXPECT_EQ(seen(1, 0), "");
  EXPECT_EQ(seen(1.03, 1), "");
  EXPECT_THAT(seen(1.1, 0.5), HasSubstr("differ by 10 %, the longer one at 28 degrees"));
  EXPECT_THAT(seen(4.0 / 3, 0), HasSubstr("differ by 29 %, the longer one at 0 degrees"));
}

}  // namespace
}  // namespace tribotrack::vision
