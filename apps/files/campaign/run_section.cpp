#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "apps/files/campaign/keys.h"
#include "apps/program/errors.h"
#include "apps/program/streams.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

/// An incline beyond 45 degrees is none that a part rests on.
constexpr double kSteepest = std::numbers::pi / 4;

void check_sds(const StrictTable& table, const CampaignRun& run) {
  if (run.free_slide)
    for (const char* key : {"phi_rad_sd", "dtau_rad_sd", "amplitude_mm_sd", "angular_frequency_rad_s_sd",
                            "phase_at_zero_rad_sd", "start_phase_rad_sd"})
      if (table.has(key)) table.fail(key, "belongs to a driven run: a free slide's platform rests");
  if (!run.has_track())
    for (const char* key : {"phase_at_zero_rad_sd", "mm_per_px_sd"})
      if (table.has(key)) table.fail(key, "belongs to a run with a video or a track");
  if (run.start_phase_sd && run.phase_at_zero)
    table.fail("start_phase_rad_sd", "is not needed: phase_at_zero_rad gives the phase at the start");
}

/// A free slide's plane.
void check_slope(const StrictTable& table, CampaignRun& run) {
  if (!run.slope) return;
  if (!run.free_slide)
    table.fail("slope_rad", "belongs to a run of kind = \"free_slide\": its part slides on a plane at rest");
  if (!(std::abs(*run.slope) <= kSteepest))
    table.fail("slope_rad",
               fmt::format("must lie within pi/4, not {0}: degrees? write \"{0}deg\"", *run.slope));
  if (*run.slope == 0) run.slope.reset();
}

/// Which of several parts this run shows is said once.
void check_places(const StrictTable& table, const CampaignRun& run) {
  if (!table.has("parts")) return;
  if (!run.part.empty())
    table.fail("parts", "and `part` both say which part this run is about; give one of them");
  for (const char* key : {"disc_px", "template_px", "track", "alpha_rad"})
    if (table.has(key)) table.fail("parts", fmt::format("says where each part lies, and so does `{}`", key));
}

/// What belongs to tracking does not belong to a finished track.
void check_track(const StrictTable& table, const CampaignRun& run) {
  if (run.track && run.video)
    table.fail("track", "and `video` are two sources of one motion; a run has one of them");
  if (run.track)
    for (const char* key : {"disc_px", "template_px", "marker_px"})
      if (table.has(key)) table.fail(key, "is for tracking a `video`; this run's `track` is finished");
}

/// A run has one source of its motion, and all that the fit needs to know of it.
void check_source(const StrictTable& table, const CampaignRun& run, bool with_sds) {
  const bool any_summary = run.alpha || run.alpha_sd || run.v || run.v_sd;
  const bool whole_summary = run.alpha && run.v && (!with_sds || (run.alpha_sd && run.v_sd));
  if (run.has_track() && any_summary)
    throw InvalidInput(
        "{}: a run has either a video (or track) or alpha_rad, v_mm_s measured elsewhere, not both",
        run.place);
  if (!run.has_track() && !whole_summary)
    throw InvalidInput(
        "{}: a run needs `video` or `track`, or all of alpha_rad, alpha_sd_rad, v_mm_s, v_sd_mm_s",
        run.place);
  if (!run.has_track() && run.free_slide)
    throw InvalidInput("{}: a free slide needs `video` or `track`: mu1 comes from its whole track",
                       run.place);
  if (!run.free_slide && (!table.has("phi_rad") || !table.has("dtau_rad")))
    throw InvalidInput("{}: a run needs `phi_rad` and `dtau_rad` (or kind = \"free_slide\")", run.place);
}

/// What the campaign's other keys say of a run's track.
void complete_reading(const CameraSection& camera, CampaignRun& run) {
  TrackReading& reading = run.reading;
  reading.mm_per_px = run.mm_per_px ? run.mm_per_px : camera.mm_per_px;
  reading.mm_per_px_sd = run.mm_per_px ? run.mm_per_px_sd.value_or(0) : camera.mm_per_px_sd;
  reading.frame_rate_hz = camera.frame_rate_hz;
  reading.xi_axis_rad = camera.xi_axis_rad;
  reading.first_frame = run.first_frame;
  reading.last_frame = run.last_frame;
}

void read_frames(StrictTable& table, CampaignRun& run, const fs::path&) {
  const auto frames = table.integers("frames", table.count("frames") == 3 ? 3 : 2);
  if (!frames) return;
  if ((*frames)[0] > (*frames)[1] || (frames->size() == 3 && frames->back() < 1))
    table.fail("frames", "must be [first, last], both included, or [first, last, step]");
  run.first_frame = (*frames)[0];
  run.last_frame = (*frames)[1];
  if (frames->size() == 3) run.frame_step = (*frames)[2];
}

