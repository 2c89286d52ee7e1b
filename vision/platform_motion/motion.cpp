#include "vision/platform_motion/motion.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "vision/kernels/dense.h"
#include "vision/kernels/median.h"
#include "vision/kernels/plane.h"

namespace tribotrack::vision {
namespace {

constexpr double kMostFloats = 32e6;  ///< of frames kept for the learning: 128 MB
constexpr int kFewestFrames = 12;
constexpr int kMargin = 8;           ///< px about its place: the start's error, the spline's reach
constexpr double kWorstLimit = 1;    ///< px: slopes do not locate a ground that is known worse
constexpr double kMotion = 4;        ///< times what noise explains, in squares: twice the sd
constexpr double kLeastScore = 0.5;  ///< of the usual one: less, and it is not the ground

/// Of the frame, where the ground's place should be seen; of what lies outside, the nearest pixels.
Rect moved_window(const Rect& place, const Point& by, const Rect& bounds) {
  const auto within = [](double from, int length, int whole) {
    const int first =
        std::clamp(static_cast<int>(std::floor(std::clamp(from, -1e6, 1e6))) - kMargin, 0, whole - 1);
    const int last = std::clamp(static_cast<int>(std::ceil(std::clamp(from, -1e6, 1e6))) + length + kMargin,
                                first + 1, whole);
    return std::pair(first, last - first);
  };
  const auto [left, width] = within(place.x + by.x, place.width, bounds.width);
  const auto [top, height] = within(place.y + by.y, place.height, bounds.height);
  return {left, top, width, height};
}

/// At most one of each of so many stretches, its place in it by the golden ratio.
std::vector<std::int64_t> spread(std::int64_t first, std::int64_t last, std::int64_t count) {
  std::vector<std::int64_t> indices;
  const double stretch = static_cast<double>(last - first + 1) / static_cast<double>(count);
  for (std::int64_t k = 0; k < count; ++k) {
    const auto n = static_cast<double>(k);
    const auto index = first + static_cast<std::int64_t>((n + std::fmod(n * std::numbers::phi, 1)) * stretch);
    if (indices.empty() || index > indices.back()) indices.push_back(index);  // neighbours may share a frame
  }
  return indices;
}

double worse_sd(const Eigen::Matrix2d& covariance) {
  return std::sqrt(eigenvalues(covariance)(1));
}

GroundVerdict verdict_on(const std::optional<LearntGround>& learnt) {
  GroundVerdict v;
  if (!learnt) {
    v.reason = "the ground shows no texture above the noise";
    return v;
  }
  v.texture = learnt->texture;
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  std::vector<double> worst;
  double count = 0;
  for (const auto& fix : learnt->fixes) {
    if (!fix) continue;
    const Eigen::Matrix2d weight = fix->covariance.inverse();
    information += weight;
    mean += weight * Eigen::Vector2d(fix->displacement.x, fix->displacement.y);
    worst.push_back(worse_sd(fix->covariance));
    ++count;
  }
  mean = information.inverse() * mean;
  double squares = 0, motion = 0, noise = 0;
  for (const auto& fix : learnt->fixes) {
    if (!fix) continue;
    const Eigen::Vector2d off = Eigen::Vector2d(fix->displacement.x, fix->displacement.y) - mean;
    squares += off.dot(fix->covariance.inverse() * off);
    motion += off.squaredNorm();
    noise += fix->covariance.trace();
  }
  const Eigen::Vector2d known = eigenvalues(information);
  v.brushed = known(0) < 0.25 * known(1);
  v.limit_px = median(worst);
  v.motion_px = std::sqrt(std::max(0.0, motion - noise) / (2 * count));
  v.visible = v.limit_px < kWorstLimit;
  const double ratio = squares / (2 * (count - 1));
  v.moves = ratio > kMotion;
  if (!v.visible)
    v.reason = fmt::format(
        "the ground's texture of {:.2g} grey levels rms would locate it to {:.2g} px a frame only", v.texture,
        v.limit_px);
  else if (!v.moves)
    v.reason = fmt::format(
        "the ground rests: its texture of {:.2g} grey levels rms locates it to {:.2g} px a frame, and it "
        "moves "
        "by {:.2g} px rms, {:.1f} sd",
        v.texture, v.limit_px, v.motion_px, std::sqrt(ratio));
  else
    v.reason = fmt::format(
        "the ground's texture of {:.2g} grey levels rms locates it to {:.2g} px a frame; it moves by {:.2g} "
        "px rms",
        v.texture, v.limit_px, v.motion_px);
  return v;
}

/// Registers frame after frame, each from where the last two lead.
class GroundFollower {
 public:
  GroundFollower(FrameSource& source, std::int64_t first, const GroundMotionOptions& options,
                 const LearntGround& learnt)
      : source_(source),
        options_(options),
        learnt_(learnt),
        registration_(learnt.ground, options.threads),
        first_(first) {
    registration_.set_excess(learnt.excess);
  }

  std::optional<GroundFix> step(std::int64_t index) {
    frame_.index = index;
    frame_.hidden = options_.hidden(index);
    auto fix = at(last_ && before_ ? Point{2 * last_->x - before_->x, 2 * last_->y - before_->y}
                                   : last_.value_or(Point{}));
    if (!fix) fix = at(searched(index));
    before_ = fix ? last_ : std::nullopt;
    if (fix) last_ = fix->displacement;
    return fix;
  }

 private:
  std::optional<GroundFix> at(const Point& start) {
    frame_.window = moved_window(learnt_.ground.place, start, source_.bounds());
    source_.read(frame_.index, frame_.window, frame_.picture);
    const auto fix = registration_.refine(frame_, start);
    return fix && fix->score > kLeastScore * learnt_.score ? fix : std::nullopt;
  }
  Point searched(std::int64_t index) {
    if (!coarse_) coarse_.emplace(source_.read(first_), options_.hidden(first_), options_.noise_variance);
    return coarse_->of(source_.read(index), frame_.hidden);
  }

