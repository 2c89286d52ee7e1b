// What data can tell at best: Fisher's information by central differences at the truth.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <functional>
#include <vector>

#include "model/scenario.h"

namespace tribotrack::bench {

/// An unknown of simulated runs.
struct Unknown {
  std::function<void(model::Scenario&, double by)> move;
  double step = 0;      ///< of the difference
  double prior_sd = 0;  ///< 0: nothing known beforehand
};

/// What is observed of one run, whitened: unit variance, independent.
using Observed = std::function<Eigen::VectorXd(std::size_t run, const model::Scenario&)>;

/// Cramer-Rao standard deviations of the first `reported` unknowns.
inline std::vector<double> cramer_rao(const std::vector<model::Scenario>& runs,
                                      const std::vector<Unknown>& unknowns, std::size_t reported,
                                      const Observed& observed) {
  const auto count = static_cast<Eigen::Index>(unknowns.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double sd = unknowns[static_cast<std::size_t>(i)].prior_sd;
    if (sd > 0) information(i, i) = 1 / (sd * sd);
  }
  for (std::size_t run = 0; run < runs.size(); ++run) {
    Eigen::MatrixXd slopes;
    for (Eigen::Index i = 0; i < count; ++i) {
      const Unknown& unknown = unknowns[static_cast<std::size_t>(i)];
      model::Scenario up = runs[run], down = runs[run];
      unknown.move(up, unknown.step);
      unknown.move(down, -unknown.step);
      const Eigen::VectorXd slope = (observed(run, up) - observed(run, down)) / (2 * unknown.step);
      slopes.conservativeResize(slope.size(), count);
      slopes.col(i) = slope;
    }
    information += slopes.transpose() * slopes;
  }
  // In units that make the diagonal 1: what nothing is known of comes out as a large number, not as NaN.
  const Eigen::VectorXd unit = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = unit.asDiagonal() * information * unit.asDiagonal();
  const Eigen::MatrixXd covariance = (scaled + 1e-14 * Eigen::MatrixXd::Identity(count, count))
                                         .ldlt()
                                         .solve(Eigen::MatrixXd::Identity(count, count));
  std::vector<double> sd;
  for (std::size_t i = 0; i < reported; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    sd.push_back(unit(k) * std::sqrt(covariance(k, k)));
  }
  return sd;
}

}  // namespace tribotrack::bench
