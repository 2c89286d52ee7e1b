#include "vision/rotation/rotation_follower.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tribotrack::vision {
namespace {

using std::numbers::pi;

/// Rad turned after which the mean has forgotten all but 1/e. From 0.1 to 0.2 the rendered metals give the
/// same angles; much more and the metal has changed its look, much less and noise adds up.
constexpr double kMemory = 0.15;
constexpr double kConfirms = 0.95;  ///< of the usual correlation
constexpr double kAsGood = 0.9;     ///< of the best: the nearest such peak counts, for parts with a symmetry
constexpr double kSeen = 0.3;       ///< correlation, at least
constexpr double kChance = 4;       ///< sd of the correlation of noise
constexpr double kNewest = 0.3;     ///< weight of the newest step in the rate of turning
constexpr int kSteps = 6;

/// exp(i m theta).
Eigen::ArrayXcd phases(Eigen::Index count, double theta) {
  Eigen::ArrayXcd out(count);
  const std::complex<double> turn = std::polar(1.0, theta);
  std::complex<double> power = 1;
  for (Eigen::Index m = 0; m < count; ++m, power *= turn) out(m) = power;
  return out;
}

Harmonics turned_back(const Harmonics& seen, double theta) {
  return seen.rowwise() * phases(seen.cols(), theta).transpose();
}

}  // namespace

RotationFollower::RotationFollower(const Harmonics& first, const Eigen::ArrayXXd& weights, std::int64_t frame)
    : weights_(weights),
      orders_(Eigen::ArrayXd::LinSpaced(first.cols(), 0, static_cast<double>(first.cols() - 1))),
      mean_(first),
      frame_(frame) {
  const auto count = static_cast<double>((weights_ > 0).count());
  chance_ = std::max(kSeen, kChance / std::sqrt(2 * std::max(1.0, count)));
}

double RotationFollower::information() const {
  return (weights_ * mean_.abs2())
      .matrix()
      .colwise()
      .sum()
      .transpose()
      .array()
      .matrix()
      .dot(orders_.square().matrix());
}

double RotationFollower::predicted(std::int64_t frame) const {
  return theta_ + rate_ * static_cast<double>(frame - frame_);
}

std::optional<Turn> RotationFollower::step(const Harmonics& seen, std::int64_t frame) {
  const Eigen::ArrayXcd correlation = (weights_ * (mean_.conjugate() * seen)).colwise().sum().transpose();
  const double expected = predicted(frame);
  double theta = climb(correlation, expected);
  if (correlation_at(seen, theta) < kConfirms * usual_)
    theta = climb(correlation, best_angle(correlation, expected));
  const double agreement = correlation_at(seen, theta);
  if (agreement < chance_) return std::nullopt;
  usual_ += 0.2 * (agreement - usual_);
  theta += 2 * pi * std::round((expected - theta) / (2 * pi));
  const Harmonics back = turned_back(seen, theta);
  const Turn turn = judged(back, theta);
  learn(back, theta, frame);
  return turn;
}

/// Newton's steps to the nearest maximum of the correlation.
double RotationFollower::climb(const Eigen::ArrayXcd& correlation, double theta) const {
  for (int k = 0; k < kSteps; ++k) {
    const Eigen::ArrayXcd here = correlation * phases(correlation.size(), theta);
    const double slope = -(orders_ * here.imag()).sum();
    const double curvature = -(orders_.square() * here.real()).sum();
    if (!(curvature < 0)) break;
    const double step = std::clamp(-slope / curvature, -0.1, 0.1);
    theta += step;
    if (std::abs(step) < 1e-7) break;
  }
  return theta;
}

/// Of all angles the nearest one that is nearly as good as the best.
double RotationFollower::best_angle(const Eigen::ArrayXcd& correlation, double near) const {
  const int count = 4 * static_cast<int>(correlation.size());
  Eigen::ArrayXd merit(count);
  for (int k = 0; k < count; ++k) {
    merit(k) = (correlation * phases(correlation.size(), near + 2 * pi * k / count)).real().sum();
  }
  const double top = merit.maxCoeff();
  double best = near, distance = 10;
  for (int k = 0; k < count; ++k) {
    const double left = merit((k + count - 1) % count), right = merit((k + 1) % count);
    if (merit(k) < left || merit(k) < right || merit(k) < kAsGood * top) continue;
    const double away = k <= count / 2 ? 2 * pi * k / count : 2 * pi * k / count - 2 * pi;
    if (std::abs(away) < distance) {
      distance = std::abs(away);
      best = near + away;
    }
  }
  return best;
}

double RotationFollower::correlation_at(const Harmonics& seen, double theta) const {
  const Harmonics back = turned_back(seen, theta);
  const double product = (weights_ * (mean_.conjugate() * back).real()).sum();
  const double squares = (weights_ * mean_.abs2()).sum() * (weights_ * back.abs2()).sum();
  return squares > 0 ? product / std::sqrt(squares) : 0;
}

/// Rings of one harmonic err together, harmonics each for itself.
Turn RotationFollower::judged(const Harmonics& back, double theta) const {
  const double gain = (weights_ * (mean_.conjugate() * back).real()).sum() / (weights_ * mean_.abs2()).sum();
  const Eigen::ArrayXd pulls =
      orders_ * (gain * weights_ * (mean_.conjugate() * back).imag()).colwise().sum().transpose();
  const auto used = static_cast<double>((weights_.colwise().sum() > 0).count());
  return {theta, gain * gain * information(), pulls.square().sum() * used / std::max(1.0, used - 1)};
}

void RotationFollower::learn(const Harmonics& back, double theta, std::int64_t frame) {
  const double turned = theta - theta_;
  share_ = std::max(1 / (1 / share_ + 1), 1 - std::exp(-std::abs(turned) / kMemory));
  mean_ += share_ * (back - mean_);
  rate_ += kNewest * (turned / static_cast<double>(frame - frame_) - rate_);
  theta_ = theta;
  frame_ = frame;
}

}  // namespace tribotrack::vision
