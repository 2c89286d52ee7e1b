// Integrating the friction model: one trajectory, its dense output and its derivatives.
//
// Eq. (5) is solved between its events, not by steps that run over them: the switches of mu are hit exactly,
// slip and stick are separate states with exact stops and releases, and friction is never regularised. The
// end of 20 cycles is good to some 1e-16 m. Derivatives by up to 16 parameters are carried along (dual
// numbers, jumps at events included); they exist wherever the motion depends smoothly on the parameter.
//   IntegrationOptions options;
//   options.derivatives = {Parameter::mu1, Parameter::lag};
//   const Trajectory run = integrate(scenario, options);
//   const Eigen::Vector2d half_way = run.at(0.5 * run.end_time()).position;   // m
//   const Eigen::Matrix2Xd slopes = run.sensitive_end().position_jacobian;    // d(end)/d(mu1), d(end)/d(lag)
#pragma once

#include <Eigen/Core>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "model/scenario.h"

namespace tribotrack::model {

enum class State { slip, stick };

/// The motion of the part relative to the platform at one time. m, m/s, m/s^2.
struct Sample {
  double time = 0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();
  Eigen::Vector2d acceleration = Eigen::Vector2d::Zero();
  double angle = 0;  ///< rad turned since the start; 0 for a run without spin
  double spin = 0;   ///< rad/s
  double mu = 0;
  State state = State::slip;
};

/// Derivatives of x and y, a column for each parameter: at most 16, so that no sample allocates memory.
using Columns = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::ColMajor, 2, 16>;

/// A sample with its derivatives: column j is d/d(parameters[j]), SI. Where a pulse's edge lies on a start
/// from rest, which is a kink, they are those of a later edge.
struct SensitiveSample {
  Sample sample;
  Columns position_jacobian;
  Columns velocity_jacobian;
  Eigen::RowVectorXd angle_jacobian;  ///< empty for a run without spin
};

struct IntegrationOptions {
  /// Local error per step, relative to the motion's own scale. Smaller is slower only slowly: the order grows
  /// with it. Default near machine precision because that is cheap.
  double tolerance = 1e-16;
  /// Parameters to differentiate by, in the order of the Jacobians' columns. Empty: plain run.
  std::vector<Parameter> derivatives;
  /// Keep what `at` needs. Without it only the end is known (at() before the end throws std::logic_error),
  /// and a run is several times as fast.
  bool dense = true;
  /// Once a cycle begins as the one before did, within the tolerance, add its displacement instead of
  /// integrating its copies. Off: every cycle is integrated.
  bool reuse_repeating_cycles = true;
  /// More steps than this is an error (StepLimitExceeded), never a silent stop. The search for a periodic
  /// start may take as many.
  long max_steps = 10'000'000;
};

/// What the integration did.
struct IntegrationSummary {
  long steps = 0;         ///< arcs and Taylor steps, all machinery counted
  int stops = 0;          ///< slip -> stick transitions
  int releases = 0;       ///< stick -> slip transitions, a start from rest not counted
  double stick_time = 0;  ///< s
  double sticking_fraction = 0;
  std::string brief_report() const;
};

/// A solved run. Immutable, cheap to sample, safe to read from several threads.
class Trajectory {
 public:
  const Scenario& scenario() const;
  const IntegrationSummary& summary() const;
  double end_time() const { return scenario().end_time(); }
  Sample at(double time) const;  ///< dense output, 0 <= time <= end_time()
  SensitiveSample sensitive_at(
      double time) const;  ///< at a fixed time; needs IntegrationOptions::derivatives
  /// Columns: positions at `times`, m; with `jacobian` rows 2 k and 2 k + 1 of it are those of time k by the
  /// derivatives' parameters, at a fixed time. With `exposure` T the means over t - T/2 .. t + T/2 to second
  /// order, x + T^2/24 x'' (off by (wT)^4/1920 of the amplitude where no friction switches, by T^2/48 of the
  /// jump of x'' at most where it does); the Jacobian stays that of x, of which this share is (wT)^2/24.
  void positions_at(const std::vector<double>& times, double exposure, Eigen::Matrix2Xd& positions,
                    Eigen::MatrixXd* jacobian) const;
  Sample end() const { return at(end_time()); }
  /// At the end. If the end is N whole cycles (Scenario::duration == 0) the end time moves with w and the
  /// column of angular_frequency holds that, too: dx/dw = s_x + u dT/dw.
  SensitiveSample sensitive_end() const;

  struct Implementation;
  explicit Trajectory(std::shared_ptr<const Implementation> implementation);

 private:
  std::shared_ptr<const Implementation> implementation_;
};

/// The motion was not followed to its end within IntegrationOptions::max_steps.
class StepLimitExceeded : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Integrates a scenario; a part that spins is followed where Scenario::spin says so or Parameter::spin is
/// among the derivatives, likewise viscous friction (tolerance 1e-13 at best, the end is good to some 1e-12
/// of the way). Throws InvalidParameter for a bad scenario, a tolerance outside (0, 0.1), more than 16
/// derivatives or a start on a periodic motion that does not exist, and StepLimitExceeded beyond max_steps.
Trajectory integrate(const Scenario& scenario, const IntegrationOptions& options = {});

}  // namespace tribotrack::model
