#include "vision/platform_motion/motion.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <span>
#include <utility>

#include "vision/kernels/dense.h"
#include "vision/kernels/median.h"
#include "vision/kernels/parallel.h"
#include "vision/kernels/plane.h"

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

/// Deviations from `before`, where there is one: outliers from it are left out.
void add(const Placed& placed, const Rect& place, const Ground* before, float outlier, PlaceSums& sums) {
  const Rect& window = placed.frame->window;
  const Rect r = places_shown(place, window, placed.displacement, kBorder);
  if (r.width <= 0 || r.height <= 0) return;
  Picture levels(r.width, r.height);
  const double x0 = r.x + placed.displacement.x, y0 = r.y + placed.displacement.y;
  QuinticSpline(placed.frame->picture)
      .sample_window(x0 - window.x, y0 - window.y, r.width, r.height, levels.levels().data(), nullptr,
                     nullptr);
  const auto gain = static_cast<float>(1 / placed.gain), offset = static_cast<float>(placed.offset);
  for (int y = 0; y < r.height; ++y) {
    std::vector<std::pair<double, double>> covered;  // of this row, from and to
    for (const Circle& c : placed.frame->hidden) {
      const double square = c.radius * c.radius - (y0 + y - c.y) * (y0 + y - c.y);
      if (square >= 0) covered.emplace_back(c.x - std::sqrt(square) - x0, c.x + std::sqrt(square) - x0);
    }
    for (int x = 0; x < r.width; ++x) {
      if (std::ranges::any_of(covered, [&](const auto& c) { return c.first <= x && x <= c.second; }))
        continue;
      const int u = r.x - place.x + x, v = r.y - place.y + y;
      const float level = (levels.at(x, y) - offset) * gain;
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

/// In so many parts whatever the number of threads: the sums' rounding is the same.
PlaceSums sums_of(const std::vector<Placed>& frames, const Rect& place, const Ground* before, float outlier,
                  int threads) {
  constexpr std::size_t kParts = 8;
  std::vector<PlaceSums> parts(kParts, PlaceSums(place));
  parallel_for(kParts, threads, [&](std::size_t part, std::size_t) {
    for (std::size_t k = part; k < frames.size(); k += kParts)
      add(frames[k], place, before, outlier, parts[part]);
  });
  for (std::size_t part = 1; part < kParts; ++part)
    for (Picture PlaceSums::*of : {&PlaceSums::sum, &PlaceSums::squares, &PlaceSums::count})
      matrix_of(parts.front().*of) += matrix_of(parts[part].*of);
  return std::move(parts.front());
}

Ground mean_of(const std::vector<Placed>& frames, const Rect& place, const Ground* before,
               double noise_variance, int threads, float outlier = kOutlier) {
  const PlaceSums sums = sums_of(frames, place, before, outlier, threads);
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
  /// `before`: a ground they can be registered to at once; null: the mean of the frames at their starts.
  Learning(std::span<const GroundFrame* const> frames, const Rect& place, double noise_variance, int threads,
           const Ground* before)
      : frames_(frames), place_(place), noise_variance_(noise_variance), threads_(threads) {
    learnt_.fixes.resize(frames.size());
    if (before) {
      learnt_.ground = *before;
      return;
    }
    for (const GroundFrame* f : frames) placed_.push_back(Placed{f, f->start});
    const Ground all = mean_of(placed_, place_, nullptr, noise_variance_, threads_);
    learnt_.ground = mean_of(placed_, place_, &all, noise_variance_, threads_, kOutlierAtFirst);
  }

  /// False where too few frames can be registered.
  bool rounds(int most) {
    for (int k = 0; k < most; ++k) {
      const double moved = register_all();
      if (!enough()) return false;
      learnt_.ground = mean_of(placed_, place_, &learnt_.ground, noise_variance_, threads_);
      if (moved < kSettled) break;
    }
    return true;
  }

  LearntGround finish() {
    learnt_.texture = GroundRegistration(learnt_.ground).texture();
    std::vector<double> scores;
    for (const auto& fix : learnt_.fixes)
      if (fix) scores.push_back(fix->score);
    learnt_.score = median(scores);
    return std::move(learnt_);
  }

 private:
  /// How far the frames have moved against each other, sd rms.
  double register_all() {
    GroundRegistration registration(learnt_.ground, threads_);
    learnt_.excess.setZero();
    std::vector<Placed> placed;
    std::vector<Eigen::Vector2d> moves;
    std::vector<Eigen::Matrix2d> normals;
    Eigen::Vector2d common = Eigen::Vector2d::Zero();
    for (std::size_t k = 0; k < frames_.size(); ++k) {
      auto& fix = learnt_.fixes[k];
      const Point from = fix ? fix->displacement : frames_[k]->start;
      fix = registration.refine(*frames_[k], from);
      if (!fix) continue;
      const Point to = fix->displacement;
      const Eigen::Matrix2d root = inverse_root(registration.normal());
      learnt_.excess += root * registration.scatter() * root;
      placed.push_back({frames_[k], to, fix->gain, fix->offset});
      moves.emplace_back(to.x - from.x, to.y - from.y);
      normals.push_back(registration.normal());
      common += moves.back();
    }
    placed_ = std::move(placed);
    if (moves.empty()) return 0;
    in_mean_light(placed_);
    learnt_.excess /= static_cast<double>(moves.size());
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

  std::span<const GroundFrame* const> frames_;
  Rect place_;
  double noise_variance_;
  int threads_;
  std::vector<Placed> placed_;  ///< those that could be registered
  LearntGround learnt_;
};

}  // namespace

std::optional<LearntGround> learn_ground(const std::vector<GroundFrame>& frames, const Rect& place,
                                         double noise_variance, int most_rounds, int threads) {
  // Of many a few find where the ground lies, at an eighth of the cost of a round.
  constexpr std::size_t kMany = 64, kEvery = 8;
  std::vector<const GroundFrame*> all, few;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    all.push_back(&frames[k]);
    if (k % kEvery == 0) few.push_back(&frames[k]);
  }
  std::optional<Ground> found;
  if (frames.size() >= kMany) {
    Learning first(few, place, noise_variance, threads, nullptr);
    if (first.rounds(most_rounds)) found = first.finish().ground;
  }
  Learning learning(all, place, noise_variance, threads, found ? &*found : nullptr);
  if (!learning.rounds(most_rounds)) return std::nullopt;
  return learning.finish();
}

}  // namespace tribotrack::vision