Json written_frames(const CampaignRun& run) {
  if (!run.first_frame) return {};
  Json frames = Json::array({*run.first_frame, *run.last_frame});
  if (run.frame_step > 1) frames.push_back(run.frame_step);
  return frames;
}

/// A trace, or two of an oscilloscope that writes a file for each channel.
void read_scope_files(StrictTable& table, CampaignRun& run, const fs::path& folder) {
  if (!table.is_list("scope")) {
    if (const auto scope = table.text("scope")) run.scope = folder / *scope;
    return;
  }
  const auto files = table.texts("scope");
  if (files->empty() || files->size() > 2)
    table.fail("scope", fmt::format("must name one file, or two of one channel each, not {}", files->size()));
  run.scope = folder / files->front();
  if (files->size() == 2) run.second_scope = folder / files->back();
}

Json written_scope_files(const CampaignRun& run) {
  if (!run.scope) return {};
  const std::string file = run.scope->filename().string();
  return run.second_scope ? Json::array({file, run.second_scope->filename().string()}) : Json(file);
}

/// Where each of several parts lies at first.
void read_parts(StrictTable& table, CampaignRun& run, const fs::path&) {
  auto places = table.table("parts");
  if (!places) return;
  for (const std::string& name : places->keys()) run.parts[name] = read_place(*places, name.c_str());
  places->finish();
}

}  // namespace

const Keys<CampaignRun>& run_keys() {
  using R = CampaignRun;
  static const Keys<R> keys = {
      {"video", Kind::file, at<&R::video>, "\"phi000_dtau060.cine\"",
       "relative to this file: .cine, video, TIFF stack, folder of pictures, dir/%05d.png"},
      {"track", Kind::file, at<&R::track>, "\"tracker.txt\"",
       "instead of a video: a track of Tracker, Kinovea, DLTdv, trackpy, of columns t_s, x_mm, y_mm, or "
       "ours"},
      {"track_unit", Kind::one_of(kTrackUnits), at<&R::reading, &TrackReading::unit>, "\"mm\"",
       "where it differs from [data]", "track"},
      {"track_y", Kind::one_of(kTrackY), at<&R::reading, &TrackReading::y>, "\"up\"",
       "where it differs from [data]", "track"},
      {"track_frame", Kind::one_of(kTrackFrames), at<&R::reading, &TrackReading::frame>, "\"platform\"",
       "where it differs from [data]", "track"},
      {"track_point", Kind::text, at<&R::reading, &TrackReading::point>, "\"mass A\"",
       "where it differs from [data]", "track"},
      {"track_mark", Kind::text, at<&R::reading, &TrackReading::mark>, "\"mass B\"",
       "where it differs from [data]", "track"},
      {"name", Kind::text, at<&R::name>, "\"first\"", "of its results; else the recording's"},
      {"kind", Kind::one_of({"pulses", "free_slide"}), at<&R::free_slide>, "\"free_slide\"",
       "set sliding by hand on the platform at rest; gives mu1 by itself (film several). Else \"pulses\""},
      {"slope_rad", Kind::angle, at<&R::slope>, "\"20deg\"",
       "of a free slide on an incline: > 0 slides down, < 0 is pushed up; mu1 = tan(slope) - a/(g "
       "cos(slope))"},
      {"slope_rad_sd", Kind::sd, at<&R::slope_sd>, "0.002", "the same for all inclines of the campaign"},
      {"phi_rad", Kind::angle, at<&R::phi>, "\"45deg\"", "commanded phase of the pulse"},
      {"phi_rad_sd", Kind::sd, at<&R::phi_sd>, "0.005", "of this run alone"},
      {"dtau_rad", Kind::angle, at<&R::dtau>, "\"pi/3\"", "commanded width of the pulse"},
      {"dtau_rad_sd", Kind::sd, at<&R::dtau_sd>, "0.005"},
      {"frames", Kind::two_wholes, Own<R>{read_frames, written_frames}, "[120, 480]",
       "first and last image number, both included; a third number n: every n-th of them"},
      {"start", Kind::one_of(kStarts), at<&R::start>, "\"rest\"", "where it differs from [fit]"},
      {"cycles", Kind::wholes(1, 1'000'000), at<&R::cycles>, "20", "where it differs from [fit]"},
      {"amplitude_mm", Kind::not_negative, milli<&R::amplitude>, "0.28", "where it differs from [platform]"},
      {"amplitude_mm_sd", Kind::sd, milli<&R::amplitude_sd>, "0.001"},
      {"angular_frequency_rad_s", Kind::above_zero, at<&R::angular_frequency>, "62.8",
       "where it differs from [platform]"},
      {"angular_frequency_rad_s_sd", Kind::sd, at<&R::angular_frequency_sd>, "0.001"},
      {"phase_at_zero_rad", Kind::angle, at<&R::phase_at_zero>, "0.0",
       "the platform's phase at the recording's first image, where nothing shows it"},
      {"phase_at_zero_rad_sd", Kind::sd, at<&R::phase_at_zero_sd>, "0.01"},
      {"start_phase_rad", Kind::angle, at<&R::start_phase>, "0.0",
       "the platform's phase at the start of a run without video"},
      {"start_phase_rad_sd", Kind::sd, at<&R::start_phase_sd>, "0.01"},
      {"mm_per_px", Kind::above_zero, at<&R::mm_per_px>, "0.02", "where it differs from [camera]"},
      {"mm_per_px_sd", Kind::sd, at<&R::mm_per_px_sd>, "0.00002"},
      {"disc_px", Kind::circle, at<&R::target>, "[640, 400, 150]", "where it differs from [camera]"},
      {"template_px", Kind::rectangle, at<&R::target>, "[100, 40, 41, 41]", "where it differs from [camera]"},
      {"part", Kind::text, at<&R::part>, "\"disc\"", "which of several [[part]] this run shows"},
      {"parts", Kind::place_by_name, Own<R>{read_parts}, "{ disc = [640, 400, 150] }",
       "several in one recording: where each lies at first, [x, y, radius] or [x, y, width, height]"},
      {"marker_px", Kind::circle, at<&R::marker_px>, "[200, 180, 24]", "where it differs from [camera]"},
      {"scope", Kind::text_or_texts, Own<R>{read_scope_files, written_scope_files}, "\"phi000_dtau060.csv\"",
       "oscilloscope trace: phi and dtau are measured from it; [\"CH1.csv\", \"CH2.csv\"] where a file holds "
       "one channel"},
      {"alpha_rad", Kind::angle, at<&R::alpha>, "5.93",
       "measured elsewhere, with the three below, instead of a video: direction of the displacement"},
      {"alpha_sd_rad", Kind::above_zero, at<&R::alpha_sd>, "0.02"},
      {"v_mm_s", Kind::not_negative, milli<&R::v>, "1.78", "mean velocity"},
      {"v_sd_mm_s", Kind::above_zero, milli<&R::v_sd>, "0.04"},
  };
  return keys;
}

