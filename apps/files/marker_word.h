// How the platform's mark is named in campaigns, on the command line and in Python.
#pragma once

#include <optional>
#include <string>

#include "vision/tracker.h"

namespace tribotrack::apps {

/// "auto", "texture", "none", "tag:FAMILY" or "tag:FAMILY:NUMBER"; nothing for other words. Throws
/// std::invalid_argument for a family of tags that is none.
std::optional<vision::MarkerChoice> marker_named(const std::string& word);

/// What may be written, for messages.
inline constexpr const char* kMarkerWords =
    "auto, texture, none or tag:FAMILY[:NUMBER], as tag:apriltag_36h11:3";

/// "tag:FAMILY[:NUMBER]" of a tag.
std::string tag_word(const vision::MarkerChoice& marker);

}  // namespace tribotrack::apps
