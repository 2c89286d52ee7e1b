// Simulated campaigns of every kind that is filmed, with known truth: what intervals are judged on.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "fit/problem.h"

namespace tribotrack::bench {

/// How a campaign is laid out. Displacements after 20 cycles from rest unless it says otherwise.
enum class Design {
  both_sweeps,          ///< 8 values of phi at one dtau, 6 values of dtau at one phi
  phi_only,             ///< 8 values of phi at one dtau
  three_runs,           ///< phi and dtau at random
  five_runs,            ///< likewise
  eight_runs,           ///< likewise
  repeats,              ///< four settings at random, three times each
  tilt_unknown,         ///< both sweeps on a platform tilted by 0.1 deg sd per axis, which is fitted
  conditions_measured,  ///< both sweeps; A and w measured: each known to an sd, the same in all runs
  sticking_with_tilt,   ///< as tilt_unknown with mu1 g above A w^2: it rests between the pulses
  slides,               ///< three to eight free slides, filmed at 240 Hz, each with a mu1 of its own
  trajectories          ///< four short runs at random, point by point, with errors that neighbours share
};
inline constexpr std::array kDesigns{
    Design::both_sweeps,        Design::phi_only, Design::three_runs,   Design::five_runs,
    Design::eight_runs,         Design::repeats,  Design::tilt_unknown, Design::conditions_measured,
    Design::sticking_with_tilt, Design::slides,   Design::trajectories};
const char* to_string(Design design);

/// Of displacements: 1 deg and 2 %, or 2.9 deg and 5.7 %. Slides: 20 or 60 um a point, mu1 scattering by 1 or
/// 4 %. Trajectories: 1 to 4 um or 4 to 16 um a point, slow errors of 2 to 10 or 8 to 40 um. A and w: 1 % and
/// 0.1 %, or 3 % and 0.3 %.
enum class NoiseLevel { low, high };
inline constexpr std::array kNoiseLevels{NoiseLevel::low, NoiseLevel::high};
const char* to_string(NoiseLevel level);

/// One campaign. Its problem holds nothing of the truth: no first guesses, other values in the scenarios.
struct CoverageCampaign {
  fit::Problem problem;
  std::vector<double> truth;  ///< in the order of problem.free, SI
  /// Standard deviations that no unbiased estimate falls below (Cramer and Rao), at the truth: the unit in
  /// which intervals are wide or narrow.
  std::vector<double> bound;
};

/// mu1 from 0.05 to 0.16 (above the threshold where it is to stick), mu1/mu2 from 4 to 12, the lag +-0.5.
/// Displacements and tracks by a segmented Dormand-Prince integrator (peers/baselines.h), slides by their
/// parabola: neither shares anything with what fits. Where friction is less than 2 % below the drive, that
/// integrator does not get away from rest: such truths are drawn anew. Depends on the arguments alone.
CoverageCampaign draw_campaign(Design design, NoiseLevel level, std::uint64_t seed, int index);

/// Displacements of `runs` runs, phi and dtau at random, as of Design::five_runs: for the search's test.
CoverageCampaign draw_random_runs(int runs, NoiseLevel level, std::uint64_t seed, int index);

/// The generator of one campaign.
class Dice {
 public:
  Dice(std::uint64_t seed, std::uint32_t what, int index) {
    std::seed_seq mixed{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32), what,
                        static_cast<std::uint32_t>(index)};
    random_.seed(mixed);
  }
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double log_uniform(double low, double high) { return low * std::pow(high / low, uniform(0, 1)); }
  double normal() { return normal_(random_); }
  Eigen::Vector2d normal_pair() {
    const double x = normal();
    return {x, normal()};
  }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

/// A laboratory whose truth is drawn like that of a campaign of both sweeps; it films one run after the
/// other.
class SimulatedLab {
 public:
  SimulatedLab(NoiseLevel level, std::uint64_t seed, int index);
  /// The displacement of another run after 20 cycles from rest, with an error of its own. The run's scenario
  /// holds nothing of the truth. Throws PeerHangs.
  fit::SummaryRun film(double phi, double dtau);
  double mu1() const { return truth_.friction.nominal; }

 private:
  NoiseLevel level_;
  Dice dice_;
  model::Scenario truth_;
  int runs_ = 0;
};

/// The peer's integrator did not come to an end.
struct PeerHangs {};

// Of designs_of_tracks.cpp:
CoverageCampaign draw_slides(NoiseLevel level, Dice& dice);
CoverageCampaign draw_trajectories(NoiseLevel level, const model::Scenario& truth, Dice& dice);

}  // namespace tribotrack::bench
