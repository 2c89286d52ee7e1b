#include "apps/recording/job.h"

namespace tribotrack::apps {

namespace {

vision::MarkerChoice marker_of(const CameraSection& camera) {
  if (camera.marker_px) return {vision::MarkerChoice::Kind::circle, *camera.marker_px};
  return camera.marker;
}

}  // namespace

void apply(const PartSection& part, const CameraSection& camera, RecordingJob& job) {
  job.frame_rate_hz = camera.frame_rate_hz;
  job.frame_rate_reason = camera.frame_rate_reason;
  job.mm_per_px = camera.mm_per_px;
  job.mm_per_px_sd = camera.mm_per_px_sd;
  job.calibration = camera.calibration;
  job.diameter_mm = part.diameter_mm;
  job.diameter_sd_mm = part.diameter_sd_mm;
  job.height_mm = part.height_mm;
  job.working_distance_mm = camera.working_distance_mm;
  job.xi_axis_rad = camera.xi_axis_rad;
  job.tag_mm = camera.tag_mm;
  job.tag_mm_sd = camera.tag_mm_sd;
  job.row_time_s = camera.row_time_s;
  const auto follow = [&job](const auto& place) {
    if (place.template_px) job.track.target = {vision::Target::Kind::rectangle, {}, *place.template_px};
    if (place.disc_px) job.track.target = {vision::Target::Kind::disc, *place.disc_px, {}};
  };
  follow(part);
  follow(camera);
  job.track.marker = marker_of(camera);
  job.track.gate = camera.gate_px;
}

RecordingJob job_for(const Campaign& campaign, const CampaignRun& run) {
  RecordingJob job;
  job.video = *run.video;
  CameraSection camera = campaign.camera;
  if (run.disc_px) {
    camera.disc_px = run.disc_px;
    camera.template_px.reset();
  }
  if (run.template_px) {
    camera.template_px = run.template_px;
    camera.disc_px.reset();
  }
  if (run.marker_px) camera.marker_px = run.marker_px;
  if (run.mm_per_px) {
    camera.mm_per_px = run.mm_per_px;
    camera.mm_per_px_sd = run.mm_per_px_sd.value_or(0);
  }
  apply(campaign.part, camera, job);
  if (job.mm_per_px) job.calibration.reset();
  if (job.mm_per_px || job.calibration) job.tag_mm.reset();
  if (job.mm_per_px || job.calibration || job.tag_mm) job.diameter_mm.reset();
  if (run.free_slide) {  // its platform rests and no actuator works
    if (!job.tag_mm) job.track.marker = {vision::MarkerChoice::Kind::none, {}};
    job.track.gate.reset();
  }
  job.track.first_frame = run.first_frame;
  job.track.last_frame = run.last_frame;
  return job;
}

}  // namespace tribotrack::apps
