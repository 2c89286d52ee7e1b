// What a fit finds: estimates, intervals, residuals of every run, and what the data cannot tell.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "fit/problem.h"

namespace tribotrack::fit {

struct Interval {
  double low = 0;  ///< -infinity / +infinity where open
  double high = 0;
};

struct ParameterEstimate {
  FitParameter parameter = FitParameter::mu1;
  double estimate = 0;
  double sd = 0;
  /// From the covariance; Student's t where a scatter or slow errors were estimated. For mu1, A, w and scale
  /// on the axis of their logarithm, for mu2 too while sd < 0.3 mu2, else linear and cut at 0. sd and
  /// interval are infinite for a parameter that a flat direction moves.
  Interval ci95;
  /// From the profile likelihood, re-optimised at every point; infinite where open, 0 where mu is compatible
  /// with 0. NaN when profiles were not asked for.
  Interval profile_ci95;
  /// From the parametric bootstrap: the 2.5 and 97.5 % points of refits to simulated data. NaN when it was
  /// not asked for.
  Interval bootstrap_ci95;
};

/// One observable of one run.
struct Residual {
  std::string observable;  ///< "dx_mm", "dy_mm", "alpha_rad", "v_mm_s", ...
  double measured = 0;     ///< SI unless the name carries a unit, then in that unit
  double modelled = 0;
  double sd = 0;
  double standardised = 0;  ///< whitened where the observables of a run are correlated
};

struct RunResult {
  std::string name;
  model::Scenario fitted;  ///< the run's scenario at the fitted values, for curves
  std::vector<Residual> residuals;
  std::size_t points = 0;  ///< trajectory runs: points used
  double rms_m = 0;        ///< trajectory runs: rms of the residual, m
  std::map<std::string, double>
      nuisance;  ///< trajectory runs: start point, initial velocity, onset, ... with units in the names
  /// Free slides, one entry per point used: distance along the initial velocity from the fitted start point.
  struct Slide {
    std::vector<double> time;      ///< s, the recording's
    std::vector<double> measured;  ///< m
    std::vector<double> modelled;  ///< m
  } slide;
};

enum class Verdict { identifiable, weak, not_identifiable };

struct Identifiability {
  Verdict verdict = Verdict::identifiable;
  /// Each in words with its figure: "mu1 up 1 % is hidden by phase_lag_rad down 0.021".
  std::vector<std::string> weak_directions;
  std::vector<double> singular_values;  ///< of the whitened sensitivity, parameters scaled by their own size
};

/// A run that would shrink the intervals most.
struct NextExperiment {
  double phi = 0, dtau = 0;                     ///< rad
  double amplitude = 0, angular_frequency = 0;  ///< m, rad/s
  /// The parameter whose interval it shrinks most (c-optimal); empty: the volume of all (D-optimal).
  std::optional<FitParameter> aim;
  std::map<FitParameter, double> predicted_sd;
  std::map<FitParameter, Interval> predicted_ci95;
  std::string sentence;
};

/// A run that contradicts the others.
struct Outlier {
  std::string run;
  double deviation = 0;                  ///< standard deviations from the fit to the others (studentised)
  double chance = 1;                     ///< that the largest of so many runs lies as far
  std::optional<double> looks_like_phi;  ///< rad; where a wrong phi alone explains it
  std::string sentence;
};

/// One model among those compared.
struct ModelComparison {
  std::string name;
  int parameters = 0;  ///< unknowns
  double chi2 = 0;     ///< with the data's own sigma
  /// chi^2 + 2 k and chi^2 + k ln n; with n ln(chi^2/n) for chi^2 where no model agrees with the sigmas.
  double aic = 0, bic = 0;
  std::string sentence;  ///< what it found
};

/// How strongly a far run may pull: squares fully, Huber as much as one at 2 sigma, Cauchy hardly.
enum class Loss { squares, huber, cauchy };

/// A minimum of chi^2.
struct OneMinimum {
  std::map<FitParameter, double> values;  ///< of the fitted parameters
  double chi2_above = 0;                  ///< the best one's, in units of the scatter about it
  std::string sentence;                   ///< empty for the best
};

/// Errors that many points of a driven track share, one size for all runs of a fit: standard deviations per
/// axis, m, told from the residuals beside the points' own noise (restricted maximum likelihood). 0 where the
/// residuals do not ask.
struct SlowErrors {
  double drift = 0;      ///< of a straight drift over `time`: a run's own and what all share along their ways
  double walk = 0;       ///< of a Brownian walk over `time`
  double circle = 0;     ///< of each of cos wt and sin wt
  double overtones = 0;  ///< of each of cos and sin of 2wt and 3wt
  double common_circle = 0;     ///< as circle, but one error that all runs share
  double common_overtones = 0;  ///< as overtones, likewise
  double time = 0;              ///< s, of the longest run; 0 where no driven track was fitted
  bool any() const {
    return drift > 0 || walk > 0 || circle > 0 || overtones > 0 || common_circle > 0 || common_overtones > 0;
  }
};

struct FitResult {
  std::vector<ParameterEstimate> parameters;
  Eigen::MatrixXd covariance;  ///< SI, in the order of parameters
  Eigen::MatrixXd correlation;
  double chi2 = 0;
  int dof = 0;
  bool converged = false;
  Identifiability identifiability;
  std::vector<RunResult> runs;
  std::optional<NextExperiment> next_experiment;
  /// The best run for each parameter alone, and, where it helps much more, the best with another A or w.
  std::vector<NextExperiment> other_next_experiments;
  std::vector<Outlier> outliers;  ///< farthest first
  Loss loss = Loss::squares;
  int bootstrap = 0;  ///< refits that converged
  unsigned bootstrap_seed = 0;
  double scatter = 0;  ///< m, added in quadrature per axis; 0 where the residuals did not ask for it
  /// m, between summary runs, along their displacements (v) and across (alpha): equal unless the residuals
  /// say that they differ.
  double scatter_along = 0, scatter_across = 0;
  SlowErrors slow_errors;  ///< counted in the covariance
  /// Repeated runs tell the scatter by themselves: then chi2 counts it, and p_value still judges the model.
  bool scatter_from_replicates = false;
  int replicate_dof = 0;                ///< two for each repetition
  std::string covariance_meaning;       ///< which covariance is printed, in words
  double chi2_before_scatter = 0;       ///< with the data's own sigma alone
  double p_value = 1;                   ///< of chi^2 with the data's own sigma and the replicates' scatter
  std::vector<OneMinimum> minima;       ///< all within chi-square 9 of the best, which is the first
  int starts_screened = 0;              ///< points of the box looked at
  int starts = 0;                       ///< descents made
  int starts_at_best = 0;               ///< of them, those that ended in the minimum told
  double runs_test_p_value = 1;         ///< small: neighbouring runs err alike, a wrong model
  std::vector<ModelComparison> models;  ///< the one fitted first; empty where none was compared
  std::vector<std::string> left_out;    ///< what the data did not ask for, and why
  /// How far an error in what was taken as known moves the parameters, in words: "A up 1 %: mu1 up 1.02 %".
  std::vector<std::string> systematics;
  std::vector<std::string> warnings;
  bool usable() const { return converged && identifiability.verdict != Verdict::not_identifiable; }
  double value(FitParameter parameter) const;
  std::string brief_report() const;
  std::string full_report() const;
};

}  // namespace tribotrack::fit
