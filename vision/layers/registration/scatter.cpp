#include "vision/layers/registration/scatter.h"

#include <algorithm>

namespace tribotrack::vision {
namespace {

using Pulls = std::vector<ClusterPulls>;

/// Sum over the clusters of the mean over frame k of x_k . x_(k + lag), half of it: of a coordinate.
double correlation(const Pulls& frames, std::size_t lag) {
  double sum = 0;
  for (std::size_t k = 0; k + lag < frames.size(); ++k)
    for (std::size_t c = 0; c < frames[k].size(); ++c)
      sum += 0.5 * static_cast<double>(frames[k][c].dot(frames[k + lag][c]));
  return sum / static_cast<double>(frames.size() - lag);
}

Pulls about_their_mean(Pulls frames) {
  const std::size_t clusters = frames.front().size();
  for (std::size_t c = 0; c < clusters; ++c) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const ClusterPulls& f : frames) sum += f[c].cast<double>();
    const Eigen::Vector2f mean = (sum / static_cast<double>(frames.size())).cast<float>();
    for (ClusterPulls& f : frames) f[c] -= mean;
  }
  return frames;
}

}  // namespace

RunScatter run_scatter(const Pulls& frames, const Eigen::Array2d& taken) {
  RunScatter out;
  const auto n = static_cast<double>(frames.size());
  if (frames.size() < 4) return out;
  const Pulls about = about_their_mean(frames);
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (const ClusterPulls& f : about)
    for (const Eigen::Vector2f& pull : f) {
      const Eigen::Vector2d x = pull.cast<double>();
      sum += x * x.transpose();
    }
  const Eigen::Vector2d left = (1 - taken).rsqrt();
  out.covariance = left.asDiagonal() * sum * left.asDiagonal() / (n - 1);
  // Half the square of a difference; the mean has taken nothing of it.
  const double all = correlation(about, 0), next = correlation(about, 1);
  out.white = std::min((all - next) / (1 - taken.mean()), 0.5 * out.covariance.trace());
  out.slow = 0.5 * out.covariance.trace() - out.white;
  if (!(next > 0)) return out;
  double integral = 0.5;
  for (std::size_t lag = 1; lag < frames.size() / 2; ++lag) {
    const double share = correlation(about, lag) / next;
    if (share <= 0) break;
    integral += share;
  }
  out.slow_frames = integral;
  return out;
}

}  // namespace tribotrack::vision
