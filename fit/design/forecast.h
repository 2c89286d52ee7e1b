// The information that a run not yet filmed would add.
#pragma once

#include <optional>

#include "fit/residuals/residuals.h"

namespace tribotrack::fit::internal {

/// A run that could be filmed.
struct Candidate {
  double phi = 0, dtau = 0;                     ///< rad
  double amplitude = 0, angular_frequency = 0;  ///< m, rad/s, of the first driven run's kind
};

/// What it would add to the information on what all runs share, in natural units: J'J of its whitened
/// sensitivity.
struct Forecast {
  Candidate candidate;
  Eigen::MatrixXd information;  ///< empty: none, or unknown
  long steps = 0;               ///< of the integration
  bool empty() const { return information.size() == 0; }
};

/// Forecasts with the start, length and kind of the runs so far (displacements or whole tracks, whichever are
/// more) and an error like theirs. A displacement's error is that of the run whose displacement is nearest in
/// length, growing with the length as it does among them; a track has as many points per cycle as the first,
/// its scatter, correlation and correlated errors, and a start point and phase of its own.
class Forecaster {
 public:
  /// Refers to the residuals, which must outlive it.
  Forecaster(const Residuals& residuals, const Eigen::VectorXd& values);
  Forecaster(const Residuals&& residuals, const Eigen::VectorXd& values) = delete;
  Candidate drive_so_far() const;
  /// Empty where the model cannot be evaluated, takes more than 50 times the steps of the longest of the
  /// runs so far, or where nothing fitted moves the run.
  Forecast forecast(const Candidate& candidate, double tolerance) const;

 private:
  double variance(const Eigen::Vector2d& displacement) const;
  model::Scenario scenario(const Candidate& candidate) const;
  void of_displacement(const model::Scenario& scenario, double tolerance, Forecast& forecast) const;
  void of_track(const model::Scenario& scenario, double tolerance, Forecast& forecast) const;

  const Residuals& residuals_;
  Eigen::VectorXd values_, units_;
  model::Scenario base_;
  bool amplitude_from_track_ = false;
  std::optional<std::size_t> track_;  ///< the trajectory run it is like; else like the summary runs
  double sd_ = 0, length_ = 1, power_ = 0;
  long most_steps_ = 0;
};

}  // namespace tribotrack::fit::internal
