#include "fit/checks/runs.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "fit/tools/parameter_text.h"
#include "fit/tools/statistics.h"
#include "fit/tools/thresholds.h"
#include "fit/uncertainty/covariance.h"

namespace tribotrack::fit::internal {
namespace {

/// The angle by which the run's pulse would have to be turned, where that explains its displacement.
/// nullopt, too, where it is no more than the run's own error in angle.
std::optional<double> looks_like(const SummaryRun& run, const Eigen::Vector2d& modelled, double sigma) {
  const Eigen::Vector2d& measured = run.measured.vector;
  if (std::abs(measured.norm() - modelled.norm()) > 4 * sigma + 0.1 * modelled.norm()) return std::nullopt;
  double turned = std::atan2(measured.y(), measured.x()) - std::atan2(modelled.y(), modelled.x());
  if (std::sin(run.scenario.drive.phase_shift) >= 0) turned = -turned;  // clockwise
  turned = std::remainder(turned, 2 * std::numbers::pi);
  if (std::abs(turned) < std::max(0.05, 3 * sigma / std::max(modelled.norm(), sigma))) return std::nullopt;
  return std::remainder(run.scenario.friction.phase + turned, 2 * std::numbers::pi);
}

Outlier describe(const SummaryRun& run, double deviation, double probability, std::optional<double> phi) {
  Outlier outlier;
  outlier.run = run.name;
  outlier.deviation = deviation;
  outlier.chance = probability;
  outlier.sentence = "Run '" + run.name + "' lies " + number(deviation, 2) +
                     " sigma from the fit to all other runs (chance " + number(probability, 1) +
                     "); check its phi, dtau and label";
  if (phi) {
    outlier.looks_like_phi = *phi < 0 ? *phi + 2 * std::numbers::pi : *phi;
    outlier.sentence += ": it moved as if phi were " + number(*outlier.looks_like_phi / std::numbers::pi, 2) +
                        " pi instead of " + number(run.scenario.friction.phase / std::numbers::pi, 2) + " pi";
  }
  outlier.sentence += ".";
  return outlier;
}

}  // namespace

double chance_of_run(double drop, double rest, double dof) {
  if (dof < 1 || rest <= dof) return std::exp(-0.5 * drop);  // chi^2 with 2 degrees of freedom
  return std::pow(1 + drop / rest, -0.5 * dof);              // F with 2 and dof
}

std::pair<std::size_t, double> worst_run(const Unknowns& unknowns, const Minimum& best,
                                         const std::vector<bool>& out) {
  const Eigen::MatrixXd covariance = uncertainty(unknowns, unknowns.values(best.z), best.at).shared;
  const RowGroup& summary = best.at.groups.front();
  std::pair<std::size_t, double> found{0, 0};
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (out[i]) continue;
    const auto row = 2 * static_cast<Eigen::Index>(i);
    const Eigen::Vector2d r = summary.residuals.segment<2>(row);
    const Eigen::MatrixXd j = summary.shared.middleRows(row, 2);
    const Eigen::Matrix2d left = Eigen::Matrix2d::Identity() - j * covariance * j.transpose();
    if (!(left.determinant() > 1e-6)) continue;  // the run alone pins something: nothing checks it
    const double drop = r.dot(left.inverse() * r);
    if (drop > found.second) found = {i, drop};
  }
  return found;
}

std::vector<Outlier> find_outliers(Residuals residuals, Minimum best) {
  constexpr double kLeftOut = 1e-12;  ///< weight of a run that does not count but is still compared
  const Problem& problem = residuals.unknowns().problem();
  const std::size_t runs = problem.summary_runs.size();
  std::vector<bool> out(runs, false);
  std::vector<Outlier> found;
  double dof = residuals.degrees_of_freedom();
  best = linearised(residuals, std::move(best));
  while (found.size() < runs / 4 && dof > 3 && !best.at.empty()) {
    const auto [i, first_order] = worst_run(residuals.unknowns(), best, out);
    const double count = static_cast<double>(runs);
    if (!(count * chance_of_run(first_order, std::max(0.0, best.chi2 - first_order), dof - 2) <
          10 * kOutlier))
      break;
    out[i] = true;
    std::vector<double> weights;
    for (std::size_t k = 0; k < runs; ++k) weights.push_back(out[k] ? kLeftOut : 1);
    residuals.set_weights(weights);
    const Minimum without = linearised(residuals, minimise(residuals, best.z, {.decrement = 1e-6}));
    const double drop = best.chi2 - without.chi2;
    const double probability = std::min(1.0, count * chance_of_run(drop, without.chi2, dof - 2));
    if (!(probability < kOutlier) || without.at.empty()) break;
    const double spread = std::sqrt(std::max(1.0, without.chi2 / (dof - 2)));
    const Eigen::Vector2d modelled =
        problem.summary_runs[i].measured.vector - residuals.difference(without.at, i);
    const double sigma = spread * std::sqrt(0.5 * residuals.covariance(i).trace());
    found.push_back(describe(problem.summary_runs[i], std::sqrt(drop) / spread, probability,
                             looks_like(problem.summary_runs[i], modelled, sigma)));
    best = without;
    dof -= 2;
  }
  // Where the rest does not hold either, the fault is not theirs alone.
  if (!(chi2_survival(best.chi2, dof) >= kSurprise)) found.clear();
  return found;
}

namespace {

/// P(no more than `seen` runs among `up` and `down` signs), normal approximation.
double few_runs(int seen, double up, double down) {
  if (up < 4 || down < 4) return 1;
  const double n = up + down, mean = 1 + 2 * up * down / n;
  const double variance = (mean - 1) * (mean - 2) / (n - 1);
  return 0.5 * std::erfc(-(seen + 0.5 - mean) / std::sqrt(2 * variance));
}

}  // namespace

double runs_test(std::vector<InOrder> runs) {
  if (runs.size() < 8) return 1;
  std::stable_sort(runs.begin(), runs.end(), [](const InOrder& a, const InOrder& b) {
    return std::tie(a.width, a.phi) < std::tie(b.width, b.phi);
  });
  double smallest = 1;
  for (const bool is_along : {true, false}) {
    int changes = 1, up = 0;
    bool before = false;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const auto& [width, phi, modelled, difference] = runs[i];
      const Eigen::Vector2d across(-modelled.y(), modelled.x());
      const bool above = (is_along ? modelled : across).dot(difference) > 0;
      up += above;
      changes += i > 0 && above != before;
      before = above;
    }
    smallest = std::min(smallest, few_runs(changes, up, static_cast<double>(runs.size()) - up));
  }
  return std::min(1.0, 2 * smallest);  // of two components
}

double runs_test(const std::vector<RunResult>& runs) {
  std::vector<InOrder> rows;
  for (const RunResult& run : runs) {
    if (run.points > 0 || run.prediction || run.residuals.size() < 2) continue;
    const Residual &x = run.residuals[0], &y = run.residuals[1];
    rows.push_back({run.fitted.friction.pulse_width,
                    run.fitted.friction.phase,
                    {x.modelled, y.modelled},
                    {x.measured - x.modelled, y.measured - y.modelled}});
  }
  return runs_test(std::move(rows));
}

}  // namespace tribotrack::fit::internal
