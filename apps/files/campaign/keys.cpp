#include "apps/files/campaign/keys.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/files/campaign/sections.h"

namespace tribotrack::apps {

namespace {

const std::vector<std::string> kStarts = {"rest", "circling", "steady"};
const std::vector<std::string> kUnits = {"px", "um", "mm", "cm", "m"};
const std::vector<std::string> kFrames = {"platform", "camera"};

}  // namespace

const Keys<Campaign>& top_keys() {
  static const Keys<Campaign> keys = {
      {"title", Kind::text, at<&Campaign::title>, "\"Silver disc, 6 mm, on polished duralumin\"",
       "of the report; else this file's name"},
  };
  return keys;
}

const Keys<PlatformSection>& platform_keys() {
  using P = PlatformSection;
  static const Keys<P> keys = {
      {"amplitude_mm", Kind::not_negative, milli<&P::amplitude>, "0.28",
       "A; leave out to measure it from mark or texture. 0: platform at rest"},
      {"amplitude_mm_sd", Kind::sd, milli<&P::amplitude_sd>, "0.001",
       "its standard deviation; without one that of the last digit, 0.5 % at least"},
      {"amplitude_y_mm", Kind::not_negative, milli<&P::amplitude_y>, "0.28",
       "A_y, where the platform moves on an ellipse"},
      {"amplitude_y_mm_sd", Kind::sd, milli<&P::amplitude_y_sd>, "0.001"},
      {"angular_frequency_rad_s", Kind::above_zero, at<&P::angular_frequency>, "62.8",
       "w; leave out to measure it. Also as frequency_hz, w / 2 pi"},
      {"angular_frequency_rad_s_sd", Kind::sd, at<&P::angular_frequency_sd>, "0.001"},
      {"phase_shift_rad", Kind::angle, at<&P::phase_shift>, "\"pi/2\"",
       "epsilon: pi/2 turns clockwise, \"-pi/2\" counter-clockwise, as seen with y up; leave out to measure "
       "it"},
      {"phase_shift_rad_sd", Kind::sd, at<&P::phase_shift_sd>, "0.01"},
      {"gravity_m_s2", Kind::above_zero, at<&P::gravity>, "9.81"},
      {"gravity_m_s2_sd", Kind::sd, at<&P::gravity_sd>, "0.001"},
      {"tilt_x_rad", Kind::angle, at<&P::tilt_x>, "\"0.1deg\"",
       "slope of the platform towards +x (right): gravity pulls with g sin(tilt)"},
      {"tilt_x_rad_sd", Kind::sd, at<&P::tilt_x_sd>, "0.0002", "by the resolution of the spirit level"},
      {"tilt_y_rad", Kind::angle, at<&P::tilt_y>, "0.0", "likewise towards +y (up)"},
      {"tilt_y_rad_sd", Kind::sd, at<&P::tilt_y_sd>, "0.0002"},
  };
  return keys;
}

const Keys<PartSection>& part_keys() {
  using P = PartSection;
  static const Keys<P> keys = {
      {"name", Kind::text, at<&P::name>, "\"disc\"",
       "where there are several: a [[part]] of its own for each; each gets its own fit"},
      {"disc_px", Kind::circle, at<&P::target>, "[640, 400, 150]",
       "where it lies at first, unless the run says"},
      {"template_px", Kind::rectangle, at<&P::target>, "[100, 40, 41, 41]", "instead of a disc"},
      {"diameter_mm", Kind::above_zero, at<&P::diameter_mm>, "6.0",
       "sets the scale, unless mm_per_px or a calibration does"},
      {"diameter_mm_sd", Kind::sd, at<&P::diameter_sd_mm>, "0.005", "by a caliper"},
      {"chamfer_mm", Kind::not_negative, at<&P::chamfer_mm>, "0.1",
       "width of its chamfer seen from above, 0 for a sharp edge: without it a diameter gives the scale to 1 "
       "to "
       "2 %"},
      {"height_mm", Kind::above_zero, at<&P::height_mm>, "0.8",
       "with working_distance_mm: the part's top is nearer to the camera than the mark"},
      {"height_mm_sd", Kind::sd, at<&P::height_sd_mm>, "0.01"},
  };
  return keys;
}

const Keys<CameraSection>& camera_keys() {
  using C = CameraSection;
  static const Keys<C> keys = {
      {"frame_rate_hz", Kind::above_zero, at<&C::frame_rate_hz>, "1000.0",
       "only where the recording does not give it (see `tribotrack probe VIDEO`)"},
      {"frame_rate_reason", Kind::text, at<&C::frame_rate_reason>, "\"the camera's display\"",
       "how you know it, where the file states the rate of playback", "frame_rate_hz"},
      {"frame_rate_hz_sd", Kind::sd, at<&C::frame_rate_sd_hz>, "0.01"},
      {"mm_per_px", Kind::above_zero, at<&C::mm_per_px>, "0.02", "leave out to scale by the part's diameter"},
      {"tag_mm", Kind::above_zero, at<&C::tag_mm>, "8.0",
       "side of the tag's black square, where `marker` is one: sets the scale"},
      {"tag_mm_sd", Kind::sd, at<&C::tag_mm_sd>, "0.02", "as printed"},
      {"mm_per_px_sd", Kind::not_negative, at<&C::mm_per_px_sd>, "0.00002"},
      {"calibration", Kind::file, at<&C::calibration>, "\"calibration.json\"",
       "by `tribotrack calibrate`, instead of mm_per_px"},
      {"working_distance_mm", Kind::above_zero, at<&C::working_distance_mm>, "100.0",
       "from lens to platform"},
      {"working_distance_mm_sd", Kind::sd, at<&C::working_distance_sd_mm>, "1.0"},
      {"row_time_s", Kind::number, at<&C::row_time_s>, "0.00001",
       "rolling shutter: from one row of the picture to the next one below"},
      {"xi_axis_rad", Kind::angle, at<&C::xi_axis_rad>, "0.0",
       "direction, in the picture, of the platform's displacement when the phase sensor fires"},
      {"xi_axis_rad_sd", Kind::sd, at<&C::xi_axis_sd_rad>, "0.01"},
      {"disc_px", Kind::circle, at<&C::target>, "[640, 400, 150]",
       "x, y, radius in the first frame; leave out to have it found"},
      {"template_px", Kind::rectangle, at<&C::target>, "[100, 40, 41, 41]",
       "instead of a disc: x, y, width, height of a part of any shape in the first frame; needs mm_per_px"},
      {"marker_px", Kind::circle, at<&C::marker_px>, "[200, 180, 24]",
       "a mark fixed to the platform; leave out where there is none"},
      {"marker", Kind::text, Own<C>{read_marker, written_marker}, "\"texture\"",
       "without marker_px: by the platform's own texture (as by itself where that moves); \"auto\": a round "
       "mark, else texture; \"none\"; \"tag:apriltag_36h11:3\": an ArUco or AprilTag tag"},
      {"gate_px", Kind::circle, at<&C::gate_px>, "[30, 30, 6]",
       "an LED that is on while the actuator is: phi and dtau are measured from it"},
  };
  return keys;
}

const Keys<ScopeSection>& scope_keys() {
  using S = ScopeSection;
  static const Keys<S> keys = {
      {"sensor_channel", Kind::wholes(0, 4), at<&S::sensor_channel>, "1",
       "reference pulses of the platform's phase sensor; 0: none"},
      {"actuator_channel", Kind::wholes(0, 4), at<&S::actuator_channel>, "2",
       "the bursts that drive the actuator; 0: none"},
      {"carrier_hz", Kind::above_zero, at<&S::carrier_hz>, "5890", "of the bursts"},
      {"sensor_delay_s", Kind::number, at<&S::sensor_delay_s>, "0.0",
       "by which the sensor's filter makes its pulse late"},
      {"sensor_delay_sd_s", Kind::not_negative, at<&S::sensor_delay_sd_s>, "0.00001"},
      {"tie", Kind::one_of({"sensor", "trigger", "lamp"}), at<&S::tie>, "\"sensor\"",
       "phi counts from the sensor; \"trigger\": both zero at one trigger; \"lamp\": phi from gate_px"},
      {"trigger_time_s", Kind::number, at<&S::trigger_time_s>, "0.0",
       "the trigger in the recording's time; a .cine holds it itself"},
      {"tie_sd_s", Kind::not_negative, at<&S::tie_sd_s>, "0.00001", "of that tie"},
  };
  return keys;
}

const Keys<DataSection>& data_keys() {
  using D = DataSection;
  static const Keys<D> keys = {
      {"table", Kind::text_or_texts, Own<D>{read_tables, written_tables}, "\"alpha_v.csv\"",
       "or a list; every point becomes a run: columns phi_deg, dtau_deg, alpha_deg, v_mm_s (or phi_rad, "
       "...), alpha_sd_deg, v_sd_mm_s; separated by , ; or tabs"},
      {"runs", Kind::file, at<&D::runs>, "\"runs.csv\"",
       "a [[run]] for each line: columns video or track, phi_deg, dtau_deg, name, or any other key of a run"},
      {"alpha_sd_rad", Kind::angle, at<&D::alpha_sd>, "\"2deg\"",
       "of the lines that have none; else repeats of a point tell", "table"},
      {"v_sd_mm_s", Kind::above_zero, milli<&D::v_sd>, "0.1", "likewise", "table"},
      {"track_unit", Kind::one_of(kUnits), at<&D::tracks, &TrackReading::unit>, "\"mm\"",
       "of tracks whose columns name none: px (with mm_per_px), um, mm, cm, m"},
      {"track_y", Kind::one_of({"up", "down"}), at<&D::tracks, &TrackReading::y>, "\"up\"",
       "where y of tracks points, if not down in pixels and up in lengths"},
      {"track_frame", Kind::one_of(kFrames), at<&D::tracks, &TrackReading::frame>, "\"platform\"",
       "of tracks: \"platform\": its motion is taken out of them already; else by track_mark, or \"camera\""},
      {"track_point", Kind::text, at<&D::tracks, &TrackReading::point>, "\"mass A\"",
       "which point of tracks is the part, where there are several"},
      {"track_mark", Kind::text, at<&D::tracks, &TrackReading::mark>, "\"mass B\"",
       "and which is fixed to the platform, if one is"},
  };
  return keys;
}

const Keys<FitSection>& fit_keys() {
  using F = FitSection;
  static const Keys<F> keys = {
      {"parameters", Kind::texts, Own<F>{read_parameters, written_parameters},
       "[\"mu1\", \"mu2\", \"phase_lag_rad\"]",
       "these (free slides alone: mu1), delay_s, amplitude_mm, angular_frequency_rad_s, mm_per_px, "
       "tilt_x_rad, tilt_y_rad"},
      {"data", Kind::one_of({"summary", "trajectory"}), at<&F::trajectory>, "\"summary\"",
       "each run's displacement (alpha, v); \"trajectory\": every tracked point"},
      {"exact", Kind::true_or_texts, Own<F>{read_exact, written_exact}, "[\"amplitude_mm\"]",
       "what is known without an error although it has no sd (frequency_hz, tilt_x_rad, start_phase_rad, "
       "friction_law, ...); "
       "true: everything, also what is not given"},
      {"hold_out", Kind::texts, at<&F::hold_out>, "[\"run name\"]",
       "driven runs that are not fitted, but predicted by the fit"},
      {"start", Kind::one_of(kStarts), at<&F::start>, "\"rest\"",
       "how runs start at their first analysed frame: rest, circling or steady"},
      {"cycles", Kind::wholes(1, 1'000'000), at<&F::cycles>, "20",
       "whole cycles alpha and v are measured over, at most"},
  };
  return keys;
}

const Keys<CampaignRun>& run_keys() {
  using R = CampaignRun;
  static const Keys<R> keys = {
      {"video", Kind::file, at<&R::video>, "\"phi000_dtau060.cine\"",
       "relative to this file: .cine, video, TIFF stack, folder of pictures, dir/%05d.png"},
      {"track", Kind::file, at<&R::track>, "\"tracker.txt\"",
       "instead of a video: a track of Tracker, Kinovea, DLTdv, trackpy, of columns t_s, x_mm, y_mm, or "
       "ours"},
      {"track_unit", Kind::one_of(kUnits), at<&R::reading, &TrackReading::unit>, "\"mm\"",
       "where it differs from [data]", "track"},
      {"track_y", Kind::one_of({"up", "down"}), at<&R::reading, &TrackReading::y>, "\"up\"",
       "where it differs from [data]", "track"},
      {"track_frame", Kind::one_of(kFrames), at<&R::reading, &TrackReading::frame>, "\"platform\"",
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

namespace {

/// Of [fit.fixed] and [fit.guess].
KeyFacts of_parameter(fit::FitParameter parameter, const char* example, const char* meaning = "") {
  return {fit::to_string(parameter), kind_of(parameter), example, meaning};
}

}  // namespace

const std::vector<CampaignSection>& campaign_sections() {
  using Quantity = fit::FitParameter;
  static const std::vector<CampaignSection> sections = {
      {"", "the campaign as a whole", facts_of(top_keys())},
      {"platform", "xi = A cos(wt) to the right, eta = A_y cos(wt + epsilon) upwards",
       facts_of(platform_keys())},
      {"part", "what lies on the platform", facts_of(part_keys())},
      {"camera", "the picture: its scale, its time, and what lies where in the first analysed frame",
       facts_of(camera_keys())},
      {"scope", "oscilloscope traces that runs name by `scope`", facts_of(scope_keys())},
      {"data", "alpha and v from a spreadsheet, and tracks of other programs", facts_of(data_keys())},
      {"fit", "what is fitted, to what", facts_of(fit_keys())},
      {"fit.fixed",
       "values of mu1, mu2, phase_lag_rad or delay_s that are not among `parameters`",
       {of_parameter(Quantity::mu1, "0.1"), of_parameter(Quantity::mu2, "0.01"),
        of_parameter(Quantity::lag, "0.2"),
        of_parameter(Quantity::delay, "0.003", "the lag as a time, the same at all frequencies")}},
      {"fit.guess",
       "first guesses, where the fit needs better ones than its own",
       {of_parameter(Quantity::mu1, "0.1", "or any other of `parameters`")}},
      {"fit.prior",
       "what is known beforehand of what is fitted",
       {{"mu1", Kind::mean_and_sd, "{ mean = 0.1, sd = 0.01 }", "or any other of `parameters`"}}},
      {"run", "one per recording. Vary phi AND dtau: phi alone cannot separate mu1 from the lag",
       facts_of(run_keys()), true},
  };
  return sections;
}

std::vector<std::string> sections_with(const std::string& key) {
  std::vector<std::string> names;
  for (const CampaignSection& section : campaign_sections())
    if (std::ranges::count(section.keys, key, &KeyFacts::name) > 0) names.push_back(section.name);
  return names;
}

}  // namespace tribotrack::apps
