// The platform's and the lamp's points for drawing: orbit, phase residual over time, brightness over phase.
#pragma once

#include "apps/files/track_file.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// Adds the drawings' points to a platform whose measured numbers are filled in; nothing where it was not
/// seen to move. The lines drawn are those numbers, not a new measurement: `track` must have the scale they
/// were measured at.
void add_drawings(const TrackFile& track, ReportPlatform& platform);

}  // namespace tribotrack::apps
