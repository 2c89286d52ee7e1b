// First: how a run's recording is to be tracked.
#pragma once

#include "apps/campaign/track_recording.h"
#include "apps/files/camera_section.h"
#include "apps/files/campaign.h"

namespace tribotrack::apps {

/// Puts [part] and [camera] into a job.
void apply(const PartSection& part, const CameraSection& camera, RecordingJob& job);

/// What a campaign says of one of its runs with a video: the run's own keys beat those of [camera].
RecordingJob job_for(const Campaign& campaign, const CampaignRun& run);

}  // namespace tribotrack::apps
