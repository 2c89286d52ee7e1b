#include "fit/estimate.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

#include "fit/checks/explanations.h"
#include "fit/checks/runs.h"
#include "fit/checks/verdict.h"
#include "fit/design/next_experiment.h"
#include "fit/minimum/multi_start.h"
#include "fit/report/fill_result.h"
#include "fit/slides/between_slides.h"
#include "fit/slides/one_by_one.h"
#include "fit/tools/parameter_text.h"
#include "fit/tools/statistics.h"
#include "fit/tools/thresholds.h"
#include "fit/uncertainty/budget.h"
#include "fit/uncertainty/covariance.h"
#include "fit/uncertainty/identifiability.h"
#include "fit/uncertainty/profile.h"
#include "fit/variances/excess_variance.h"

namespace tribotrack::fit {
namespace {

using namespace internal;

/// Error of the integrator relative to the path: 1e-12 m and less.
constexpr double kFine = 1e-9;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Of chi^2, beyond what a kink leaves of it: own errors that move the minimum by more have it found again.
constexpr double kMoved = 1e-10;

/// Descents under an explanation.
constexpr int kStartsNearby = 4;

/// Scatter beyond this share of what was measured leaves no result.
constexpr double kScatterShare = 0.1;

bool lag_taken_as_zero(const Problem& problem) {
  const auto known = [&](FitParameter parameter) {
    return problem.fixed.count(parameter) > 0 || problem.fits(parameter);
  };
  return problem.has_pulses() && !known(FitParameter::lag) && !known(FitParameter::delay);
}

/// An evaluation is worth more than one thread.
bool is_large(const Problem& problem) {
  constexpr std::size_t kManyRuns = 64;
  return !problem.trajectory_runs.empty() || problem.summary_runs.size() > kManyRuns;
}

/// A fit from its start to its result; the members are called in their order.
class Estimation {
 public:
  /// `slides`: how the slides' mu1 differ; null where they do not count as a sample.
  Estimation(const Problem& problem, const FitOptions& options, const BetweenSlides* slides = nullptr)
      : problem_(problem),
        slides_(slides),
        options_(options),
        unknowns_(problem),
        residuals_(unknowns_, is_large(problem) ? options.threads : 1) {
    residuals_.set_tolerance(kFine);
    result_.loss = options.loss;
  }
  Estimation(const Estimation&) = delete;  // residuals_ refers to unknowns_
  Estimation& operator=(const Estimation&) = delete;

  void find_minimum();
  /// p of chi^2 with the data's own sigma and the scatter of repeated runs; outlying runs.
  void test_residuals();
  /// Best first; those near the best refitted where chi^2 rejects the fit, or where asked for.
  std::vector<ExplainedProblem> explanations() const {
    return internal::explanations(residuals_, minimum_, rejected() || options_.rivals, options_.threads);
  }
  /// Descends from where fits under explanations ended. True where that is lower than the minimum found,
  /// which was but another valley.
  bool lower_from(const std::vector<Eigen::VectorXd>& values);
  /// The values where this fit ended, of the unknowns of another to the same runs.
  Eigen::VectorXd values_for(const Estimation& other) const {
    return other.unknowns_.values_of(unknowns_, unknowns_.values(minimum_.z));
  }
  /// By chance in one of a thousand; the scatter of repeated runs is none of the model's.
  bool rejected() const { return p_value_ < kSurprise; }
  double chi2() const { return minimum_.chi2; }
  const std::vector<Outlier>& outliers() const { return result_.outliers; }
  double value_of(FitParameter parameter) const {
    return unknowns_.value_of(parameter, unknowns_.values(minimum_.z));
  }
  /// By displacements.
  double roughly(FitParameter parameter) const {
    return unknowns_.value_of(parameter, unknowns_.values(by_displacements_));
  }
  /// Of Problem::free.
  std::map<FitParameter, double> estimates_alone() const;
  /// By how much friction differs from track to track, relative, of tracks with errors of their own in it.
  double scatter_of_friction() const;
  /// As an explanation of another fit to the same runs.
  Explanation scatter_explained(const Estimation& other) const;
  /// Where the residuals exceed their sigma: scatter, correlated errors, robust weights.
  void explain_excess_variance();
  void quantify_uncertainty();
  /// Estimates and runs alone.
  FitResult estimates();
  /// What the fit says before anything is explained, with intervals from the covariance.
  FitResult assumed() const;
  /// With what determines them and what checks them.
  FitResult report();
  /// What to film next.
  void look_ahead(FitResult& result) const;

