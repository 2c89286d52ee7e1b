// First: is the recording there, what does it hold, and is its track there already?
#pragma once

#include <filesystem>
#include <string>

#include "apps/recording/recording.h"

namespace tribotrack::apps {

/// How it is tracked, apart from what its inputs hold: the key's configuration, no file looked at.
Json settings_of(const Recording& recording);

/// With the content of its inputs and its key. Throws InvalidInput.
Recording checked(Recording recording);
/// The same for frames that are in memory already: there is nothing to hash but a calibration, and no key.
Recording checked_in_memory(Recording recording);

/// Is csv there with a meta file of this key?
bool is_current(const std::filesystem::path& csv, const std::string& key);

/// What the recording itself says against what was given of it. Throws vision::InputError where its frame
/// rate is unknown, with the flag to give, UsageError for a template scaled by a diameter, InvalidInput for
/// another frame rate than the camera's and for a rolling shutter slower than a frame.
void require_trackable(const Recording& recording, const vision::SourceInfo& info);

}  // namespace tribotrack::apps
