// What real recordings do to a tracker, scene by scene. Truth is the renderer's own pose; every scene is
// integrated over pixels and exposure.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "vision/analytic_scene.h"
#include "vision/camera/pixels.h"
#include "vision/cramer_rao_bound.h"
#include "vision/kernels/informative_pixels.h"
#include "vision/scene.h"
#include "vision/tracker.h"

namespace tribotrack::vision {
namespace {

using test::RenderedSource;

constexpr double kFps = 500;

/// A recording at 500 frames a second: the scene may differ from frame to frame, and so may what is done to
/// the picture after the camera's optics.
struct Recording {
  Scene scene;
  int frames = 200;
  double exposure_s = 0;
  std::function<ScenePose(double frame)> pose;
  std::function<void(int frame, Scene&)> change = [](int, Scene&) {};
  std::function<void(int frame, Picture&)> spoil = [](int, Picture&) {};
  std::function<double(int frame)> lamp = [](int) { return 1.0; };
  bool steady = true;  ///< `change` does nothing: one renderer serves all frames

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
      const int frame = static_cast<int>(k);
      Scene now = scene;
      change(frame, now);
      const auto at = [&](double t) { return pose(t * kFps); };
      const double t = static_cast<double>(k) / kFps;
      Picture picture = steady ? shared->render(k, t, exposure_s, at, lamp(frame))
                               : SceneRenderer(now).render(k, t, exposure_s, at, lamp(frame));
      spoil(frame, picture);
      return picture;
    });
    return out;
  }
  /// Cramer-Rao bound of one coordinate in a frame, px.
  double bound(int frame) const {
    Scene now = scene;
    change(frame, now);
    const Eigen::Matrix2d c = position_bound(SceneRenderer(now), frame / kFps, exposure_s,
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

/// Of the points told to be ok, their mean offset removed.
struct Errors {
  int ok = 0;
  double rms = 0;           ///< px
  double standardised = 0;  ///< rms of the components over their told sd
  double worst = 0;         ///< largest of a point, in its own sd
};

Errors errors_of(const TrackResult& result, const std::function<Point(std::int64_t)>& truth) {
  std::vector<Eigen::Vector2d> errors;
  std::vector<Eigen::Matrix2d> told;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const TrackPoint& p : result.track.points) {
    if (p.status != TrackStatus::ok) continue;
    errors.emplace_back(p.x - truth(p.frame).x, p.y - truth(p.frame).y);
    const double c = p.rho_xy * p.sigma_x * p.sigma_y;
    told.push_back(Eigen::Matrix2d{{p.sigma_x * p.sigma_x, c}, {c, p.sigma_y * p.sigma_y}});
    mean += errors.back();
  }
  Errors out;
  out.ok = static_cast<int>(errors.size());
  for (std::size_t k = 0; k < errors.size(); ++k) {
    const Eigen::Vector2d e = errors[k] - mean / out.ok;
    const double squares = e.dot(told[k].inverse() * e);
    out.rms += e.squaredNorm() / (2.0 * out.ok);
    out.standardised += squares / (2.0 * out.ok);
    out.worst = std::max(out.worst, std::sqrt(squares));
  }
  out.rms = std::sqrt(out.rms);
  out.standardised = std::sqrt(out.standardised);
  return out;
}

/// Tracked from a click beside the disc; what came of it is printed.
struct Outcome {
  TrackResult result;
  Errors errors;
  double bound = 0;
};

Outcome followed(const char* name, const Recording& r, const std::function<Point(std::int64_t)>& truth) {
  RenderedSource source = r.source();
  Outcome out{track(source, follow(r)), {}, r.bound(r.frames / 2)};
  out.errors = errors_of(out.result, truth);
  const TrackSummary& s = out.result.summary;
  std::printf("%s: ok %d, lost %lld, rms %.4f px = %.2f bound, standardised %.2f, worst %.1f sd%s\n", name,
              out.errors.ok, static_cast<long long>(s.lost), out.errors.rms, out.errors.rms / out.bound,
              out.errors.standardised, out.errors.worst, s.layered ? ", layered" : "");
  return out;
}

Outcome followed(const char* name, const Recording& r) {
  return followed(name, r, [&](std::int64_t k) { return r.truth(k); });
}

/// The scene costs nothing: as sharp as on a good recording, and as true. 400 components scatter by 4 %.
void expect_at_the_limit(const Outcome& o, int frames) {
  EXPECT_EQ(o.errors.ok, frames);
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

TEST_P(Robustness, Flicker) {
  Recording r = recording();
  r.scene.flicker = 0.15;
  r.scene.flicker_hz = 93;
  r.exposure_s = 0.5e-3;
  expect_at_the_limit(followed("flicker", r), r.frames);
}

TEST_P(Robustness, Defocus) {
  Recording r = recording();
  r.scene.disc.edge_blur_px = 4;
  const Outcome o = followed("defocus", r);
  EXPECT_EQ(o.errors.ok, r.frames);
  EXPECT_LT(o.errors.rms, 1.15 * o.bound);
  EXPECT_GT(o.errors.standardised, 0.87);
  EXPECT_LT(o.errors.standardised, 1.13);
}

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
  expect_at_the_limit(followed("motion blur", r, mean), r.frames);
}

TEST_P(Robustness, Saturation) {
  Recording r = recording();
  r.scene.disc.level = 262;
  expect_at_the_limit(followed("saturated disc", r), r.frames);
}

/// Those that every change is tested by; the others wait for a campaign.
class EverydayRobustness : public Robustness {};

TEST_P(EverydayRobustness, HotAndDeadPixels) {
  Recording r = recording();
  std::mt19937 random(5);
  std::vector<Pixel> bad;
  for (int n = 0; n < 72; ++n)  // one in 500
    bad.push_back({static_cast<int>(random() % 300), static_cast<int>(random() % 120)});
  r.spoil = [&](int, Picture& p) {
    for (std::size_t n = 0; n < bad.size(); ++n) p.at(bad[n].x, bad[n].y) = n % 3 > 0 ? 255.0F : 0.0F;
  };
  const Outcome o = followed("hot pixels", r);
  expect_at_the_limit(o, r.frames);
  const auto& plan = o.result.summary.plan;
  const auto stage =
      std::find_if(plan.begin(), plan.end(), [](const auto& s) { return s.name == "bad pixels"; });
  ASSERT_NE(stage, plan.end());
  EXPECT_TRUE(stage->on);
}

TEST_P(Robustness, DroppedAndDuplicatedFrames) {
  Recording r = recording();
  const auto pose = r.pose;
  r.pose = [=](double k) {
    const int n = static_cast<int>(std::lround(k));
    return pose(n < 50 ? n : n == 50 ? 49 : n < 120 ? n + 6 : n + 20);
  };
  expect_at_the_limit(followed("dropped, duplicated", r), r.frames);
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
  const Outcome o = followed("tool", r);
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

TEST_P(Robustness, LampThatCoversPartOfThePath) {
  for (const double radius : {6.0, 14.0}) {
    Recording r = recording();
    r.scene.lamp = Lamp{{130, 80}, radius, 250, 20};
    const Outcome o = followed("lamp over the path", r);
    // Known limit: a lamp as small as this stands in the picture of a ground at rest, and seems to shine
    // through the part as well; a circle fitted to the rim is four times the bound off.
    EXPECT_LT(o.errors.rms, 1.6 * o.bound);
    EXPECT_LT(o.errors.standardised, 1.2);
    EXPECT_LT(o.errors.worst, 5);
    for (const TrackPoint& p : o.result.track.points) {
      const double gap = std::hypot(r.truth(p.frame).x - 130, r.truth(p.frame).y - 80) - 24 - radius;
      if (gap > 5) {
        EXPECT_TRUE(is_ok(p)) << "lost in frame " << p.frame << ", before or after the lamp";
      }
    }
  }
}

struct GlareSpot {
  const char* name;
  double sd, peak;  ///< px, grey levels
};

/// Light that lies over part of the path, up to half as bright as the disc, on part and ground alike.
class Glare : public testing::TestWithParam<std::tuple<double, GlareSpot>> {
 protected:
  Outcome tracked() const {
    const auto& [texture, spot] = GetParam();
    Recording r;
    r.scene.platform.texture_rms = texture;
    r.spoil = [s = spot](int, Picture& p) {
      for (int y = 0; y < p.height(); ++y)
        for (int x = 0; x < p.width(); ++x) {
          const double q = ((x - 130) * (x - 130) + (y - 50) * (y - 50)) / (2 * s.sd * s.sd);
          p.at(x, y) = static_cast<float>(std::min(255.0, std::round(p.at(x, y) + s.peak * std::exp(-q))));
        }
    };
    return followed("glare", r);
  }
};
class FaintGlare : public Glare {};
class BrightGlare : public Glare {};

// A single template is 11 times the bound off.
TEST_P(FaintGlare, IsLearntAndTakenOut) {
  const Outcome o = tracked();
  EXPECT_EQ(o.errors.ok, 200);
  EXPECT_LT(o.errors.rms, 1.2 * o.bound);
  EXPECT_LT(o.errors.standardised, 1.15);
}

// Known limit: over a texture a bright or broad light is told from the ground only in part: the narrow one
// leaves 1.5 times the bound, the broad one, on which the rim is the better choice, 4 times. A single
// template is 11 to 60 times the bound off, a circle fitted to the rim 4 to 6 times.
TEST_P(BrightGlare, IsTakenOutInPart) {
  const Outcome o = tracked();
  EXPECT_EQ(o.errors.ok, 200);
  const auto& [texture, spot] = GetParam();
  EXPECT_LT(o.errors.rms, (texture == 0 ? 1.25 : spot.sd < 15 ? 1.8 : spot.sd < 30 ? 2.5 : 4.5) * o.bound);
  EXPECT_LT(o.errors.standardised, texture > 0 && spot.sd > 30 ? 2.2 : 1.25);
}

std::string spot_name(const testing::TestParamInfo<std::tuple<double, GlareSpot>>& p) {
  return std::get<1>(p.param).name + std::string(std::get<0>(p.param) > 0 ? "Brushed" : "Plain");
}

INSTANTIATE_TEST_SUITE_P(Standing, FaintGlare,
                         testing::Combine(testing::Values(8.0),
                                          testing::Values(GlareSpot{"FaintNarrow", 10, 20})),
                         spot_name);
INSTANTIATE_TEST_SUITE_P(DISABLED_Campaign, BrightGlare,
                         testing::Combine(testing::Values(0.0, 8.0),
                                          testing::Values(GlareSpot{"BrightNarrow", 10, 60},
                                                          GlareSpot{"Middling", 25, 40},
                                                          GlareSpot{"BrightWide", 60, 80})),
                         spot_name);

TEST_P(EverydayRobustness, RecordingThatStartsBeforeThePartIsThere) {
  Recording r = recording();
  r.pose = [](double k) { return ScenePose{{-60.3 + 1.6 * k, 60.2 + 3 * std::sin(0.11 * k)}, 0, {0, 0}}; };
  RenderedSource source = r.source();
  const TrackResult result = track(source, {});
  const Errors e = errors_of(result, [&](std::int64_t k) { return r.truth(k); });
  std::printf("comes in: ok %d, absent %lld, rms %.2f bound, standardised %.2f\n", e.ok,
              static_cast<long long>(result.summary.absent_at_first), e.rms / r.bound(150), e.standardised);
  std::int64_t whole = 0;
  while (r.truth(whole).x - 24 < 0) ++whole;
  EXPECT_GE(result.summary.absent_at_first, whole);
  EXPECT_LE(result.summary.absent_at_first, whole + 8);
  EXPECT_EQ(e.ok + result.summary.absent_at_first, r.frames);
  EXPECT_EQ(static_cast<std::int64_t>(result.track.points.size()), r.frames);
  EXPECT_EQ(result.track.points.front().status, TrackStatus::lost);
  EXPECT_EQ(result.summary.lost_counted, 0);
  EXPECT_TRUE(result.summary.gate_passed);
  EXPECT_LT(e.rms, 1.15 * r.bound(150));
}

TEST_P(Robustness, PartPutDownWhereTheUserSaysItIs) {
  Recording r = recording();
  r.steady = false;
  r.change = [](int k, Scene& s) { s.disc.visible = k >= 30; };
  r.pose = [](double k) { return ScenePose{{60.3 + 0.6 * std::max(0.0, k - 40), 60.2}, 0, {0, 0}}; };
  const Outcome o = followed("put down later", r);
  EXPECT_EQ(o.result.summary.absent_at_first, 30);
  EXPECT_EQ(o.errors.ok, r.frames - 30);
  EXPECT_LT(o.errors.rms, 1.15 * o.bound);
}

TEST_P(Robustness, DiscsOf8And400Pixels) {
  for (const double radius : {4.0, 200.0}) {
    Recording r = recording();
    r.scene.disc.radius_px = radius;
    r.scene.width = static_cast<int>(2 * radius + 140);
    r.scene.height = static_cast<int>(2 * radius + 40);
    r.frames = radius > 100 ? 60 : 200;
    r.pose = [=](double k) {
      return ScenePose{{radius + 20.3 + 0.4 * k, radius + 20.2 + 3 * std::sin(0.11 * k)}, 0, {0, 0}};
    };
    const Outcome o = followed(radius < 10 ? "8 px across" : "400 px across", r);
    EXPECT_EQ(o.errors.ok, r.frames);
    EXPECT_LT(o.errors.rms, 1.2 * o.bound);
  }
}

std::string texture_name(const testing::TestParamInfo<double>& texture) {
  return texture.param > 0 ? "Brushed" : "Plain";
}

INSTANTIATE_TEST_SUITE_P(DISABLED_Campaign, Robustness, testing::Values(0.0, 8.0), texture_name);
INSTANTIATE_TEST_SUITE_P(PlatformTexture, EverydayRobustness, testing::Values(8.0), texture_name);

TEST(OutlierPixels, SpreadFromWhatLiesTogetherOnly) {
  const std::vector<TilePlace> places{{0, 0}, {8, 0}};
  std::vector<unsigned char> outliers(2 * kTilePixels);
  const auto at = [&](int x, int y) -> unsigned char& {
    return outliers[static_cast<std::size_t>(x / 8) * kTilePixels + static_cast<std::size_t>(8 * y + x % 8)];
  };
  at(7, 3) = at(7, 4) = at(8, 3) = 1;  // across the tiles' border
  at(1, 1) = 1;                        // a speck
  const std::size_t count = spread_outliers(places, 2, outliers);
  std::size_t expected = 0;
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 16; ++x) {
      const bool near =
          std::hypot(x - 7, y - 3) <= 2 || std::hypot(x - 7, y - 4) <= 2 || std::hypot(x - 8, y - 3) <= 2;
      const bool is = near || (x == 1 && y == 1);
      EXPECT_EQ(at(x, y) != 0, is) << x << ", " << y;
      expected += is;
    }
  EXPECT_EQ(count, expected);
}

TEST(BadPixels, AreFoundAndNothingElseIs) {
  Recording r;
  r.scene.platform.texture_rms = 8;
  r.scene.marker = MarkerAppearance{{250, 90}, 5};
  r.scene.disc.scratches = 12;
  const std::vector<Pixel> bad{{10, 100}, {200, 20}, {201, 20}, {120, 5}};  // two of them neighbours
  r.spoil = [&](int, Picture& p) {
    for (const Pixel& q : bad) p.at(q.x, q.y) = q.x == 10 ? 0.0F : 255.0F;
  };
  RenderedSource source = r.source();
  BadPixelSearch search(source.read(0), 4);
  for (int k = 1; k < 4; ++k) search.look(source.read(k));
  const auto found = search.found();
  ASSERT_EQ(found.size(), bad.size());
  for (const Pixel& q : bad)
    EXPECT_TRUE(
        std::any_of(found.begin(), found.end(), [&](const Pixel& f) { return f.x == q.x && f.y == q.y; }))
        << q.x << ", " << q.y;
  MendedSource mended(source, found);
  const Picture whole = mended.read(7), raw = source.read(7);
  for (const Pixel& q : bad) EXPECT_NEAR(whole.at(q.x, q.y), raw.at(q.x - 1, q.y + 1), 30);
  Picture window;
  mended.read(7, {195, 15, 20, 10}, window);
  EXPECT_EQ(window.at(5, 5), whole.at(200, 20));
  std::size_t changed = 0;
  for (int y = 0; y < raw.height(); ++y)
    for (int x = 0; x < raw.width(); ++x) changed += raw.at(x, y) != whole.at(x, y);
  EXPECT_EQ(changed, bad.size());
}

}  // namespace
}  // namespace tribotrack::vision
