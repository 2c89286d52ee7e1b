#include "fit/slides/blows.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "fit/tools/statistics.h"

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

}  // namespace tribotrack::fit::internal
