// What a recording's time stamps say of its making: frames that are missing, a rate that changed.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tribotrack::vision {

/// Steps between frame `first` and frame `last` (indices, both included) take the same time.
struct SteadyStretch {
  std::int64_t first = 0, last = 0;
  double rate_hz = 0;
};

/// Frames that should stand between frame `after` and the next, and do not.
struct MissingFrames {
  std::int64_t after = 0;
  std::int64_t count = 0;  ///< by the stamps
};

struct StampCheck {
  double rate_hz = 0;     ///< that of the median step
  double jitter = 0;      ///< median absolute deviation of the steps from their median, of a step
  bool uniform = true;    ///< every step is the median one
  bool variable = false;  ///< the steps differ all along: neither drops nor a few stretches explain them
  std::vector<SteadyStretch> stretches;  ///< two or more where the rate changed within the shot
  std::vector<MissingFrames> missing;
  std::vector<std::int64_t> strays;  ///< stamped too far from their neighbours to belong to them
};

/// `times` rise. A step is steady when it is within `tolerance` (of a step) of the others of its stretch; 2
/// to 1000 times that are frames missing, more is a stray. A stretch has at least 3 steps: shorter ones are
/// missing frames or strays.
StampCheck check_stamps(std::span<const double> times_s, double tolerance);

/// One sentence for each finding, with image numbers counted from first_number; at most a few of each kind.
std::vector<std::string> findings(const StampCheck& check, std::int64_t first_number);

}  // namespace tribotrack::vision
