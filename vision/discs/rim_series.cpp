#include "vision/discs/rim_series.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "vision/kernels/median.h"

namespace tribotrack::vision {
namespace {

constexpr std::size_t kFewestFrames = 4;  ///< from which a pattern can be told from noise
constexpr std::size_t kNearby = 8;        ///< frames on either side
constexpr double kHuber = 2.5;            ///< usual residuals
constexpr int kReweightings = 4;

using Deviations = std::vector<std::vector<double>>;  ///< [frame][sector], px

/// p_k; zero where too few frames show the sector.
std::vector<double> usual_deviations(const std::vector<RimSectors>& frames) {
  std::vector<double> pattern(frames.front().deviation.size(), 0);
  for (std::size_t k = 0; k < pattern.size(); ++k) {
    std::vector<double> seen;
    for (const RimSectors& f : frames)
      if (f.information[k] > 0) seen.push_back(static_cast<double>(f.deviation[k]));
    if (seen.size() >= kFewestFrames) pattern[k] = median(seen);
  }
  return pattern;
}

Eigen::Vector3d direction(std::size_t sector, std::size_t count) {
  const Point u = sector_direction(static_cast<int>(sector), static_cast<int>(count));
  return {u.x, u.y, 1};
}

/// The circle through a frame's edges: its step from where they are measured, and what it leaves.
struct CircleFit {
  Eigen::Vector3d step = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();
  std::vector<double> weight, residual;
};

CircleFit fit_circle(const RimSectors& frame, const std::vector<double>& pattern, double usual) {
  const std::size_t count = pattern.size();
  CircleFit fit;
  fit.weight.resize(count);
  fit.residual.resize(count);
  for (int round = 0; round <= kReweightings; ++round) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < count; ++k) {
      const Eigen::Vector3d u = direction(k, count);
      const double off = std::abs(fit.residual[k]);
      fit.weight[k] =
          static_cast<double>(frame.information[k]) * (off > kHuber * usual ? kHuber * usual / off : 1);
      normal += fit.weight[k] * u * u.transpose();
      right += fit.weight[k] * (static_cast<double>(frame.deviation[k]) - pattern[k]) * u;
    }
    fit.inverse = normal.inverse();
    fit.step = fit.inverse * right;
    for (std::size_t k = 0; k < count; ++k)
      fit.residual[k] = static_cast<double>(frame.deviation[k]) - pattern[k] - direction(k, count).dot(fit.step);
  }
  return fit;
}

/// sum w v, the variance at which a frame's residuals are usual.
double expected_squares(const CircleFit& fit, const std::vector<double>& variance) {
  double sum = 0;
  for (std::size_t k = 0; k < variance.size(); ++k) sum += fit.weight[k] * variance[k];
  return sum;
}

double usual_size(const std::vector<RimSectors>& frames, const std::vector<double>& pattern) {
  std::vector<double> sizes;
  for (const RimSectors& f : frames)
    for (std::size_t k = 0; k < pattern.size(); ++k)
      if (f.information[k] > 0) sizes.push_back(std::abs(static_cast<double>(f.deviation[k]) - pattern[k]));
  return std::max(1e-6, kNormalMad * median(sizes));
}

/// v_tk; corrected for the three numbers that each frame's circle took and for the pattern.
std::vector<double> nearby_variance(const std::vector<CircleFit>& fits, std::size_t frame) {
  const std::size_t first = frame > kNearby ? frame - kNearby : 0;
  const std::size_t last = std::min(fits.size() - 1, frame + kNearby);
  const auto sectors = static_cast<double>(fits.front().residual.size());
  const auto all = static_cast<double>(fits.size());
  const double taken = sectors / (sectors - 3) * (fits.size() >= kFewestFrames ? all / (all - 1) : 1);
  std::vector<double> variance(fits.front().residual.size(), 0);
  for (std::size_t k = 0; k < variance.size(); ++k) {
    double squares = 0, count = 0;
    for (std::size_t t = first; t <= last; ++t) {
      if (!(fits[t].weight[k] > 0)) continue;
      squares += fits[t].residual[k] * fits[t].residual[k];
      ++count;
    }
    if (count > 0) variance[k] = taken * squares / count;
  }
  return variance;
}

/// A frame that is worse than its neighbours by more than chance says so.
double own_excess(const CircleFit& fit, const std::vector<double>& variance) {
  const double sectors = static_cast<double>(variance.size());
  double squares = 0;
  for (std::size_t k = 0; k < variance.size(); ++k)
    squares += fit.weight[k] * fit.residual[k] * fit.residual[k];
  const double ratio = squares * sectors / (sectors - 3) / std::max(1e-300, expected_squares(fit, variance));
  return ratio > 1 + 3 * std::sqrt(2 / (sectors - 3)) ? ratio : 1;
}

}  // namespace

std::vector<RimFix> fix_centres(const std::vector<RimSectors>& frames) {
  if (frames.empty()) return {};
  const std::vector<double> pattern = usual_deviations(frames);
  const double usual = usual_size(frames, pattern);
  std::vector<CircleFit> fits;
  for (const RimSectors& f : frames) fits.push_back(fit_circle(f, pattern, usual));
  std::vector<RimFix> fixes;
  for (std::size_t t = 0; t < frames.size(); ++t) {
    const CircleFit& fit = fits[t];
    const std::vector<double> variance = nearby_variance(fits, t);
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (std::size_t k = 0; k < variance.size(); ++k) {
      const Eigen::Vector3d u = direction(k, variance.size());
      scatter += fit.weight[k] * fit.weight[k] * variance[k] * u * u.transpose();
    }
    const Eigen::Matrix3d covariance = own_excess(fit, variance) * fit.inverse * scatter * fit.inverse;
    const Circle& c = frames[t].circle;
    fixes.push_back({{c.x + fit.step(0), c.y + fit.step(1)}, covariance.topLeftCorner<2, 2>()});
  }
  return fixes;
}

}  // namespace tribotrack::vision
