// What a slide's track shows by itself: blows, and the rate at which the disc turns.
#include "fit/slides/blows.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

#include "fit/residuals/free_slide.h"
#include "fit/tools/dense.h"
#include "fit/tools/statistics.h"
#include "model/trajectory.h"

namespace tribotrack::fit::internal {
namespace {

/// That a track without any blow shows one.
constexpr double kFalseAlarm = 1e-3;
/// Points of the windows that first measure noise and deceleration, and the fewest through which a parabola
/// is tested.
constexpr std::size_t kFirstWindow = 8, kFewest = 4;
/// Of the highest speed: below it a part counts as resting when the deceleration of sliding is looked for.
constexpr double kSlow = 0.2;

/// Points that are no part of the motion.
using Left = std::vector<bool>;

/// A parabola through the points [first, last) that are not `left` out, about the time `middle`.
struct Parabola {
  Eigen::Matrix<double, 3, 2> coefficients;
  double slope_variance = 0;  ///< of the velocity at `middle`, for points of variance 1
  double squares = 0;         ///< left over

  Parabola(const TrackTable& track, std::size_t first, std::size_t last, double middle,
           const Left& left = {}) {
    Eigen::Index n = 0;
    for (std::size_t row = first; row < last; ++row) n += left.empty() || !left[row];
    const double unit = std::max(track.time[last - 1] - track.time[first], 1e-12);
    Eigen::MatrixX3d a(n, 3);
    Eigen::MatrixX2d b(n, 2);
    Eigen::Index i = 0;
    for (std::size_t row = first; row < last; ++row) {
      if (!left.empty() && left[row]) continue;
      const double t = (track.time[row] - middle) / unit;
      a.row(i) << 1, t, t * t;
      b.row(i++) = track.position[row].transpose();
    }
    const Eigen::Matrix3d inverse = (a.transpose() * a).inverse();
    coefficients = inverse * (a.transpose() * b);
    squares = (b - a * coefficients).squaredNorm();
    slope_variance = inverse(1, 1) / (unit * unit);
    coefficients.row(1) /= unit;
    coefficients.row(2) /= unit * unit;
  }
  Eigen::Vector2d velocity() const { return coefficients.row(1).transpose(); }
  Eigen::Vector2d acceleration() const { return 2 * coefficients.row(2).transpose(); }
};

double middle_time(const TrackTable& track, std::size_t first, std::size_t last) {
  return 0.5 * (track.time[first] + track.time[last - 1]);
}

/// What the track shows nearly everywhere: its noise, and how fast the part slows down.
struct Usual {
  double noise = 0;         ///< m per axis
  double deceleration = 0;  ///< m/s^2
  double top_speed = 0;     ///< m/s
};

Usual usual_of(const TrackTable& track) {
  std::vector<double> squares, speeds, decelerations;
  for (std::size_t i = 0; i + kFirstWindow <= track.time.size(); ++i) {
    const Parabola fit(track, i, i + kFirstWindow, middle_time(track, i, i + kFirstWindow));
    squares.push_back(fit.squares / (2.0 * (kFirstWindow - 3)));
    speeds.push_back(fit.velocity().norm());
    decelerations.push_back(fit.acceleration().norm());
  }
  Usual usual;
  usual.noise = std::sqrt(upper_median(squares));
  usual.top_speed = *std::max_element(speeds.begin(), speeds.end());
  std::vector<double> sliding;
  for (std::size_t i = 0; i < speeds.size(); ++i)
    if (speeds[i] > kSlow * usual.top_speed) sliding.push_back(decelerations[i]);
  if (!sliding.empty()) usual.deceleration = upper_median(sliding);
  return usual;
}

class BlowSearch {
 public:
  explicit BlowSearch(const TrackTable& track)
      : track_(track), usual_(usual_of(track)), left_(track.time.size(), false) {
    const double n = static_cast<double>(track.time.size());
    step_ = (track.time.back() - track.time.front()) / (n - 1);
    sigmas_ = std::sqrt(2 * std::log(n / kFalseAlarm));  // a jump has two components
    // The window in which noise and friction together hide least: the sd of a parabola's slope at its end is
    // sqrt(192) noise/(w^1.5 step).
    const double friction = usual_.deceleration * step_ * step_;
    const double noise = sigmas_ * std::sqrt(2 * 192.0) * usual_.noise;
    const double best = friction > 0 ? std::pow(1.5 * noise / friction, 0.4) : n;
    window_ = static_cast<std::size_t>(std::clamp(best, kFewest + 1.0, std::max(kFewest + 1.0, n / 6)));
  }

  void search(std::size_t first, std::size_t last, std::vector<FoundBlow>& found) {
    const auto blow = strongest(first, last);
    if (!blow) return;
    search(first, blow->row - 1, found);
    found.push_back(*blow);
    search(std::min(blow->row + 1, last), last, found);
  }

