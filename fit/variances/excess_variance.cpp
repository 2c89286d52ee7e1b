#include "fit/variances/excess_variance.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "fit/tools/statistics.h"
#include "fit/tools/thresholds.h"

namespace tribotrack::fit::internal {
namespace {

constexpr int kFewestRepetitions =
    6;  ///< degrees of freedom: fewer determine their own scatter to a third at best

double chi2_with(const std::vector<Eigen::Vector2d>& residuals,
                 const std::vector<Eigen::Matrix2d>& covariances, double added) {
  double sum = 0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const Eigen::Matrix2d total = covariances[i] + added * added * Eigen::Matrix2d::Identity();
    sum += residuals[i].dot(total.inverse() * residuals[i]);
  }
  return sum;
}

/// s with chi^2(s) = expected; 0 where chi^2(0) is no surprise.
double scatter_for(const std::vector<Eigen::Vector2d>& residuals,
                   const std::vector<Eigen::Matrix2d>& covariances, double expected, bool already,
                   double level = kSurprise) {
  if (!(expected > 0)) return 0;
  const double now = chi2_with(residuals, covariances, 0);
  if (already ? now <= expected : chi2_survival(now, expected) >= level) return 0;
  double high = 0;
  for (const auto& r : residuals) high = std::max(high, r.norm());
  double low = 0;
  while (chi2_with(residuals, covariances, high) > expected) high *= 2;
  for (int i = 0; i < 80; ++i) {
    const double middle = 0.5 * (low + high);
    (chi2_with(residuals, covariances, middle) > expected ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Turned so that x is along the run's displacement.
Eigen::Matrix2d turn_of(const SummaryRun& run) {
  const double length = run.measured.vector.norm();
  if (!(length > 0)) return Eigen::Matrix2d::Identity();
  const Eigen::Vector2d u = run.measured.vector / length;
  Eigen::Matrix2d turn;
  turn << u.x(), u.y(), -u.y(), u.x();
  return turn;
}

void between_runs(const Problem& problem, const std::vector<Eigen::Vector2d>& differences,
                  const std::vector<Eigen::Matrix2d>& covariances, double expected, ExcessVariance& result) {
  const double both = scatter_for(differences, covariances, expected, result.runs() > 0, kDoubt);
  result.along = result.across = both;
  if (!(both > 0)) return;
  std::vector<Eigen::Vector2d> parts[2];
  std::vector<Eigen::Matrix2d> variances[2];
  double whole[2], trimmed[2];
  for (int axis = 0; axis < 2; ++axis) {
    for (std::size_t i = 0; i < differences.size(); ++i) {
      const Eigen::Matrix2d turn = turn_of(problem.summary_runs[i]);
      const double variance = (turn * covariances[i] * turn.transpose())(axis, axis);
      parts[axis].emplace_back((turn * differences[i])(axis), 0);
      variances[axis].push_back(variance * Eigen::Matrix2d::Identity());
    }
    // One bad run is no scatter: the largest term may not make the difference.
    double largest = 0;
    for (std::size_t i = 0; i < parts[axis].size(); ++i)
      largest = std::max(largest, chi2_with({parts[axis][i]}, {variances[axis][i]}, both));
    whole[axis] = chi2_with(parts[axis], variances[axis], both);
    trimmed[axis] = whole[axis] - largest;
  }
  // ln of the ratio of two mean squares of nu degrees of freedom each: sd 2/sqrt(nu); 1 % on both sides.
  const double nu = 0.5 * expected;
  const double ratio = std::max(trimmed[0] / whole[1], trimmed[1] / whole[0]);
  if (nu < 4 || !(std::log(ratio) > 2.576 * 2 / std::sqrt(nu))) return;
  result.along = scatter_for(parts[0], variances[0], nu, true);
  result.across = scatter_for(parts[1], variances[1], nu, true);
}

bool repeats(const SummaryRun& a, const SummaryRun& b) {
  const auto near = [](double x, double y) { return std::abs(x - y) <= 1e-6 * std::max(1.0, std::abs(y)); };
  const auto &s = a.scenario, &t = b.scenario;
  return near(s.friction.phase, t.friction.phase) && near(s.friction.pulse_width, t.friction.pulse_width) &&
         near(1e3 * s.drive.amplitude, 1e3 * t.drive.amplitude) &&
         near(1e3 * s.drive.amplitude_y, 1e3 * t.drive.amplitude_y) &&
         near(s.drive.angular_frequency, t.drive.angular_frequency) &&
         near(s.drive.phase_shift, t.drive.phase_shift) && near(s.start_phase, t.start_phase) &&
         s.start == t.start && near(a.measured.duration, b.measured.duration);
}

}  // namespace

Replicates replicates(const Problem& problem) {
  const auto& runs = problem.summary_runs;
  std::vector<bool> counted(runs.size(), false);
  std::vector<Eigen::Vector2d> deviations;
  std::vector<Eigen::Matrix2d> covariances;
  Replicates result;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (counted[i]) continue;
    std::vector<std::size_t> group;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (std::size_t k = i; k < runs.size(); ++k)
      if (!counted[k] && repeats(runs[i], runs[k])) {
        counted[k] = true;
        group.push_back(k);
        mean += runs[k].measured.vector;
      }
    if (group.size() < 2) continue;
    const double n = static_cast<double>(group.size());
    mean /= n;
    result.dof += 2 * static_cast<int>(group.size() - 1);
    for (const std::size_t k : group) {  // stretched by sqrt(n/(n-1)), as if the mean had been known
      deviations.push_back(std::sqrt(n / (n - 1)) * (runs[k].measured.vector - mean));
      covariances.push_back(runs[k].measured.covariance);
    }
  }
  if (result.dof < kFewestRepetitions) return result;
  // Stretched deviations number more than their freedom: chi^2 of them is theirs times that ratio.
  const double stretched = 2 * static_cast<double>(deviations.size()), dof = result.dof;
  const double chi2 = chi2_with(deviations, covariances, 0) * dof / stretched;
  if (chi2_survival(chi2, dof) < kSurprise)
    result.scatter = scatter_for(deviations, covariances, stretched, true);
  return result;
}

ExcessVariance estimate_excess_variance(const Residuals& residuals, const Eigen::VectorXd& values,
                                        const Linearised& at) {
  const auto& problem = residuals.unknowns().problem();
  ExcessVariance result = residuals.excess_variance();
  const double data = 2.0 * static_cast<double>(problem.summary_runs.size());
  double points = 0;
  for (std::size_t i = 0; i < problem.trajectory_runs.size(); ++i)
    points +=
        2.0 * static_cast<double>(residuals.track(i).points()) / result.trajectories[i].correlation_time;

  std::vector<Eigen::Vector2d> differences;
  std::vector<Eigen::Matrix2d> covariances;
  for (std::size_t i = 0; i < problem.summary_runs.size(); ++i) {
    differences.push_back(residuals.difference(at, i));
    covariances.push_back(problem.summary_runs[i].measured.covariance);
  }
  // The unknowns take their share of the freedom from runs and points in proportion.
  const double unknowns = static_cast<double>(residuals.unknowns().size());
  const double share = std::max(0.0, 1 - unknowns / (data + points));
  between_runs(problem, differences, covariances, data * share, result);

  const Eigen::VectorXd common = residuals.common_error(values);
  for (std::size_t i = 0; i < problem.trajectory_runs.size(); ++i) {
    const PointResiduals run = residuals.points(values, i, common);
    auto& scatter = result.trajectories[i];
    covariances.clear();
    std::vector<double> x, y;
    std::vector<Eigen::Vector2d> quick;  // without what is known to be slow
    for (std::size_t k = 0; k < run.row.size(); ++k) {
      covariances.push_back(run.innovation_covariance[k]);
      quick.push_back(run.innovation[k]);
      x.push_back(quick.back().x());
      y.push_back(quick.back().y());
    }
    // A fitted column takes as much of correlated noise as of that many independent points.
    const double along = problem.trajectory_runs[i].free_slide ? 3 : 1,
                 across = problem.trajectory_runs[i].free_slide ? 2 : 1;
    const double rows = 2.0 * static_cast<double>(run.row.size()) - run.rows_taken;
    const double expected = std::max(0.4 * rows, rows - (along + across) * scatter.correlation_time);
    scatter.between_points = scatter_for(quick, covariances, expected, scatter.between_points > 0);
    scatter.correlation_time = 1;
    if (scatter.between_points > 0) {
      double x_square = 0, y_square = 0;
      for (std::size_t k = 0; k < x.size(); ++k) {
        x_square += x[k] * x[k];
        y_square += y[k] * y[k];
      }
      const double both =
          (x_square * residual_correlation_time(x, along) + y_square * residual_correlation_time(y, along)) /
          (x_square + y_square);
      scatter.correlation_time = std::min(static_cast<double>(run.row.size()) / 4, both);
    }
  }
  return result;
}

}  // namespace tribotrack::fit::internal
