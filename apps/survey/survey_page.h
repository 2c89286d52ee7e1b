// A page to find places in a recording with the mouse: frames to scrub, circles to draw, lines to copy.
#pragma once

#include <string>

#include "vision/survey.h"

namespace tribotrack::apps {

/// A self-contained HTML page. Reads some frames of the recording, spread evenly. Throws vision::InputError.
std::string survey_page(vision::FrameSource& source, const vision::Survey& seen);

}  // namespace tribotrack::apps