CampaignRun read_run(StrictTable& table, const Campaign& campaign, bool with_sds) {
  CampaignRun run;
  run.place = table.place();
  run.reading = campaign.data.tracks;
  run.start = campaign.fit.start;
  run.cycles = campaign.fit.cycles;
  read_keys(table, run_keys(), run, campaign.file.parent_path());
  if (!(run.dtau >= 0 && run.dtau <= 2 * std::numbers::pi))
    table.fail("dtau_rad",
               fmt::format("must lie between 0 and 2pi, not {0}: degrees? write \"{0}deg\"", run.dtau));
  check_track(table, run);
  check_sds(table, run);
  check_slope(table, run);
  check_places(table, run);
  table.finish();
  complete_reading(campaign.camera, run);
  check_source(table, run, with_sds);
  return run;
}

void require_scale(const Campaign& campaign, const CampaignRun& run) {
  const bool scale_given =
      run.mm_per_px || campaign.camera.mm_per_px || campaign.camera.calibration || campaign.camera.tag_mm;
  const vision::Target& target = is_given(run.target) ? run.target : campaign.camera.target;
  if (run.video && !scale_given && target.kind == vision::Target::Kind::rectangle)
    throw InvalidInput(
        "{}: a part that is followed by template_px has no diameter to scale by: give `mm_per_px` or "
        "`calibration` in [camera]",
        run.place);
  if (run.video && !scale_given && !campaign.part.diameter_mm)
    throw InvalidInput(
        "{}: the size of a pixel is not known; give `diameter_mm` in [part], or `mm_per_px` or `calibration` "
        "in [camera]",
        run.place);
}

void name_runs(std::vector<CampaignRun>& runs) {
  const auto controls = [](unsigned char c) { return c < 0x20 || c == 0x7F; };
  std::set<std::string> taken;
  for (const CampaignRun& run : runs)
    if (!run.name.empty() && !taken.insert(run.name).second)
      throw InvalidInput("{}: the name \"{}\" is taken by an earlier run", run.place, run.name);
  for (std::size_t k = 0; k < runs.size(); ++k) {
    CampaignRun& run = runs[k];
    if (run.name.find('/') != std::string::npos || run.name == "." || run.name == "..")
      throw InvalidInput("{}: the name \"{}\" cannot be a folder's name", run.place, run.name);
    if (std::ranges::any_of(run.name, controls))
      throw InvalidInput("{}: the name \"{}\" holds a control character; results bear it: take it out",
                         run.place, printable(run.name));
    if (!run.name.empty()) continue;
    std::string base = run.video   ? run.video->stem().string()
                       : run.track ? run.track->stem().string()
                                   : fmt::format("run{:02}", k + 1);
    std::ranges::replace_if(base, controls, '_');
    run.name = base;
    for (int n = 2; !taken.insert(run.name).second; ++n) run.name = fmt::format("{}_{}", base, n);
  }
}

}  // namespace tribotrack::apps
