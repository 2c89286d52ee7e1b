#include "fit/stages/estimation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "fit/checks/runs.h"
#include "fit/checks/verdict.h"
#include "fit/design/next_experiment.h"
#include "fit/report/fill_result.h"
#include "fit/rounding.h"
#include "fit/tools/parameter_text.h"
#include "fit/tools/statistics.h"
#include "fit/uncertainty/budget.h"
#include "fit/uncertainty/identifiability.h"

namespace tribotrack::fit::internal {
namespace {

/// Error of the integrator relative to the path: 1e-12 m and less.
constexpr double kFine = 1e-9;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Of chi^2, beyond what a kink leaves of it: own errors that move the minimum by more have it found again.
constexpr double kMoved = 1e-10;

/// Scatter beyond this share of what was measured leaves no result.
constexpr double kScatterShare = 0.1;

}  // namespace

Estimation::Estimation(const Problem& problem, const FitOptions& options, const BetweenSlides* slides)
    : problem_(problem),
      slides_(slides),
      options_(options),
      unknowns_(problem),
      residuals_(unknowns_, options.threads) {
  residuals_.set_tolerance(kFine);
  result_.loss = options.loss;
}

void Estimation::find_minimum() {
  residuals_.set_own_errors(unknowns_.first_guess());
  const bool tracks = problem_.has_driven_tracks();
  if (tracks) {
    DisplacementSearch found = search_by_displacements(residuals_, options_);
    search_ = std::move(found.search);
    by_displacements_ = std::move(found.place);
  } else {
    search_ = multi_start(residuals_, options_);
  }
  if (search_.minima.empty()) {
    std::string why;
    residuals_.at(unknowns_.first_guess(), false, &why);
    throw DataError("The model cannot be evaluated at any start" + (why.empty() ? "" : " (" + why + ")") +
                    ": check the drive and the first guesses ([fit.guess]).");
  }
  result_.starts_screened = static_cast<int>(search_.sample.size());
  result_.starts = search_.starts;
  result_.starts_at_best = search_.at_best;
  constexpr int kFromThinned = 15;
  if (tracks) residuals_.linearise(unknowns_.values(search_.minima.front().z));
  const Lowest lowest =
      tracks ? Lowest{minimise_linearised(residuals_, search_.minima.front().z, {.full_steps = kFromThinned})}
             : lowest_minimum(residuals_, search_, options_.threads);
  minimum_ = lowest.minimum;
  led_here_ = lowest.from;
  if (std::any_of(problem_.summary_runs.begin(), problem_.summary_runs.end(),
                  [](const SummaryRun& run) { return !run.own.parameters.empty(); })) {
    const Eigen::VectorXd values = unknowns_.values(minimum_.z);
    const double left = minimum_.at.empty() ? 0 : newton_decrement(minimum_.at);
    residuals_.set_own_errors(values);
    auto at = residuals_.at(values);
    if (!at || newton_decrement(*at) > kMoved + 2 * left) {
      minimum_ = minimise_linearised(residuals_, minimum_.z);
    } else {
      minimum_.chi2 = at->chi2();
      minimum_.at = std::move(*at);
    }
  }
  result_.dof = std::max(0, static_cast<int>(std::lround(residuals_.degrees_of_freedom())));
  result_.noise_dof = residuals_.noise_degrees_of_freedom();
  state_chi2(minimum_.chi2);
  result_.conditions = static_cast<int>(unknowns_.common() - unknowns_.reported());
}

std::vector<Eigen::VectorXd> Estimation::ends() const {
  std::vector<Eigen::VectorXd> ends{minimum_.z};
  for (const Minimum& minimum : search_.minima) ends.push_back(minimum.z);
  return ends;
}

bool Estimation::lower_from(const std::vector<Eigen::VectorXd>& values) {
  constexpr double kLower =
      0.5;  ///< of chi^2: less of a fall is not worth explaining again, if rejected still
  bool lower = false;
  for (const Eigen::VectorXd& from : values) {
    Residuals there = residuals_;
    if (any(residuals_.excess_variance()) || !there.linear_in_conditions() || !there.linearise(from))
      continue;
    const Minimum other = minimise_linearised(there, unknowns_.z(from));
    const bool still_rejected = residuals_.p_value(other.chi2) < kSurprise;
    if (!(other.chi2 < (still_rejected ? kLower : 1) * minimum_.chi2) || !admissible(unknowns_, other.z))
      continue;
    residuals_ = there;
    minimum_ = other;
    lower = true;
  }
  if (!lower) return false;
  state_chi2(minimum_.chi2);
  test_residuals();
  return true;
}

/// Before any scatter.
void Estimation::state_chi2(double chi2) {
  result_.chi2 = chi2;
  result_.p_value = residuals_.p_value(chi2);
}

void Estimation::add_scatter_of_replicates() {
  const Replicates repeated = replicates(problem_);
  result_.replicate_dof = repeated.dof;
  result_.scatter_from_replicates = options_.estimate_scatter && repeated.scatter > 0;
  if (!result_.scatter_from_replicates) return;
  ExcessVariance excess = residuals_.excess_variance();
  excess.runs = repeated.scatter;
  residuals_.set_excess_variance(excess);
  minimum_ = minimise(residuals_, minimum_.z);
}

void Estimation::test_residuals() {
  add_scatter_of_replicates();
  p_value_ = residuals_.p_value(minimum_.chi2);
  excess_ = residuals_.excess(minimum_.chi2);
  result_.outliers = find_outliers(residuals_, minimum_);
}

void Estimation::explain_excess_variance() {
  const bool known = problem_.summary_runs.empty() || result_.scatter_from_replicates;
  const bool scattered = p_value_ < (known ? kSurprise : kDoubt);
  const Reweighting reweighting{options_.estimate_scatter && problem_.has_driven_tracks(),
                                options_.estimate_scatter && scattered, options_.loss};
  // Where points reject the model the lowest chi^2 by their own errors may lie far from where displacements
  // do.
  if (rejected() && by_displacements_.size() > 0) {
    residuals_.linearise(unknowns_.values(by_displacements_));
    minimum_ = {};
    minimum_.z = by_displacements_;
  }
  if (reweighting.correlated_errors || reweighting.scatter || options_.loss != Loss::squares)
    correlated_ = reweighted_fit(residuals_, minimum_, reweighting);
}

void Estimation::evaluate_curvature(const Minimum& minimum) {
  best_ = linearised(residuals_, minimum);
  values_ = unknowns_.values(minimum.z);
  if (best_.at.empty()) throw DataError("The model cannot be evaluated at the minimum: check the drive.");
  if (options_.loss == Loss::squares) {
    uncertainty_ = uncertainty(unknowns_, values_, best_.at);
    return;
  }
  // The covariance of an M-estimate rests on the unweighted sensitivity.
  Residuals plain = residuals_;
  plain.set_weights({});
  const auto at = plain.at(values_);
  if (!at) throw DataError("The model cannot be evaluated at the minimum: check the drive.");
  const double factor = robust_covariance_factor(residuals_, best_.at);
  uncertainty_ = uncertainty(unknowns_, values_,
                             at->scaled(Eigen::VectorXd::Constant(unknowns_.size(), 1 / std::sqrt(factor))));
}

/// Degrees of freedom that the scatter between slides leaves to a parameter (Satterthwaite): few slides know
/// it badly, where the mean rests on them. Driven runs take a share of the variance away; what all slides
/// share, as a tilt, adds one.
double Estimation::by_slides(Eigen::Index parameter) const {
  if (!slides_ || slides_->dof < 1 || unknowns_.parameter(parameter) != FitParameter::mu1) return kInfinity;
  const double by_scatter = slides_->information * uncertainty_.covariance(parameter, parameter);
  const double share = std::min(by_scatter, 1 / by_scatter);
  return slides_->dof / (share * share);
}

/// Student's t where a variance was estimated, be it that of the points: by the degrees of freedom that it
/// has, or Satterthwaite's.
std::vector<double> Estimation::quantiles() const {
  const bool from_residuals = any(residuals_.excess_variance()) || options_.loss != Loss::squares;
  const double estimated_by = result_.scatter_from_replicates
                                  ? result_.replicate_dof
                                  : std::max(1.0, residuals_.degrees_of_freedom());
  const auto numbers = 2 * (problem_.summary_runs.size() + problem_.trajectory_runs.size());
  const double by_runs = problem_.counts_run_scatter()
                             ? static_cast<double>(numbers) - static_cast<double>(unknowns_.reported())
                             : kInfinity;
  std::vector<double> t;
  for (Eigen::Index i = 0; i < unknowns_.reported(); ++i) {
    const double by_correlated =
        correlated_.degrees_of_freedom.size() > 0 ? correlated_.degrees_of_freedom(i) : kInfinity;
    const double dof =
        std::max(1.0, std::min({from_residuals ? estimated_by : residuals_.noise_degrees_of_freedom(),
                                by_correlated, by_runs, by_slides(i)}));
    t.push_back(two_sided_quantile(kConfidence, dof));
  }
  return t;
}

/// Deleted residuals of the priors of parameters, judged as chi^2 of one degree of freedom.
std::vector<std::string> Estimation::contradicted_priors(const Eigen::VectorXd& values,
                                                         const Eigen::MatrixXd& covariance) const {
  std::vector<std::string> found;
  for (Eigen::Index i = 0; i < unknowns_.reported(); ++i) {
    const auto prior = unknowns_.prior(i);
    if (!prior || !(prior->sd > 0)) continue;
    const double variance = covariance(i, i), of_prior = prior->sd * prior->sd;
    const double off = values(i) - prior->mean, left = 1 - variance / of_prior;
    if (!(left > 1e-6) || chi2_survival(off * off / (of_prior * left), 1) >= kSurprise) continue;
    const FitParameter parameter = unknowns_.parameter(i);
    const double unit = display_factor(parameter);
    found.push_back(
        fmt::format("the prior of {}, {}, contradicts the data, which alone say about {}",
                    to_string(parameter), quoted(unit * prior->mean, unit * prior->sd),
                    quoted(unit * (prior->mean + off / left), unit * std::sqrt(variance / left))));
  }
  return found;
}

/// With the errors now known other minima may be as good, or better.
void Estimation::find_other_minima() {
  minima_ = {best_};
  // Of values that are not to be used no other is told.
  if (search_.minima.size() < 2 || (rejected() && residuals_.linear_in_conditions())) return;
  const double lowest = search_.minima.front().chi2, excess = residuals_.excess(best_.chi2);
  std::size_t best = 0, refined = 1;
  for (std::size_t i = 0; i < search_.minima.size() && refined < kRefined; ++i) {
    if (i == led_here_) continue;
    const Minimum& rough = search_.minima[i];
    if (rough.chi2 - lowest > 2 * kNearMinimum * excess_) continue;
    Residuals there = residuals_;
    there.linearise(unknowns_.values(rough.z));
    const Minimum near = minimise(there, fold_lag(unknowns_, rough.z), {.decrement = 0.1, .known = &minima_});
    if (near.joined || near.abandoned || !(near.chi2 - best_.chi2 < 2 * kNearMinimum * excess)) continue;
    const Minimum other = minimise_linearised(there, near.z);
    const bool known = std::any_of(minima_.begin(), minima_.end(), [&](const Minimum& minimum) {
      return same(unknowns_, minimum, other, excess);
    });
    ++refined;
    if (known || !std::isfinite(other.chi2) || !admissible(unknowns_, other.z)) continue;
    minima_.push_back(linearised(there, other));
    if (other.chi2 < minima_[best].chi2) best = minima_.size() - 1;
  }
  if (best > 0) take(best);
}

/// The estimate is this one of `minima_`.
void Estimation::take(std::size_t index) {
  std::rotate(minima_.begin(), minima_.begin() + static_cast<std::ptrdiff_t>(index),
              minima_.begin() + static_cast<std::ptrdiff_t>(index) + 1);
  residuals_.linearise(unknowns_.values(minima_.front().z));
  evaluate_curvature(Minimum(minima_.front()));
  minima_.front() = best_;
}

void Estimation::quantify_uncertainty() {
  // What the residuals need beyond the repetitions' scatter is estimated from them.
  if (rejected()) result_.scatter_from_replicates = false;
  const ExcessVariance& excess = residuals_.excess_variance();
  if (residuals_.linear_in_conditions() && (any(excess) || excess.correlated != CorrelatedVariances{}))
    minimum_ = minimise_linearised(residuals_, minimum_.z);
  minimum_.z = fold_lag(unknowns_, minimum_.z);
  evaluate_curvature(minimum_);
  find_other_minima();
  t_ = quantiles();
  if (!options_.profiles || options_.loss != Loss::squares || problem_.stuck_throughout()) return;
  std::vector<double> rises;
  for (const double t : t_) rises.push_back(t * t);
  const double found = best_.chi2;
  profiles_ = profiles(residuals_, minima_, search_.sample, moved_by_flat_direction(uncertainty_), rises,
                       options_.threads);
  if (minima_.front().chi2 < found) take(0);
  if (!any(residuals_.excess_variance())) state_chi2(best_.chi2);
}

void Estimation::describe() {
  result_.converged = best_.converged;
  fill_parameters(unknowns_, values_, uncertainty_, t_, result_);
  for (std::size_t i = 0; i < profiles_.size(); ++i)
    fill_profile(profiles_[i], t_[i] * t_[i], result_.parameters[i]);
  fill_excess_variance(residuals_, options_.estimate_scatter, result_);
  fill_correlated_errors(residuals_, result_);
}

FitResult Estimation::assumed() const {
  FitResult result = result_;
  const Minimum here = linearised(residuals_, minimum_);
  const Eigen::VectorXd values = unknowns_.values(fold_lag(unknowns_, minimum_.z));
  const Eigen::MatrixXd covariance = uncertainty(unknowns_, values, here.at).covariance;
  result.as_assumed = estimates_under(unknowns_, values, covariance);
  result.contradicted_priors = contradicted_priors(values, covariance);
  return result;
}

std::map<FitParameter, double> Estimation::estimates_alone() const {
  std::map<FitParameter, double> values;
  for (const FitParameter parameter : problem_.free) values[parameter] = value_of(parameter);
  return values;
}

double Estimation::scatter_of_friction() const {
  const Eigen::VectorXd values = unknowns_.values(minimum_.z);
  double square = 0, count = 0;
  for (const NuisanceBlock& block : unknowns_.nuisances()) {
    if (block.kind != Nuisance::own) continue;
    const auto& own = problem_.trajectory_runs[block.run].own.parameters;
    for (std::size_t k = 0; k < own.size(); ++k) {
      if (own[k] != model::Parameter::mu1 && own[k] != model::Parameter::mu2) continue;
      const double mu = value_of(own[k] == model::Parameter::mu1 ? FitParameter::mu1 : FitParameter::mu2);
      square += std::pow(values(block.first + static_cast<Eigen::Index>(k)) / mu, 2);
      ++count;
    }
  }
  return std::sqrt(square / std::max(1.0, count - 2));
}

std::optional<std::pair<Explanation, RunScatter>> Estimation::scatter_at(
    const Eigen::VectorXd& values) const {
  Residuals rows = residuals_;
  rows.set_own_errors(values);
  rows.linearise(values);
  const auto at = rows.at(values);
  const auto scatter = at ? run_scatter(rows, values, *at) : std::nullopt;
  if (!scatter) return std::nullopt;
  Explanation found = scatter_of(100 * scatter->relative, 2 * problem_.summary_runs.size());
  found.chi2_fall = minimum_.chi2 - at->chi2() + scatter->fall;
  found.p_after = residuals_.p_value(scatter->chi2, 1);
  found.parameters = estimates_under(unknowns_, values, uncertainty(unknowns_, values, *at).covariance);
  found.refitted = true;
  std::vector<InOrder> in_order;
  for (std::size_t i = 0; i < problem_.summary_runs.size(); ++i) {
    const SummaryRun& run = problem_.summary_runs[i];
    const Eigen::Vector2d difference = rows.difference(*at, i);
    if (!run.held_out)
      in_order.push_back({run.scenario.friction.pulse_width, run.scenario.friction.phase,
                          run.measured.vector - difference, difference});
  }
  found.explains = scatter->beyond_any > kPreferred && found.p_after > kExplained &&
                   runs_test(std::move(in_order)) > kExplained;
  return std::pair(found, *scatter);
}

std::pair<std::size_t, double> Estimation::worst() const {
  std::vector<bool> out;
  for (const SummaryRun& run : problem_.summary_runs) out.push_back(run.held_out);
  return worst_run(unknowns_, linearised(residuals_, minimum_), out);
}

double Estimation::log_likelihood(const Eigen::VectorXd& values) const {
  Residuals rows = residuals_;
  rows.linearise(values);
  return estimate_correlated_errors(rows, values).log_likelihood;
}

Explanation Estimation::as_explanation(Explanation found, const Estimation& of) const {
  found.chi2_fall = of.chi2() - chi2();
  found.p_after = p_value_;
  found.parameters = assumed().as_assumed;
  found.refitted = true;
  found.explains = by_tracking();
  return found;
}

FitResult Estimation::estimates() {
  describe();
  fill_runs(residuals_, best_, result_);
  return std::move(result_);
}

FitResult Estimation::report() {
  describe();
  const Minimum& best = best_;
  FitResult& result = result_;
  if (options_.bootstrap > 0) {
    const Bootstrap refits = bootstrap(residuals_, best, any(residuals_.excess_variance()), options_);
    result.bootstrap = {refits.converged, options_.bootstrap_seed};
    for (std::size_t i = 0; i < refits.ci95.size(); ++i) result.parameters[i].bootstrap_ci95 = refits.ci95[i];
  }
  result.contradicted_priors = contradicted_priors(values_, uncertainty_.covariance);
  result.identifiability = identifiability(unknowns_, values_, uncertainty_, result.parameters);
  result.scatter_dominates = rejected() && result.scatter > kScatterShare * problem_.typical_displacement();
  if (result.scatter_dominates)
    result.warnings.push_back(
        "The runs scatter about the model by " + number(1e3 * result.scatter, 2) +
        " mm per axis, more than a tenth of their typical displacement: they do not follow it.");
  if (problem_.has_pulses() && !unknowns_.is_known(FitParameter::lag) &&
      !unknowns_.is_known(FitParameter::delay))
    result.warnings.push_back(
        "phase_lag_rad is not fitted and taken as 0: add it to [fit] parameters, or give it in [fit.fixed].");
  result.agreement = agreement(result);
  fill_runs(residuals_, best, result);
  const Eigen::MatrixXd influence = influence_of_runs(residuals_, best, uncertainty_);
  for (std::size_t run = 0; run < result.runs.size(); ++run) {
    const auto row = influence.row(static_cast<Eigen::Index>(run));
    result.runs[run].influence.assign(row.begin(), row.end());
  }
  fill_predictions(residuals_, best, uncertainty_, result);
  fill_laws(unknowns_, values_, uncertainty_, result);
  for (const Outlier& outlier : result.outliers) result.warnings.push_back(outlier.sentence);
  result.budget = budget(residuals_, best, uncertainty_);
  result.improve_first = improve_first(result.budget, result.parameters);
  result.systematics = taken_as_exact(result.budget, result.parameters);
  fill_minima(residuals_, minima_, result);
  if (!result.converged)
    result.warnings.push_back(
        "The fit did not converge: start nearer ([fit.guess]) or fit fewer parameters.");
  return std::move(result_);
}

void Estimation::look_ahead(FitResult& result) const {
  if (!options_.next_experiment) return;
  NextExperiments next =
      next_experiments(residuals_, values_, best_.at, *std::max_element(t_.begin(), t_.end()), options_);
  result.next_experiment = std::move(next.best);
  result.other_next_experiments = std::move(next.others);
  if (next.given_up)
    result.left_out.push_back("The search for the run to film next takes too long and was given up.");
}

}  // namespace tribotrack::fit::internal
