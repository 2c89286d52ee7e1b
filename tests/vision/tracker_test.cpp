#include "vision/tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "vision/analytic_scene.h"
#include "vision/millimetres.h"
#include "vision/recordings.h"
#include "vision/track_errors.h"

namespace tribotrack::vision {
namespace {

using test::RenderedSource;
using test::TestDisc;
using test::TestScene;

constexpr double kSigma = 2;

/// Frames of a scene whose discs are placed by `place(frame)`; noise drawn from the frame's number alone.
RenderedSource recording(int width, int height, std::int64_t frames,
                         const std::function<void(std::int64_t, TestScene&)>& place, double sigma = kSigma) {
  return {width, height, frames, [=](std::int64_t k) {
            TestScene scene;
            scene.width = width;
            scene.height = height;
            place(k, scene);
            std::mt19937 random(static_cast<unsigned>(1000 + k));
            return test::noisy(scene.render(), sigma, random);
          }};
}

TestDisc disc_at(double x, double y, double radius = 12) {
  return {x, y, radius, 0, 150, {}};
}

TrackOptions follow(double x, double y, double radius = 12) {
  TrackOptions options;
  options.target.kind = Target::Kind::disc;
  options.target.disc = {x, y, radius};
  return options;
}

/// No position may be further than `tolerance` from the truth; nothing is invented.
void expect_true(const TrackResult& result, const std::function<Point(std::int64_t)>& truth,
                 double tolerance) {
  for (const TrackPoint& p : result.track.points) {
    if (p.status != TrackStatus::ok) continue;
    const Point t = truth(p.frame);
    EXPECT_NEAR(p.x, t.x, tolerance) << "frame " << p.frame;
    EXPECT_NEAR(p.y, t.y, tolerance) << "frame " << p.frame;
  }
}

TEST(Tracker, CirclingDiscIsFollowedAtTheBound) {
  constexpr int n = 400;
  const auto truth = [](std::int64_t k) {
    const double t = 0.13 * static_cast<double>(k);
    return Point{50.3 + 9 * std::cos(t) + 0.02 * static_cast<double>(k), 44.8 - 9 * std::sin(t)};
  };
  auto source = recording(
      112, 96, n, [&](std::int64_t k, TestScene& scene) { scene.discs = {disc_at(truth(k).x, truth(k).y)}; });
  const TrackResult result = track(source, {});  // found by itself
  EXPECT_EQ(result.summary.ok, n);
  EXPECT_NEAR(result.summary.disc.radius, 12, 0.05);
  EXPECT_NEAR(result.summary.noise_levels, std::sqrt(kSigma * kSigma + 1.0 / 12), 0.1);
  expect_true(result, truth, 0.05);
  const test::TrackErrors e = test::errors_of(result.track, truth);
  EXPECT_LT(e.rms, 1.1 * result.summary.limit_px);
  EXPECT_GT(e.standardised, 0.9);
  EXPECT_LT(e.standardised, 1.1);
}

TEST(Tracker, FastDiscsAreFollowed) {
  for (const double speed : {5.0, 20.0, 50.0}) {
    SCOPED_TRACE(testing::Message() << speed << " px per frame");
    const auto truth = [&](std::int64_t k) { return Point{30.4 + speed * static_cast<double>(k), 40.2}; };
    const auto frames = static_cast<std::int64_t>(500 / speed);
    auto source = recording(560, 80, frames, [&](std::int64_t k, TestScene& scene) {
      scene.discs = {disc_at(truth(k).x, truth(k).y)};
    });
    const TrackResult result = track(source, follow(30, 40));
    EXPECT_EQ(result.summary.ok, frames);
    expect_true(result, truth, 0.05);
  }
}

TEST(Tracker, DiscThatLeavesIsEdgeThenLostAndDoesNotFailTheGate) {
  const auto truth = [](std::int64_t k) { return Point{60.2 + 2.5 * static_cast<double>(k), 50}; };
  auto source = recording(160, 100, 120, [&](std::int64_t k, TestScene& scene) {
    scene.discs = {disc_at(truth(k).x, truth(k).y), disc_at(30, 50)};  // a look-alike stays behind
  });
  const TrackResult result = track(source, follow(60, 50));
  expect_true(result, truth, 0.05);
  for (const TrackPoint& p : result.track.points) {
    const double room = 159.5 - (truth(p.frame).x + 12);
    if (room > 1.2) {
      EXPECT_EQ(p.status, TrackStatus::ok) << p.frame;
    }
    if (room < 0.8 && room > -20) {
      EXPECT_EQ(p.status, TrackStatus::edge) << p.frame;
    }
  }
  EXPECT_TRUE(result.summary.left_for_good);
  EXPECT_TRUE(result.summary.gate_passed);
  EXPECT_EQ(result.summary.lost_counted, 0);
  EXPECT_EQ(result.summary.refound, 0);
}

TEST(Tracker, DiscThatComesBackIsFoundAgain) {
  const auto truth = [](std::int64_t k) {
    return Point{90 + 75 * std::sin(2 * std::numbers::pi * static_cast<double>(k) / 150), 50.5};
  };
  auto source = recording(160, 100, 150, [&](std::int64_t k, TestScene& scene) {
    scene.discs = {disc_at(truth(k).x, truth(k).y)};
  });
  const TrackResult result = track(source, follow(90, 50));
  expect_true(result, truth, 0.05);
  EXPECT_EQ(result.summary.refound, 1);
  EXPECT_FALSE(result.summary.left_for_good);
  int whole = 0;
  for (std::int64_t k = 0; k < 150; ++k) whole += truth(k).x + 13.5 < 159.5 && truth(k).x - 13.5 > -0.5;
  EXPECT_GE(result.summary.ok, whole - 2);
}

TEST(Tracker, CoveredDiscIsLostThenFoundAgainNeverGuessed) {
  const auto truth = [](std::int64_t k) { return Point{40.3 + 0.8 * static_cast<double>(k), 50.1}; };
  auto source = recording(160, 100, 80, [&](std::int64_t k, TestScene& scene) {
    scene.discs = {disc_at(truth(k).x, truth(k).y), disc_at(40, 20)};
    if (k >= 30 && k < 50) scene.discs.push_back({truth(k).x, 50, 30, 0, 95, {}});  // a hand over it
  });
  const TrackResult result = track(source, follow(40, 50));
  expect_true(result, truth, 0.06);
  for (const TrackPoint& p : result.track.points)
    EXPECT_EQ(p.status, p.frame >= 30 && p.frame < 50 ? TrackStatus::lost : TrackStatus::ok) << p.frame;
  EXPECT_EQ(result.summary.refound, 1);
  EXPECT_FALSE(result.summary.gate_passed);  // 20 of 80 frames
}

TEST(Tracker, MarkerIsFollowedAndSubtracted) {
  std::mt19937 random(31);
  const test::Waves ground = test::random_waves(random, 8, 8, 3);
  const auto platform = [](std::int64_t k) {
    const double t = 0.1 * static_cast<double>(k);
    return Point{6 * std::cos(t), 6 * std::sin(t)};
  };
  const auto truth = [&](std::int64_t k) {
    return Point{110.3 + platform(k).x + 0.1 * static_cast<double>(k), 80 + platform(k).y};
  };
  auto source = recording(200, 160, 70, [&](std::int64_t k, TestScene& scene) {
    const Point p = platform(k);
    for (test::Wave w : ground.waves) {
      w.phase -= w.kx * p.x + w.ky * p.y;
      scene.ground_texture.waves.push_back(w);
    }
    scene.discs = {{40.2 + p.x, 40.7 + p.y, 12, 0, 220, {}},
                   {40.2 + p.x, 40.7 + p.y, 8, 0, 20, {}},
                   disc_at(truth(k).x, truth(k).y, 25)};
  });
  for (const auto kind : {MarkerChoice::Kind::find, MarkerChoice::Kind::circle}) {
    TrackOptions options;
    options.marker.kind = kind;
    options.marker.circle = {45, 41, 8};
    const TrackResult result = track(source, options);
    ASSERT_EQ(result.summary.ok, 70);
    ASSERT_TRUE(result.track.has_marker);
    const auto mm =
        place_track(result.track, PlaneGeometry({1, 0, "given"}, ScalePlane::part_top, std::nullopt), 0);
    for (std::size_t k = 0; k < mm.size(); ++k) {
      ASSERT_TRUE(mm[k]) << k;
      EXPECT_NEAR(mm[k]->mm.x(), 0.1 * static_cast<double>(k), 0.06) << k;
      EXPECT_NEAR(mm[k]->mm.y(), 0, 0.06) << k;
      EXPECT_NEAR(result.track.points[k].marker->x - result.track.points[0].marker->x,
                  platform(static_cast<std::int64_t>(k)).x - 6, 0.03);
    }
  }
}

TEST(Tracker, TurningTexturedDiscIsFollowedThroughAllAngles) {
  std::mt19937 random(32);
  const test::Waves texture = test::random_waves(random, 12, 8, 20);
  const auto truth = [](std::int64_t k) { return Point{60.3 + 0.3 * static_cast<double>(k), 60.4}; };
  auto source = recording(140, 120, 120, [&](std::int64_t k, TestScene& scene) {
    scene.discs = {disc_at(truth(k).x, truth(k).y, 20)};
    scene.discs[0].texture = texture;
    scene.discs[0].theta = 0.07 * static_cast<double>(k);
  });
  const TrackResult result = track(source, follow(60, 60, 20));
  EXPECT_EQ(result.summary.ok, 120);
  // The template's centre turns with the disc: what the rim fit of the first frame was off by (the texture
  // reaches the rim: 0.1 px rms over textures such as this) goes round, no more.
  const double off = std::hypot(result.summary.disc.x - truth(0).x, result.summary.disc.y - truth(0).y);
  EXPECT_LT(off, 0.3);
  expect_true(result, truth, off + 0.02);
}

// ---- recordings nobody here made; they are not part of the project --------------------------------------

TEST(TrackerOnRealRecordings, DicChallengeShiftOfATenthOfAPixel) {
  if (real_data().empty()) GTEST_SKIP() << "TRIBOTRACK_REAL_DATA is not set";
  const auto folder = real_data() / "dic_sample5";
  const Picture first = open_source(folder / "Sample5-000 X0.00 Y0.00 N2 C75 R10.tif")->read(0);
  const Picture second = open_source(folder / "Sample5-001 X0.10 Y0.10 N2 C100 R20.tif")->read(0);
  const auto run = [](const Picture& from, const Picture& to, double& mx, double& my) {
    std::vector<double> dx, dy;
    for (int y = 20; y + 41 + 20 <= from.height(); y += 60)
      for (int x = 20; x + 41 + 20 <= from.width(); x += 60) {
        RenderedSource source(from.width(), from.height(), 2,
                              [&](std::int64_t k) { return k == 0 ? from : to; });
        TrackOptions options;
        options.target.kind = Target::Kind::rectangle;
        options.target.rectangle = {x, y, 41, 41};
        const TrackResult r = track(source, options);
        const TrackPoint& p = r.track.points[1];
        EXPECT_EQ(p.status, TrackStatus::ok);
        dx.push_back(p.x - r.track.points[0].x);
        dy.push_back(p.y - r.track.points[0].y);
      }
    mx = my = 0;
    for (std::size_t k = 0; k < dx.size(); ++k) {
      mx += dx[k] / static_cast<double>(dx.size());
      my += dy[k] / static_cast<double>(dy.size());
    }
    return dx.size();
  };
  double mx = 0;
  double my = 0;
  EXPECT_GE(run(first, second, mx, my), 50U);
  EXPECT_NEAR(mx, 0.10, 0.003);
  EXPECT_NEAR(my, 0.10, 0.003);
  run(open_source(folder / "Sample5 Reference.tif")->read(0), second, mx, my);
  EXPECT_NEAR(mx, 0.10, 0.003);
  EXPECT_NEAR(my, 0.10, 0.003);
}

}  // namespace
}  // namespace tribotrack::vision
