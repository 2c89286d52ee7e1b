#include "vision/platform_motion/motion.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/kernels/dense.h"
#include "vision/kernels/median.h"
#include "vision/platform_motion/registration.h"

namespace tribotrack::vision {
namespace {

constexpr double kMostFloats = 32e6;  ///< of frames kept for the learning: 128 MB
constexpr int kFewestFrames = 12;
constexpr int kMargin = 8;           ///< px about a field: the start's error, the spline's reach
constexpr double kWorstLimit = 1;    ///< px: slopes do not locate a ground that is known worse
constexpr double kMotion = 4;        ///< times what noise explains, in squares: twice the sd
constexpr double kLeastScore = 0.5;  ///< of the usual one: less, and it is not the ground

Rect moved_window(const Rect& field, const Point& by, const Rect& bounds) {
  if (field.width == bounds.width && field.height == bounds.height) return bounds;
  const int left = std::max(0, field.x + static_cast<int>(std::floor(by.x)) - kMargin);
  const int top = std::max(0, field.y + static_cast<int>(std::floor(by.y)) - kMargin);
  const int right =
      std::min(bounds.width, field.x + field.width + static_cast<int>(std::ceil(by.x)) + kMargin);
  const int bottom =
      std::min(bounds.height, field.y + field.height + static_cast<int>(std::ceil(by.y)) + kMargin);
  return {left, top, std::max(1, right - left), std::max(1, bottom - top)};
}

Picture cut(const Picture& whole, const Rect& window) {
  Picture out(window.width, window.height);
  for (int y = 0; y < window.height; ++y)
    std::ranges::copy(
        whole.row(window.y + y)
            .subspan(static_cast<std::size_t>(window.x), static_cast<std::size_t>(window.width)),
        out.row(y).begin());
  return out;
}

/// The fields of a frame, near where they should be.
void read_fields(FrameSource& source, const std::vector<Rect>& fields, GroundFrame& frame) {
  frame.windows.clear();
  frame.pictures.resize(fields.size());
  for (std::size_t f = 0; f < fields.size(); ++f) {
    frame.windows.push_back(moved_window(fields[f], frame.start, source.bounds()));
    source.read(frame.index, frame.windows.back(), frame.pictures[f]);
  }
}

/// One of each of so many stretches, its place in it by the golden ratio.
std::vector<std::int64_t> spread(std::int64_t first, std::int64_t last, std::int64_t count) {
  std::vector<std::int64_t> indices;
  const double stretch = static_cast<double>(last - first + 1) / static_cast<double>(count);
  for (std::int64_t k = 0; k < count; ++k) {
    const auto n = static_cast<double>(k);
    indices.push_back(first + static_cast<std::int64_t>((n + std::fmod(n * std::numbers::phi, 1)) * stretch));
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
      : source_(source), options_(options), learnt_(learnt), registration_(learnt.ground), first_(first) {
    registration_.set_excess(learnt.excess);
    for (const GroundField& f : learnt.ground.fields) fields_.push_back(f.place);
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
    frame_.start = start;
    read_fields(source_, fields_, frame_);
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
  std::vector<Rect> fields_;
  std::optional<CoarseShift> coarse_;
  GroundFrame frame_;
  std::optional<Point> last_, before_;
};

constexpr int kField = 128;

bool in_any(const std::vector<Circle>& circles, int x, int y) {
  return std::ranges::any_of(circles,
                             [&](const Circle& c) { return std::hypot(x - c.x, y - c.y) <= c.radius + 1; });
}

/// A central difference of white noise has half its variance.
double information(const Picture& p, const Rect& r, std::vector<Circle> hidden, double noise_variance) {
  std::erase_if(hidden, [&](const Circle& c) {
    return c.x + c.radius + 1 < r.x || c.x - c.radius - 1 > r.x + r.width || c.y + c.radius + 1 < r.y ||
           c.y - c.radius - 1 > r.y + r.height;
  });
  double xx = 0, xy = 0, yy = 0, n = 0;
  for (int y = std::max(1, r.y); y < std::min(p.height() - 1, r.y + r.height); ++y)
    for (int x = std::max(1, r.x); x < std::min(p.width() - 1, r.x + r.width); ++x) {
      if (!hidden.empty() && in_any(hidden, x, y)) continue;
      ++n;
      const double gx = 0.5 * (p.at(x + 1, y) - p.at(x - 1, y));
      const double gy = 0.5 * (p.at(x, y + 1) - p.at(x, y - 1));
      xx += gx * gx;
      xy += gx * gy;
      yy += gy * gy;
    }
  const double smaller = 0.5 * (xx + yy) - std::hypot(0.5 * (xx - yy), xy);
  return smaller - 0.5 * noise_variance * n;
}

/// The whole picture, or of a large one the fields of 128 x 128 px with the most information: the smaller
/// eigenvalue of sum grad f grad f^T beyond the noise. What lies over the ground (`hidden`) tells nothing of
/// it, strong as its edges are.
std::vector<Rect> ground_fields(const Picture& first, const std::vector<Circle>& hidden,
                                double noise_variance, int most_pixels) {
  const Rect whole{0, 0, first.width(), first.height()};
  if (whole.width * whole.height <= most_pixels) return {whole};
  std::vector<std::pair<double, Rect>> fields;
  for (int y = 0; y < whole.height; y += kField)
    for (int x = 0; x < whole.width; x += kField) {
      const Rect r{x, y, std::min(kField, whole.width - x), std::min(kField, whole.height - y)};
      fields.emplace_back(information(first, r, hidden, noise_variance), r);
    }
  std::ranges::stable_sort(fields, std::greater<>(), &std::pair<double, Rect>::first);
  std::vector<Rect> chosen;
  int pixels = 0;
  for (const auto& [information, r] : fields) {
    if (pixels + r.width * r.height > most_pixels) break;
    pixels += r.width * r.height;
    chosen.push_back(r);
  }
  return chosen;
}

}  // namespace

GroundSampler::GroundSampler(const Picture& first_picture, const std::vector<Circle>& hidden,
                             std::int64_t first, std::int64_t last, const GroundEffort& effort,
                             double noise_variance)
    : coarse_(first_picture, hidden, noise_variance) {
  sample_.fields = ground_fields(first_picture, hidden, noise_variance, effort.pixels);
  double floats = 0;
  for (const Rect& f : sample_.fields)
    floats += static_cast<double>(f.width + 2 * kMargin) * (f.height + 2 * kMargin);
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
  for (const Rect& field : sample_.fields) {
    frame.windows.push_back(moved_window(field, frame.start, source.bounds()));
    frame.pictures.push_back(cut(whole_, frame.windows.back()));
  }
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
  return verdict_on(learn_ground(sample.frames, sample.fields, noise_variance, kGroundGlance.rounds));
}

GroundMotion follow_ground(FrameSource& source, std::int64_t first, std::int64_t last,
                           const GroundMotionOptions& options) {
  GroundMotion motion;
  std::optional<LearntGround> learnt;
  {
    const GroundSample sample = sample_ground(source, first, last, kGroundLearning, options);
    learnt = learn_ground(sample.frames, sample.fields, options.noise_variance, kGroundLearning.rounds);
    motion.learnt_from = static_cast<int>(sample.frames.size());
  }
  motion.verdict = verdict_on(learnt);
  if (!motion.verdict.visible) return motion;
  GroundFollower follower(source, first, options, *learnt);
  for (std::int64_t index = first; index <= last; ++index) motion.frames.push_back(follower.step(index));
  motion.ground = std::move(learnt->ground);
  return motion;
}

}  // namespace tribotrack::vision
