// One fit from its start to its result, stage by stage.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "fit/checks/explanations.h"
#include "fit/checks/run_scatter.h"
#include "fit/estimate.h"
#include "fit/minimum/multi_start.h"
#include "fit/slides/between_slides.h"
#include "fit/tools/thresholds.h"
#include "fit/uncertainty/covariance.h"
#include "fit/uncertainty/profile.h"
#include "fit/variances/excess_variance.h"

namespace tribotrack::fit::internal {

/// A fit from its start to its result; the members are called in their order.
class Estimation {
 public:
  /// `slides`: how the slides' mu1 differ; null where they do not count as a sample.
  Estimation(const Problem& problem, const FitOptions& options, const BetweenSlides* slides = nullptr);
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
  /// Where this fit ended, and the descents of its search.
  std::vector<Eigen::VectorXd> ends() const;
  /// By chance in one of a thousand; the scatter of repeated runs is none of the model's.
  bool rejected() const { return p_value_ < kSurprise; }
  /// What points deviate by may be errors of tracking.
  bool by_tracking() const { return minimum_.chi2 < kMostOfTracking * result_.dof; }
  double chi2() const { return minimum_.chi2; }
  int degrees_of_freedom() const { return result_.dof; }
  /// The summary run without which chi^2 falls most, to first order, and by how much.
  std::pair<std::size_t, double> worst() const;
  const Unknowns& unknowns() const { return unknowns_; }
  Eigen::VectorXd values() const { return unknowns_.values(minimum_.z); }
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
  /// Friction that differs from run to run, by the residuals of displacements at these values. It explains
  /// them unless they go with the setting, as under a law.
  std::optional<std::pair<Explanation, RunScatter>> scatter_at(const Eigen::VectorXd& values) const;
  /// Logarithm of the restricted likelihood of tracks near these values, errors that neighbouring points
  /// share being as large as is likeliest (CorrelatedEstimate).
  double log_likelihood(const Eigen::VectorXd& values) const;
  /// `found`, which this fit counts, with what it makes of the residuals of another fit to the same runs.
  Explanation as_explanation(Explanation found, const Estimation& of) const;
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
  std::vector<std::string> contradicted_priors(const Eigen::VectorXd& values,
                                               const Eigen::MatrixXd& covariance) const;

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

}  // namespace tribotrack::fit::internal
