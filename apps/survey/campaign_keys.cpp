#include "apps/survey/campaign_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "apps/files/campaign/campaign.h"

namespace tribotrack::apps {

namespace {

constexpr std::array kSections = {
    CampaignSection{"", "the campaign as a whole"},
    CampaignSection{"platform", "xi = A cos(wt) to the right, eta = A_y cos(wt + epsilon) upwards"},
    CampaignSection{"part", "what lies on the platform"},
    CampaignSection{"camera",
                    "the picture: its scale, its time, and what lies where in the first analysed frame"},
    CampaignSection{"scope", "oscilloscope traces that runs name by `scope`"},
    CampaignSection{"data", "alpha and v from a spreadsheet, and tracks of other programs"},
    CampaignSection{"fit", "what is fitted, to what"},
    CampaignSection{"fit.fixed",
                    "values of mu1, mu2, phase_lag_rad or delay_s that are not among `parameters`"},
    CampaignSection{"fit.guess", "first guesses, where the fit needs better ones than its own"},
    CampaignSection{"fit.prior", "what is known beforehand of what is fitted"},
    CampaignSection{"run", "one per recording. Vary phi AND dtau: phi alone cannot separate mu1 from the lag",
                    true},
};

constexpr std::array kKeys = {
    CampaignKey{"", "title", "\"Silver disc, 6 mm, on polished duralumin\"",
                "of the report; else this file's name"},

    CampaignKey{"platform", "amplitude_mm", "0.28",
                "A; leave out to measure it from mark or texture. 0: platform at rest"},
    CampaignKey{"platform", "amplitude_mm_sd", "0.001",
                "its standard deviation; without one it is taken as exact", "amplitude_mm"},
    CampaignKey{"platform", "amplitude_y_mm", "0.28", "A_y, where the platform moves on an ellipse"},
    CampaignKey{"platform", "amplitude_y_mm_sd", "0.001", "", "amplitude_y_mm"},
    CampaignKey{"platform", "angular_frequency_rad_s", "62.8", "w; leave out to measure it"},
    CampaignKey{"platform", "angular_frequency_rad_s_sd", "0.001", "", "angular_frequency_rad_s"},
    CampaignKey{"platform", "phase_shift_rad", "\"pi/2\"",
                "epsilon: pi/2 turns clockwise, \"-pi/2\" counter-clockwise, as seen with y up; leave out to "
                "measure it"},
    CampaignKey{"platform", "phase_shift_rad_sd", "0.01", "", "phase_shift_rad"},
    CampaignKey{"platform", "gravity_m_s2", "9.81", ""},
    CampaignKey{"platform", "gravity_m_s2_sd", "0.001", "", "gravity_m_s2"},
    CampaignKey{"platform", "tilt_x_rad", "\"0.1deg\"",
                "slope of the platform towards +x (right): gravity pulls with g sin(tilt)"},
    CampaignKey{"platform", "tilt_x_rad_sd", "0.0002", "what a spirit level leaves open", "tilt_x_rad"},
    CampaignKey{"platform", "tilt_y_rad", "0.0", "likewise towards +y (up)"},
    CampaignKey{"platform", "tilt_y_rad_sd", "0.0002", "", "tilt_y_rad"},

    CampaignKey{"part", "name", "\"disc\"",
                "where there are several: a [[part]] of its own for each; each gets its own fit"},
    CampaignKey{"part", "disc_px", "[640, 400, 150]", "where it lies at first, unless the run says"},
    CampaignKey{"part", "template_px", "[100, 40, 41, 41]", "instead of a disc"},
    CampaignKey{"part", "diameter_mm", "6.0", "sets the scale, unless mm_per_px or a calibration does"},
    CampaignKey{"part", "diameter_mm_sd", "0.005", "by a caliper", "diameter_mm"},
    CampaignKey{"part", "diameter_sd_mm", "0.005", "earlier name of diameter_mm_sd", "diameter_mm"},
    CampaignKey{"part", "height_mm", "0.8",
                "with working_distance_mm: the part's top is nearer to the camera than the mark"},
    CampaignKey{"part", "height_mm_sd", "0.01", "", "height_mm, working_distance_mm"},

    CampaignKey{"camera", "frame_rate_hz", "1000.0",
                "only where the recording does not give it (see `tribotrack probe VIDEO`)"},
    CampaignKey{"camera", "frame_rate_reason", "\"the camera's display\"",
                "how you know it, where the file states the rate of playback", "frame_rate_hz"},
    CampaignKey{"camera", "frame_rate_hz_sd", "0.01", "", "frame_rate_hz"},
    CampaignKey{"camera", "mm_per_px", "0.02", "leave out to scale by the part's diameter"},
    CampaignKey{"camera", "tag_mm", "8.0",
                "side of the tag's black square, where `marker` is one: sets the scale"},
    CampaignKey{"camera", "tag_mm_sd", "0.02", "as printed", "tag_mm"},
    CampaignKey{"camera", "mm_per_px_sd", "0.00002", "", "mm_per_px"},
    CampaignKey{"camera", "calibration", "\"calibration.json\"",
                "by `tribotrack calibrate`, instead of mm_per_px"},
    CampaignKey{"camera", "working_distance_mm", "100.0", "from lens to platform"},
    CampaignKey{"camera", "working_distance_mm_sd", "1.0", "", "working_distance_mm, height_mm"},
    CampaignKey{"camera", "row_time_s", "0.00001",
                "rolling shutter: from one row of the picture to the next one below"},
    CampaignKey{"camera", "xi_axis_rad", "0.0",
                "direction, in the picture, of the platform's displacement when the phase sensor fires"},
    CampaignKey{"camera", "xi_axis_rad_sd", "0.01", "", "xi_axis_rad"},
    CampaignKey{"camera", "disc_px", "[640, 400, 150]",
                "x, y, radius in the first frame; leave out to have it found"},
    CampaignKey{
        "camera", "template_px", "[100, 40, 41, 41]",
        "instead of a disc: x, y, width, height of a part of any shape in the first frame; needs mm_per_px"},
    CampaignKey{"camera", "marker_px", "[200, 180, 24]",
                "a mark fixed to the platform; leave out where there is none"},
    CampaignKey{"camera", "marker", "\"texture\"",
                "without marker_px: by the platform's own texture (as by itself where that moves); \"auto\": "
                "a round mark, else texture; \"none\"; \"tag:apriltag_36h11:3\": an ArUco or AprilTag tag"},
    CampaignKey{"camera", "gate_px", "[30, 30, 6]",
                "a lamp that is lit while the actuator is on: phi and dtau are measured from it"},

    CampaignKey{"scope", "sensor_channel", "1", "reference pulses of the platform's phase sensor; 0: none"},
    CampaignKey{"scope", "actuator_channel", "2", "the bursts that drive the actuator; 0: none"},
    CampaignKey{"scope", "carrier_hz", "5890", "of the bursts"},
    CampaignKey{"scope", "sensor_delay_s", "0.0", "by which the sensor's filter makes its pulse late"},
    CampaignKey{"scope", "sensor_delay_sd_s", "0.00001", ""},
    CampaignKey{
        "scope", "tie", "\"sensor\"",
        "phi counts from the sensor; \"trigger\": both zero at one trigger; \"lamp\": phi from gate_px"},
    CampaignKey{"scope", "trigger_time_s", "0.0",
                "the trigger in the recording's time; a .cine holds it itself"},
    CampaignKey{"scope", "tie_sd_s", "0.00001", "of that tie"},

    CampaignKey{"data", "table", "\"alpha_v.csv\"",
                "or a list; every point becomes a run: columns phi_deg, dtau_deg, alpha_deg, v_mm_s (or "
                "phi_rad, ...), "
                "alpha_sd_deg, v_sd_mm_s; separated by , ; or tabs"},
    CampaignKey{"data", "alpha_sd_rad", "\"2deg\"",
                "of the lines that have none; else repeats of a point tell", "table"},
    CampaignKey{"data", "v_sd_mm_s", "0.1", "likewise", "table"},
    CampaignKey{"data", "track_unit", "\"mm\"",
                "of tracks whose columns name none: px (with mm_per_px), um, mm, cm, m"},
    CampaignKey{"data", "track_y", "\"up\"",
                "where y of tracks points, if not down in pixels and up in lengths"},
    CampaignKey{"data", "track_point", "\"mass A\"",
                "which point of tracks is the part, where there are several"},
    CampaignKey{"data", "track_mark", "\"mass B\"", "and which is fixed to the platform, if one is"},

    CampaignKey{"fit", "parameters", "[\"mu1\", \"mu2\", \"phase_lag_rad\"]",
                "these (free slides alone: mu1), delay_s, amplitude_mm, angular_frequency_rad_s, mm_per_px, "
                "tilt_x_rad, tilt_y_rad"},
    CampaignKey{"fit", "data", "\"summary\"",
                "each run's displacement (alpha, v); \"trajectory\": every tracked point"},
    CampaignKey{"fit", "start", "\"rest\"",
                "how runs start at their first analysed frame: rest, circling or steady"},
    CampaignKey{"fit", "cycles", "20", "whole cycles alpha and v are measured over, at most"},
    CampaignKey{"fit.fixed", "mu1", "0.1", ""},
    CampaignKey{"fit.fixed", "mu2", "0.01", ""},
    CampaignKey{"fit.fixed", "phase_lag_rad", "0.2", ""},
    CampaignKey{"fit.fixed", "delay_s", "0.003", "the lag as a time, the same at all frequencies"},
    CampaignKey{"fit.guess", "mu1", "0.1", "or any other of `parameters`"},
    CampaignKey{"fit.prior", "mu1", "{ mean = 0.1, sd = 0.01 }", "or any other of `parameters`"},

    CampaignKey{"run", "video", "\"phi000_dtau060.cine\"",
                "relative to this file: .cine, video, TIFF stack, folder of pictures, dir/%05d.png"},
    CampaignKey{"run", "track", "\"tracker.txt\"",
                "instead of a video: a track of Tracker, Kinovea, DLTdv, trackpy, of columns t_s, x_mm, "
                "y_mm, or ours"},
    CampaignKey{"run", "track_unit", "\"mm\"", "where it differs from [data]", "track"},
    CampaignKey{"run", "track_y", "\"up\"", "where it differs from [data]", "track"},
    CampaignKey{"run", "track_point", "\"mass A\"", "where it differs from [data]", "track"},
    CampaignKey{"run", "track_mark", "\"mass B\"", "where it differs from [data]", "track"},
    CampaignKey{"run", "name", "\"first\"", "of its results; else the recording's"},
    CampaignKey{
        "run", "kind", "\"free_slide\"",
        "set sliding by hand on the platform at rest; gives mu1 by itself (film several). Else \"pulses\""},
    CampaignKey{"run", "slope_rad", "\"20deg\"",
                "of a free slide on an incline: > 0 slides down, < 0 is pushed up; mu1 = tan(slope) - a/(g "
                "cos(slope))",
                "kind"},
    CampaignKey{"run", "slope_rad_sd", "0.002", "the same for all inclines of the campaign",
                "kind, slope_rad"},
    CampaignKey{"run", "phi_rad", "\"45deg\"", "commanded phase of the pulse"},
    CampaignKey{"run", "phi_rad_sd", "0.005", "of this run alone", "phi_rad"},
    CampaignKey{"run", "dtau_rad", "\"pi/3\"", "commanded width of the pulse"},
    CampaignKey{"run", "dtau_rad_sd", "0.005", "", "dtau_rad"},
    CampaignKey{"run", "frames", "[120, 480]", "first and last image number, both included"},
    CampaignKey{"run", "start", "\"rest\"", "where it differs from [fit]"},
    CampaignKey{"run", "cycles", "20", "where it differs from [fit]"},
    CampaignKey{"run", "amplitude_mm", "0.28", "where it differs from [platform]"},
    CampaignKey{"run", "amplitude_mm_sd", "0.001", "", "amplitude_mm"},
    CampaignKey{"run", "angular_frequency_rad_s", "62.8", "where it differs from [platform]"},
    CampaignKey{"run", "angular_frequency_rad_s_sd", "0.001", "", "angular_frequency_rad_s"},
    CampaignKey{"run", "phase_at_zero_rad", "0.0",
                "the platform's phase at the recording's first image, where nothing shows it"},
    CampaignKey{"run", "phase_at_zero_rad_sd", "0.01", "", "phase_at_zero_rad"},
    CampaignKey{"run", "start_phase_rad", "0.0", "the platform's phase at the start of a run without video"},
    CampaignKey{"run", "start_phase_rad_sd", "0.01", "", "start_phase_rad"},
    CampaignKey{"run", "mm_per_px", "0.02", "where it differs from [camera]"},
    CampaignKey{"run", "mm_per_px_sd", "0.00002", "", "mm_per_px"},
    CampaignKey{"run", "disc_px", "[640, 400, 150]", "where it differs from [camera]"},
    CampaignKey{"run", "template_px", "[100, 40, 41, 41]", "where it differs from [camera]", "mm_per_px"},
    CampaignKey{"run", "part", "\"disc\"", "which of several [[part]] this run shows"},
    CampaignKey{
        "run", "parts", "{ disc = [640, 400, 150] }",
        "several in one recording: where each lies at first, [x, y, radius] or [x, y, width, height]"},
    CampaignKey{"run", "marker_px", "[200, 180, 24]", "where it differs from [camera]"},
    CampaignKey{"run", "scope", "\"phi000_dtau060.csv\"",
                "oscilloscope trace: phi and dtau are measured from it; [\"CH1.csv\", \"CH2.csv\"] where a "
                "file holds one channel"},
    CampaignKey{
        "run", "alpha_rad", "5.93",
        "measured elsewhere, with the three below, instead of a video: direction of the displacement"},
    CampaignKey{"run", "alpha_sd_rad", "0.02", ""},
    CampaignKey{"run", "v_mm_s", "1.78", "mean velocity"},
    CampaignKey{"run", "v_sd_mm_s", "0.04", ""},
};

}  // namespace

std::span<const CampaignSection> campaign_sections() {
  return kSections;
}

std::span<const CampaignKey> campaign_keys() {
  return kKeys;
}

std::string campaign_reference() {
  const std::vector<AskedKey> asked = keys_asked_of_campaign();
  const auto kind_of = [&](const CampaignKey& key) -> std::string {
    const auto found = std::ranges::find_if(
        asked, [&](const AskedKey& a) { return a.section == key.section && a.key == key.key; });
    return found == asked.end() ? "" : found->kind;
  };
  std::string text =
      "A campaign is a TOML file: a lab's recordings and what is to be learnt from them. Units stand in the "
      "names of "
      "keys.\nAngles are radians, or texts such as \"11pi/9\", \"-pi/2\", \"90deg\". KEY_sd is a standard "
      "deviation; a "
      "quantity\nwithout one is taken as exact. `tribotrack init DIR` writes a campaign to start from.\n";
  for (const CampaignSection& section : kSections) {
    text += section.name.empty() ? fmt::format("\nFirst: {}\n", section.remark)
            : section.repeated   ? fmt::format("\n[[{}]]  {}\n", section.name, section.remark)
                                 : fmt::format("\n[{}]  {}\n", section.name, section.remark);
    for (const CampaignKey& key : kKeys) {
      if (key.section != section.name) continue;
      text += fmt::format("  {:<30} {}\n", fmt::format("{} = {}", key.key, key.example), kind_of(key));
      if (!key.meaning.empty()) text += fmt::format("      {}\n", key.meaning);
    }
  }
  return text;
}

}  // namespace tribotrack::apps
