// The vector of everything a fit adjusts, and how a run's scenario follows from it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "fit/problem.h"
#include "fit/residuals/transform.h"

namespace tribotrack::fit::internal {

/// A run's scenario at given values, with the chain from the model's parameters to the unknowns.
struct AppliedScenario {
  model::Scenario scenario;
  double scale = 1;
  double stretch = 1;  ///< factor on the modelled displacement: w over the w by which v became a displacement
  std::vector<model::Parameter> wanted;  ///< to differentiate by
  Eigen::MatrixXd chain;                 ///< d wanted / d unknowns
};

/// Order: the parameters of Problem::free, then the conditions, then the initial velocity (x, y) of each free
/// slide, its spin where that is seen and the deviation of its mu1 from the mean where slides differ, and the
/// shift of the platform's phase of each trajectory run whose phase has an sd,
/// and then the errors of what it alone is known by. "Values" are physical (SI),
/// "z" the optimiser's.
class Unknowns {
 public:
  /// Refers to the problem, which must outlive the unknowns.
  explicit Unknowns(const Problem& problem);
  explicit Unknowns(const Problem&& problem) = delete;

  Eigen::Index size() const { return static_cast<Eigen::Index>(transforms_.size()); }
  /// Those reported: Problem::free.
  Eigen::Index reported() const { return static_cast<Eigen::Index>(problem_->free.size()); }
  /// Reported and conditions; the rest are initial velocities and phase shifts.
  Eigen::Index common() const { return static_cast<Eigen::Index>(common_.size()); }
  FitParameter parameter(Eigen::Index i) const { return common_[static_cast<std::size_t>(i)]; }
  std::optional<Eigen::Index> find(FitParameter parameter) const;
  /// Of the velocity of trajectory run `run`, -1 where it is no free slide.
  Eigen::Index velocity_index(std::size_t run) const { return velocity_[run]; }

  /// Of the spin of trajectory run `run`, the bearing face behind it, -1 where it has none.
  Eigen::Index spin_index(std::size_t run) const { return spin_[run]; }

  /// Of the deviation of its mu1, -1 where all slides share mu1.
  Eigen::Index deviation_index(std::size_t run) const { return deviation_[run]; }

  /// Of the phase shift of trajectory run `run`, -1 where its phase is taken as exact.
  Eigen::Index phase_index(std::size_t run) const { return phase_[run]; }

  /// Of what trajectory run `run` alone is known by (TrajectoryRun::own), -1 where nothing is.
  Eigen::Index own_index(std::size_t run) const { return own_[run]; }

  Eigen::VectorXd values(const Eigen::VectorXd& z) const;
  Eigen::VectorXd z(const Eigen::VectorXd& values) const;
  Eigen::VectorXd slopes(const Eigen::VectorXd& z) const;
  const Transform& transform(Eigen::Index i) const { return transforms_[static_cast<std::size_t>(i)]; }

  /// The size against which a change of unknown i is judged: its own value for mu1, A, w and scale, 1 rad for
  /// the lag, 1/w for the delay, mu1 for a tilt (g tilt against mu1 g), its own value but at least mu1/20 for
  /// mu2, the speed for a velocity.
  Eigen::VectorXd natural_units(const Eigen::VectorXd& values) const;

  /// What is known beforehand of unknown i < common(): Problem::prior for a fitted one, the runs' own value
  /// for a condition, the sds of its independent errors in quadrature.
  std::optional<Prior> prior(Eigen::Index i) const;

  /// First guesses: Problem::start, else the prior's mean, else the scene's own scale.
  Eigen::VectorXd first_guess() const;

  /// Value of a parameter that is neither fitted nor fixed: the first run's, 0 where runs have none.
  double as_given(FitParameter parameter) const;
  /// Value of a parameter that is fitted or fixed or the run's own.
  double value_of(FitParameter parameter, const Eigen::VectorXd& values) const;
  AppliedScenario apply(const Eigen::VectorXd& values, const model::Scenario& base, bool amplitude_from_track,
                        bool derivatives) const;
  /// The run lasts as long as it was measured, whatever w is tried; given as alpha and v, it lasts its
  /// cycles.
  AppliedScenario apply_summary(const Eigen::VectorXd& values, const SummaryRun& run, bool derivatives) const;
  AppliedScenario apply_trajectory(const Eigen::VectorXd& values, std::size_t run, bool derivatives) const;
  AppliedScenario apply_free_slide(const Eigen::VectorXd& values, std::size_t run, bool derivatives) const;

  /// A w^2 / g of the first driven run: the mu up to which the part slides. nullopt when all rest.
  std::optional<double> sliding_threshold() const;
  double reference_amplitude() const { return amplitude_; }
  double reference_frequency() const { return frequency_; }
  const Problem& problem() const { return *problem_; }

 private:
  /// The scenario of a slide, chain and all, from a level platform to the slide's incline.
  void apply_slope(const Eigen::VectorXd& values, const TrajectoryRun& slide, bool derivatives,
                   AppliedScenario& applied) const;

  const Problem* problem_;
  std::vector<FitParameter> common_;
  std::vector<Transform> transforms_;
  std::vector<Eigen::Index> velocity_, spin_, deviation_, phase_, own_;
  std::vector<Eigen::Vector2d> slide_velocity_;  ///< first guesses
  std::optional<double> slide_mu_;
  double amplitude_ = 0;  ///< A of the first driven run; fitted amplitudes are those of this run
  double frequency_ = 0;
  double gravity_ = 9.81, tilt_x_ = 0, tilt_y_ = 0;
};

}  // namespace tribotrack::fit::internal
