// What motion a track shows, in words, and what to do where it is not the one that was asked for.
#pragma once

#include <optional>
#include <string>

#include "apps/files/track_file.h"
#include "fit/measurement.h"
#include "fit/motion.h"

namespace tribotrack::apps {

/// In `fit::ShownMotion` the platform's, where its mark shows that it circles; else the part's own.
struct TrackMotion {
  fit::ShownMotion shown;
  bool platform_seen = false;  ///< by a mark that circles
  std::string sentence;        ///< what it shows, without a full stop
  /// What gives friction from such a track, or what to film instead.
  std::string remedy() const;
};

/// `platform`: as its mark shows it. A mark that moves and does not circle was moved with the camera.
TrackMotion motion_of(const Track& track, const std::optional<fit::PlatformMotion>& platform);

/// Why what was measured over cycles of the w given is not what the part shows: it does something else, or
/// circles at another frequency. Empty where it may be.
std::string against_drive(const TrackMotion& motion, double angular_frequency);

}  // namespace tribotrack::apps
