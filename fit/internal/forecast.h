// What a run not yet filmed would tell.
#pragma once

#include <optional>
#include <vector>

#include "fit/internal/residuals.h"

namespace tribotrack::fit::internal {

/// A run that could be filmed.
struct Candidate {
  double phi = 0, dtau = 0;                     ///< rad
  double amplitude = 0, angular_frequency = 0;  ///< m, rad/s, of the first driven run's kind
};

/// Its whitened sensitivity: two rows, by natural units.
struct Forecast {
  Candidate candidate;
  Eigen::MatrixXd rows;
  Eigen::Vector2d displacement;  ///< m
};

/// Forecasts with the start and length of the runs so far and an error like theirs: that of the run whose
/// displacement is nearest in length, growing with the length as it does among them.
class Forecaster {
 public:
  Forecaster(const Residuals& residuals, const Eigen::VectorXd& values);
  Candidate drive_so_far() const;
  /// nullopt where the model cannot be evaluated or nothing fitted moves the run.
  std::optional<Forecast> forecast(const Candidate& candidate, double tolerance) const;
  /// The same turned to another phi by the rotation law: exact for the steady drift of a circling platform
  /// without tilt, good to some degrees from rest.
  Forecast turned(const Forecast& forecast, double phi) const;

 private:
  double variance(const Eigen::Vector2d& displacement) const;

  const Residuals& residuals_;
  Eigen::VectorXd values_, units_;
  SummaryRun base_;
  double sd_ = 0, length_ = 1, power_ = 0;
  bool clockwise_ = true;
};

}  // namespace tribotrack::fit::internal
