// The platform's motion from its ground, against rendered scenes whose motion is known exactly.
#include "vision/platform_motion/motion.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "vision/scene.h"

namespace tribotrack::vision {
namespace {

constexpr double kRate = 500;    // frames/s
constexpr double kOmega = 62.8;  // rad/s

/// A disc over a brushed platform that circles, without a mark.
struct Circling {
  Scene scene;
  int frames = 100;
  double circle_px = 2.8;

  Circling() {
    scene.width = 240;
    scene.height = 200;
    scene.disc.radius_px = 30;
    scene.platform.texture_rms = 5;
    scene.read_noise = 3;
    scene.seed = 11;
  }
  Point platform(double t) const {
    return {circle_px * std::cos(kOmega * t), -circle_px * std::sin(kOmega * t)};
  }
  ScenePose pose(double t) const {
    const Point p = platform(t);
    return {{110 + 60 * t + 0.8 * p.x, 95 - 40 * t + 0.8 * p.y}, 0, p};
  }
  std::vector<Picture> pictures() const {
    const SceneRenderer renderer(scene);
    std::vector<Picture> out;
    for (int k = 0; k < frames; ++k)
      out.push_back(renderer.render(k, k / kRate, 20e-6, [&](double t) { return pose(t); }));
    return out;
  }
  GroundMotionOptions options() const {
    GroundMotionOptions out;
    out.noise_variance = scene.read_noise * scene.read_noise;
    out.hidden = [this](std::int64_t k) {
      const Point disc = pose(static_cast<double>(k) / kRate).disc;
      return std::vector<Circle>{{disc.x, disc.y, scene.disc.radius_px + 4}};
    };
    return out;
  }
};

/// Errors of the displacements less their mean (the grid's own place), along and across the brush.
struct Errors {
  int found = 0;
  double along = 0, across = 0;        ///< px rms
  double sd_along = 0, sd_across = 0;  ///< as reported
  double ratio = 0;                    ///< error over reported sd, from the whole covariance
  Eigen::Vector2d amplitude_off, phase_off, amplitude_sd;  ///< per axis; relative, rad, relative = rad
};

Errors errors_of(const GroundMotion& motion, const Circling& s) {
  std::vector<Eigen::Vector2d> off, seen, truth;
  std::vector<double> times;
  std::vector<Eigen::Matrix2d> covariances;
  for (std::size_t k = 0; k < motion.frames.size(); ++k) {
    if (!motion.frames[k]) continue;
    times.push_back(static_cast<double>(k) / kRate);
    const Point p = s.platform(times.back()), d = motion.frames[k]->displacement;
    off.emplace_back(d.x - p.x, d.y - p.y);
    seen.emplace_back(d.x, d.y);
    truth.emplace_back(p.x, p.y);
    covariances.push_back(motion.frames[k]->covariance);
  }
  Errors e;
  e.found = static_cast<int>(off.size());
  const double n = e.found;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& o : off) mean += o / n;
  const double angle = s.scene.platform.brush_angle_rad;
  const Eigen::Vector2d along(std::cos(angle), -std::sin(angle)), across(std::sin(angle), std::cos(angle));
  Eigen::Matrix2d reported = Eigen::Matrix2d::Zero();
  for (std::size_t k = 0; k < off.size(); ++k) {
    const Eigen::Vector2d o = off[k] - mean;
    e.along += std::pow(o.dot(along), 2) / n;
    e.across += std::pow(o.dot(across), 2) / n;
    e.ratio += o.dot(covariances[k].inverse() * o) / (2 * n);
    reported += covariances[k] / n;
  }
  e.along = std::sqrt(e.along);
  e.across = std::sqrt(e.across);
  e.ratio = std::sqrt(e.ratio);
  e.sd_along = std::sqrt(along.dot(reported * along));
  e.sd_across = std::sqrt(across.dot(reported * across));
  Eigen::MatrixX3d basis(off.size(), 3);
  Eigen::MatrixX2d is(off.size(), 2), should(off.size(), 2);
  for (std::size_t k = 0; k < off.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    basis.row(row) << std::cos(kOmega * times[k]), std::sin(kOmega * times[k]), 1;
    is.row(row) = seen[k];
    should.row(row) = truth[k];
  }
  const auto solver = basis.colPivHouseholderQr();
  const Eigen::MatrixX2d a = solver.solve(is), b = solver.solve(should);
  for (int axis = 0; axis < 2; ++axis) {
    const std::complex<double> ratio =
        std::complex<double>(a(0, axis), -a(1, axis)) / std::complex<double>(b(0, axis), -b(1, axis));
    e.amplitude_off[axis] = std::abs(ratio) - 1;
    e.phase_off[axis] = std::arg(ratio);
    e.amplitude_sd[axis] = std::sqrt(2 * reported(axis, axis) / n) / s.circle_px;
  }
  return e;
}

GroundMotion followed(const Circling& s, std::vector<Picture> pictures, int threads = 1) {
  MemorySource source(std::move(pictures), kRate);
  GroundMotionOptions options = s.options();
  options.threads = threads;
  return follow_ground(source, 0, s.frames - 1, options);
}

GroundVerdict glance(const Circling& s, std::vector<Picture> pictures) {
  MemorySource source(std::move(pictures), kRate);
  const GroundMotionOptions options = s.options();
  return look_at_ground(sample_ground(source, 0, s.frames - 1, kGroundGlance, options),
                        options.noise_variance);
}

/// 100 frames with two coordinates each: the ratio of rms error and sd scatters by a twentieth.
void expect_right(const Errors& e, const Circling& s) {
  EXPECT_EQ(e.found, s.frames);
  EXPECT_GT(e.ratio, 0.8);
  EXPECT_LT(e.ratio, 1.2);
  for (int axis = 0; axis < 2; ++axis) {
    EXPECT_LT(std::abs(e.amplitude_off[axis]), 3 * e.amplitude_sd[axis]) << axis;
    EXPECT_LT(std::abs(e.phase_off[axis]), 3 * e.amplitude_sd[axis]) << axis;
  }
}

/// What the noise-free ground allows along and across its brush, px: Cramer-Rao over what is uncovered.
Eigen::Vector2d bound(const Circling& s) {
  Scene still = s.scene;
  still.disc.visible = false;
  const SceneRenderer renderer(still);
  const auto at = [&](double x, double y) {
    return renderer.render_exact(0, 0, [&](double) { return ScenePose{{}, 0, {x, y}}; });
  };
  const double h = 0.05;
  const Picture right = at(h, 0), left = at(-h, 0), down = at(0, h), up = at(0, -h);
  const double angle = s.scene.platform.brush_angle_rad;
  const Point disc = s.pose(0.5 * s.frames / kRate).disc;
  double along = 0, across = 0;
  for (int y = 0; y < still.height; ++y)
    for (int x = 0; x < still.width; ++x) {
      if (std::hypot(x - disc.x, y - disc.y) < s.scene.disc.radius_px + 4) continue;
      const double gx = (right.at(x, y) - left.at(x, y)) / (2 * h),
                   gy = (down.at(x, y) - up.at(x, y)) / (2 * h);
      along += std::pow(std::cos(angle) * gx - std::sin(angle) * gy, 2);
      across += std::pow(std::sin(angle) * gx + std::cos(angle) * gy, 2);
    }
  const double noise = std::sqrt(still.read_noise * still.read_noise + 1.0 / 12);
  return {noise / std::sqrt(along), noise / std::sqrt(across)};
}

TEST(GroundMotion, BrushedGroundTellsItsMotionToTheLimitInBothDirections) {
  const Circling s;
  const GroundMotion motion = followed(s, s.pictures()), on_two = followed(s, s.pictures(), 2);
  for (std::size_t k = 0; k < motion.frames.size(); ++k)
    EXPECT_EQ(motion.frames[k]->displacement.x, on_two.frames[k]->displacement.x) << "for any threads";
  const Errors e = errors_of(motion, s);
  expect_right(e, s);
  const Eigen::Vector2d limit = bound(s);
  // The limit knows the ground, and counts the places beside the border and the part.
  EXPECT_LT(e.along, 1.4 * limit[0]);
  EXPECT_LT(e.across, 1.3 * limit[1]);
  EXPECT_GT(e.sd_along, 2 * e.sd_across);
}

// As JPEG does it: steps of so many grey levels for every coefficient of 8 x 8 px.
void quantise(Picture& picture, double step) {
  cv::Mat levels(picture.height(), picture.width(), CV_32F, picture.levels().data());
  for (int y = 0; y + 8 <= levels.rows; y += 8)
    for (int x = 0; x + 8 <= levels.cols; x += 8) {
      cv::Mat cell = levels(cv::Rect(x, y, 8, 8)), spectrum;
      cv::dct(cell, spectrum);
      for (float& c : cv::Mat_<float>(spectrum)) c = static_cast<float>(step * std::round(c / step));
      cv::idct(spectrum, cell);
    }
}

// Along its brush a ground follows too little of its motion, by 7 to 98 %, from steps of about its texture
// on.
TEST(GroundMotion, ABrushedGroundIsSeenThroughStepsFinerThanItsTexture) {
  Circling s;
  s.scene.read_noise = 1;
  for (const double step : {1.0, 4.0}) {
    std::vector<Picture> pictures = s.pictures();
    for (Picture& p : pictures) quantise(p, step);
    const GroundMotion motion = followed(s, std::move(pictures));
    EXPECT_TRUE(motion.verdict.brushed);
    EXPECT_LT(step, motion.verdict.texture);
    const Errors e = errors_of(motion, s);
    for (int axis = 0; axis < 2; ++axis)
      EXPECT_LT(std::abs(e.amplitude_off[axis]), 0.005) << step << " " << axis;
  }
}

TEST(GroundMotion, AGlanceTellsRestFromMotion) {
  Circling s;
  const GroundVerdict moving = glance(s, s.pictures());
  EXPECT_TRUE(moving.moves) << moving.reason;
  EXPECT_NEAR(moving.motion_px, s.circle_px / std::numbers::sqrt2, 0.25);
  EXPECT_NEAR(moving.texture, s.scene.platform.texture_rms, 0.8);
  // A motion of a few sd of a frame.
  s.circle_px = 0.25;
  EXPECT_TRUE(glance(s, s.pictures()).moves);
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    s.scene.seed = seed;
    s.circle_px = 0;
    s.scene.flicker = 0.05;
    const GroundVerdict resting = glance(s, s.pictures());
    EXPECT_TRUE(resting.visible) << resting.reason;
    EXPECT_FALSE(resting.moves) << resting.reason;
    EXPECT_NE(resting.reason.find("rests"), std::string::npos) << resting.reason;
  }
}

// Of few frames more than are wanted, too, the sample reaches to the end.
TEST(GroundMotion, TheSampleReachesToTheEnd) {
  Circling s;
  for (const int frames : {12, 13, 14, 16, 18, 40}) {
    s.frames = frames;
    MemorySource source(s.pictures(), kRate);
    const GroundSample sample = sample_ground(source, 0, frames - 1, kGroundGlance, s.options());
    EXPECT_GE(sample.frames.size(), 9U) << frames;
    EXPECT_GE(sample.frames.back().index, 0.8 * (frames - 1)) << frames;
  }
}

TEST(GroundMotion, WithoutTextureNothingIsFollowed) {
  Circling s;
  s.scene.platform.texture_rms = 0;
  s.scene.vignetting = 0.3;
  const GroundVerdict plain = glance(s, s.pictures());
  EXPECT_FALSE(plain.moves) << plain.reason;
  const GroundMotion motion = followed(s, s.pictures());
  EXPECT_FALSE(motion.verdict.visible) << motion.verdict.reason;
  EXPECT_TRUE(motion.frames.empty());
}

}  // namespace
}  // namespace tribotrack::vision
