// The vector of everything a fit adjusts, and how a run's scenario follows from it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "fit/problem.h"
#include "fit/tools/parameters.h"
#include "fit/tools/transform.h"

namespace tribotrack::fit::internal {

/// A run's scenario at given values, with the chain from the model's parameters to the unknowns.
struct AppliedScenario {
  model::Scenario scenario;
  double scale = 1;
  double stretch = 1;  ///< factor on the modelled displacement: w over the w by which v became a displacement
  std::vector<model::Parameter> wanted;  ///< to differentiate by
  Eigen::MatrixXd chain;                 ///< d wanted / d unknowns: those that all runs share, then the run's
};

/// Unknowns of one trajectory run: the initial velocity (x, y) of a free slide, its spin where that is seen
/// (rate and ln of the bearing), the deviation of its mu1 (and viscous part) from the mean where slides
/// differ; the shift of the platform's phase where that has an sd, and the errors of what the run alone is
/// known by.
enum class Nuisance { velocity, spin, deviation, phase, own };

struct NuisanceBlock {
  Nuisance kind = Nuisance::velocity;
  std::size_t run = 0;           ///< of Problem::trajectory_runs
  Eigen::Index first = 0;        ///< place in the vector of unknowns
  Eigen::VectorXd guess, scale;  ///< value = scale z
  /// L^-1 of the covariance L L' with which they are known beforehand to be the guess; empty: they are not.
  Eigen::MatrixXd known;
  Eigen::Index size() const { return guess.size(); }
};

/// A part of the vector of unknowns.
struct Range {
  Eigen::Index first = 0, count = 0;
};

/// Order: what all runs share - the parameters of Problem::free, then the conditions -, then the nuisances,
/// run by run. "Values" are physical (SI), "z" the optimiser's.
class Unknowns {
 public:
  /// Refers to the problem, which must outlive the unknowns.
  explicit Unknowns(const Problem& problem);
  explicit Unknowns(const Problem&& problem) = delete;

  Eigen::Index size() const { return static_cast<Eigen::Index>(transforms_.size()); }
  /// Those reported: Problem::free.
  Eigen::Index reported() const { return static_cast<Eigen::Index>(problem_->free.size()); }
  /// Reported and conditions.
  Eigen::Index common() const { return static_cast<Eigen::Index>(common_.size()); }
  /// The places of those.
  const std::vector<Eigen::Index>& shared() const { return shared_; }
  FitParameter parameter(Eigen::Index i) const { return common_[static_cast<std::size_t>(i)]; }
  std::optional<Eigen::Index> find(FitParameter parameter) const;

  const std::vector<NuisanceBlock>& nuisances() const { return nuisances_; }
  std::span<const NuisanceBlock> nuisances(std::size_t trajectory_run) const;
  /// Null where the run has none of the kind.
  const NuisanceBlock* find(Nuisance kind, std::size_t trajectory_run) const;
  /// All that the run has.
  Range own(std::size_t trajectory_run) const { return own_[trajectory_run]; }

  Eigen::VectorXd values(const Eigen::VectorXd& z) const { return mapped(&Transform::value, z); }
  Eigen::VectorXd z(const Eigen::VectorXd& values) const { return mapped(&Transform::z, values); }
  Eigen::VectorXd slopes(const Eigen::VectorXd& z) const { return mapped(&Transform::slope, z); }
  const Transform& transform(Eigen::Index i) const { return transforms_[static_cast<std::size_t>(i)]; }
  /// Values of a problem with the same trajectory runs, whose unknowns may be others: those it does not have
  /// are as given.
  Eigen::VectorXd values_of(const Unknowns& other, const Eigen::VectorXd& values) const;

  /// The size against which a change of unknown i is judged: its own value for mu1, A, w and scale, 1 rad for
  /// the lag, 1/w for the delay, mu1 for a tilt (g tilt against mu1 g), its own value but at least mu1/20 for
  /// mu2, the speed for a velocity.
  Eigen::VectorXd natural_units(const Eigen::VectorXd& values) const;

  /// What is known beforehand of unknown i < common(): Problem::prior for a fitted one, the runs' own value
  /// for a condition, the sds of its independent errors in quadrature.
  std::optional<Prior> prior(Eigen::Index i) const;

  /// First guesses: Problem::start, else the prior's mean, else the scene's own scale.
  Eigen::VectorXd first_guess() const;

  /// Fitted or fixed.
  bool is_known(FitParameter parameter) const {
    return find(parameter) || problem_->fixed.count(parameter) > 0;
  }
  /// Value of a parameter that is neither.
  double as_given(FitParameter parameter) const { return reference_.as_given(parameter); }
  /// Value of a parameter that is fitted or fixed or the run's own.
  double value_of(FitParameter parameter, const Eigen::VectorXd& values) const;
  /// By what all runs share.
  AppliedScenario apply(const Eigen::VectorXd& values, const model::Scenario& base, bool amplitude_from_track,
                        bool derivatives) const;
  /// The run lasts as long as it was measured, whatever w is tried; given as alpha and v, it lasts its
  /// cycles. `by`: the shared unknowns to differentiate by; the chain is 0 for the others.
  AppliedScenario apply_summary(const Eigen::VectorXd& values, const SummaryRun& run,
                                const std::vector<Eigen::Index>& by) const;
  /// Of a trajectory run, driven or a free slide.
  AppliedScenario apply_trajectory(const Eigen::VectorXd& values, std::size_t run, bool derivatives) const;

  /// A w^2 / g of the first driven run: the mu up to which the part slides. nullopt when all rest.
  std::optional<double> sliding_threshold() const;
  double reference_amplitude() const { return reference_.amplitude; }
  double reference_frequency() const { return reference_.angular_frequency; }
  /// m/s, A w; of the fastest slide where nothing is driven.
  double reference_speed() const { return speed_; }
  /// A search that strays beyond all sense (w of 1e26 rad/s) would integrate without end: with more steps
  /// than this there is no motion. Ordinary motion takes 5 to 10 a turn, along a line up to 112; a slide
  /// stops.
  long most_steps(const model::Scenario& scenario) const;
  const Problem& problem() const { return *problem_; }

 private:
  Eigen::VectorXd mapped(double (Transform::*by)(double) const, const Eigen::VectorXd& from) const;
  AppliedScenario apply_free_slide(const Eigen::VectorXd& values, std::size_t run, bool derivatives) const;

  const Problem* problem_;
  std::vector<FitParameter> common_;
  std::vector<Eigen::Index> shared_;  ///< 0, 1, ...
  Reference reference_;               ///< fitted A and w are those of this run
  std::vector<Transform> transforms_;
  std::vector<NuisanceBlock> nuisances_;  ///< run by run
  std::vector<Range> own_;                ///< of each trajectory run
  std::optional<double> slide_mu_;        ///< first guess
  double mean_width_ = 0;                 ///< rad, of the gates of all pulsed runs
  double speed_ = 0;                      ///< m/s, of reference_speed()
};

}  // namespace tribotrack::fit::internal
