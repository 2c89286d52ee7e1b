// How many runs must be filmed until mu1 is known to a percent: chosen one by one, as `watch` chooses them,
// against the source paper's design. Simulated laboratories with known truth.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "apps/bench/fit/designs.h"

namespace tribotrack::bench {

enum class Choice {
  next_for_goal,  ///< the fit's suggestion for the goal (fit/goal.h), after a first run at phi = 0, dtau =
                  ///< pi/3
  paper           ///< 8 values of phi at dtau = pi/3, then 6 values of dtau at phi = 0, then all over again
};
inline constexpr Choice kChoices[] = {Choice::next_for_goal, Choice::paper};
const char* to_string(Choice choice);

struct FilmingOptions {
  int campaigns = 100;  ///< of each noise level
  double goal = 0.01;   ///< half the 95 % interval of mu1 over mu1
  int most_runs = 100;  ///< then filming is given up
  std::uint64_t seed = 20210909;
  std::vector<NoiseLevel> levels{kNoiseLevels.begin(), kNoiseLevels.end()};
  int threads = 1;  ///< over campaigns
  std::function<void(int done, int total)> progress;
};

/// One choice at one noise level. Quartiles count campaigns that did not arrive as most_runs.
struct FilmingRow {
  Choice choice = Choice::paper;
  NoiseLevel level = NoiseLevel::low;
  int campaigns = 0, reached = 0;
  int holds = 0;  ///< of those that reached the goal: the interval holds the true mu1
  double runs_low = 0, runs_median = 0, runs_high = 0;  ///< quartiles
};

/// A check that it works: one campaign, a coarse goal.
FilmingOptions quick_filming_options();

std::vector<FilmingRow> filming(const FilmingOptions& options = {});

}  // namespace tribotrack::bench
