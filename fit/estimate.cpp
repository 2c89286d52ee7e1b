#include "fit/estimate.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <utility>

#include "fit/checks/score_tests.h"
#include "fit/checks/verdict.h"
#include "fit/report/fill_result.h"
#include "fit/slides/between_slides.h"
#include "fit/slides/one_by_one.h"
#include "fit/stages/explain.h"

namespace tribotrack::fit {

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

using namespace internal;

/// Descents under an explanation.
constexpr int kStartsNearby = 4;

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
  const bool mistyped = fit.rejected() && options.mistyped && options.mistyped(fit.assumed());
  auto [list, quoted] = mistyped ? Explained{} : explain_tracks(problem, fit, options);
  if (!quoted && !mistyped) {
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
    result.contradicted_priors = assumed.contradicted_priors;
    result.quoted_under = quoted->under;
    result.agreement = agreement(result);
    widen(quoted->as_good, result);
  } else {
    result = quantified(fit);
  }
  for (const ExplainedProblem& explanation : list) {
    result.explanations.push_back(explanation.found);
    if (explanation.found.explains && explanation.found.name == kUnseenSpin)
      result.improve_first =
          "A spin and a law of friction cannot be told apart by the path: mark the part so that its turning "
          "is seen, or start it without spin.";
  }
  result.mistyped = mistyped;
  result.slides = std::move(slides);
  describe_slides(between ? &*between : nullptr, result);
  judge(result);
  (under ? *under : fit).look_ahead(result);
  return result;
}

}  // namespace tribotrack::fit
