#include "vision/rotation/rotation_follower.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "vision/kernels/vector_kernels.h"

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

/// Sums over one ring, added to five numbers for each harmonic: Re and Im of w conj(T) P, w |T|^2, w |P|^2.
TRIBOTRACK_CLONES void add_ring(const float* w, const float* t_re, const float* t_im, const float* p_re,
                                const float* p_im, std::ptrdiff_t count, std::ptrdiff_t orders, float* sums) {
  float *re = sums, *im = sums + orders, *mean = sums + 2 * orders, *seen = sums + 3 * orders;
  for (std::ptrdiff_t m = 0; m < count; ++m) {
    re[m] += w[m] * (t_re[m] * p_re[m] + t_im[m] * p_im[m]);
    im[m] += w[m] * (t_re[m] * p_im[m] - t_im[m] * p_re[m]);
    mean[m] += w[m] * (t_re[m] * t_re[m] + t_im[m] * t_im[m]);
    seen[m] += w[m] * (p_re[m] * p_re[m] + p_im[m] * p_im[m]);
  }
}

/// Of the harmonics that count.
RingSums ring_sums(const Eigen::ArrayXXf& weights, const std::vector<RotationFollower::Span>& spans,
                   const Harmonics& mean, const Harmonics& seen) {
  const Eigen::Index orders = weights.rows();
  Eigen::ArrayXXf sums = Eigen::ArrayXXf::Zero(orders, 4);
  for (const auto& [k, m, count] : spans)
    add_ring(&weights(m, k), &mean.re(m, k), &mean.im(m, k), &seen.re(m, k), &seen.im(m, k), count, orders,
             &sums(m, 0));
  RingSums out{Eigen::ArrayXcd(orders), sums.col(2).cast<double>(), sums.col(3).cast<double>()};
  out.correlation.real() = sums.col(0).cast<double>();
  out.correlation.imag() = sums.col(1).cast<double>();
  return out;
}

/// t += share (p c - t) with the phases c, of one ring.
TRIBOTRACK_CLONES void learn_ring(const float* p_re, const float* p_im, const float* c_re, const float* c_im,
                                  float share, std::ptrdiff_t orders, float* t_re, float* t_im) {
  for (std::ptrdiff_t m = 0; m < orders; ++m) {
    t_re[m] += share * (p_re[m] * c_re[m] - p_im[m] * c_im[m] - t_re[m]);
    t_im[m] += share * (p_re[m] * c_im[m] + p_im[m] * c_re[m] - t_im[m]);
  }
}

}  // namespace

RotationFollower::RotationFollower(const Harmonics& first, const Eigen::ArrayXXf& weights, std::int64_t frame)
    : weights_(weights),
      orders_(Eigen::ArrayXd::LinSpaced(first.orders(), 0, static_cast<double>(first.orders() - 1))),
      mean_(first),
      frame_(frame) {
  for (Eigen::Index k = 0; k < weights_.cols(); ++k) {
    Eigen::Index begin = 0, end = weights_.rows();
    while (begin < end && !(weights_(begin, k) > 0)) ++begin;
    while (end > begin && !(weights_(end - 1, k) > 0)) --end;
    if (end > begin) spans_.push_back({k, begin, end - begin});
  }
  const auto count = static_cast<double>((weights_ > 0).count());
  chance_ = std::max(kSeen, kChance / std::sqrt(2 * std::max(1.0, count)));
}

double RotationFollower::information() const {
  return (ring_sums(weights_, spans_, mean_, mean_).of_mean * orders_.square()).sum();
}

double RotationFollower::predicted(std::int64_t frame) const {
  return theta_ + rate_ * static_cast<double>(frame - frame_);
}

std::optional<Turn> RotationFollower::step(const Harmonics& seen, std::int64_t frame) {
  const RingSums sums = ring_sums(weights_, spans_, mean_, seen);
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
  const Eigen::ArrayXf re = back.real(), im = back.imag();
  for (const auto& [k, m, count] : spans_)
    learn_ring(&seen.re(m, k), &seen.im(m, k), &re(m), &im(m), static_cast<float>(share_), count,
               &mean_.re(m, k), &mean_.im(m, k));
  rate_ += kNewest * (turned / static_cast<double>(frame - frame_) - rate_);
  theta_ = theta;
  frame_ = frame;
}

}  // namespace tribotrack::vision
