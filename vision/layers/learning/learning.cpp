#include "vision/layers/learning/learning.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vision/discs/disc_detection.h"
#include "vision/layers/learning/anderson_acceleration.h"
#include "vision/layers/learning/through_rim.h"

namespace tribotrack::vision {
namespace {

constexpr int kMostSweeps = 30;           ///< over the early windows
constexpr double kKnotUnit = 0.1;         ///< px per whole of the rim's profile
constexpr double kLevelUnit = 1e-4;       ///< px per grey level of the disc's picture
constexpr double kSettled = 0.1;          ///< of the standard deviation: windows that move less have settled
constexpr std::size_t kFewest = 12;       ///< windows that must be explained
constexpr double kBlendEvidence = 1e3;    ///< per px^4: kappa stays at its start where little texture is seen
constexpr double kShiftEvidence = 2.5e3;  ///< per px^2: likewise the rim
constexpr double kMostBlend = 9;          ///< px^2
constexpr double kOdd = 0.25;  ///< of the median: windows whose rim leaves more hold something else
constexpr double kOddSd = 6;   ///< likewise, in standard deviations

NoiseLaw noise_law(const LayeredRegistration::LevelSums& s) {
  NoiseLaw law;
  const double mean = s.level / s.n;
  const double spread = s.level_level / s.n - mean * mean;
  const double square = s.square / s.n;
  if (spread > 1) law.per_level = std::max(0.0, (s.level_square / s.n - mean * square) / spread);
  law.constant = square - law.per_level * mean;
  if (law.constant < 1.0 / 12) {
    law.constant = 1.0 / 12;
    law.per_level = mean > 0 ? std::max(0.0, (square - law.constant) / mean) : 0;
  }
  return law;
}

/// What a sweep starts from: the windows' centres, px; then the rim and the disc's picture, in units in which
/// they hardly count for the acceleration but follow it.
Eigen::VectorXd packed(std::span<const KeptWindow> windows, const LayeredDisc& disc) {
  const LayeredDisc::Standing standing = disc.standing();
  const auto levels = standing.picture.levels();
  Eigen::VectorXd out(static_cast<Eigen::Index>(2 * windows.size() + standing.knots.size() + levels.size()));
  Eigen::Index k = 0;
  for (const KeptWindow& w : windows) {
    out(k++) = w.state.centre.x;
    out(k++) = w.state.centre.y;
  }
  for (const double knot : standing.knots) out(k++) = kKnotUnit * knot;
  for (const float level : levels) out(k++) = kLevelUnit * static_cast<double>(level);
  return out;
}

void unpack(const Eigen::VectorXd& from, std::span<KeptWindow> windows, LayeredDisc& disc) {
  LayeredDisc::Standing standing = disc.standing();
  Eigen::Index k = 0;
  for (KeptWindow& w : windows) {
    w.state.centre.x = from(k++);
    w.state.centre.y = from(k++);
  }
  for (double& knot : standing.knots) knot = from(k++) / kKnotUnit;
  for (float& level : standing.picture.levels()) level = static_cast<float>(from(k++) / kLevelUnit);
  disc.set_standing(standing);
}

/// How far the windows moved, px rms per coordinate, a move of all together not counted.
double moved(const Eigen::VectorXd& from, const Eigen::VectorXd& to, std::size_t windows) {
  const auto n = static_cast<Eigen::Index>(windows);
  const Eigen::Map<const Eigen::Matrix2Xd> a(from.data(), 2, n), b(to.data(), 2, n);
  const Eigen::Matrix2Xd d = b - a;
  return std::sqrt((d.colwise() - d.rowwise().mean()).squaredNorm() / static_cast<double>(2 * n));
}

}  // namespace

LayeredLearning::LayeredLearning(LayeredDisc& disc, GroundPicture& ground, LayeredRegistration& registration,
                                 double radius, const NoiseLaw& noise, double least_noise)
    : disc_(disc),
      ground_(ground),
      registration_(registration),
      radius_(radius),
      noise_(noise),
      start_noise_(noise.at(ground.mean())),
      least_noise_(least_noise) {}

/// The disc's picture turns about the middle of its grid: its rim's centre is brought there first.
void LayeredLearning::learn(std::span<KeptWindow> windows, bool last) {
  for (KeptWindow& w : windows) {
    w.state.centre.x += offset_.x;
    w.state.centre.y += offset_.y;
  }
  offset_ = {};
  if (sweeps_ > 0) look_through_rim(windows, disc_, noise_.at(ground_.mean()), ground_);
  // The even middle once, and at the end where it tells of light in the picture; then what tells about the
  // place.
  const bool middle_too = sweeps_ == 0 || (last && registration_.has_illumination());
  if (middle_too) first_windows_ = static_cast<int>(windows.size());
  disc_.learn(windows, ground_, start_noise_, middle_too ? nullptr : &registration_.chosen());
  ++sweeps_;
  registration_.set_noise(noise_);
  registration_.disc_changed(first_windows_);
  if (!last && !disc_.turning()) return;
  const auto middle = static_cast<double>(disc_.half());
  if (const auto fit = fit_disc(disc_.on_plain(ground_.mean()), {middle, middle, radius_}, 2.0)) {
    offset_ = {fit->circle.x - middle, fit->circle.y - middle};
    disc_radius_ = fit->circle.radius;
    disc_radius_sd_ = fit->radius_sd;
  }
}

/// False where most windows are not explained.
bool LayeredLearning::measure(std::span<KeptWindow> windows, std::vector<GroundLean>* leans) {
  LayeredRegistration::LevelSums levels;
  LayeredRegistration::RimSums rim_sums;
  double explained = 0, rim = 0, variance = 0;
  std::vector<MeasuredSlope> slopes;
  std::vector<double> rim_chi_squared(windows.size(), std::numeric_limits<double>::infinity());
  for (std::size_t k = 0; k < windows.size(); ++k) {
    KeptWindow& w = windows[k];
    if (const auto fix = registration_.refine(w.picture, w.x, w.y, w.state)) {
      w.state = fix->state;
      ++explained;
      rim_chi_squared[k] = fix->rim_chi_squared;
      rim += fix->rim_chi_squared;
      variance += 0.5 * fix->covariance.trace();
      slopes.push_back(
          {fix->state.centre, fix->state.slope_x, fix->state.slope_y, fix->sigma_slope * fix->sigma_slope});
      registration_.add_residuals(levels);
      registration_.add_rim(rim_sums);
      if (leans) {
        leans->push_back(registration_.lean(*fix));
        leans->back().frame = w.frame;
      }
    }
  }
  if (explained < static_cast<double>(std::max(kFewest, windows.size() / 2))) return false;
  rim_chi_squared_ = rim / explained;
  leave_out_odd(windows, rim_chi_squared);
  sigma_ = std::sqrt(variance / explained);
  light_ = IlluminationSlope(slopes);
  noise_ = noise_law(levels);
  noise_.constant = std::max(noise_.constant, least_noise_ - noise_.per_level * ground_.mean());
  disc_.set_blend(std::clamp(disc_.blend() + rim_sums.qr / (rim_sums.qq + kBlendEvidence), 0.0, kMostBlend));
  shift_ = (rim_sums.shift_normal + Eigen::Matrix2d(kShiftEvidence * Eigen::Matrix2d::Identity()))
               .ldlt()
               .solve(rim_sums.shift_force);
  registration_.set_noise(noise_);
  return true;
}

/// What crosses the disc in some windows, a tool or the edge of a lamp, must not become part of the layers.
void LayeredLearning::leave_out_odd(std::span<KeptWindow> windows,
                                    const std::vector<double>& rim_chi_squared) const {
  std::vector<double> sorted = rim_chi_squared;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double most = *middle * (1 + std::max(kOdd, kOddSd * std::sqrt(2 / registration_.rim_pixels())));
  for (std::size_t k = 0; k < windows.size(); ++k) windows[k].explained = rim_chi_squared[k] <= most;
}

/// The rim is round about the centre of the grid, the disc's picture wherever the first pass took its centre
/// to be: only a textured ground tells, and alternation would move the one to the other very slowly.
void LayeredLearning::centre_rim(std::span<KeptWindow> windows) {
  for (KeptWindow& w : windows) {
    w.state.centre.x += shift_.x();
    w.state.centre.y += shift_.y();
  }
  disc_.shift_standing({shift_.x(), shift_.y()});
}

bool LayeredLearning::run(std::span<KeptWindow> early, std::span<KeptWindow> all) {
  AndersonAcceleration acceleration;
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    const Eigen::VectorXd before = packed(early, disc_);
    learn(early, false);
    if (!measure(early)) return false;
    centre_rim(early);
    const Eigen::VectorXd after = packed(early, disc_);
    if (sweep == 0) continue;  // the disc has had no picture before
    // A slow mode moves little in a sweep, and far when followed to its end.
    const Eigen::VectorXd next = acceleration.next(before, after);
    const double limit = kSettled * sigma_;
    if (sweep > 1 && moved(before, after, early.size()) < limit && moved(after, next, early.size()) < limit)
      break;
    unpack(next, early, disc_);
  }
  // The early ones have just been measured.
  if (!measure(all.size() < 2 * early.size() ? all : all.subspan(early.size()))) return false;
  learn(all, true);
  std::vector<GroundLean> leans;
  if (!measure(all, &leans)) return false;
  std::ranges::sort(leans, {}, &GroundLean::frame);
  slow_error_ = vision::slow_error(leans, ground_);
  return true;
}

}  // namespace tribotrack::vision