  FrameSource& source_;
  const GroundMotionOptions& options_;
  const LearntGround& learnt_;
  GroundRegistration registration_;
  std::int64_t first_;
  std::optional<CoarseShift> coarse_;
  GroundFrame frame_;
  std::optional<Point> last_, before_;
};

constexpr int kStep = 32;  ///< px between windows that are compared

/// The whole picture, or of a large one the window with the most information: the smaller eigenvalue of sum
/// grad f grad f^T beyond the noise. What lies over the ground (`hidden`) tells nothing of it, strong as its
/// edges are.
Rect best_window(const Picture& first, const std::vector<Circle>& hidden, double noise_variance,
                 int most_pixels) {
  const int side = static_cast<int>(std::sqrt(most_pixels));
  Rect best{0, 0, std::min(first.width(), side), std::min(first.height(), side)};
  best.width = std::min(first.width(), most_pixels / best.height);
  best.height = std::min(first.height(), most_pixels / best.width);
  const cv::Mat levels = matrix_of(first);
  cv::Mat x, y, there(levels.size(), CV_32F, cv::Scalar(1)), xx, xy, yy, n;
  cv::Sobel(levels, x, CV_32F, 1, 0, 1, 0.5);
  cv::Sobel(levels, y, CV_32F, 0, 1, 1, 0.5);
  for (const Circle& c : hidden)
    cv::circle(there, {static_cast<int>(c.x), static_cast<int>(c.y)}, static_cast<int>(c.radius) + 2,
               cv::Scalar(0), cv::FILLED);
  x = x.mul(there);
  y = y.mul(there);
  cv::integral(x.mul(x), xx, CV_64F);
  cv::integral(x.mul(y), xy, CV_64F);
  cv::integral(y.mul(y), yy, CV_64F);
  cv::integral(there, n, CV_64F);
  double most = -1e300;
  for (int top = 0; top + best.height <= first.height(); top += kStep)
    for (int left = 0; left + best.width <= first.width(); left += kStep) {
      const auto sum = [&](const cv::Mat& of) {
        const int right = left + best.width, bottom = top + best.height;
        return of.at<double>(bottom, right) - of.at<double>(top, right) - of.at<double>(bottom, left) +
               of.at<double>(top, left);
      };
      // A central difference of white noise has half its variance.
      const double information = 0.5 * (sum(xx) + sum(yy)) - std::hypot(0.5 * (sum(xx) - sum(yy)), sum(xy)) -
                                 0.5 * noise_variance * sum(n);
      if (information <= most) continue;
      most = information;
      best.x = left;
      best.y = top;
    }
  return best;
}

}  // namespace

GroundSampler::GroundSampler(const Picture& first_picture, const std::vector<Circle>& hidden,
                             std::int64_t first, std::int64_t last, const GroundEffort& effort,
                             double noise_variance)
    : coarse_(first_picture, hidden, noise_variance) {
  sample_.place = best_window(first_picture, hidden, noise_variance, effort.pixels);
  const double floats =
      static_cast<double>(sample_.place.width + 2 * kMargin) * (sample_.place.height + 2 * kMargin);
  const auto affordable = static_cast<std::int64_t>(kMostFloats / floats);
  indices_ = spread(first, last,
                    std::min({std::max<std::int64_t>(affordable, kFewestFrames), std::int64_t{effort.frames},
                              last - first + 1}));
}

bool GroundSampler::wants(std::int64_t index) const {
  return sample_.frames.size() < indices_.size() && index == indices_[sample_.frames.size()];
}

void GroundSampler::see(FrameSource& source, std::int64_t index, const std::vector<Circle>& hidden) {
  GroundFrame frame;
  frame.index = index;
  frame.hidden = hidden;
  source.read(index, source.bounds(), whole_);
  if (index != indices_.front()) frame.start = coarse_.of(whole_, hidden);
  frame.window = moved_window(sample_.place, frame.start, source.bounds());
  source.read(index, frame.window, frame.picture);
  sample_.frames.push_back(std::move(frame));
}

GroundSample sample_ground(FrameSource& source, std::int64_t first, std::int64_t last,
                           const GroundEffort& effort, const GroundMotionOptions& options) {
  GroundSampler sampler(source.read(first), options.hidden(first), first, last, effort,
                        options.noise_variance);
  for (std::int64_t index = first; index <= last; ++index)
    if (sampler.wants(index)) sampler.see(source, index, options.hidden(index));
  return sampler.sample();
}

GroundVerdict look_at_ground(const GroundSample& sample, double noise_variance) {
  return verdict_on(learn_ground(sample.frames, sample.place, noise_variance, kGroundGlance.rounds));
}

GroundMotion follow_ground(FrameSource& source, std::int64_t first, std::int64_t last,
                           const GroundMotionOptions& options) {
  GroundMotion motion;
  std::optional<LearntGround> learnt;
  {
    const GroundSample sample = sample_ground(source, first, last, kGroundLearning, options);
    learnt = learn_ground(sample.frames, sample.place, options.noise_variance, kGroundLearning.rounds,
                          options.threads);
    motion.learnt_from = static_cast<int>(sample.frames.size());
  }
  motion.verdict = verdict_on(learnt);
  if (!motion.verdict.visible) return motion;
  GroundFollower follower(source, first, options, *learnt);
  for (std::int64_t index = first; index <= last; ++index) motion.frames.push_back(follower.step(index));
  return motion;
}

}  // namespace tribotrack::vision
