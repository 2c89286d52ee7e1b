// What real recordings do to a tracker, scene by scene. Truth is the renderer's own pose; every scene is
// integrated over pixels and exposure.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <vector>

#include "vision/analytic_scene.h"
#include "vision/camera/pixels.h"
#include "vision/cramer_rao_bound.h"
#include "vision/scene.h"
#include "vision/track_errors.h"
#include "vision/tracker.h"

namespace tribotrack::vision {
namespace {

using test::RenderedSource;
using test::TrackErrors;

constexpr double kFps = 500;

/// A recording at 500 frames a second, and what is done to each picture after the camera's optics.
struct Recording {
  Scene scene;
  int frames = 200;
  double exposure_s = 0;
  std::function<ScenePose(double frame)> pose;
  std::function<void(int frame, Picture&)> spoil = [](int, Picture&) {};

  Recording() {
    scene.width = 300;
    scene.height = 120;
    scene.disc.radius_px = 24;
    scene.disc.scratches = 0;
    scene.disc.highlight = 0;
    scene.platform.texture_rms = 0;
    scene.read_noise = 2;
    scene.seed = 4711;
    pose = [](double k) { return ScenePose{{60.3 + 0.6 * k, 60.2 + 3 * std::sin(0.11 * k)}, 0, {0, 0}}; };
  }
  Point truth(std::int64_t frame) const { return pose(static_cast<double>(frame)).disc; }

