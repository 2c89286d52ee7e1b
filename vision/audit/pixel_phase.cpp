#include "vision/audit/pixel_phase.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/kernels/dense.h"

namespace tribotrack::vision {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Eigen::Index kColumns = 4;
/// Power of a column over that of the noise in the positions it is made from: the noise then explains a
/// tenth.
constexpr double kMoving = 10;

/// Columns over the frames of a stretch.
std::vector<std::vector<double>> columns_of(const Stretch& s, const LocalPolynomial& fit) {
  std::vector<std::vector<double>> out(kColumns, std::vector<double>(s.size()));
  const std::vector<double> x = fit.smoothed(s.x), y = fit.smoothed(s.y);
  for (std::size_t k = 0; k < s.size(); ++k) {
    const double px = 2 * std::numbers::pi * x[k], py = 2 * std::numbers::pi * y[k];
    out[0][k] = std::cos(px);
    out[1][k] = std::sin(px);
    out[2][k] = std::cos(py);
    out[3][k] = std::sin(py);
  }
  return out;
}

/// The regression of one coordinate, every row over its standard deviation.
struct Regression {
  MatrixXd filtered;  ///< columns as the polynomial leaves them
  MatrixXd whole;     ///< columns as they are
  MatrixXd spread;    ///< transposed filter of `filtered`: what noise of every frame does to the sums
  VectorXd residual;
  double noise_power = 0;  ///< that the positions' noise gives a column
};

Regression regression_of(const std::vector<Stretch>& stretches, const Axis& axis,
                         const LocalPolynomial& fit) {
  std::vector<std::vector<double>> filtered(kColumns), whole(kColumns), spread(kColumns);
  std::vector<double> residual;
  double noise_power = 0;
  for (const Stretch& s : stretches) {
    if (s.size() <= 2 * fit.half()) continue;
    const auto columns = columns_of(s, fit);
    const std::vector<double>& sd = s.*axis.sigma;
    const std::vector<double> left = fit.residual(s.*axis.position);
    for (std::size_t k = 0; k < left.size(); ++k) residual.push_back(left[k] / sd[k + fit.half()]);
    for (std::size_t c = 0; c < columns.size(); ++c) {
      std::vector<double> part = fit.residual(columns[c]), weighted = part;
      for (std::size_t k = 0; k < part.size(); ++k) {
        part[k] /= sd[k + fit.half()];
        weighted[k] /= sd[k + fit.half()] * sd[k + fit.half()];
      }
      filtered[c].insert(filtered[c].end(), part.begin(), part.end());
      const std::vector<double> back = fit.transposed(weighted, s.size());
      for (std::size_t k = 0; k < s.size(); ++k) {
        whole[c].push_back(columns[c][k] / sd[k]);
        spread[c].push_back(back[k] * sd[k]);
      }
    }
    // d cos(2 pi x) = 2 pi dx, over the standard deviation, at each residual.
    noise_power +=
        4 * std::numbers::pi * std::numbers::pi * fit.smoothed_variance() * static_cast<double>(left.size());
  }
  const auto matrix = [](const std::vector<std::vector<double>>& columns) {
    MatrixXd out(static_cast<Eigen::Index>(columns[0].size()), kColumns);
    for (Eigen::Index c = 0; c < kColumns; ++c)
      out.col(c) = Eigen::Map<const VectorXd>(columns[static_cast<std::size_t>(c)].data(), out.rows());
    return out;
  };
  return {matrix(filtered), matrix(whole), matrix(spread),
          Eigen::Map<const VectorXd>(residual.data(), static_cast<Eigen::Index>(residual.size())),
          noise_power};
}

void leave_out_outliers(Regression& r) {
  const std::vector<double> numbers(r.residual.begin(), r.residual.end());
  const double limit = outlier_size(numbers);
  for (Eigen::Index k = 0; k < r.residual.size(); ++k)
    if (std::abs(r.residual(k)) > limit) r.residual(k) = 0;
}

/// Mean square of the fitted errors beyond that of noise, and its scatter without any.
std::optional<MeanSquare> excess(Regression r, double noise) {
  if (r.residual.size() < 10 * kColumns) return std::nullopt;
  leave_out_outliers(r);
  const SymmetricEigen seen = eigen_symmetric(r.filtered.transpose() * r.filtered);
  const Eigen::Index kept = (seen.values.array() > kMoving * r.noise_power).count();
  if (kept == 0) return std::nullopt;
  const MatrixXd axes = seen.vectors.rightCols(kept);
  const MatrixXd inverse = axes * seen.values.tail(kept).cwiseInverse().asDiagonal() * axes.transpose();
  const VectorXd amplitudes = inverse * (r.filtered.transpose() * r.residual);
  const MatrixXd centred = r.whole.rowwise() - r.whole.colwise().mean();
  const MatrixXd power = centred.transpose() * centred / static_cast<double>(centred.rows());
  const MatrixXd of_noise = noise * power * inverse * (r.spread.transpose() * r.spread) * inverse;
  return MeanSquare{amplitudes.dot(power * amplitudes) - of_noise.trace(),
                    std::sqrt(2 * (of_noise * of_noise).trace())};
}

}  // namespace

std::optional<MeanSquare> pixel_phase(const std::vector<Stretch>& stretches, const Axis& axis,
                                      const LocalPolynomial& fit, double noise) {
  const auto found = excess(regression_of(stretches, axis, fit), noise);
  if (!found) return std::nullopt;
  return MeanSquare{1 + std::max(0.0, found->value), found->scatter};
}

}  // namespace tribotrack::vision
