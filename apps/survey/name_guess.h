// What the name of a recording says of it: labs write phi, dtau and the frame rate into file names.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace tribotrack::apps {

struct NameGuess {
  std::optional<double> phi_rad, dtau_rad;
  std::string phi_text, dtau_text;  ///< as a campaign writes them: "45deg", "0.785"
  std::optional<double> frame_rate_hz;
  bool free_slide = false;
};

/// For each of some names that belong together (without folder and suffix): angles may be named
/// (`phi045_dtau060`, `p45-d60`, `phase_0.79rad_tau1.05rad`) or be two numbers with a unit (`45deg_60deg`:
/// phi, then dtau). Where no name states a unit, numbers beyond a turn anywhere make all of them degrees, as
/// do leading zeros; decimal fractions alone make them radians; with neither, nothing is guessed. `240fps` or
/// `1000Hz` is the frame rate; `slide` and `incline` mark a free slide.
std::vector<NameGuess> guesses_from(const std::vector<std::string>& names);

}  // namespace tribotrack::apps
