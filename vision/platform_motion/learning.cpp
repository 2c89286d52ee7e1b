#include "vision/platform_motion/learning.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "vision/kernels/median.h"
#include "vision/platform_motion/noise_free.h"
#include "vision/platform_motion/registration.h"

namespace tribotrack::vision {
namespace {

constexpr int kMostRounds = 10;
constexpr double kSettled = 0.1;    ///< of the standard deviation, rms: a hundredth of the variance
constexpr double kOutlier = 4;      ///< sd, as in the registration
constexpr int kBorder = 3;          ///< px beside a picture's border where a spline sees its mirror image
constexpr float kFewest = 2;        ///< frames that make a mean and a variance
constexpr double kLeastShare = 0.5; ///< of the frames that must be registered

/// Where a frame was taken to lie, and in which light.
struct Placed {
  const GroundFrame* frame = nullptr;
  Point displacement;
  double gain = 1, offset = 0;
};

/// Sums over frames at one field's places.
struct FieldSums {
  Picture sum, squares, count;
  explicit FieldSums(const Rect& place)
      : sum(place.width, place.height), squares(place.width, place.height), count(place.width, place.height) {}
};

/// Where a frame's window covers the field, on the field's own grid.
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
void add(const Placed& placed, std::size_t f, const Rect& place, const GroundField* before, FieldSums& sums) {
  const Rect& window = placed.frame->windows[f];
  const Point& p = placed.displacement;
  const Rect r = covered(place, window, p);
  if (r.width == 0 || r.height == 0) return;
  const QuinticSpline spline(placed.frame->pictures[f]);
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
      const float level =
          (levels[static_cast<std::size_t>(y) * static_cast<std::size_t>(r.width) + static_cast<std::size_t>(x)] -
           offset) * gain;
      const bool known = before && before->seen.at(u, v) >= kFewest;
      const float off = known ? level - before->quiet.at(u, v) : level;
      if (known && off * off > kOutlier * kOutlier * before->variance.at(u, v)) continue;
      sums.sum.at(u, v) += level;
      sums.squares.at(u, v) += level * level;
      sums.count.at(u, v) += 1;
    }
  }
}

/// Mean over 5 x 5 places of what is known: a variance from a hundred frames scatters by a seventh.
Picture smoothed(const Picture& variance, const Picture& seen) {
  constexpr int kReach = 2;
  const int w = variance.width(), h = variance.height();
  Picture rows(w, h), counts(w, h), out(w, h);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      for (int k = std::max(0, x - kReach); k <= std::min(w - 1, x + kReach); ++k)
        if (seen.at(k, y) >= kFewest) {
          rows.at(x, y) += variance.at(k, y);
          counts.at(x, y) += 1;
        }
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      float sum = 0, count = 0;
      for (int k = std::max(0, y - kReach); k <= std::min(h - 1, y + kReach); ++k) {
        sum += rows.at(x, k);
        count += counts.at(x, k);
      }
      out.at(x, y) = count > 0 ? sum / count : 0;
    }
  return out;
}

GroundField field_from(const Rect& place, const FieldSums& sums, double noise_variance) {
  GroundField field;
  field.place = place;
  field.seen = sums.count;
  field.mean = field.variance = Picture(place.width, place.height);
  double total = 0, known = 0, left = 0;
  for (std::size_t i = 0; i < sums.count.levels().size(); ++i) {
    const float n = sums.count.levels()[i];
    if (n < kFewest) continue;
    const double mean = static_cast<double>(sums.sum.levels()[i]) / n;
    const double variance = (static_cast<double>(sums.squares.levels()[i]) - n * mean * mean) / (n - 1);
    field.mean.levels()[i] = static_cast<float>(mean);
    field.variance.levels()[i] = static_cast<float>(std::max(variance, noise_variance));
    total += mean;
    left += field.variance.levels()[i] / n;
    ++known;
  }
  const auto elsewhere = static_cast<float>(known > 0 ? total / known : 0);
  for (std::size_t i = 0; i < field.mean.levels().size(); ++i)
    if (sums.count.levels()[i] < kFewest) field.mean.levels()[i] = elsewhere;
  field.variance = smoothed(field.variance, field.seen);
  field.quiet = known > 0 ? noise_free(field.mean, left / known) : field.mean;
  return field;
}

