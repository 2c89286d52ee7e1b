// What a survey of a recording saw, as text, JSON and the lines of a campaign.
#pragma once

#include <string>
#include <vector>

#include "apps/text/json.h"
#include "vision/survey.h"

namespace tribotrack::apps {

/// "disc 2: a mark, (42.8, 40.0) px, radius 14.0 px, moves by up to 2.8 px", one line for each disc and lamp.
std::vector<std::string> descriptions(const vision::Survey& seen);

/// One line of a campaign's [camera] or [[run]], with the reason as a comment: places that were found.
/// A part that the tracker would find by itself is a comment, too.
struct CampaignLine {
  std::string key, value;
  std::string why;
};

/// disc_px, marker_px, gate_px, as far as they were seen.
std::vector<CampaignLine> places(const vision::Survey& seen);

/// "frame_rate_hz = ..." or why it must be given; then places(), under [camera].
std::string camera_section(const vision::Survey& seen, const vision::SourceInfo& info);

Json json_of(const vision::Survey& seen);

/// A circle as a campaign writes it: "[42.8, 40.0, 14.0]".
std::string circle_text(const vision::Circle& circle);

}  // namespace tribotrack::apps
