// TemplateRegistration, robustness: pixels that do not belong to the template (glare, a hand) are trimmed,
// and what the template does not explain enters the covariance.
#include <algorithm>
#include <cmath>

#include "vision/kernels/median.h"
#include "vision/kernels/outlier_pixels.h"
#include "vision/registration/registration.h"

namespace tribotrack::vision {
namespace {

constexpr double kOutlierEdge = 3;         ///< px about a covering object that are half covered
constexpr double kMaxTrim = 0.4;           ///< a larger share of outliers: it is not the template
constexpr double kUsual = 4 * kNormalMad;  ///< median sizes of the residual

}  // namespace

/// Sets the weight of pixels to zero whose residual cannot be noise. Returns how many.
std::size_t TemplateRegistration::trim(const ForceSums& sums, double gain, double offset, double noise_sd) {
  const double least = std::max(6 * noise_sd, 0.5 * std::abs(gain) * contrast_);
  if (sums.largest <= least) return 0;
  residual_.resize(mask_.size());
  // The usual residual matters where it is no small one: else it need not be known.
  const ResidualCounts counts =
      tile_kernels().residuals(arrays_, base_weight_, static_cast<float>(gain), static_cast<float>(offset),
                               static_cast<float>(least / kUsual), residual_);
  double limit = least;
  if (counts.small <= counts.counted / 2) {
    std::vector<float> sizes;
    for (std::size_t i = 0; i < mask_.size(); ++i)
      if (base_weight_[i] > 0) sizes.push_back(residual_[i]);
    limit = std::max(least, kUsual * static_cast<double>(median(sizes)));
  }
  outliers_.resize(mask_.size());
  tile_kernels().mark(residual_, static_cast<float>(limit), outliers_);
  // A texture that has turned does not match anywhere until its angle is found.
  if (!options_.rotation) spread_outliers(places_, kOutlierEdge, outliers_);
  std::size_t count = 0;
  for (std::size_t i = 0; i < mask_.size(); i += kTile) {
    if (!any_in_row(outliers_.data() + i)) continue;
    for (std::size_t k = i; k < i + kTile; ++k) {
      if (outliers_[k] == 0 || !(base_weight_[k] > 0)) continue;
      arrays_.weight[k] = 0;
      ++count;
    }
  }
  trimmed_ = true;
  if (static_cast<double>(count) > kMaxTrim * static_cast<double>(counts.counted)) {
    arrays_.weight = base_weight_;
    return 0;
  }
  return count;
}

/// Sandwich covariance of (dx, dy, theta) with the tiles as clusters.
Eigen::Matrix3d TemplateRegistration::sandwich(const Matrix& inverse, double gain, double offset) {
  scores_.resize(places_.size());
  tile_kernels().scores(arrays_, static_cast<float>(gain), static_cast<float>(offset), scores_);
  Eigen::Matrix<double, 5, 5> meat = Eigen::Matrix<double, 5, 5>::Zero();
  for (const std::array<double, 5>& of_tile : scores_) {
    const Eigen::Map<const Eigen::Matrix<double, 5, 1>> score(of_tile.data());
    meat += score * score.transpose();
  }
  const Matrix covariance = inverse * meat.topLeftCorner(columns(), columns()) * inverse / (gain * gain);
  Eigen::Matrix3d out = Eigen::Matrix3d::Zero();
  out.topLeftCorner<2, 2>() = covariance.topLeftCorner<2, 2>();
  if (options_.rotation) out(2, 2) = covariance(4, 4);
  return out;
}

}  // namespace tribotrack::vision
