#include "fit/variances/excess_variance.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "fit/tools/dense.h"
#include "fit/tools/statistics.h"
#include "fit/tools/thresholds.h"

namespace tribotrack::fit::internal {
namespace {

constexpr int kFewestRepetitions =
    6;  ///< degrees of freedom: fewer determine their own scatter to a third at best

constexpr double kMedianSquare = 2 * std::numbers::ln2;  ///< of chi^2 with two degrees of freedom

/// Differences from the model, and what is known of their errors.
struct Deviations {
  std::vector<Eigen::Vector2d> differences;
  std::vector<Eigen::Matrix2d> covariances;

  void add(const Eigen::Vector2d& difference, const Eigen::Matrix2d& covariance) {
    differences.push_back(difference);
    covariances.push_back(covariance);
  }
  /// Squared distances with so much scatter per axis added.
  std::vector<double> squares(double scatter) const {
    std::vector<double> result;
    for (std::size_t i = 0; i < differences.size(); ++i) {
      const Eigen::Matrix2d total = covariances[i] + scatter * scatter * Eigen::Matrix2d::Identity();
      result.push_back(differences[i].dot(Factor2(total).solved(differences[i])));
    }
    return result;
  }
  double chi2(double scatter) const {
    const std::vector<double> terms = squares(scatter);
    return std::accumulate(terms.begin(), terms.end(), 0.0);
  }
  double longest() const {
    double length = 0;
    for (const auto& difference : differences) length = std::max(length, difference.norm());
    return length;
  }
  /// s with chi^2(s) = expected; 0 where chi^2(0) is no surprise, once `found` where it is not above.
  double scatter(double expected, bool found, double level = kSurprise) const {
    if (!(expected > 0) || (!found && chi2_survival(chi2(0), expected) >= level)) return 0;
    return falls_to([&](double s) { return chi2(s); }, expected, longest());
  }
  /// s at which the squares have the median of good data; 0 where they nearly do without.
  double scatter_by_median(double expected) const {
    const auto median = [&](double s) { return upper_median(squares(s)); };
    return median(0) <= 2 * expected ? 0 : falls_to(median, expected, longest());
  }
};

/// Of a trajectory run's points without what is known to be slow, and how long it lasts.
PointScatter between_points(const PointResiduals& points, bool free_slide, const PointScatter& before) {
  Deviations quick;
  std::vector<double> x, y;
  double x_square = 0, y_square = 0;
  for (std::size_t k = 0; k < points.row.size(); ++k) {
    const Eigen::Vector2d& innovation = points.innovation[k];
    quick.add(innovation, points.innovation_covariance[k]);
    x.push_back(innovation.x());
    y.push_back(innovation.y());
    x_square += innovation.x() * innovation.x();
    y_square += innovation.y() * innovation.y();
  }
  // A fitted column takes as much of correlated noise as of that many independent points.
  const double along = free_slide ? 3 : 1, across = free_slide ? 2 : 1;
  const double count = static_cast<double>(points.row.size()), rows = 2 * count - points.rows_taken;
  const double expected = std::max(0.4 * rows, rows - (along + across) * before.correlation_time);
  PointScatter scatter{quick.scatter(expected, before.between_points > 0), 1};
  if (scatter.between_points > 0)
    scatter.correlation_time = std::min(count / 4, (x_square * residual_correlation_time(x, along) +
                                                    y_square * residual_correlation_time(y, along)) /
                                                       (x_square + y_square));
  return scatter;
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
  Deviations deviations;
  Replicates result;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (counted[i] || runs[i].held_out) continue;
    std::vector<std::size_t> group;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (std::size_t k = i; k < runs.size(); ++k)
      if (!counted[k] && !runs[k].held_out && repeats(runs[i], runs[k])) {
        counted[k] = true;
        group.push_back(k);
        mean += runs[k].measured.vector;
      }
    if (group.size() < 2) continue;
    const double n = static_cast<double>(group.size());
    mean /= n;
    result.dof += 2 * static_cast<int>(group.size() - 1);
    for (const std::size_t k : group)  // stretched by sqrt(n/(n-1)), as if the mean had been known
      deviations.add(std::sqrt(n / (n - 1)) * (runs[k].measured.vector - mean), runs[k].measured.covariance);
  }
  if (result.dof < kFewestRepetitions) return result;
  // Stretched deviations number more than their freedom: chi^2 of them is theirs times that ratio.
  const double stretched = 2 * static_cast<double>(deviations.differences.size()), dof = result.dof;
  const double chi2 = deviations.chi2(0) * dof / stretched;
  if (chi2_survival(chi2, dof) < kSurprise) result.scatter = deviations.scatter(stretched, true);
  return result;
}

ExcessVariance estimate_excess_variance(const Residuals& residuals, const Eigen::VectorXd& values,
                                        const Linearised& at, Loss loss) {
  const Problem& problem = residuals.unknowns().problem();
  const bool robust = loss != Loss::squares;
  ExcessVariance result = residuals.excess_variance();
  Deviations runs;
  for (std::size_t i = 0; i < problem.summary_runs.size(); ++i)
    if (const SummaryRun& run = problem.summary_runs[i]; !run.held_out)
      runs.add(residuals.difference(at, i), run.measured.covariance);
  // The unknowns take their share of the freedom from runs and points in proportion.
  const double data = 2.0 * static_cast<double>(runs.differences.size()),
               unknowns = static_cast<double>(residuals.unknowns().size());
  double points = 0;
  for (std::size_t i = 0; i < problem.trajectory_runs.size(); ++i)
    points +=
        2.0 * static_cast<double>(residuals.track(i).points()) / result.trajectories[i].correlation_time;
  if (!robust)
    result.runs = runs.scatter(data * std::max(0.0, 1 - unknowns / (data + points)), result.runs > 0, kDoubt);
  else if (runs.differences.size() >= 3)
    result.runs = runs.scatter_by_median(kMedianSquare * std::max(0.2, 1 - unknowns / data));

  for (std::size_t i = 0; i < problem.trajectory_runs.size(); ++i)
    result.trajectories[i] = between_points(residuals.points(values, i),
                                            problem.trajectory_runs[i].free_slide, result.trajectories[i]);
  return result;
}

namespace {

constexpr int kReweightings = 12;

double largest_change(const Residuals& now, const Residuals& before) {
  double change = 0;
  for (std::size_t i = 0; i < now.weights().size(); ++i)
    change = std::max(change, std::abs(now.weight(i) - before.weight(i)));
  return change;
}

bool unchanged(const ExcessVariance& was, const ExcessVariance& is) {
  bool same = std::abs(is.runs - was.runs) <= 1e-3 * was.runs;
  for (std::size_t i = 0; i < is.trajectories.size(); ++i)
    same = same && std::abs(is.trajectories[i].between_points - was.trajectories[i].between_points) <=
                       1e-2 * was.trajectories[i].between_points;
  for (std::size_t part = 0; part < kErrorParts; ++part)
    same = same && std::abs(is.correlated[part] - was.correlated[part]) <=
                       3e-2 * was.correlated[part];  // known to 20 %
  return same;
}

}  // namespace

bool any(const ExcessVariance& scatter) {
  return scatter.runs > 0 || std::any_of(scatter.trajectories.begin(), scatter.trajectories.end(),
                                         [](const auto& run) { return run.between_points > 0; });
}

CorrelatedEstimate reweighted_fit(Residuals& residuals, Minimum& best, const Reweighting& reweighting) {
  const Unknowns& unknowns = residuals.unknowns();
  const bool squares = reweighting.loss == Loss::squares;
  CorrelatedEstimate correlated;
  for (int round = 0; round < kReweightings; ++round) {
    const Residuals before = residuals;
    best = linearised(residuals, std::move(best));
    const Eigen::VectorXd values = unknowns.values(best.z);
    if (reweighting.correlated_errors) {
      correlated = estimate_correlated_errors(residuals, values);
      ExcessVariance scatter = residuals.excess_variance();
      scatter.correlated = correlated.variances;
      residuals.set_excess_variance(scatter);
    }
    if (reweighting.scatter)
      residuals.set_excess_variance(estimate_excess_variance(residuals, values, best.at, reweighting.loss));
    if (!squares) residuals.set_weights(robust_weights(residuals, best.at));
    const ExcessVariance &was = before.excess_variance(), &is = residuals.excess_variance();
    if (squares && !any(is) && is.correlated == CorrelatedVariances{} && was.correlated == is.correlated)
      return correlated;
    const double change = largest_change(residuals, before);
    best =
        reweighting.correlated_errors ? minimise_linearised(residuals, best.z) : minimise(residuals, best.z);
    if (round > (reweighting.scatter ? 1 : 0) && change < 1e-3 && unchanged(was, is)) return correlated;
  }
  return correlated;
}

namespace {

constexpr double kHuber = 2;

double distance(const Residuals& residuals, const Linearised& at, std::size_t run) {
  return at.groups.front().residuals.segment<2>(2 * static_cast<Eigen::Index>(run)).norm() /
         std::sqrt(residuals.weight(run));
}

}  // namespace

double robust_weight(double s) {
  return s <= kHuber ? 1 : kHuber / s;
}

std::vector<double> robust_weights(const Residuals& residuals, const Linearised& at) {
  std::vector<double> weights;
  for (std::size_t i = 0; i < residuals.unknowns().problem().summary_runs.size(); ++i)
    weights.push_back(robust_weight(distance(residuals, at, i)));
  return weights;
}

double robust_covariance_factor(const Residuals& residuals, const Linearised& at) {
  const auto runs = residuals.unknowns().problem().summary_runs.size();
  const double n = 2 * static_cast<double>(runs), p = static_cast<double>(residuals.unknowns().size());
  double psi_square = 0, mean = 0, square = 0;
  for (std::size_t i = 0; i < runs; ++i) {
    const double s = distance(residuals, at, i), psi = s * robust_weight(s);
    const double k = s < kHuber ? 1 : 0.5 * kHuber / s;  // half the trace of d psi/d r in the plane
    psi_square += psi * psi;
    mean += k / static_cast<double>(runs);
    square += k * k / static_cast<double>(runs);
  }
  const double correction = 1 + p / n * std::max(0.0, square - mean * mean) / (mean * mean);
  return correction * correction * (psi_square / std::max(1.0, n - p)) / (mean * mean);
}

const char* robust_meaning(Loss loss) {
  return loss == Loss::squares
             ? ""
             : " Robust loss (Huber): runs beyond 2 sigma count less and the intervals are an M-estimate's "
               "(Huber's formula), from the spread of the residuals; they trust that at most about one run "
               "in "
               "five is bad, and a profile likelihood has no meaning with it.";
}

}  // namespace tribotrack::fit::internal