  RenderedSource source() const {
    const auto shared = std::make_shared<SceneRenderer>(scene);
    RenderedSource out(scene.width, scene.height, frames, [this, shared](std::int64_t k) {
      Picture picture = shared->render(
          k, static_cast<double>(k) / kFps, exposure_s, [&](double t) { return pose(t * kFps); }, 1);
      spoil(static_cast<int>(k), picture);
      return picture;
    });
    return out;
  }
  /// Cramer-Rao bound of one coordinate in a frame, px.
  double bound(int frame) const {
    const Eigen::Matrix2d c = position_bound(SceneRenderer(scene), frame / kFps, exposure_s,
                                             [&](double t) { return pose(t * kFps); });
    return std::sqrt(0.5 * c.trace());
  }
};

TrackOptions follow(const Recording& r) {
  TrackOptions options;
  options.target.kind = Target::Kind::disc;
  options.target.disc = {r.truth(0).x + 0.4, r.truth(0).y - 0.3, r.scene.disc.radius_px};
  return options;
}

/// Tracked from a click beside the disc.
struct Outcome {
  TrackResult result;
  TrackErrors errors;
  double bound = 0;
};

Outcome followed(const Recording& r, const std::function<Point(std::int64_t)>& truth) {
  RenderedSource source = r.source();
  TrackResult result = track(source, follow(r));
  const TrackErrors errors = test::errors_of(result.track, truth);
  return {std::move(result), errors, r.bound(r.frames / 2)};
}
Outcome followed(const Recording& r) {
  return followed(r, [&](std::int64_t k) { return r.truth(k); });
}

/// The scene costs nothing: as sharp as on a good recording, and as true. 400 components scatter by 4 %.
void expect_at_the_limit(const Outcome& o, int frames) {
  EXPECT_EQ(o.errors.count, frames);
  EXPECT_LT(o.errors.rms, 1.15 * o.bound);
  EXPECT_GT(o.errors.standardised, 0.87);
  EXPECT_LT(o.errors.standardised, 1.13);
}

bool is_ok(const TrackPoint& p) {
  return p.status == TrackStatus::ok;
}

/// The disc on a plain and on a brushed platform at rest.
class Robustness : public testing::TestWithParam<double> {
 protected:
  Recording recording() const {
    Recording r;
    r.scene.platform.texture_rms = GetParam();
    return r;
  }
};

TEST_P(Robustness, MotionBlurShowsTheMeanOverTheExposure) {
  Recording r = recording();
  r.exposure_s = 1 / kFps;
  constexpr double w = 0.11;  // rad per frame
  const auto circling = [=](double k, double smear) {
    return Point{60.3 + 0.6 * k, 60.2 + 8 * smear * std::sin(w * k)};
  };
  r.pose = [=](double k) { return ScenePose{circling(k, 1), 0, {0, 0}}; };
  const double smear = std::sin(w / 2) / (w / 2);
  const auto mean = [=](std::int64_t k) { return circling(static_cast<double>(k), smear); };
  expect_at_the_limit(followed(r, mean), r.frames);
}

TEST_P(Robustness, Saturation) {
  Recording r = recording();
  r.scene.disc.level = 262;
  expect_at_the_limit(followed(r), r.frames);
}

/// Those that every change is tested by; the others wait for a campaign.
class EverydayRobustness : public Robustness {};

// Pictures that were enlarged and are then stored as they are: nothing says that neighbouring pixels err
// alike.
TEST_P(EverydayRobustness, ErrorsThatNeighbouringPixelsShare) {
  Recording r = recording();
  r.scene.disc.scratches = 40;
  r.spoil = [](int, Picture& p) {
    cv::Mat seen(p.height(), p.width(), CV_32F), small;
    for (int y = 0; y < p.height(); ++y)
      for (int x = 0; x < p.width(); ++x) seen.at<float>(y, x) = p.at(x, y);
    cv::resize(seen, small, {}, 0.5, 0.5, cv::INTER_AREA);
    cv::resize(small, seen, seen.size(), 0, 0, cv::INTER_CUBIC);
    for (int y = 0; y < p.height(); ++y)
      for (int x = 0; x < p.width(); ++x) p.at(x, y) = seen.at<float>(y, x);
  };
  const Outcome o = followed(r);
  EXPECT_EQ(o.errors.count, r.frames);
  EXPECT_LT(o.errors.rms, 3 * o.bound);
  EXPECT_LT(o.errors.standardised, 2);
}

TEST_P(EverydayRobustness, HotAndDeadPixels) {
  Recording r = recording();
  std::mt19937 random(5);
  std::vector<Pixel> bad;
  for (int n = 0; n < 72; ++n)  // one in 500
    bad.push_back({static_cast<int>(random() % 300), static_cast<int>(random() % 120)});
  r.spoil = [&](int, Picture& p) {
    for (std::size_t n = 0; n < bad.size(); ++n) p.at(bad[n].x, bad[n].y) = n % 3 > 0 ? 255.0F : 0.0F;
  };
  const Outcome o = followed(r);
  expect_at_the_limit(o, r.frames);
  const auto& plan = o.result.summary.plan;
  const auto stage =
      std::find_if(plan.begin(), plan.end(), [](const auto& s) { return s.name == "bad pixels"; });
  ASSERT_NE(stage, plan.end());
  EXPECT_TRUE(stage->on);
}

TEST_P(Robustness, ToolThatCrosses) {
  Recording r = recording();
  const auto covers = [](double k, double x, double y) {  // a slanted bar that sweeps to the left
    const double d = x - 0.3 * y - (300 - 3.0 * (k - 60));
    return k >= 60 && d > 0 && d < 40;
  };
  r.spoil = [&](int k, Picture& p) {
    for (int y = 0; y < p.height(); ++y)
      for (int x = 0; x < p.width(); ++x)
        if (covers(k, x, y)) p.at(x, y) = 35;
  };
  const Outcome o = followed(r);
  // The tool must not pass for a ground that moves.
  EXPECT_TRUE(o.result.summary.layered);
  EXPECT_FALSE(o.result.track.has_marker);
  // The bound knows nothing of the tool, which covers a part of the disc in some of the frames of a plain
  // track.
  if (GetParam() > 0) {
    EXPECT_LT(o.errors.rms, 1.15 * o.bound);
  }
  EXPECT_GT(o.errors.standardised, 0.87);
  EXPECT_LT(o.errors.standardised, 1.13);
  EXPECT_LT(o.errors.worst, 5);
  int clear = 0;
  for (const TrackPoint& p : o.result.track.points) {
    const auto k = static_cast<double>(p.frame);
    const Point c = r.truth(p.frame);
    if (covers(k, c.x, c.y)) {
      EXPECT_FALSE(is_ok(p)) << "guessed in frame " << p.frame;
    }
    bool touched = covers(k, c.x, c.y);
    for (int n = 0; n < 63 && !touched; ++n)
      for (const double rho : {12.0, 22.0, 32.0})
        touched = touched || covers(k, c.x + rho * std::cos(0.1 * n), c.y + rho * std::sin(0.1 * n));
    clear += !touched && !is_ok(p);
  }
  EXPECT_LE(clear, 1) << "lost where nothing covers the disc (one frame may pass until it is confirmed)";
}

/// Light that lies over part of the path, up to half as bright as the disc, on part and ground alike.
struct Spot {
  const char* name;
  double texture, sd, peak;        ///< of the platform, grey levels; px, grey levels
  double most, most_standardised;  ///< rms over the bound
};

class Glare : public testing::TestWithParam<Spot> {};

// A single template is 11 to 60 times the bound off, a circle fitted to the rim 4 to 6 times. Known limit:
// over a texture the edge, which is blind to such light, does not know the ground beside it either.
TEST_P(Glare, MovesNothing) {
  const Spot& spot = GetParam();
  Recording r;
  r.scene.platform.texture_rms = spot.texture;
  r.spoil = [&](int, Picture& p) {
    for (int y = 0; y < p.height(); ++y)
      for (int x = 0; x < p.width(); ++x) {
        const double q = ((x - 130) * (x - 130) + (y - 50) * (y - 50)) / (2 * spot.sd * spot.sd);
        p.at(x, y) = static_cast<float>(std::min(255.0, std::round(p.at(x, y) + spot.peak * std::exp(-q))));
      }
  };
  const Outcome o = followed(r);
  EXPECT_EQ(o.errors.count, 200);
  EXPECT_LT(o.errors.rms, spot.most * o.bound);
  EXPECT_LT(o.errors.standardised, spot.most_standardised);
}

const auto name_of_spot = [](const auto& spot) { return spot.param.name; };
INSTANTIATE_TEST_SUITE_P(Faint, Glare, testing::Values(Spot{"NarrowBrushed", 8, 10, 20, 2.2, 1.4}),
                         name_of_spot);
INSTANTIATE_TEST_SUITE_P(
    DISABLED_Campaign, Glare,
    testing::Values(Spot{"NarrowPlain", 0, 10, 60, 1.25, 1.25}, Spot{"MiddlingPlain", 0, 25, 40, 1.25, 1.25},
                    Spot{"WidePlain", 0, 60, 80, 1.25, 1.25}, Spot{"NarrowBrushed", 8, 10, 60, 2.5, 1.4},
                    Spot{"MiddlingBrushed", 8, 25, 40, 2.5, 1.4}, Spot{"WideBrushed", 8, 60, 80, 2.2, 1.4}),
    name_of_spot);

TEST_P(EverydayRobustness, RecordingThatStartsBeforeThePartIsThere) {
  Recording r = recording();
  r.pose = [](double k) { return ScenePose{{-60.3 + 1.6 * k, 60.2 + 3 * std::sin(0.11 * k)}, 0, {0, 0}}; };
  RenderedSource source = r.source();
  const TrackResult result = track(source, {});
  const TrackErrors e = test::errors_of(result.track, [&](std::int64_t k) { return r.truth(k); });
  std::int64_t whole = 0;
  while (r.truth(whole).x - 24 < 0) ++whole;
  EXPECT_GE(result.summary.absent_at_first, whole);
  EXPECT_LE(result.summary.absent_at_first, whole + 8);
  EXPECT_EQ(e.count + result.summary.absent_at_first, r.frames);
  EXPECT_EQ(static_cast<std::int64_t>(result.track.points.size()), r.frames);
  EXPECT_EQ(result.track.points.front().status, TrackStatus::lost);
  EXPECT_EQ(result.summary.lost_counted, 0);
  EXPECT_TRUE(result.summary.gate_passed);
  EXPECT_LT(e.rms, 1.15 * r.bound(150));
}

std::string texture_name(const testing::TestParamInfo<double>& texture) {
  return texture.param > 0 ? "Brushed" : "Plain";
}

INSTANTIATE_TEST_SUITE_P(DISABLED_Campaign, Robustness, testing::Values(0.0, 8.0), texture_name);
INSTANTIATE_TEST_SUITE_P(PlatformTexture, EverydayRobustness, testing::Values(8.0), texture_name);

}  // namespace
}  // namespace tribotrack::vision
