// First: how a run's recording is to be tracked.
#pragma once

#include "apps/files/camera.h"
#include "apps/files/campaign/campaign.h"
#include "apps/recording/track_recording.h"

namespace tribotrack::apps {

/// Puts [part] and [camera] into a job.
void apply(const PartSection& part, const CameraSection& camera, RecordingJob& job);

/// The job of one run of a campaign; keys of the run override those of [camera].
RecordingJob job_for(const Campaign& campaign, const CampaignRun& run);

}  // namespace tribotrack::apps
