// tribotrack init: a commented campaign to start from.
#include <fmt/format.h>

#include <memory>

#include "apps/commands/command.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/text/output_file.h"

namespace tribotrack::apps {

namespace {

constexpr const char* kCampaign = R"(# A tribotrack campaign: edit the lines that are not comments, then
#   tribotrack run campaign.toml -o out
# Units stand in the key names. Angles are radians: a number, or a text such as "pi/3" or "60deg".
# Each given quantity may have its standard deviation beside it, KEY_sd: amplitude_mm_sd = 0.001. The intervals count
# it; a value without one is taken as exact, and fit.json lists it under taken_as_exact. What is given and also seen in
# the recordings is compared once for all runs (conditions in fit.json).

# title = "Silver disc, 6 mm, on polished duralumin"   # of the report; else this file's name

[platform]                      # xi = A cos(wt) to the right, eta = A cos(wt + epsilon) upwards
# amplitude_mm = 0.28           # A; leave out to measure it from the marker. 0 = platform at rest
# amplitude_mm_sd = 0.001
# angular_frequency_rad_s = 62.8  # w; likewise
# angular_frequency_rad_s_sd = 0.001
phase_shift_rad = "pi/2"        # epsilon: pi/2 turns clockwise, "-pi/2" counter-clockwise (as seen, y up)
# phase_shift_rad_sd = 0.01
gravity_m_s2 = 9.81             # also: gravity_m_s2_sd
# tilt_x_rad = 0.0              # slope of the platform towards +x, +y: gravity pulls g sin(tilt)
# tilt_x_rad_sd = 0.0002        # what a spirit level leaves open; likewise tilt_y_rad, tilt_y_rad_sd
# amplitude_y_mm = 0.28         # where the platform moves on an ellipse; amplitude_y_mm_sd

[part]
diameter_mm = 6.0               # sets the scale, unless mm_per_px is given
# diameter_mm_sd = 0.005        # by a caliper
# height_mm = 0.8               # with working_distance_mm: the part's top is nearer to the camera than the mark; height_mm_sd

[camera]
# frame_rate_hz = 1000.0        # only where the recording does not give it (see `tribotrack probe VIDEO`)
# frame_rate_reason = "..."     # how you know it, where it is but the playback rate the file states
# frame_rate_hz_sd = 0.01
# mm_per_px = 0.02
# mm_per_px_sd = 0.00002
# working_distance_mm = 100.0   # from lens to platform; working_distance_mm_sd
# rehearse = true               # lossy recordings (x264, MJPEG, MPEG-4): code the tracked motion once more to know the coder's errors
# row_time_s = 0.0              # rolling shutter: from one row of the picture to the next one below
# xi_axis_rad = 0.0             # direction, in the picture, of the platform's displacement when the phase sensor fires
# xi_axis_rad_sd = 0.01
# disc_px = [640, 400, 150]     # x, y, radius in the first frame; leave out to have it found
# marker_px = [200, 180, 24]    # a mark fixed to the platform: x, y, radius in the first frame; leave out where there is none
# marker = "texture"            # without marker_px: by the platform's own texture (as by itself where that moves); "auto": a round mark, else texture; "none"
# gate_px = [30, 30, 6]         # a lamp that is lit while the actuator is on: phi and dtau are measured from it

# [scope]                       # for runs with `scope = "trace.csv"`; `tribotrack probe trace.csv` prints these lines
# sensor_channel = 1            # reference pulses of the platform's phase sensor; 0 = none
# actuator_channel = 2          # the bursts that drive the actuator; 0 = none
# carrier_hz = 5890
# sensor_delay_s = 0.0          # by which the sensor's filter makes its pulse late, with its sd
# sensor_delay_sd_s = 0.0
# tie = "sensor"                # phi counts from the sensor; "trigger": both zero at one trigger; "lamp": phi from gate_px
# trigger_time_s = 0.0          # the trigger in the recording's time; a .cine holds it itself

[fit]
parameters = ["mu1", "mu2", "phase_lag_rad"]
start = "rest"                  # how runs start at their first analysed frame: rest, circling or steady
cycles = 20                     # whole cycles alpha and v are measured over, at most

# data = "trajectory"           # fit every tracked point instead of each run's displacement
# [fit.fixed]                   # values of mu1, mu2, phase_lag_rad or delay_s that are not among `parameters`
# phase_lag_rad = 0.2
# [fit.guess]                   # first guesses, where the fit needs better ones than its own
# mu1 = 0.1
# [fit.prior]                   # what is known beforehand of what is fitted
# mu1 = { mean = 0.1, sd = 0.01 }

# One [[run]] per recording. Vary phi AND dtau: a sweep of phi alone cannot separate mu1 from the lag.
[[run]]
video = "phi000_dtau060.cine"   # relative to this file
phi_rad = 0
dtau_rad = "pi/3"
# phi_rad_sd = 0.005            # of this run alone, as its dtau_rad_sd, amplitude_mm_sd, angular_frequency_rad_s_sd,
# dtau_rad_sd = 0.005           # phase_at_zero_rad_sd, start_phase_rad_sd, mm_per_px_sd beside the run's own values

[[run]]
video = "phi090_dtau060.cine"
phi_rad = "pi/2"
dtau_rad = "pi/3"

[[run]]
video = "phi000_dtau120.cine"
phi_rad = 0
dtau_rad = "2pi/3"

# alpha and v from a spreadsheet: each line, or all lines of one point, becomes a run. Columns phi_deg, dtau_deg, alpha_deg,
# v_mm_s (or phi_rad, v_m_s, ...), alpha_sd_deg, v_sd_mm_s where they are known; separated by , ; or tabs
# [data]
# table = "alpha_v.csv"         # or a list of them
# alpha_sd_rad = "2deg"         # of the lines that have none; else repeats of a point tell
# v_sd_mm_s = 0.1
# track_unit = "mm"             # of tracks whose columns name none; likewise track_y, track_point, track_mark

# The track of another program (Tracker, Kinovea, DLTdv, trackpy, or columns t_s, x_mm, y_mm), or one of `tribotrack track`:
# [[run]]
# track = "tracker.txt"
# track_unit = "mm"             # px (with mm_per_px), um, mm, cm, m
# track_y = "up"                # where its y points, if not down in pixels and up in lengths
# track_point = "mass A"        # which of its points is the part, where there are several
# track_mark = "mass B"         # and which is fixed to the platform, if one is
# phi_rad = 0
# dtau_rad = "pi/3"

# A run measured elsewhere needs no video:
# [[run]]
# phi_rad = 0
# dtau_rad = "pi/6"
# alpha_rad = 5.93
# alpha_sd_rad = 0.02
# v_mm_s = 1.78
# v_sd_mm_s = 0.04

# The part set sliding by hand on the resting platform gives mu1 by itself:
# [[run]]
# video = "free_slide.mp4"
# kind = "free_slide"
# frames = [120, 480]           # from just after it is let go until it leaves the picture or rests
# Film several: they show how mu1 scatters, which one slide cannot.
)";

}  // namespace

void add_init(CLI::App& app, Context& context) {
  auto folder = std::make_shared<std::string>();
  CLI::App& command = *app.add_subcommand("init", "Write a commented campaign to start from");
  command.add_option("DIR", *folder, "Folder to write campaign.toml into; made if it is not there")
      ->required();
  add_common(command, context, "  tribotrack init my_campaign");
  command.callback([folder, &context] {
    create_folder(*folder);
    const std::filesystem::path file = std::filesystem::path(*folder) / "campaign.toml";
    if (std::filesystem::exists(file))
      throw InvalidInput(
          fmt::format("{}: exists already and is not overwritten; give another folder", file.string()));
    write_file(file, kCampaign);
    print("{}\n", file.string());
    say(context.quiet, fmt::format("edit it, then: tribotrack run {} -o {}", file.string(),
                                   (std::filesystem::path(*folder) / "out").string()));
  });
}

}  // namespace tribotrack::apps
