// The result of a fit: estimates, intervals, residuals of every run, and what the data cannot determine.
//
//   const FitResult result = estimate(problem);
//   if (!result.usable()) std::puts(result.identifiability.weak_directions.front().c_str());
//   if (result.agreement == Agreement::poor) ...;  // the model misses the data
//   const ParameterEstimate& mu1 = result.parameters[0];  // in the order of Problem::free
//   std::printf("mu1 = %g +- %g, 95 %% from %g to %g\n", mu1.estimate, mu1.sd, mu1.ci95.low, mu1.ci95.high);
//   std::puts(result.full_report().c_str());
//
// All numbers are SI unless a name carries a unit.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <limits>
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

/// A value at which a parameter was held while all others were fitted again.
struct ProfilePoint {
  double value = 0;  ///< SI
  double rise = 0;   ///< of chi^2 above its minimum
};

struct ParameterEstimate {
  FitParameter parameter = FitParameter::mu1;
  double estimate = 0;
  /// From C = (J'J)^-1, J the whitened sensitivity d r/d theta at the minimum; infinite, as
  /// `covariance_ci95`, for a parameter that a flat direction moves.
  double sd = 0;
  /// The interval to quote: the profile's where one of its ends differs from the covariance's by more than a
  /// tenth of that one's half width, or it has two pieces; else the covariance's.
  Interval ci95;
  /// Two or more where values between are excluded, else one; `ci95` reaches from the first to the last.
  std::vector<Interval> ci95_pieces;
  /// estimate -+ t sd with t = 1.96, or Student's t where a variance was estimated from the residuals. On the
  /// axis of the logarithm for mu1, A, w and scale, for mu2 too while sd < 0.3 mu2; else linear and cut at 0.
  Interval covariance_ci95;
  /// Where the profile likelihood, the minimum of chi^2 over all other parameters, is within t^2 of its
  /// minimum, over all minima: the reference where the likelihood is no parabola. Infinite where open, 0
  /// where mu is compatible with 0, NaN where not computed (FitOptions::profiles).
  Interval profile_ci95;
  std::vector<ProfilePoint> profile;  ///< its points, ascending; for figures
  double profile_level = 0;           ///< t^2, the rise at its ends
  /// 2.5 and 97.5 % points of refits to simulated data. NaN without FitOptions::bootstrap.
  Interval bootstrap_ci95;
};

/// One observable of one run.
struct Residual {
  std::string observable;  ///< "dx_mm", "dy_mm", "alpha_rad", "v_mm_s", ...
  double measured = 0;     ///< in the unit of the name
  double modelled = 0;
  double sd = 0;
  double standardised = 0;  ///< whitened where the observables of a run are correlated
};

struct RunResult {
  std::string name;
  model::Scenario fitted;  ///< the run's scenario at the fitted values, for curves
  std::vector<Residual> residuals;
  /// Change of each parameter (FitResult::parameters) without this run, in its sd, to first order. NaN where
  /// the other runs do not determine it.
  std::vector<double> influence;
  /// Of a run that was held out: prediction and measurement compared, by the covariance of both.
  struct Prediction {
    double chi2 = 0;     ///< of two degrees of freedom
    double p_value = 1;  ///< of it
  };
  std::optional<Prediction> prediction = std::nullopt;
  std::size_t points = 0;  ///< trajectory runs: points used
  double rms_m = 0;        ///< trajectory runs: rms of the residual, m
  /// Trajectory runs: start point, initial velocity, onset, ... with units in the names.
  std::map<std::string, double> nuisance;
  /// Free slides, one entry per point used: distance along the initial velocity from the fitted start point.
  struct Slide {
    std::vector<double> time;      ///< s, the recording's
    std::vector<double> measured;  ///< m
    std::vector<double> modelled;  ///< m
    std::string sentence;          ///< initial speed and residual
  } slide;
};

enum class Verdict { identifiable, weak, not_identifiable };

struct Identifiability {
  Verdict verdict = Verdict::identifiable;
  /// Sentences with figures: "mu1 up 1 % is hidden by phase_lag_rad down 0.021".
  std::vector<std::string> weak_directions;
  std::vector<double> singular_values;  ///< of the whitened sensitivity, parameters scaled by their own size
};

/// Does the model describe the data?
enum class Agreement {
  good,               ///< chi^2 is what chance allows, p >= 0.001
  only_with_scatter,  ///< p < 0.001 by the data's own sigma; chi^2 agrees by the scatter that was added
  poor,               ///< p < 0.001 and nothing added: the model misses the data
  too_good,           ///< chi^2/dof below the 0.5 % point: the stated sigmas are too large
  unknown             ///< no more data than unknowns: nothing checks the model
};

const char* to_string(Agreement agreement);  ///< "good", "only with scatter", "poor", "too good", "unknown"

