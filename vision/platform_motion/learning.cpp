#include "vision/platform_motion/motion.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "vision/kernels/dense.h"
#include "vision/kernels/median.h"
#include "vision/kernels/plane.h"
#include "vision/platform_motion/registration.h"

namespace tribotrack::vision {
namespace {

constexpr double kSettled = 0.1;  ///< of the standard deviation, rms: a hundredth of the variance
constexpr float kOutlier = 4;     ///< sd, as in the registration
/// sd that an object widens itself: one that covers a ninth of the frames stands out by 3 of them.
constexpr float kOutlierAtFirst = 3;
constexpr int kBorder = 3;           ///< px beside a picture's border where a spline sees its mirror image
constexpr float kKnownShare = 0.5F;  ///< of the frames: seen in fewer, a place's noise passes for a texture
constexpr double kLeastShare = 0.5;  ///< of the frames that must be registered

/// Where a frame was taken to lie, and in which light.
struct Placed {
  const GroundFrame* frame = nullptr;
  Point displacement;
  double gain = 1, offset = 0;
};

/// Sums over frames at the ground's places.
struct Sums {
  Picture sum, squares, count;
  explicit Sums(const Rect& place)
      : sum(place.width, place.height),
        squares(place.width, place.height),
        count(place.width, place.height) {}
};

/// Where a frame's window covers the ground's place, on its grid.
Rect covered(const Rect& place, const Rect& window, const Point& p) {
  const int left = std::max(0, static_cast<int>(std::ceil(window.x + kBorder - p.x)) - place.x);
  const int top = std::max(0, static_cast<int>(std::ceil(window.y + kBorder - p.y)) - place.y);
  const int right = std::min(
      place.width, static_cast<int>(std::floor(window.x + window.width - 1 - kBorder - p.x)) + 1 - place.x);
  const int bottom = std::min(
      place.height, static_cast<int>(std::floor(window.y + window.height - 1 - kBorder - p.y)) + 1 - place.y);
  return {left, top, std::max(0, right - left), std::max(0, bottom - top)};
}

bool hidden_at(const std::vector<Circle>& hidden, double x, double y) {
  return std::ranges::any_of(hidden, [&](const Circle& c) {
    return (x - c.x) * (x - c.x) + (y - c.y) * (y - c.y) <= c.radius * c.radius;
  });
}

/// Deviations from `before`, where there is one: outliers from it are left out.
void add(const Placed& placed, const Rect& place, const Ground* before, float outlier, Sums& sums) {
  const Rect& window = placed.frame->window;
  const Point& p = placed.displacement;
  const Rect r = covered(place, window, p);
  if (r.width == 0 || r.height == 0) return;
  const QuinticSpline spline(placed.frame->picture);
  std::vector<float> levels(static_cast<std::size_t>(r.width) * static_cast<std::size_t>(r.height));
  const double x0 = place.x + r.x + p.x, y0 = place.y + r.y + p.y;
  spline.sample_window(x0 - window.x, y0 - window.y, r.width, r.height, levels.data(), nullptr, nullptr);
  const auto gain = static_cast<float>(1 / placed.gain), offset = static_cast<float>(placed.offset);
  for (int y = 0; y < r.height; ++y) {
    std::vector<Circle> near;  // of this row
    for (const Circle& c : placed.frame->hidden)
      if (std::abs(y0 + y - c.y) <= c.radius) near.push_back(c);
    for (int x = 0; x < r.width; ++x) {
      if (!near.empty() && hidden_at(near, x0 + x, y0 + y)) continue;
      const int u = r.x + x, v = r.y + y;
      const float level = (levels[static_cast<std::size_t>(y) * static_cast<std::size_t>(r.width) +
                                  static_cast<std::size_t>(x)] -
                           offset) *
                          gain;
      const bool known = before && before->seen.at(u, v) > 0;
      const float off = known ? level - before->quiet.at(u, v) : level;
      if (known && off * off > outlier * outlier * before->variance.at(u, v)) continue;
      sums.sum.at(u, v) += level;
      sums.squares.at(u, v) += level * level;
      sums.count.at(u, v) += 1;
    }
  }
}

/// Mean over 5 x 5 places of what is known: a variance from a hundred frames scatters by a seventh.
void smooth(Picture& variance, const Picture& seen) {
  const cv::Size around(5, 5);
  cv::Mat known, count, sum, of = matrix_of(variance);
  cv::threshold(matrix_of(seen), known, 0, 1, cv::THRESH_BINARY);
  cv::boxFilter(known, count, -1, around, {-1, -1}, false, cv::BORDER_CONSTANT);
  cv::boxFilter(of.mul(known), sum, -1, around, {-1, -1}, false, cv::BORDER_CONSTANT);
  cv::Mat(sum / cv::max(count, 1)).copyTo(of);
}

/// 0 beside what is not known, too: slopes there are half a guess.
void shrink(Picture& seen) {
  cv::Mat of = matrix_of(seen);
  cv::erode(of, of, cv::Mat::ones(2 * kBorder + 1, 2 * kBorder + 1, CV_8U));
}

Ground mean_of(const std::vector<Placed>& frames, const Rect& place, const Ground* before,
               double noise_variance, float outlier = kOutlier) {
  Sums sums(place);
  for (const Placed& p : frames) add(p, place, before, outlier, sums);
  const float fewest = std::max(2.0F, kKnownShare * static_cast<float>(frames.size()));
  Ground ground;
  ground.place = place;
  ground.seen = sums.count;
  ground.variance = Picture(place.width, place.height);
  Picture mean_level(place.width, place.height);
  double known = 0, left = 0, level = 0;
  for (std::size_t i = 0; i < sums.count.levels().size(); ++i) {
    const float n = sums.count.levels()[i];
    if (n < fewest) {
      ground.seen.levels()[i] = 0;
      continue;
    }
    const double mean = static_cast<double>(sums.sum.levels()[i]) / n;
    const double variance = (static_cast<double>(sums.squares.levels()[i]) - n * mean * mean) / (n - 1);
    mean_level.levels()[i] = static_cast<float>(mean);
    ground.variance.levels()[i] = static_cast<float>(std::max(variance, noise_variance));
    left += ground.variance.levels()[i] / n;
    level += mean / static_cast<double>(sums.count.levels().size());
    ++known;
  }
  ground.quiet = known > 0
                     ? noise_free(mean_level, ground.seen, left / known, before ? &before->quiet : nullptr)
                     : mean_level;
  smooth(ground.variance, ground.seen);
  shrink(ground.seen);
  ground.level = static_cast<float>(level);
  Picture less = ground.quiet;
  for (float& l : less.levels()) l -= ground.level;
  ground.less = QuinticSpline(less);
  return ground;
}

/// frame = gain ground + offset says nothing of the ground's own light: as it is in the mean of the frames.
/// Otherwise the contrast that is taken from the ground with its noise would be taken again in every round.
void in_mean_light(std::vector<Placed>& frames) {
  double gain = 0, offset = 0;
  for (const Placed& p : frames) {
    gain += p.gain / static_cast<double>(frames.size());
    offset += p.offset / static_cast<double>(frames.size());
  }
  for (Placed& p : frames) {
    p.gain /= gain;
    p.offset -= p.gain * offset;
  }
}

/// In turn the mean of all and each frame's place in it. A frame's own noise in the mean holds it where it
/// was taken to lie: rounds go on until that no longer matters.
class Learning {
 public:
  Learning(const std::vector<GroundFrame>& frames, const Rect& place, double noise_variance)
      : frames_(frames), place_(place), noise_variance_(noise_variance), fixes_(frames.size()) {
    for (const GroundFrame& f : frames) placed_.push_back(Placed{&f, f.start});
    const Ground all = mean_of(placed_, place_, nullptr, noise_variance_);
    ground_ = mean_of(placed_, place_, &all, noise_variance_, kOutlierAtFirst);
  }

