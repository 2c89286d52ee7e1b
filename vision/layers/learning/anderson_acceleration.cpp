#include "vision/layers/learning/anderson_acceleration.h"

#include <Eigen/QR>

namespace tribotrack::vision {
namespace {
constexpr double kGrown = 1.5;
}

Eigen::VectorXd AndersonAcceleration::next(const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  const Eigen::VectorXd residual = to - from;
  if (last_residual_.size() == residual.size()) {
    if (residual.norm() > kGrown * last_residual_.norm()) {
      images_.clear();
      residuals_.clear();
    } else {
      images_.push_back(to - last_to_);
      residuals_.push_back(residual - last_residual_);
    }
    if (images_.size() > depth_) {
      images_.erase(images_.begin());
      residuals_.erase(residuals_.begin());
    }
  }
  last_to_ = to;
  last_residual_ = residual;
  if (images_.empty()) return to;
  const auto depth = static_cast<Eigen::Index>(images_.size());
  Eigen::MatrixXd differences(residual.size(), depth);
  for (Eigen::Index k = 0; k < depth; ++k) differences.col(k) = residuals_[static_cast<std::size_t>(k)];
  const Eigen::VectorXd share = differences.colPivHouseholderQr().solve(residual);
  Eigen::VectorXd out = to;
  if (share.allFinite())
    for (Eigen::Index k = 0; k < depth; ++k) out -= share(k) * images_[static_cast<std::size_t>(k)];
  return out;
}

}  // namespace tribotrack::vision