/// The 99 % range of chi^2/dof under the model. Zeros for dof < 1. `noise_dof` as FitResult::noise_dof.
Interval expected_reduced_chi2(int dof, double noise_dof = std::numeric_limits<double>::infinity());

/// The run that would shrink the intervals most.
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
  double chance = 1;                     ///< that the largest of so many runs is as far off
  std::optional<double> looks_like_phi;  ///< rad; if a wrong phi alone explains it
  std::string sentence;
};

/// A parameter under an explanation.
struct EstimateUnder {
  double estimate = 0;
  double sd = 0;
  Interval ci95;
};

/// Something that the fit takes as exact and that may explain its residuals (fit/checks/explanations.h).
struct Explanation {
  /// tilt, amplitude, amplitude_ratio, phase_shift, clock, scale, start_phase: conditions; stribeck, viscous,
  /// mu2_speed, mu2_width, gate_edges, static_friction, wear: laws of friction; unseen_spin of slides;
  /// bad_run, run_scatter.
  std::string name;
  std::string run;       ///< of bad_run
  double chi2_fall = 0;  ///< with it free; 0 if it would have to be negative
  int dof = 1;           ///< of it
  double p_after = 0;    ///< of the remaining chi^2
  double size = 0, size_sd = 0;
  std::string unit;       ///< of both
  bool refitted = false;  ///< else to first order
  bool explains = false;  ///< with it the data agree with the model, without it they do not
  std::map<FitParameter, EstimateUnder> parameters;  ///< under it
};

/// Friction at a speed, by the law that is quoted.
struct FrictionAtSpeed {
  double speed = 0;  ///< m/s
  double mu = 0, sd = 0;
};

/// What may be done with the estimates.
enum class Use { use, care, do_not_use };

const char* to_string(Use use);  ///< "use", "care", "do_not_use"

/// A source of uncertainty and its contribution to each parameter (JCGM 100:2008, sections 5 and 8). The
/// squares of all included contributions to a parameter add up to the square of its sd.
struct BudgetEntry {
  std::string source;    ///< "tracking noise", "platform's amplitude", ...
  std::string quantity;  ///< name with unit of what has the sd, as in campaigns; empty for data
  double sd = 0;         ///< of that, SI; an assumed error if it was taken as exact
  std::string from;      ///< where value and sd came from
  bool counted =
      true;  ///< false: taken as exact, or compared only; then the contribution is what it would add
  Eigen::VectorXd contribution;  ///< of each parameter, SI: |sensitivity| sd
  Eigen::VectorXd sensitivity;   ///< d parameter / d quantity, SI; empty for data
};

/// Influence of a displacement that is s sigma off: s with squares, at most 2 with Huber's loss.
enum class Loss { squares, huber };

/// A minimum of chi^2.
struct OneMinimum {
  std::map<FitParameter, double> values;  ///< of the fitted parameters
  double chi2_above = 0;                  ///< rise above the best one's, in units of chi^2/dof there
  std::string sentence;                   ///< empty for the best
};

/// Correlated errors of neighbouring points of a driven track, one size for all runs of a fit: standard
/// deviations per axis, m, estimated from the residuals beside the points' own noise (restricted maximum
/// likelihood). 0 where the residuals show none.
struct CorrelatedErrors {
  double drift = 0;      ///< of a straight drift over `time`
  double walk = 0;       ///< of a Brownian walk over `time`
  double circle = 0;     ///< of each of cos wt and sin wt
  double overtones = 0;  ///< of each of cos and sin of 2wt and 3wt
  double time = 0;       ///< s, of the longest run; 0 where no driven track was fitted
  bool any() const { return drift > 0 || walk > 0 || circle > 0 || overtones > 0; }
};

/// A blow or collision seen in the track of a free slide.
struct Blow {
  std::int64_t frame = 0;                    ///< the first one after it
  double time = 0;                           ///< s
  double speed_before = 0, speed_after = 0;  ///< m/s
  double jump = 0;                           ///< m/s, length of the change of velocity
};

/// A free slide by itself: its own mu1, regardless of the other runs.
struct SlideResult {
  std::string run;
  Estimate mu1;     ///< without the scale's error, which all slides share
  Interval ci95;    ///< Student's t; of this slide alone
  double chi2 = 0;  ///< with the data's own sigma
  int dof = 0;
  double p_value = 1;  ///< of chi2
  double scatter = 0;  ///< m per axis, added because chi2 is larger than chance allows
  /// Where neighbouring residuals are more alike than the track tells: what they show, in place of its
  /// errors.
  std::optional<SlowError> shown_slow = std::nullopt;
  std::size_t points = 0;  ///< used
  std::int64_t first_frame = 0, last_frame = 0;
  double speed = 0;      ///< m/s at the first point
  double slope = 0;      ///< rad, as given (TrajectoryRun::slope)
  double stop_time = 0;  ///< s, the recording's; where the track ends before, of the law; may be infinite
  bool spin_seen = false;
  Estimate spin;  ///< rad/s at the first point
  /// 1/s: its own, where the slides are quoted under that law.
  std::optional<Estimate> viscous = std::nullopt;
  Estimate spin_ratio;  ///< rim speed over slide speed there
  Estimate bearing;     ///< radius of the face that bears over the part's, where the spin shows it
  /// Where no spin was seen: relative change of mu1 if the rim moved half as fast as the part slides.
  double change_by_half_spin = 0;
  std::vector<Blow> blows;  ///< strikes from rest left out
  std::string sentence;
};

