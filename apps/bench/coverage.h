// Do 95 % intervals hold the truth 95 % of the time? Simulated campaigns of every kind that is filmed, with
// known truth.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "apps/bench/comparison.h"
#include "fit/fit_result.h"
#include "fit/problem.h"

namespace tribotrack::bench {

/// The generator of one simulated campaign: depends on what it is given alone.
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
  double normal() { return normal_(random_); }
  Eigen::Vector2d normal_pair() {
    const double x = normal();
    return {x, normal()};
  }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

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
  slides                ///< three to eight free slides, filmed at 240 Hz, each with a mu1 of its own
};
inline constexpr std::array kDesigns{
    Design::both_sweeps,        Design::phi_only, Design::three_runs,   Design::five_runs,
    Design::eight_runs,         Design::repeats,  Design::tilt_unknown, Design::conditions_measured,
    Design::sticking_with_tilt, Design::slides};
const char* to_string(Design design);

/// Of displacements: 1 deg and 2 %, or 2.9 deg and 5.7 %. Slides: 20 or 60 um a point, mu1 scattering by 1 or
/// 4 %. A and w: 1 % and 0.1 %, or 3 % and 0.3 %.
enum class NoiseLevel { low, high };
inline constexpr std::array kNoiseLevels{NoiseLevel::low, NoiseLevel::high};
const char* to_string(NoiseLevel level);

/// One campaign. Its problem holds nothing of the truth: no first guesses, other values in the scenarios.
struct CoverageCampaign {
  fit::Problem problem;
  std::vector<double> truth;  ///< in the order of problem.free, SI
};

/// mu1 from 0.05 to 0.16 (above the threshold where it is to stick), mu1/mu2 from 4 to 12, the lag +-0.5.
/// Displacements by a segmented Dormand-Prince integrator (peers.h), slides by their parabola: neither shares
/// anything with what fits. Where friction is less than 2 % below the drive, that integrator does not get
/// away from rest: such truths are drawn anew. Depends on the arguments alone.
CoverageCampaign draw_campaign(Design design, NoiseLevel level, std::uint64_t seed, int index);

/// Displacements of `runs` runs, phi and dtau at random, as of Design::five_runs: for the test of the fit's
/// search.
CoverageCampaign draw_random_runs(int runs, NoiseLevel level, std::uint64_t seed, int index);

/// Counts of one design, level and parameter.
struct CoverageRow {
  Design design = Design::both_sweeps;
  NoiseLevel level = NoiseLevel::low;
  std::string parameter;  ///< as in campaigns
  int campaigns = 0;
  int usable = 0;   ///< verdict identifiable or weak: those counted below
  int weak = 0;     ///< of them, with the verdict weak
  int open = 0;     ///< of them, with an interval infinite on a side, or the whole turn of a lag
  int covered = 0;  ///< of them, by the quoted interval, open ones included
  double share() const { return usable > 0 ? double(covered) / usable : 0; }
  fit::Interval share_ci95() const;  ///< Clopper and Pearson's
};

/// Fits with profiles and blind starts, as `fit` does. Rows in the order of kDesigns and kNoiseLevels.
std::vector<CoverageRow> coverage(const BenchOptions& options = {});

/// What was quoted for a parameter: its interval, or its pieces where minima lie apart.
std::vector<fit::Interval> quoted_pieces(const fit::ParameterEstimate& parameter);
/// Does one of the pieces hold this value? A lag (`turns`) is known modulo a turn.
bool holds(const std::vector<fit::Interval>& pieces, double value, bool turns);

/// The exact 95 % interval of a probability after `hits` of `trials` (Clopper and Pearson 1934).
fit::Interval binomial_ci95(int hits, int trials);

}  // namespace tribotrack::bench