 private:
  /// Points that alone make a blow are left out: a bad registration is none.
  std::optional<FoundBlow> strongest(std::size_t first, std::size_t last) {
    while (const auto where = largest_excess(first, last)) {
      const std::size_t k = sharpest(first, *where, last);
      const auto alone = made_by(first, k, last);
      if (!alone) return described(first, k, last);
      left_[*alone] = true;
    }
    return std::nullopt;
  }
  std::optional<std::size_t> largest_excess(std::size_t first, std::size_t last) const {
    if (last < first + 2 * kFewest) return std::nullopt;
    std::optional<std::size_t> where;
    double most = 0;
    for (std::size_t k = first + kFewest; k + kFewest <= last; ++k) {
      const double by = excess(first, k, last);
      if (by > most) most = by, where = k;
    }
    return where;
  }
  /// The point without which the jump before k is within what friction and noise do.
  std::optional<std::size_t> made_by(std::size_t first, std::size_t k, std::size_t last) {
    for (std::size_t row = k - std::min(window_, k - first); row < std::min(k + window_, last); ++row) {
      if (left_[row]) continue;
      left_[row] = true;
      const double without = excess(first, k, last);
      left_[row] = false;
      if (without <= 0) return row;
    }
    return std::nullopt;
  }

  struct Sides {
    Parabola before, after;
  };
  Sides sides(std::size_t first, std::size_t k, std::size_t last) const {
    const double between = 0.5 * (track_.time[k - 1] + track_.time[k]);
    return {{track_, k - std::min(window_, k - first), k, between, left_},
            {track_, k, k + std::min(window_, last - k), between, left_}};
  }
  std::size_t used(std::size_t first, std::size_t last) const {
    std::size_t count = 0;
    for (std::size_t row = first; row < last; ++row) count += !left_[row];
    return count;
  }
  /// By how much the velocity jumps before point k beyond what friction and noise do.
  double excess(std::size_t first, std::size_t k, std::size_t last) const {
    const std::size_t fewest = kFewest - 1;  // a parabola's
    if (used(k - std::min(window_, k - first), k) < fewest || used(k, std::min(k + window_, last)) < fewest)
      return -1;
    const auto [before, after] = sides(first, k, last);
    const double jump = (after.velocity() - before.velocity()).norm();
    const double sd = usual_.noise * std::sqrt(before.slope_variance + after.slope_variance);
    const double time =
        track_.time[std::min(k + window_, last) - 1] - track_.time[k - std::min(window_, k - first)];
    return jump - 0.5 * usual_.deceleration * time - sigmas_ * sd;
  }
  /// Around k, where both parabolas together fit best.
  std::size_t sharpest(std::size_t first, std::size_t k, std::size_t last) const {
    const std::size_t low = std::max(first + kFewest, k - std::min(k, window_ / 2)),
                      high = std::min(last - kFewest, k + window_ / 2);
    std::size_t best = k;
    double least = -1;
    for (std::size_t i = low; i <= high; ++i) {
      const auto [before, after] = sides(first, i, last);
      const double squares = before.squares + after.squares;
      if (least < 0 || squares < least) least = squares, best = i;
    }
    return best;
  }
  FoundBlow described(std::size_t first, std::size_t k, std::size_t last) const {
    const auto [before, after] = sides(first, k, last);
    return {k, before.velocity(), after.velocity()};
  }