  /// How far the frames have moved against each other, sd rms.
  double round() {
    GroundRegistration registration(ground_);
    excess_.setZero();
    std::vector<Placed> placed;
    std::vector<Eigen::Vector2d> moves;
    std::vector<Eigen::Matrix2d> normals;
    Eigen::Vector2d common = Eigen::Vector2d::Zero();
    for (std::size_t k = 0; k < frames_.size(); ++k) {
      const Point from = fixes_[k] ? fixes_[k]->displacement : frames_[k].start;
      fixes_[k] = registration.refine(frames_[k], from);
      if (!fixes_[k]) continue;
      const Point to = fixes_[k]->displacement;
      const Eigen::Matrix2d root = inverse_root(registration.normal());
      excess_ += root * registration.scatter() * root;
      placed.push_back({&frames_[k], to, fixes_[k]->gain, fixes_[k]->offset});
      moves.emplace_back(to.x - from.x, to.y - from.y);
      normals.push_back(registration.normal());
      common += moves.back();
    }
    placed_ = std::move(placed);
    if (moves.empty()) return 0;
    in_mean_light(placed_);
    excess_ /= static_cast<double>(moves.size());
    ground_ = mean_of(placed_, place_, &ground_, noise_variance_);
    common /= static_cast<double>(moves.size());  // it moves the grid
    double squares = 0;
    for (std::size_t k = 0; k < moves.size(); ++k)
      squares += (moves[k] - common).dot(normals[k] * (moves[k] - common));
    return std::sqrt(squares / (2 * static_cast<double>(moves.size())));
  }

  bool enough() const {
    return static_cast<double>(placed_.size()) >=
           std::max(4.0, kLeastShare * static_cast<double>(frames_.size()));
  }

  void finish(LearntGround& out) {
    out.texture = GroundRegistration(ground_).texture();
    out.excess = excess_;
    std::vector<double> scores;
    for (const auto& fix : fixes_)
      if (fix) scores.push_back(fix->score);
    out.score = median(scores);
    out.ground = std::move(ground_);
    out.fixes = std::move(fixes_);
  }

 private:
  const std::vector<GroundFrame>& frames_;
  Rect place_;
  double noise_variance_;
  std::vector<Placed> placed_;  ///< those that could be registered
  std::vector<std::optional<GroundFix>> fixes_;
  Ground ground_;
  Eigen::Matrix2d excess_ = Eigen::Matrix2d::Zero();  ///< mean of N^(-1/2) S N^(-1/2), see GroundRegistration
};

}  // namespace

std::optional<LearntGround> learn_ground(const std::vector<GroundFrame>& frames, const Rect& place,
                                         double noise_variance, int most_rounds) {
  Learning learning(frames, place, noise_variance);
  for (int round = 0; round < most_rounds; ++round) {
    const double moved = learning.round();
    if (!learning.enough()) return std::nullopt;
    if (moved < kSettled) break;
  }
  LearntGround learnt;
  learning.finish(learnt);
  return learnt;
}

}  // namespace tribotrack::vision