 private:
  void describe();
  void state_chi2(double chi2);
  void add_scatter_of_replicates();
  void find_other_minima();
  void take(std::size_t index);
  void evaluate_curvature(const Minimum& minimum);
  std::vector<double> quantiles() const;
  double by_slides(Eigen::Index parameter) const;

  const Problem& problem_;
  const BetweenSlides* slides_;
  const FitOptions& options_;
  Unknowns unknowns_;
  Residuals residuals_;
  FitResult result_;
  Search search_;
  std::size_t led_here_ = 0;  ///< of search_.minima, to minimum_
  Minimum minimum_;
  Eigen::VectorXd by_displacements_;  ///< of tracks: where what they moved has its minimum
  double p_value_ = 1;                ///< with the scatter of repeated runs
  double excess_ = 1;                 ///< chi^2/dof before any scatter was estimated
  CorrelatedEstimate correlated_;
  // At the final minimum:
  Minimum best_;
  Eigen::VectorXd values_;
  Uncertainty uncertainty_;
  std::vector<double> t_;        ///< two-sided 95 % quantile of each parameter
  std::vector<Minimum> minima_;  ///< the best and others near it
  std::vector<Profile> profiles_;
};

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
  if (tracks) residuals_.linearise(unknowns_.values(search_.minima.front().z));
  const Lowest lowest = tracks ? Lowest{minimise_linearised(residuals_, search_.minima.front().z)}
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
/// it badly, where the mean rests on them.
double Estimation::by_slides(Eigen::Index parameter) const {
  if (!slides_ || slides_->dof < 1 || unknowns_.parameter(parameter) != FitParameter::mu1) return kInfinity;
  const double share = std::min(1.0, slides_->information * uncertainty_.covariance(parameter, parameter));
  return slides_->dof / (share * share);
}

/// Student's t where a variance was estimated: by the degrees of freedom that it has, or Satterthwaite's.
std::vector<double> Estimation::quantiles() const {
  const bool from_residuals = any(residuals_.excess_variance()) || options_.loss != Loss::squares;
  const double estimated_by = result_.scatter_from_replicates
                                  ? result_.replicate_dof
                                  : std::max(1.0, residuals_.degrees_of_freedom());
  std::vector<double> t;
  for (Eigen::Index i = 0; i < unknowns_.reported(); ++i) {
    const double by_correlated =
        correlated_.degrees_of_freedom.size() > 0 ? correlated_.degrees_of_freedom(i) : kInfinity;
    const double dof =
        std::max(1.0, std::min({from_residuals ? estimated_by : kInfinity, by_correlated, by_slides(i)}));
    t.push_back(two_sided_quantile(kConfidence, dof));
  }
  return t;
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
  result.as_assumed = estimates_under(unknowns_, values, uncertainty(unknowns_, values, here.at).covariance);
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

Explanation Estimation::scatter_explained(const Estimation& other) const {
  Explanation found;
  found.name = "run_scatter";
  found.unit = "%";
  found.dof = 1;
  found.chi2_fall = other.chi2() - chi2();
  found.size = 100 * scatter_of_friction();
  found.size_sd = found.size / std::sqrt(2.0 * static_cast<double>(problem_.trajectory_runs.size()));
  found.p_after = p_value_;
  found.parameters = assumed().as_assumed;
  found.refitted = found.explains = true;
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
  result.identifiability = identifiability(unknowns_, values_, uncertainty_, result.parameters);
  result.scatter_dominates = rejected() && result.scatter > kScatterShare * problem_.typical_displacement();
  if (result.scatter_dominates)
    result.warnings.push_back(
        "The runs scatter about the model by " + number(1e3 * result.scatter, 2) +
        " mm per axis, more than a tenth of their typical displacement: they do not follow it.");
  if (lag_taken_as_zero(problem_))
    result.warnings.push_back(
        "phase_lag_rad is not fitted and taken as 0: add it to [fit] parameters, or give it in [fit.fixed].");
  result.agreement = agreement(result);
  fill_runs(residuals_, best, result);
  fill_influence(residuals_, best, uncertainty_, result);
  fill_predictions(residuals_, best, uncertainty_, result);
  fill_mu_of_speed(unknowns_, values_, uncertainty_, result);
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

/// A slide by itself, without the checks and profiles of a whole campaign.
FitResult fit_alone(const Problem& problem, const FitOptions& options, bool scatter) {
  FitOptions quick;
  quick.multi_starts = 1;
  quick.profiles = quick.next_experiment = false;
  quick.estimate_scatter = options.estimate_scatter && scatter;
  Estimation fit(problem, quick);
  fit.find_minimum();
  fit.test_residuals();
  fit.explain_excess_variance();
  fit.quantify_uncertainty();
  return fit.estimates();
}

}  // namespace

void FitOptions::validate() const {
  const auto at_least = [](const char* name, int value, int least) {
    if (value < least)
      throw std::invalid_argument(std::string("FitOptions::") + name + " = " + std::to_string(value) +
                                  " must be at least " + std::to_string(least));
  };
  at_least("threads", threads, 1);
  at_least("multi_starts", multi_starts, 1);
  at_least("bootstrap", bootstrap, 0);
}

namespace {

/// Every stage of a fit, the explanations apart.
FitResult quantified(Estimation& fit) {
  fit.explain_excess_variance();
  fit.quantify_uncertainty();
  return fit.report();
}

void set_course(Problem& problem) {
  const auto runs = static_cast<double>(problem.summary_runs.size() + problem.trajectory_runs.size());
  double place = 0;
  const auto next = [&] { return runs > 1 ? place++ / (runs - 1) - 0.5 : 0; };
  for (SummaryRun& run : problem.summary_runs) run.course = next();
  for (TrajectoryRun& run : problem.trajectory_runs) run.course = next();
}

struct Explained {
  std::vector<ExplainedProblem> list;
  std::optional<Quoted> quoted;
};

/// What explains the residuals, and from where fits under explanations ended the minimum once more, where
/// that is lower.
Explained explain(const Problem& problem, Estimation& fit, const FitOptions& options) {
  Explained result;
  const bool squares = options.loss == Loss::squares;  // robust weights are an answer of their own
  constexpr int kMostTimes = 2;
  bool again = true;
  for (int k = 0; again && k < kMostTimes; ++k) {
    std::vector<Eigen::VectorXd> ends;
    result = {fit.explanations(), std::nullopt};
    for (const ExplainedProblem& explanation : result.list)
      if (explanation.values.size() > 0) ends.push_back(explanation.values);
    if (fit.rejected() && squares)
      result.quoted = explained(problem, fit.chi2(), result.list, fit.outliers(), [&](const Problem& next) {
        Estimation there(next, options);
        there.find_minimum();
        ends.push_back(there.values_for(fit));
        const FitResult assumed = there.assumed();
        return Refit{assumed.chi2, assumed.p_value, assumed.as_assumed,
                     assumed.p_value > kExplained ? std::vector<ExplainedProblem>{} : there.explanations()};
      });
    again = k + 1 < kMostTimes && fit.rejected() && fit.lower_from(ends);
  }
  return result;
}

/// Of driven tracks that reject the model: runs that contradict the others, and friction that differs from
/// run to run. Either takes the minimum with it. Bad runs show in displacements, to a usual scatter; how much
/// friction differs the points of each run tell. Nothing where they reject the model still.
Explained explain_tracks(const Problem& problem, const Estimation& fit, const FitOptions& options) {
  constexpr double kUsual = 0.05;  ///< of friction, from run to run
  if (!problem.has_driven_tracks() || !fit.rejected()) return {};
  Quoted under{problem, {}, {}};
  const auto with_scatter = [&](double relative) {
    return with_run_scatter(under.problem, relative, fit.roughly(FitParameter::mu1),
                            fit.roughly(FitParameter::mu2));
  };
  const Problem ends = by_displacements(with_scatter(kUsual));
  Estimation by_ends(ends, options);
  by_ends.find_minimum();
  by_ends.test_residuals();
  Explained result = explain(ends, by_ends, options);
  std::erase_if(result.list,
                [](const ExplainedProblem& e) { return !(e.found.name == "bad_run" && e.found.explains); });
  std::vector<TrajectoryRun>& tracks = under.problem.trajectory_runs;
  if (result.quoted)
    for (const SummaryRun& run : result.quoted->problem.summary_runs)
      if (run.held_out &&
          std::erase_if(tracks, [&](const auto& track) { return track.name == run.name; }) > 0) {
        under.problem.summary_runs.push_back(run);
        under.under.push_back("run '" + run.name + "' left out: it contradicts the others");
      }
  result.quoted.reset();
  if (tracks.size() < problem.trajectory_runs.size()) {
    Estimation others(under.problem, options);
    others.find_minimum();
    others.test_residuals();
    if (!others.rejected()) {
      under.problem.start = others.estimates_alone();
      result.quoted = std::move(under);
      return result;
    }
  }
  const Problem wide = with_scatter(kUsual);
  Estimation apart(wide, options);
  apart.find_minimum();
  apart.test_residuals();
  if (apart.rejected()) return {};
  under.problem = with_scatter(apart.scatter_of_friction());
  under.problem.start = apart.estimates_alone();
  Explanation scatter = apart.scatter_explained(fit);
  under.under.push_back(sentence_of(scatter));
  result.list.push_back({std::move(scatter), {}, {}});
  result.quoted = std::move(under);
  return result;
}

}  // namespace

FitResult estimate(const Problem& given, const FitOptions& wanted) {
  wanted.validate();
  given.validate();
  FitOptions options = wanted;
  if (given.summary_runs.empty()) options.loss = Loss::squares;
  Problem problem = given;
  set_course(problem);
  std::vector<SlideResult> slides = prepare_slides(problem);
  const FitAlone alone = [&](const Problem& one, bool scatter) { return fit_alone(one, options, scatter); };
  fit_one_by_one(problem, alone, options.threads, slides);
  std::optional<BetweenSlides> between = compare_slides(problem, slides);
  if (between && problem.between_slides == 0) problem.between_slides = between->sd;
  std::optional<ViscousSlides> viscous;
  if (between) viscous = fit_viscous(problem, alone, options.threads, slides);
  if (viscous) problem.between_viscous_slides = {viscous->mu1.sd, viscous->viscous.sd};

  Estimation fit(problem, options, between ? &*between : nullptr);
  fit.find_minimum();
  fit.test_residuals();
  auto [list, quoted] = explain_tracks(problem, fit, options);
  if (!quoted) {
    Explained all = explain(problem, fit, options);
    list.insert(list.end(), std::make_move_iterator(all.list.begin()),
                std::make_move_iterator(all.list.end()));
    quoted = std::move(all.quoted);
  }
  FitOptions nearby;
  std::optional<Estimation> under;
  FitResult result;
  if (quoted) {
    const FitResult assumed = fit.assumed();
    nearby = options;  // the explanation was found from the best minimum of all
    nearby.multi_starts = std::min(options.multi_starts, kStartsNearby);
    if (viscous && quoted->problem.sets_free(FitParameter::viscous)) {
      slides = viscous->slides;
      between = viscous->mu1;
    }
    under.emplace(quoted->problem, nearby, between ? &*between : nullptr);
    under->find_minimum();
    under->test_residuals();
    result = quantified(*under);
    result.chi2 = assumed.chi2;
    result.dof = assumed.dof;
    result.p_value = assumed.p_value;
    result.outliers = assumed.outliers;
    for (const Outlier& outlier : result.outliers) result.warnings.push_back(outlier.sentence);
    result.as_assumed = assumed.as_assumed;
    result.quoted_under = quoted->under;
    result.agreement = agreement(result);
    widen(quoted->as_good, result);
  } else {
    result = quantified(fit);
  }
  for (const ExplainedProblem& explanation : list) result.explanations.push_back(explanation.found);
  result.slides = std::move(slides);
  describe_slides(between ? &*between : nullptr, result);
  judge(result);
  (under ? *under : fit).look_ahead(result);
  return result;
}

}  // namespace tribotrack::fit