struct FitResult {
  // The estimates.
  std::vector<ParameterEstimate> parameters;  ///< in the order of Problem::free
  Eigen::MatrixXd covariance;                 ///< SI, in that order
  Eigen::MatrixXd correlation;
  std::string covariance_meaning;              ///< which errors the covariance includes, a sentence
  double value(FitParameter parameter) const;  ///< throws DataError for one that was not fitted

  // Can they be used?
  bool converged = false;
  Identifiability identifiability;
  Agreement agreement = Agreement::unknown;
  Use verdict = Use::do_not_use;  ///< of all that follows (fit/checks/verdict.h)
  std::vector<std::string> verdict_reasons;
  std::vector<std::string> contradicted_priors;  ///< of parameters: what the data alone say; not in fit.json
  bool mistyped = false;                         ///< FitOptions::mistyped said so; not in fit.json
  std::vector<std::string> warnings;
  /// The scatter beyond the data's own sigma exceeds a tenth of the median displacement: the model does not
  /// describe the runs.
  bool scatter_dominates = false;
  bool usable() const { return verdict != Use::do_not_use; }

  // Goodness of fit.
  double chi2 = 0;  ///< at the minimum, everything as the problem says, by the data's own sigma
  int dof = 0;
  /// Degrees of freedom of the sds that chi2 rests on, where tracks' sds were estimated from their own
  /// scatter; infinite where they are known.
  double noise_dof = std::numeric_limits<double>::infinity();
  double p_value = 1;  ///< of chi2
  int conditions = 0;  ///< unknowns with a prior: dof does not include them
  std::vector<RunResult> runs;
  std::vector<SlideResult> slides;  ///< free slides one by one
  struct BetweenSlides {
    double sd = 0;       ///< of mu1 between slides, counted in the covariance
    double p_value = 1;  ///< of that scatter by chance
  } between_slides;
  std::vector<Outlier> outliers;  ///< farthest first
  /// What would explain the residuals, best first.
  std::vector<Explanation> explanations;
  /// Names of the explanations under which `parameters` are estimated; empty: everything is as the problem
  /// says.
  std::vector<std::string> quoted_under;
  std::map<FitParameter, EstimateUnder> as_assumed;  ///< where they are: without them
  /// Where a law that depends on speed is among them, or the data show one: mu1 from rest to the highest
  /// speed seen.
  std::vector<FrictionAtSpeed> mu_of_speed;
  std::vector<std::string> left_out;  ///< checks that were skipped, with the reason

  // Errors beyond the data's own sigma, included in the covariance.
  double scatter = 0;                    ///< m, added in quadrature per axis; 0 where the residuals show none
  double scatter_between_runs = 0;       ///< m, of it between summary runs
  bool scatter_from_replicates = false;  ///< estimated from repeated runs: p_value still judges the model
  int replicate_dof = 0;                 ///< two for each repetition
  CorrelatedErrors correlated_errors;
  Loss loss = Loss::squares;
  std::vector<BudgetEntry> budget;  ///< counted sources first, largest first
  std::string improve_first;        ///< a sentence: what to do about the largest
  /// Root of the sum of squares of the contributions from one place (BudgetEntry::from), by parameter.
  Eigen::VectorXd sd_from(const std::string& place) const;
  /// Whether the possible effect of compression on the platform's motion exceeds the interval of a
  /// parameter without it.
  bool coder_exceeds_interval() const;
  /// What was taken as exact, a sentence each: "gravity is taken as exact; with 1 % more of it: mu1 down 1
  /// %".
  std::vector<std::string> systematics;

  // The search for the minimum.
  std::vector<OneMinimum> minima;  ///< all within chi^2 9 of the best, which is the first
  int starts_screened = 0;         ///< points of the box evaluated
  int starts = 0;                  ///< descents made
  int starts_at_best = 0;          ///< of them, those that ended in the reported minimum
  struct Refits {
    int refits = 0;  ///< that converged
    unsigned seed = 0;
  } bootstrap;

  // What to measure next.
  std::optional<NextExperiment> next_experiment;
  /// The best run for each parameter alone, and, where it helps much more, the best with another A or w.
  std::vector<NextExperiment> other_next_experiments;

  std::string verdict_text() const;  ///< verdict and reasons, a sentence
  std::string brief_report() const;  ///< one line
  std::string full_report() const;   ///< as `tribotrack fit` prints it
};

}  // namespace tribotrack::fit
