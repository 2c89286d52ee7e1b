#include "fit/estimate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fit/internal/bootstrap.h"
#include "fit/internal/display.h"
#include "fit/internal/identifiability.h"
#include "fit/internal/model_check.h"
#include "fit/internal/multi_start.h"
#include "fit/internal/next_experiment.h"
#include "fit/internal/outliers.h"
#include "fit/internal/parallel.h"
#include "fit/internal/profile.h"
#include "fit/internal/results.h"
#include "fit/internal/robust.h"
#include "fit/internal/scatter.h"
#include "fit/internal/settle.h"
#include "fit/internal/statistics.h"
#include "fit/internal/sticking.h"

namespace tribotrack::fit {
namespace {

using namespace internal;

constexpr double kSurprise = 1e-3;

/// Of the integrator, relative to the path: an error of 1e-12 m and less.
constexpr double kFine = 1e-9;

void warn_of_other_minima(const Residuals& residuals, const Search& search, double excess,
                          FitResult& result) {
  const Unknowns& unknowns = residuals.unknowns();
  for (std::size_t i = 1; i < search.minima.size(); ++i) {
    const Minimum& other = search.minima[i].minimum;
    const double above = other.chi2 - search.minima.front().minimum.chi2;
    if (above > 9 * excess) continue;
    const Eigen::VectorXd values = unknowns.values(fold_lag(unknowns, other.z));
    std::string text =
        "Another minimum fits nearly as well (chi2 higher by " + number(above / excess, 2) + "):";
    for (Eigen::Index k = 0; k < unknowns.reported(); ++k)
      text += std::string(k > 0 ? ", " : " ") + to_string(unknowns.parameter(k)) + " = " +
              number(values(k) * display_factor(unknowns.parameter(k)), 4);
    result.warnings.push_back(text + ".");
  }
}

void tell_scatter(const Residuals& residuals, bool allowed, FitResult& result) {
  const Problem& problem = residuals.unknowns().problem();
  const Scatter& scatter = residuals.scatter();
  result.scatter = scatter.runs();
  result.scatter_along = scatter.along;
  result.scatter_across = scatter.across;
  for (const auto& run : scatter.trajectories) result.scatter = std::max(result.scatter, run.between_points);
  if (!any(scatter)) {
    result.covariance_meaning =
        result.loss == Loss::squares
            ? "sd from the data's own sigma (absolute; not scaled by chi2), 95 % intervals with 1.96 sd."
            : std::string("95 % intervals with Student's t.") + robust_meaning(result.loss);
    if (result.p_value < kSurprise && !allowed)
      result.warnings.push_back("chi2 = " + number(result.chi2, 4) + " at " + std::to_string(result.dof) +
                                " degrees of freedom (p = " + number(result.p_value, 2) +
                                "): the model or the sigmas are wrong, and the sds too small.");
    return;
  }
  const bool repeated = result.scatter_from_replicates;
  result.covariance_meaning = std::string("sd from the data's own sigma and a scatter estimated from ") +
                              (repeated ? "repeated runs" : "the residuals") +
                              ", added in quadrature; 95 % intervals with Student's t." +
                              robust_meaning(result.loss);
  const std::string size = scatter.along == scatter.across
                               ? number(1e3 * scatter.runs()) + " mm per axis"
                               : number(1e3 * scatter.along) + " mm along (v) and " +
                                     number(1e3 * scatter.across) + " mm across their displacement (alpha)";
  if (repeated)
    result.warnings.push_back("Repeated runs scatter by " + size +
                              " more than their own sigma; with that the "
                              "fit agrees with all runs (p = " +
                              number(result.p_value, 2) + ").");
  else if (scatter.runs() > 0)
    result.warnings.push_back(
        "The runs scatter by " + size + " more than their own sigma (chi2 " +
        number(result.chi2_before_scatter, 4) + ", p = " + number(result.p_value, 2) + ")" +
        (result.replicate_dof >= 6 ? ", and by more than repeated runs do: " : ": real scatter, or ") +
        "something in A, w, tilt or the model is wrong.");
  for (std::size_t i = 0; i < scatter.trajectories.size(); ++i)
    if (const auto& run = scatter.trajectories[i]; run.between_points > 0)
      result.warnings.push_back("Run '" + problem.trajectory_runs[i].name + "': its points scatter by " +
                                number(1e3 * run.between_points) +
                                " mm per axis more than their own sigma and are correlated over " +
                                number(run.correlation_time, 2) + " points; the sd counts both.");
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
    throw DataError("The model cannot be evaluated at any start: check the drive and [fit.start].");
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
  check_model(residuals, minimum, options, result);
  const bool surprised = result.p_value < kSurprise;
  if (surprised || options.loss != Loss::squares)
    settle(residuals, minimum, options.estimate_scatter && surprised, options.loss);
  if (surprised) result.scatter_from_replicates = false;  // the residuals say more than the repetitions
  minimum.z = fold_lag(unknowns, minimum.z);

  // Uncertainty at the minimum; the profiles may find a better one, then once more.
  Judged judged = judge(residuals, minimum, options.loss);
  const double dof = residuals.degrees_of_freedom();
  const bool from_residuals = any(residuals.scatter()) || options.loss != Loss::squares;
  const double told_by = result.scatter_from_replicates ? result.replicate_dof : std::max(1.0, dof);
  const double t =
      two_sided_quantile(0.95, from_residuals ? told_by : std::numeric_limits<double>::infinity());
  std::vector<Interval> intervals;
  if (options.profiles && options.loss == Loss::squares && !stuck_throughout(problem)) {
    const double found = judged.best.minimum.chi2;
    intervals =
        profiles(residuals, judged.best, moved_by_flat_direction(judged.spread), t * t, options.threads);
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
  tell_runs(residuals, best, result);
  for (const Outlier& outlier : result.outliers) result.warnings.push_back(outlier.sentence);
  tell_systematics(residuals, best, judged.spread, result);
  warn_of_other_minima(residuals, search, excess, result);
  if (!result.converged)
    result.warnings.push_back(
        "The fit did not converge: start nearer ([fit.start]) or fit fewer parameters.");
  if (options.next_experiment) {
    const NextExperiments next = next_experiments(residuals, judged.values, best.jacobian, t, options);
    result.next_experiment = next.best;
    result.other_next_experiments = next.others;
  }
  return result;
}

}  // namespace tribotrack::fit
