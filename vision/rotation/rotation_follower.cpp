#include "vision/rotation/rotation.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "vision/io/levels.h"
#include "vision/kernels/bspline.h"
#include "vision/kernels/plane.h"

namespace tribotrack::vision {
namespace {

using std::numbers::pi;

/// Px: a disc is reduced to between this and twice this radius. Its rotation is then known far better than
/// its position whatever it shows, so that nothing is gained by more pixels.
constexpr double kRadius = 32;
constexpr double kInnermost = 2;                       ///< px: rings within hold hardly a harmonic
constexpr double kRimBlurs = 2.5, kLeastMargin = 1.5;  ///< of the rim: blurs, px
constexpr double kLongest = 40;   ///< px: longer waves are reflections and shading as much as texture
constexpr double kShortest = pi;  ///< px: just longer than two pixels, which is all that a picture resolves
constexpr int kBorder = 8;        ///< px for the spline

}  // namespace

RingHarmonics::RingHarmonics(double radius, double blur)
    : reduction_(std::max(1, static_cast<int>(radius / kRadius))), radius_(radius) {
  const double outermost = (radius - std::max(kLeastMargin, kRimBlurs * blur)) / reduction_;
  const int count = static_cast<int>(std::floor(outermost - kInnermost)) + 1;
  if (count < 2) return;
  rings_ = Eigen::ArrayXd::LinSpaced(count, kInnermost, kInnermost + count - 1);
  for (angles_ = 16; angles_ < 2 * 2 * pi * outermost / kShortest;) angles_ *= 2;
  weights_ = Eigen::ArrayXXf::Zero(angles_ / 2, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    for (Eigen::Index m = 2; m < weights_.rows(); ++m) {
      const double wave = 2 * pi * rings_(k) / static_cast<double>(m);
      if (wave >= kShortest && wave <= kLongest) weights_(m, k) = static_cast<float>(rings_(k));
    }
    for (int j = 0; j < angles_; ++j) {
      offset_x_.push_back(static_cast<float>(rings_(k) * std::cos(2 * pi * j / angles_)));
      offset_y_.push_back(static_cast<float>(-rings_(k) * std::sin(2 * pi * j / angles_)));
    }
  }
}

double RingHarmonics::reach() const {
  return radius_ + kBorder * reduction_;
}

Harmonics RingHarmonics::of(const Picture& window, const Point& centre) {
  double x = centre.x, y = centre.y;
  const Picture* picture = &window;
  if (reduction_ > 1) {
    const int width = window.width() / reduction_, height = window.height() / reduction_;
    if (reduced_.width() != width || reduced_.height() != height) reduced_ = Picture(width, height);
    const cv::Mat from = matrix_of(window)({0, 0, width * reduction_, height * reduction_});
    cv::resize(from, matrix_of(reduced_), {width, height}, 0, 0, cv::INTER_AREA);
    picture = &reduced_;
    x = (x + 0.5) / reduction_ - 0.5;
    y = (y + 0.5) / reduction_ - 0.5;
  }
  const QuinticSpline spline(*picture);
  const std::size_t count = offset_x_.size();
  for (auto* v : {&x_, &y_, &levels_}) v->resize(count);
  const auto centre_x = static_cast<float>(x), centre_y = static_cast<float>(y);
  for (std::size_t k = 0; k < count; ++k) {
    x_[k] = centre_x + offset_x_[k];
    y_[k] = centre_y + offset_y_[k];
  }
  spline.sample_places(x_, y_, levels_.data(), nullptr, nullptr);
  const auto rings = static_cast<int>(rings_.size());
  cv::Mat spectrum;
  cv::dft(cv::Mat(rings, angles_, CV_32F, levels_.data()), spectrum, cv::DFT_ROWS | cv::DFT_COMPLEX_OUTPUT);
  Harmonics out(angles_ / 2, rings);
  for (int k = 0; k < rings; ++k)
    for (int m = 0; m < angles_ / 2; ++m)
      out(m, k) = spectrum.at<std::complex<float>>(k, m) / static_cast<float>(angles_);
  return out;
}

double rotation_limit(const Picture& frame, const Circle& part, double blur, double noise_variance) {
  constexpr double kNone = 1e9, kStandsOut = 5;  // sd of what noise alone would make
  RingHarmonics rings(part.radius, blur);
  if (!rings.usable()) return kNone;
  const Rect place = window_about({part.x, part.y}, rings.reach(), bounds_of(frame));
  const Harmonics seen = rings.of(part_of(frame, place), {part.x - place.x, part.y - place.y});
  const double noise = noise_variance / rings.averaged();
  // High orders are mostly noise, and tell most of an angle: whether there is a texture all tell alike.
  double information = 0, power = 0, count = 0;
  for (Eigen::Index m = 0; m < seen.rows(); ++m)
    for (Eigen::Index k = 0; k < seen.cols(); ++k) {
      const auto pixels = static_cast<double>(rings.weights()(m, k));
      if (!(pixels > 0)) continue;
      const double beyond = 2 * pi * pixels * static_cast<double>(std::norm(seen(m, k))) - noise;
      information += 2 * static_cast<double>(m * m) * beyond;
      power += beyond;
      ++count;
    }
  const bool seen_at_all = power > kStandsOut * noise * std::sqrt(count) && information > 0;
  return seen_at_all ? std::sqrt(noise / information) : kNone;
}

namespace {

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

RingSums ring_sums(const Eigen::ArrayXXf& weights, const Harmonics& mean, const Harmonics& seen) {
  return {(weights * mean.conjugate() * seen).rowwise().sum().cast<std::complex<double>>(),
          (weights * mean.abs2()).rowwise().sum().cast<double>(),
          (weights * seen.abs2()).rowwise().sum().cast<double>()};
}

}  // namespace

RotationFollower::RotationFollower(const Harmonics& first, const Eigen::ArrayXXf& weights, std::int64_t frame)
    : weights_(weights),
      orders_(Eigen::ArrayXd::LinSpaced(first.rows(), 0, static_cast<double>(first.rows() - 1))),
      mean_(first),
      frame_(frame) {
  const auto count = static_cast<double>((weights_ > 0).count());
  chance_ = std::max(kSeen, kChance / std::sqrt(2 * std::max(1.0, count)));
}

double RotationFollower::information() const {
  return (ring_sums(weights_, mean_, mean_).of_mean * orders_.square()).sum();
}

std::optional<Turn> RotationFollower::step(const Harmonics& seen, std::int64_t frame) {
  const RingSums sums = ring_sums(weights_, mean_, seen);
  const double expected = predicted(frame);
  double theta = climb(sums.correlation, expected);
  if (correlation_at(sums, theta) < kConfirms * usual_)
    theta = climb(sums.correlation, best_angle(sums.correlation, expected));
  const double agreement = correlation_at(sums, theta);
  if (agreement < chance_) return std::nullopt;
  usual_ += 0.2 * (agreement - usual_);
  theta += 2 * pi * std::round((expected - theta) / (2 * pi));
  const Turn turn = judged(sums, theta);
  learn(seen, theta, frame);
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
  // Re sum_m C_m exp(i m (near + 2 pi k / count)) for all k.
  Eigen::ArrayXcd padded = Eigen::ArrayXcd::Zero(count), turned(count);
  padded.head(correlation.size()) = correlation * phases(correlation.size(), near);
  cv::Mat to(1, count, CV_64FC2, turned.data());
  cv::dft(cv::Mat(1, count, CV_64FC2, padded.data()), to, cv::DFT_INVERSE);
  const Eigen::ArrayXd merit = turned.real();
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

double RotationFollower::correlation_at(const RingSums& sums, double theta) const {
  const double product = (sums.correlation * phases(orders_.size(), theta)).real().sum();
  const double squares = sums.of_mean.sum() * sums.of_seen.sum();
  return squares > 0 ? product / std::sqrt(squares) : 0;
}

/// Rings of one harmonic err together, harmonics each for itself.
Turn RotationFollower::judged(const RingSums& sums, double theta) const {
  const Eigen::ArrayXcd back = sums.correlation * phases(orders_.size(), theta);
  const double gain = back.real().sum() / sums.of_mean.sum();
  const Eigen::ArrayXd pulls = orders_ * gain * back.imag();
  const auto used = static_cast<double>((weights_.rowwise().sum() > 0).count());
  return {theta, gain * gain * (sums.of_mean * orders_.square()).sum(),
          pulls.square().sum() * used / std::max(1.0, used - 1)};
}

void RotationFollower::learn(const Harmonics& seen, double theta, std::int64_t frame) {
  const double turned = theta - theta_;
  share_ = std::max(1 / (1 / share_ + 1), 1 - std::exp(-std::abs(turned) / kMemory));
  const Eigen::ArrayXcf back = phases(orders_.size(), theta).cast<std::complex<float>>();
  mean_ += static_cast<float>(share_) * (seen.colwise() * back - mean_);
  rate_ += kNewest * (turned / static_cast<double>(frame - frame_) - rate_);
  theta_ = theta;
  frame_ = frame;
}

}  // namespace tribotrack::vision
