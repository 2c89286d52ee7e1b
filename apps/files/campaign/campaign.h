// The campaign file: a lab's recordings and what is to be learnt from them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/files/camera.h"
#include "apps/files/campaign/data_section.h"
#include "apps/files/scenario_file.h"
#include "apps/text/input_file.h"
#include "apps/text/json.h"
#include "apps/text/strict_toml.h"
#include "fit/problem.h"
#include "model/scenario.h"
#include "vision/picture.h"

namespace tribotrack::apps {

/// [scope]: which channel is what, and how its time is tied to the camera's.
struct ScopeSection {
  int sensor_channel = 1, actuator_channel = 2;  ///< 1 = the file's first; 0 = there is none
  double carrier_hz = 5890;
  double sensor_delay_s = 0, sensor_delay_sd_s = 0;
  std::string tie = "sensor";  ///< "sensor", "trigger", "lamp"
  std::optional<double> trigger_time_s;
  double tie_sd_s = 0;
};

/// What a campaign takes as exact: the keys of quantities whose values have no error.
struct Exact {
  bool all = false;  ///< everything without an sd, given or by default
  std::vector<std::string> keys;
  bool holds(std::string_view key) const;
};

struct FitSection {
  bool parameters_given = false;  ///< else: mu1 alone where all runs are free slides
  std::vector<fit::FitParameter> parameters = {fit::FitParameter::mu1, fit::FitParameter::mu2,
                                               fit::FitParameter::lag};
  bool trajectory = false;                  ///< data = "trajectory"
  model::Start start = model::Start::rest;  ///< of runs that do not say otherwise, as `cycles`
  int cycles = 20;
  // In campaign units: mm, rad, s, mm/px.
  std::map<fit::FitParameter, double> fixed, guess;
  std::map<fit::FitParameter, fit::Prior> prior;
  Exact exact;
  std::vector<std::string> hold_out;  ///< names of runs
};

/// One [[run]], or a point of a table, defaults of the campaign filled in.
struct CampaignRun {
  std::string name;   ///< given, else the video's or track's stem, else "runNN"; unique
  std::string place;  ///< "campaign.toml:31:1"
  std::optional<std::filesystem::path> video;  ///< resolved against the campaign's folder
  std::optional<std::filesystem::path> track;  ///< a finished track instead, ours or another program's
  TrackReading reading;                        ///< of that track
  bool has_track() const { return video || track; }
  /// Which of the campaign's parts, where there are several: one, or where each lies at first.
  std::string part;
  std::map<std::string, vision::Target> parts;
  bool free_slide = false;
  /// Of a free slide on an incline, as in fit::TrajectoryRun. rad
  std::optional<double> slope, slope_sd;
  double phi = 0, dtau = 0;                            ///< rad
  std::optional<double> amplitude, angular_frequency;  ///< SI, of this run
  std::optional<double> phase_at_zero, start_phase;    ///< rad
  // Of the above, in the same units; empty: default_sd().
  std::optional<double> phi_sd, dtau_sd, amplitude_sd, angular_frequency_sd, phase_at_zero_sd, start_phase_sd;
  Digits digits = {};  ///< of what is given
  model::Start start = model::Start::rest;
  int cycles = 20;
  std::optional<std::int64_t> first_frame, last_frame;
  std::int64_t frame_step = 1;
  std::optional<double> mm_per_px, mm_per_px_sd;
  vision::Target target;  ///< the part in the first analysed frame
  std::optional<vision::Circle> marker_px;
  std::optional<std::filesystem::path> scope, second_scope;  ///< two where a file holds one channel
  // Measured elsewhere.
  std::optional<double> alpha, alpha_sd;  ///< rad
  std::optional<double> v, v_sd;          ///< m/s
  std::vector<std::string> pooled_from;   ///< places of a table's lines, where there are several
};

struct Campaign {
  std::filesystem::path file;
  Input input;        ///< the file, with the hash of the text that was read
  std::string title;  ///< of the report; empty: the file's name
  PlatformSection platform;
  PartSection part;
  std::vector<PartSection> parts;  ///< of [[part]], where there are two or more; then `part` is empty
  CameraSection camera;
  ScopeSection scope;
  DataSection data;
  FitSection fit;
  std::vector<CampaignRun> runs;
  std::vector<Input> table_inputs;  ///< the tables that runs were read from
  std::vector<std::string> notes;   ///< sentences on what was read, for the user to know
  /// Keys that are understood but not yet acted on, each a sentence for the user.
  std::vector<std::string> warnings;
  /// For meta files: what holds, defaults filled in.
  Json effective_configuration() const;
  /// Every file a command on this campaign may read, none of which it may write.
  std::vector<std::filesystem::path> input_files() const { return input_files(runs); }
  /// Of these runs alone.
  std::vector<std::filesystem::path> input_files(const std::vector<CampaignRun>& of) const;
};

/// The file that was meant by what was given: itself, or the campaign.toml of a folder. Throws InvalidInput
/// for a folder without one and for standard input, which has no place that paths could be relative to.
std::filesystem::path campaign_file(const std::filesystem::path& given);

/// May a campaign stand without a [[run]]?
enum class Runs { required, may_be_missing };
/// Where `run` writes unless it is told: CAMPAIGN-out for CAMPAIGN.toml.
std::filesystem::path output_of(const std::filesystem::path& campaign);
/// Reads and checks a campaign. Throws InvalidInput with file, line and column.
Campaign read_campaign(const std::filesystem::path& file, Runs runs = Runs::required);

/// A campaign for each of its parts, in their order; itself where it has one. Throws InvalidInput for a part
/// without runs.
std::vector<Campaign> campaigns_by_part(const Campaign& campaign);
/// That of the part named; of the only one for "". Throws InvalidInput naming the parts.
Campaign campaign_of_part(const Campaign& campaign, const std::string& part);

/// The same from a JSON object of the file's structure; `name` stands in messages. Paths are relative to the
/// working folder.
Campaign campaign_of(const Json& object, const std::string& name);

/// The parameters that can be fitted, and the one of a name.
const std::vector<fit::FitParameter>& fit_parameters();
std::optional<fit::FitParameter> fit_parameter_named(const std::string& name);

/// The sd of a value that is given without one, in the unit of its key: of its last digit or of the trade,
/// the larger; 0 where it is exact. For want of a key "amplitude_ratio", A_y/A where no A_y is given.
double default_sd(const Exact& exact, std::string_view key, double value, const Digits& digits);

/// Factor from campaign units (mm) to SI (m).
double si_per_campaign_unit(fit::FitParameter parameter);

}  // namespace tribotrack::apps