  const TrackTable& track_;
  Usual usual_;
  Left left_;
  double step_ = 0, sigmas_ = 0;
  std::size_t window_ = kFewest;
};

/// For how long the part slides in [first, last), s.
double sliding_time(const TrackTable& track, Stretch stretch, double slow) {
  double time = 0;
  for (std::size_t i = stretch.first; i + kFewest <= stretch.last; ++i) {
    const Parabola fit(track, i, i + kFewest, middle_time(track, i, i + kFewest));
    if (fit.velocity().norm() > slow) time += track.time[i + 1] - track.time[i];
  }
  return time;
}

}  // namespace

std::vector<FoundBlow> find_blows(const TrackTable& track) {
  std::vector<FoundBlow> found;
  if (track.time.size() < 2 * kFirstWindow) return found;
  BlowSearch(track).search(0, track.time.size(), found);
  return found;
}

Stretch longest_clean_stretch(const TrackTable& track, const std::vector<FoundBlow>& blows) {
  const Stretch whole{0, track.time.size()};
  if (blows.empty()) return whole;
  const double slow = kSlow * usual_of(track).top_speed;
  Stretch best;
  double longest = -1;
  for (std::size_t i = 0; i <= blows.size(); ++i) {
    Stretch stretch = whole;
    if (i > 0) stretch.first = std::min(blows[i - 1].row + 1, whole.last);
    if (i < blows.size()) stretch.last = blows[i].row - 1;
    if (stretch.last < stretch.first + kFirstWindow) continue;
    if (const double time = sliding_time(track, stretch, slow); time > longest)
      longest = time, best = stretch;
  }
  return longest < 0 ? whole : best;
}

namespace {

constexpr std::size_t kFewestAngles = 8;
/// Known beforehand of the bearing: all of the face, sd of its logarithm a factor of two. Where the part
/// spins enough to matter the angles know it to some per cent, and a prior half or twice as wide changes
/// nothing.
constexpr double kWholeFace = 0, kSpread = 0.7;
constexpr int kRounds = 30;

/// The angles seen, without jumps by whole turns.
struct Angles {
  std::vector<double> time, angle, sigma;  ///< time from the first point of the slide
};

Angles angles_of(const TrackTable& track, std::size_t first) {
  Angles seen;
  for (std::size_t i = first; i < track.time.size() && i < track.angle.size(); ++i) {
    if (!std::isfinite(track.angle[i]) || !(track.angle_sigma[i] > 0)) continue;
    const double time = track.time[i] - track.time[first];
    const double angle =
        seen.angle.empty()
            ? track.angle[i]
            : seen.angle.back() + std::remainder(track.angle[i] - seen.angle.back(), 2 * std::numbers::pi);
    seen.time.push_back(time);
    seen.angle.push_back(angle);
    seen.sigma.push_back(track.angle_sigma[i]);
  }
  return seen;
}

/// Straight line through the first angles: where the search begins.
double first_rate(const Angles& seen) {
  const std::size_t n = std::max(kFewestAngles / 2, seen.time.size() / 4);
  return line_through<double>(std::span(seen.time).first(n), std::span(seen.angle).first(n)).slope;
}

struct Linearised {
  Eigen::VectorXd residuals;  ///< over their sds, the prior of the bearing last
  Eigen::MatrixX3d jacobian;  ///< by theta_0, omega, bearing
};

Linearised residuals_at(const Angles& seen, model::Scenario scenario, const Eigen::Vector3d& at) {
  const double share = std::exp(at(2));
  const double inertia = 0.5 / (share * share);
  scenario.spin = {at(1), scenario.spin.radius * share, inertia};
  const model::Trajectory run = model::integrate(
      scenario, {.tolerance = 1e-10, .derivatives = {model::Parameter::spin, model::Parameter::inertia}});
  const auto n = static_cast<Eigen::Index>(seen.time.size());
  Linearised result{Eigen::VectorXd(n + 1), Eigen::MatrixX3d(n + 1, 3)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const model::SensitiveSample there = run.sensitive_at(seen.time[k]);
    const double angle = there.sample.angle, by_rate = there.angle_jacobian(0);
    result.residuals(i) = (at(0) + angle - seen.angle[k]) / seen.sigma[k];
    // theta = way of the bearing rim/radius: by ln radius through omega R, through k and directly.
    result.jacobian.row(i) << 1, by_rate, at(1) * by_rate - angle - 2 * inertia * there.angle_jacobian(1);
    result.jacobian.row(i) /= seen.sigma[k];
  }
  result.residuals(n) = (at(2) - kWholeFace) / kSpread;
  result.jacobian.row(n) << 0, 0, 1 / kSpread;
  return result;
}

}  // namespace

std::optional<DiscSpin> slide_spin(const TrajectoryRun& run, double mu, const Eigen::Vector2d& velocity) {
  if (run.track.angle.empty() || !(run.track.radius > 0)) return std::nullopt;
  const Angles seen = angles_of(run.track, guess_free_slide(run).first);
  if (seen.time.size() < kFewestAngles) return std::nullopt;

  model::Scenario scenario;
  scenario.drive.amplitude = scenario.drive.amplitude_y = 0;
  scenario.drive.gravity = run.scenario.drive.gravity;
  scenario.friction = {mu, 0, 0, 0, 0};
  scenario.initial_velocity = velocity;
  scenario.spin.radius = run.track.radius;
  scenario.duration = seen.time.back();

  Eigen::Vector3d at(seen.angle.front(), first_rate(seen), kWholeFace);
  Linearised here = residuals_at(seen, scenario, at);
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::Vector3d step = least_squares(here.jacobian, -here.residuals);
    double share = 1;
    const auto moved = [&] {
      const Eigen::Vector3d to = at + share * step;
      return Eigen::Vector3d(to(0), to(1), DiscSpin::within(to(2), run.track.round));
    };
    Linearised there = residuals_at(seen, scenario, moved());
    while (!(there.residuals.squaredNorm() <= here.residuals.squaredNorm()) && share > 1e-4) {
      share /= 2;
      there = residuals_at(seen, scenario, moved());
    }
    const double gained = here.residuals.squaredNorm() - there.residuals.squaredNorm();
    if (!(gained >= 0)) break;
    at = moved();
    here = std::move(there);
    if (gained < 1e-6 * (1 + here.residuals.squaredNorm())) break;
  }
  const Eigen::Matrix3d covariance = (here.jacobian.transpose() * here.jacobian).inverse();
  const double dof = static_cast<double>(seen.time.size()) - 2;
  const double excess = std::max(1.0, here.residuals.squaredNorm() / dof);
  return DiscSpin{at(1), at(2), excess * covariance.bottomRightCorner<2, 2>()};
}

std::optional<DiscSpin> first_slide_spin(const TrajectoryRun& run) {
  const FreeSlideGuess guess = guess_free_slide(run);
  return slide_spin(run, guess.mu, guess.velocity);
}

}  // namespace tribotrack::fit::internal
