#include "fit/estimate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fit/checks/model_check.h"
#include "fit/checks/outliers.h"
#include "fit/design/next_experiment.h"
#include "fit/minimum/multi_start.h"
#include "fit/report/error_text.h"
#include "fit/report/fill_result.h"
#include "fit/residuals/sticking.h"
#include "fit/tools/parallel.h"
#include "fit/tools/parameter_text.h"
#include "fit/tools/statistics.h"
#include "fit/uncertainty/bootstrap.h"
#include "fit/uncertainty/identifiability.h"
#include "fit/uncertainty/profile.h"
#include "fit/variances/excess_variance.h"
#include "fit/variances/reweighted_fit.h"
#include "fit/variances/robust.h"

namespace tribotrack::fit {
namespace {

using namespace internal;

/// Of the integrator, relative to the path: an error of 1e-12 m and less.
constexpr double kFine = 1e-9;

/// All minima within a chi-square of the best, the lag folded, the best as it stands now first.
void tell_minima(const Residuals& residuals, const Search& search, double excess, FitResult& result) {
  const Unknowns& unknowns = residuals.unknowns();
  result.minima.emplace_back();
  for (const ParameterEstimate& p : result.parameters) result.minima.front().values[p.parameter] = p.estimate;
  for (std::size_t i = 1; i < search.minima.size(); ++i) {
    const Minimum& other = search.minima[i].minimum;
    const double above = (other.chi2 - search.minima.front().minimum.chi2) / excess;
    if (above > 9) continue;
    const Eigen::VectorXd values = unknowns.values(fold_lag(unknowns, other.z));
    OneMinimum minimum;
    minimum.chi2_above = above;
    std::string text = "Another minimum fits nearly as well (chi2 higher by " + number(above, 2) + "):";
    for (Eigen::Index k = 0; k < unknowns.reported(); ++k) {
      const FitParameter parameter = unknowns.parameter(k);
      minimum.values[parameter] = values(k);
      text += std::string(k > 0 ? ", " : " ") + to_string(parameter) + " = " +
              number(values(k) * display_factor(parameter), 4);
    }
    minimum.sentence = text + ".";
    result.warnings.push_back(minimum.sentence);
    result.minima.push_back(minimum);
  }
}

void add_scatter_of_replicates(Residuals& residuals, const FitOptions& options, Minimum& minimum,
                               FitResult& result) {
  const Replicates repeated = replicates(residuals.unknowns().problem());
  result.replicate_dof = repeated.dof;
  result.scatter_from_replicates = options.estimate_scatter && repeated.scatter > 0;
  if (!result.scatter_from_replicates) return;
  Scatter scatter = residuals.scatter();
  scatter.along = scatter.across = repeated.scatter;
  residuals.set_scatter(scatter);
  minimum = minimise(residuals, minimum.z);
}

/// Everything that rests on the minimum and its curvature.
struct Judged {
  KnownMinimum best;
  Eigen::VectorXd values;
  Uncertainty spread;
};

Judged judge(const Residuals& residuals, const Minimum& minimum, Loss loss) {
  Judged judged{with_curvature(residuals, minimum), residuals.unknowns().values(minimum.z), {}};
  const Minimum& best = judged.best.minimum;
  if (best.jacobian.rows() == 0)
    throw DataError("The model cannot be evaluated at the minimum: check the drive.");
  if (loss == Loss::squares) {
    judged.spread = uncertainty(residuals.unknowns(), judged.values, best.jacobian);
    return judged;
  }
  // An M-estimate's covariance rests on the unweighted sensitivity.
  Residuals plain = residuals;
  plain.set_weights({});
  Eigen::VectorXd r;
  Eigen::MatrixXd jacobian;
  plain.evaluate(judged.values, r, &jacobian);
  const double factor = robust_covariance_factor(residuals, best.residuals, loss);
  judged.spread = uncertainty(residuals.unknowns(), judged.values, jacobian / std::sqrt(factor));
  return judged;
}

}  // namespace

FitResult estimate(const Problem& problem, const FitOptions& options) {
  problem.validate();
  const Unknowns unknowns(problem);
  const int run_threads = problem.trajectory_runs.empty() ? 1 : options.threads;
  Residuals residuals(problem, unknowns, run_threads);
  residuals.set_tolerance(kFine);

  const Search search = multi_start(residuals, options);
  if (search.minima.empty())
    throw DataError("The model cannot be evaluated at any start: check the drive and [fit.guess].");
  FitResult result;
  result.starts_screened = search.screened;
  result.starts = search.starts;
  result.starts_at_best = search.at_best;
  result.loss = options.loss;

  Minimum minimum = minimise(residuals, search.minima.front().minimum.z);
  result.chi2_before_scatter = minimum.chi2;
  add_scatter_of_replicates(residuals, options, minimum, result);
  result.p_value = chi2_survival(minimum.chi2, residuals.degrees_of_freedom());
  const double excess = residuals.excess(minimum.chi2);
  result.outliers = find_outliers(residuals, minimum);
  if (problem.trajectory_runs.empty()) check_model(residuals, minimum, options, result);
  const bool surprised = result.p_value < kSurprise;
  const bool driven = std::any_of(problem.trajectory_runs.begin(), problem.trajectory_runs.end(),
                                  [](const auto& run) { return !run.free_slide; });
  const bool told = problem.summary_runs.empty() || result.scatter_from_replicates;
  const bool asks = result.p_value < (told ? kSurprise : kDoubt);
  const Settling settling{options.estimate_scatter && driven, options.estimate_scatter && asks, options.loss};
  SlowEstimate slow;
  if (settling.slow_errors || settling.scatter || options.loss != Loss::squares)
    slow = settle(residuals, minimum, settling);
  if (!problem.trajectory_runs.empty()) check_model(residuals, minimum, options, result);
  if (surprised) result.scatter_from_replicates = false;  // the residuals say more than the repetitions
  minimum.z = fold_lag(unknowns, minimum.z);

  // Uncertainty at the minimum; the profiles may find a better one, then once more.
  Judged judged = judge(residuals, minimum, options.loss);
  const double dof = residuals.degrees_of_freedom();
  const bool from_residuals = any(residuals.scatter()) || options.loss != Loss::squares;
  const double told_by = result.scatter_from_replicates ? result.replicate_dof : std::max(1.0, dof);
  const double infinite = std::numeric_limits<double>::infinity();
  std::vector<double> t, rises;  // of each parameter
  for (Eigen::Index i = 0; i < unknowns.reported(); ++i) {
    const double by_slow = slow.degrees_of_freedom.size() > 0 ? slow.degrees_of_freedom(i) : infinite;
    t.push_back(
        two_sided_quantile(0.95, std::max(1.0, std::min(from_residuals ? told_by : infinite, by_slow))));
    rises.push_back(t.back() * t.back());
  }
  std::vector<Interval> intervals;
  if (options.profiles && options.loss == Loss::squares && !stuck_throughout(problem)) {
    const double found = judged.best.minimum.chi2;
    intervals =
        profiles(residuals, judged.best, moved_by_flat_direction(judged.spread), rises, options.threads);
    if (judged.best.minimum.chi2 < found) judged = judge(residuals, judged.best.minimum, options.loss);
  }

  const Minimum& best = judged.best.minimum;
  result.converged = best.converged;
  result.chi2 = best.chi2;
  result.dof = std::max(0, static_cast<int>(std::lround(dof)));
  tell_parameters(unknowns, judged.values, judged.spread, t, result);
  for (std::size_t i = 0; i < intervals.size(); ++i) result.parameters[i].profile_ci95 = intervals[i];
  if (options.bootstrap > 0) {
    const Bootstrap refits = bootstrap(residuals, best, any(residuals.scatter()), options);
    result.bootstrap = refits.converged;
    result.bootstrap_seed = options.bootstrap_seed;
    for (std::size_t i = 0; i < refits.ci95.size(); ++i) result.parameters[i].bootstrap_ci95 = refits.ci95[i];
  }
  result.identifiability = identifiability(unknowns, judged.values, judged.spread);
  compare_with_profiles(unknowns, result.parameters, result.identifiability);
  tell_scatter(residuals, options.estimate_scatter, result);
  tell_slow_errors(residuals, result);
  tell_runs(residuals, best, result);
  for (const Outlier& outlier : result.outliers) result.warnings.push_back(outlier.sentence);
  tell_systematics(residuals, best, judged.spread, result);
  tell_minima(residuals, search, excess, result);
  if (!result.converged)
    result.warnings.push_back(
        "The fit did not converge: start nearer ([fit.guess]) or fit fewer parameters.");
  if (options.next_experiment) {
    const NextExperiments next = next_experiments(residuals, judged.values, best.jacobian,
                                                  *std::max_element(t.begin(), t.end()), options);
    result.next_experiment = next.best;
    result.other_next_experiments = next.others;
  }
  return result;
}

}  // namespace tribotrack::fit