Ground mean_of(const std::vector<Placed>& frames, const std::vector<Rect>& places, const Ground* before,
               double noise_variance) {
  Ground ground;
  double level = 0;
  for (std::size_t f = 0; f < places.size(); ++f) {
    FieldSums sums(places[f]);
    for (const Placed& p : frames) add(p, f, places[f], before ? &before->fields[f] : nullptr, sums);
    ground.fields.push_back(field_from(places[f], sums, noise_variance));
    const auto levels = ground.fields.back().mean.levels();
    for (const float l : levels) level += static_cast<double>(l) / static_cast<double>(levels.size());
  }
  ground.level = static_cast<float>(level / static_cast<double>(places.size()));
  for (GroundField& field : ground.fields) {
    Picture less = field.quiet;
    for (float& l : less.levels()) l -= ground.level;
    field.less = QuinticSpline(less);
  }
  return ground;
}

/// Mean over frames of N^(-1/2) S N^(-1/2), see GroundRegistration.
class Excess {
 public:
  void add(const GroundRegistration& r) {
    const Eigen::Matrix2d root =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(r.normal()).operatorInverseSqrt();
    sum_ += root * r.scatter() * root;
    ++count_;
  }
  Eigen::Matrix2d mean() const { return count_ > 0 ? Eigen::Matrix2d(sum_ / count_) : sum_; }

 private:
  Eigen::Matrix2d sum_ = Eigen::Matrix2d::Zero();
  double count_ = 0;
};

double median_score(const std::vector<std::optional<GroundFix>>& fixes) {
  std::vector<double> scores;
  for (const auto& fix : fixes)
    if (fix) scores.push_back(fix->score);
  return median(scores);
}

}  // namespace

std::optional<LearntGround> learn_ground(const std::vector<GroundFrame>& frames,
                                         const std::vector<Rect>& places, double noise_variance) {
  std::vector<Placed> placed;
  for (const GroundFrame& f : frames) placed.push_back({&f, f.start});
  LearntGround learnt;
  learnt.ground = mean_of(placed, places, nullptr, noise_variance);
  std::vector<Point> last;
  for (const GroundFrame& f : frames) last.push_back(f.start);
  for (bool settled = false; !settled && learnt.rounds < kMostRounds; ++learnt.rounds) {
    GroundRegistration registration(learnt.ground);
    registration.set_excess(learnt.excess);
    Excess excess;
    learnt.texture = registration.texture();
    learnt.fixes.assign(frames.size(), std::nullopt);
    placed.clear();
    double moved = 0;
    for (std::size_t k = 0; k < frames.size(); ++k) {
      const auto fix = registration.refine(frames[k], last[k]);
      if (!fix) continue;
      excess.add(registration);
      learnt.fixes[k] = fix;
      placed.push_back({&frames[k], fix->displacement, fix->gain, fix->offset});
      const Eigen::Vector2d step(fix->displacement.x - last[k].x, fix->displacement.y - last[k].y);
      moved += step.dot(registration.normal() * step);
      last[k] = fix->displacement;
    }
    const auto count = static_cast<double>(placed.size());
    if (count < kLeastShare * static_cast<double>(frames.size()) || count < kFewest) return std::nullopt;
    learnt.excess = excess.mean();
    settled = learnt.rounds > 0 && moved < 2 * count * kSettled * kSettled;
    if (!settled) learnt.ground = mean_of(placed, places, &learnt.ground, noise_variance);
  }
  learnt.score = median_score(learnt.fixes);
  return learnt;
}

}  // namespace tribotrack::vision
