// Which object is the part, and is it still the same? Scenes of equal discs, and what may be said of them.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "vision/analytic_scene.h"
#include "vision/recordings.h"
#include "vision/tracker.h"

namespace tribotrack::vision {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

constexpr double kGround = 60, kLevel = 160, kBlur = 0.8, kNoise = 1.5;

Picture pictured(int width, int height, const std::vector<Circle>& discs, std::mt19937& random) {
  std::normal_distribution<float> noise(0, kNoise);
  Picture picture(width, height, kGround);
  for (const Circle& c : discs)
    for (int y = std::max(0, static_cast<int>(c.y - c.radius - 5));
         y < std::min<double>(height, c.y + c.radius + 5); ++y)
      for (int x = std::max(0, static_cast<int>(c.x - c.radius - 5));
           x < std::min<double>(width, c.x + c.radius + 5); ++x)
        picture.at(x, y) += static_cast<float>(
            (kLevel - kGround) * 0.5 *
            std::erfc((std::hypot(x - c.x, y - c.y) - c.radius) / (std::numbers::sqrt2 * kBlur)));
  for (float& level : picture.levels()) level = std::round(level + noise(random));
  return picture;
}

MemorySource recorded(int width, int height, int frames,
                      const std::function<std::vector<Circle>(int frame)>& discs) {
  std::mt19937 random(7);
  std::vector<Picture> pictures;
  for (int k = 0; k < frames; ++k) pictures.push_back(pictured(width, height, discs(k), random));
  return {std::move(pictures), 500};
}

TrackOptions given(const Circle& disc) {
  TrackOptions options;
  options.target = {Target::Kind::disc, disc, {}};
  options.layers = Layers::off;
  options.marker.kind = MarkerChoice::Kind::none;
  return options;
}

/// 28 equal dots, 40 px apart, carried by one platform.
struct Dots {
  static constexpr double kApart = 40;
  std::function<Point(int frame)> carried;
  MemorySource recording(int frames) const {
    return recorded(340, 220, frames, [this](int k) {
      std::vector<Circle> dots;
      const Point by = carried(k);
      for (int column = 0; column < 7; ++column)
        for (int row = 0; row < 4; ++row)
          dots.push_back({50.3 + kApart * column + by.x, 50.6 + kApart * row + by.y, 7});
      return dots;
    });
  }
};

int ok_rows_on_another_dot(const TrackResult& result, const Dots& dots, const Circle& start) {
  int wrong = 0;
  const Point first = dots.carried(0);
  for (const TrackPoint& p : result.track.points) {
    const Point by = dots.carried(static_cast<int>(p.frame));
    wrong += p.status == TrackStatus::ok &&
             std::hypot(p.x - start.x - by.x + first.x, p.y - start.y - by.y + first.y) > 1;
  }
  return wrong;
}

TEST(LookAlikes, AJumpByHalfTheirDistanceEndsTheTrackAndIsSaid) {
  const std::vector<Circle> starts = {{170.3, 90.6, 7}, {50.3, 50.6, 7}, {290.3, 170.6, 7}};
  const std::vector<Point> jumps = {{20, 0}, {-20, 0}, {0, 20}, {20, 20}};
  for (const Circle& start : starts)
    for (const Point& jump : jumps)
      for (const int from : {1, 6}) {
        const Dots dots{[&](int k) {
          const double steps = k < from ? 0 : (k - from) % 3 + 1;
          return Point{0.7 * k + jump.x * steps, -0.3 * k + jump.y * steps};
        }};
        MemorySource source = dots.recording(12);
        const TrackResult result = track(source, given(start));
        EXPECT_EQ(ok_rows_on_another_dot(result, dots, start), 0)
            << start.x << ", " << jump.x << ", " << jump.y << ", " << from;
        EXPECT_FALSE(result.summary.gate_passed);
        if (start.x == starts[0].x) {
          EXPECT_THAT(result.summary.warnings, Contains(HasSubstr("look like the part")));
        }
      }
}

TEST(LookAlikes, CarriedSlowlyAreToldApart) {
  const Dots dots{[](int k) { return Point{8 * std::sin(0.5 * k), 8 * std::cos(0.5 * k)}; }};
  MemorySource source = dots.recording(30);
  const Circle start{170.3, 98.6, 7};
  const TrackResult result = track(source, given(start));
  EXPECT_EQ(result.summary.ok, 30);
  EXPECT_EQ(ok_rows_on_another_dot(result, dots, start), 0);
}

/// Its speed is not known in the second frame, and it passes others that rest.
TEST(LookAlikes, ThatStayWhereTheyAreDoNotEndAFastTrack) {
  MemorySource source = recorded(300, 120, 16, [](int k) {
    return std::vector<Circle>{{30.4 + 11.0 * k, 60.2, 8}, {50.3, 42.2, 8}, {100.3, 79, 8}, {160.3, 41, 8}};
  });
  EXPECT_EQ(track(source, given({30.4, 60.2, 8})).summary.ok, 16);
}

TEST(Question, SeveralDiscsOfEqualRightAreNumbered) {
  MemorySource source = recorded(200, 120, 4, [](int k) {
    return std::vector<Circle>{{140.2, 70.4, 10}, {50.5 + k, 40.3, 10.4}, {100, 30, 4}};
  });
  try {
    track(source, {});
    FAIL() << "no question";
  } catch (const AmbiguousTarget& question) {
    EXPECT_THAT(question.what(), HasSubstr("2 discs in frame 0"));
    EXPECT_TRUE(question.first);
    ASSERT_EQ(question.discs.size(), 2U);  // the small one is not alike
    EXPECT_NEAR(question.discs[0].x, 50.5, 0.1);
    EXPECT_NEAR(question.discs[1].x, 140.2, 0.1);
  }
}

TEST(Question, ADiscThatRestsWhileAnotherComesInIsOne) {
  const auto scene = [](bool another) {
    return recorded(200, 120, 60, [another](int k) {
      std::vector<Circle> discs{{60.4, 60.2, 16}};
      if (another && k >= 20) discs.push_back({190 - 2.0 * (k - 20), 30.3, 9});
      return discs;
    });
  };
  MemorySource alone = scene(false), both = scene(true);
  EXPECT_THAT(track(alone, {}).summary.warnings, Contains(HasSubstr("stays within")));
  try {
    track(both, {});
    FAIL() << "no question";
  } catch (const AmbiguousTarget& question) {
    EXPECT_THAT(question.what(), HasSubstr("rests for ever"));
    EXPECT_FALSE(question.first);
    ASSERT_EQ(question.discs.size(), 2U);
    EXPECT_NEAR(question.discs[0].x, 60.4, 0.1);
    EXPECT_NEAR(question.discs[1].x, 190 - 2.0 * static_cast<double>(question.frame - 20), 0.3);
  }
}

TEST(Question, ADiscThatIsStruckByAnotherMayBeThePart) {
  MemorySource source = recorded(200, 120, 60, [](int k) {
    std::vector<Circle> discs{{60.4 + 1.5 * std::max(0, k - 30), 60.2, 10}};
    if (k >= 12) discs.push_back({190 - 2.0 * (k - 12), 30.3, 10});
    return discs;
  });
  EXPECT_THAT(refusal_of([&] { track(source, {}); }),
              HasSubstr("rests until frame 30 (is it the part? --disc 60.4,60.2,10.0 --frames 30:)"));
}

/// A disc sliding past the place that was given for it.
TEST(GivenDisc, ThatIsNotThereIsSaidAtOnceWithTheNearest) {
  MemorySource source = recorded(240, 120, 100, [](int k) {
    return std::vector<Circle>{{60.4 + 0.5 * k, 60.2, 10}};
  });
  for (const Circle& wrong : {Circle{67.4, 60.2, 10}, Circle{60.4, 97.2, 10}}) {
    const std::string refusal = refusal_of([&] { track(source, given(wrong)); });
    EXPECT_THAT(refusal, HasSubstr("no disc at --disc"));
    EXPECT_THAT(refusal, HasSubstr("--disc 60.4,60.2,10"));
  }
  EXPECT_EQ(track(source, given({61.9, 59, 10})).summary.ok, 100);
}

/// A coder leaves steps of a level or two on an even ground, without noise.
TEST(GivenDisc, IsNotWhatACoderLeavesOfAnEvenGround) {
  std::vector<Picture> pictures;
  for (int k = 0; k < 40; ++k) {
    test::TestScene scene;
    scene.width = 120;
    scene.height = 80;
    scene.discs = {{60, 40, k < 20 ? 5.0 : 8.0, 0, k < 20 ? 62.0 : 160.0, {}}};
    Picture picture = scene.render();
    for (float& level : picture.levels()) level = std::round(level);
    pictures.push_back(std::move(picture));
  }
  MemorySource source(std::move(pictures), 100);
  const TrackSummary summary = track(source, given({60, 40, 8})).summary;
  EXPECT_EQ(summary.absent_at_first, 20);
  EXPECT_EQ(summary.ok, 20);
  EXPECT_THAT(summary.warnings, Contains(HasSubstr("before frame 20")));
}

Point held_then_sliding(int k) {
  return {60.4 + (k < 18 ? 0 : 0.8 * (k - 18)), 60.2};
}

/// A hand - dark, as large as the disc, textured - holds it in the first frames, then lets go and leaves.
MemorySource held_by_a_hand() {
  std::mt19937 random(3);
  std::vector<Picture> pictures;
  for (int k = 0; k < 120; ++k) {
    const Point at = held_then_sliding(k);
    Picture picture = pictured(240, 120, {{at.x, at.y, 10}}, random);
    const double away = k < 18 ? 0.05 * k : 3.0 * (k - 18);
    const Point middle{50.4 - away, 63.2};
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 240; ++x)
        if (std::hypot(x - middle.x, y - middle.y) < 10)
          picture.at(x, y) = static_cast<float>(100 + 30 * std::sin(0.9 * (x - middle.x)) +
                                                20 * std::cos(0.7 * (y - middle.y)));
    pictures.push_back(std::move(picture));
  }
  return {std::move(pictures), 500};
}

/// Where the template shows the hand the part is lost, not taken for the hand.
TEST(Hand, InTheFirstFramesIsNotFollowed) {
  for (const bool by_itself : {false, true}) {
    MemorySource source = held_by_a_hand();
    TrackOptions options = given({60.4, 60.2, 10});
    if (by_itself) options.target.kind = Target::Kind::find_disc;
    for (const TrackPoint& p : track(source, options).track.points) {
      const Point truth = held_then_sliding(static_cast<int>(p.frame));
      EXPECT_FALSE(p.status == TrackStatus::ok && std::hypot(p.x - truth.x, p.y - truth.y) > 5)
          << "the hand in frame " << p.frame << ", by itself: " << by_itself;
    }
  }
}

}  // namespace
}  // namespace tribotrack::vision
