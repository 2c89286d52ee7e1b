#include "vision/coding/response.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace tribotrack::vision {
namespace {

using Columns = Eigen::MatrixXd;
using Values = Eigen::VectorXd;

/// Constant and straight line.
Columns line(Eigen::Index n) {
  Columns out(n, 2);
  for (Eigen::Index k = 0; k < n; ++k)
    out.row(k) << 1, 2.0 * static_cast<double>(k) / static_cast<double>(n) - 1;
  return out;
}

Values without_line(const Values& values) {
  const Columns basis = line(values.size());
  return values - basis * basis.householderQr().solve(values);
}

Values velocity_of(const Values& path, double interval) {
  const Eigen::Index n = path.size();
  Values out(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index before = std::max<Eigen::Index>(0, k - 1), after = std::min(n - 1, k + 1);
    out(k) = (path(after) - path(before)) / (interval * static_cast<double>(after - before));
  }
  return out;
}

/// What correlated noise adds to the variance of a mean: 1 + 2 sum of the correlations up to the first that
/// is not positive.
double correlation_factor(const Values& noise, Eigen::Index half) {
  const auto products = [&](Eigen::Index lag) {
    double sum = 0;
    for (const Eigen::Index start : {Eigen::Index{0}, half})
      for (Eigen::Index k = start; k + lag < start + half; ++k) sum += noise(k) * noise(k + lag);
    return sum;
  };
  const double all = products(0);
  double factor = 1;
  for (Eigen::Index lag = 1; lag < half / 2 && all > 0; ++lag) {
    const double share = products(lag) / all;
    if (share <= 0) break;
    factor += 2 * share;
  }
  return factor;
}

}  // namespace

CodedResponse coded_response(const std::vector<Point>& seen, const std::vector<Point>& true_path,
                             double interval) {
  const auto n = static_cast<Eigen::Index>(seen.size());
  Columns model(2 * n, 2);
  Values error(2 * n);
  for (const bool along_y : {false, true}) {
    Values path(n), off(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const Point &p = true_path[static_cast<std::size_t>(k)], &s = seen[static_cast<std::size_t>(k)];
      path(k) = along_y ? p.y : p.x;
      off(k) = (along_y ? s.y : s.x) - path(k);
    }
    const Eigen::Index at = along_y ? n : 0;
    model.col(0).segment(at, n) = -without_line(path);
    model.col(1).segment(at, n) = -without_line(velocity_of(path, interval));
    error.segment(at, n) = without_line(off);
  }
  const Values found = model.colPivHouseholderQr().solve(error);
  const Values noise = error - model * found;
  const Eigen::Matrix2d normal = model.transpose() * model;
  const double variance = noise.squaredNorm() / static_cast<double>(2 * n - 6) * correlation_factor(noise, n);
  const auto sd = [&](Eigen::Index i) {
    const double own = normal(i, i) - normal(0, 1) * normal(0, 1) / std::max(normal(1 - i, 1 - i), 1e-300);
    return own > 0 ? std::sqrt(variance / own) : 0;
  };
  return {.attenuation = found(0), .attenuation_sd = sd(0), .delay = found(1), .delay_sd = sd(1)};
}

}  // namespace tribotrack::vision
