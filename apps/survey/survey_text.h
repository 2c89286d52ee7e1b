// What the name of a recording says of it: labs write phi, dtau and the frame rate into file names.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/text/json.h"
#include "vision/survey.h"

namespace tribotrack::apps {

struct NameGuess {
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

// What a survey of a recording saw, as text, JSON and the lines of a campaign.

/// "disc 2: a mark, (42.8, 40.0) px, radius 14.0 px, moves by up to 2.8 px", one line for each disc and lamp.
std::vector<std::string> descriptions(const vision::Survey& seen);

/// [camera] with disc_px, marker_px and gate_px as far as they were seen, the reason behind each, and why
/// frame_rate_hz must be given where it must.
std::string camera_section(const vision::Survey& seen, const vision::SourceInfo& info);

Json json_of(const vision::Survey& seen);

/// A circle as a campaign writes it: "[42.8, 40.0, 14.0]".
std::string circle_text(const vision::Circle& circle);

// A page to find places in a recording with the mouse: frames to scrub, circles to draw, lines to copy.

/// A self-contained HTML page. Reads some frames of the recording, spread evenly. Throws vision::InputError.
std::string survey_page(vision::FrameSource& source, const vision::Survey& seen);

}  // namespace tribotrack::apps
