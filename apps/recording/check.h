// First: is the recording there, what does it hold, and is its track there already?
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "apps/recording/recording.h"

namespace tribotrack::apps {

/// How it is tracked, apart from what its inputs hold: the key's configuration, no file looked at.
Json settings_of(const Recording& recording);

/// With the content of its inputs and its key. Throws InvalidInput.
Recording checked(Recording recording);
/// The same for frames that are in memory already: there is nothing to hash but a calibration, and no key.
Recording checked_in_memory(Recording recording);

/// Why the track in csv is not that of a recording just checked: edited, of other settings, of another
/// recording or revision of this program; empty where there is none. Nothing where it is the one.
std::optional<std::string> why_outdated(const std::filesystem::path& csv, const Recording& recording);

/// What the recording itself says against what was given of it. Throws vision::InputError where its frame
/// rate is unknown, with the flag to give, UsageError for a template scaled by a diameter, InvalidInput for
/// another frame rate than the camera's and for a rolling shutter slower than a frame.
void require_trackable(const Recording& recording, const vision::SourceInfo& info);

}  // namespace tribotrack::apps
