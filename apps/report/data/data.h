// Everything the report page shows, as plain numbers and text: from_results.h and from_files.h fill it,
// page/page.h turns it into HTML. Units stand in the names, as in the result files; NaN = no value.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "fit/fit_result.h"
#include "vision/track.h"

namespace tribotrack::apps {

inline constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

/// The profile likelihood of a parameter: by how much chi-square rises when it is held there and all others
/// are fitted again. Ascending by value; empty where it was not computed.
struct ReportProfile {
  std::vector<double> value, rise;
  double level = no_value;  ///< rise at the ends of the 95 % interval
};

/// An interval; -infinity / +infinity where open, NaN where not computed.
struct ReportInterval {
  double low = no_value;
  double high = no_value;
};

/// A fitted parameter in the unit its campaign key carries.
struct ReportParameter {
  std::string name;  ///< campaign key: "mu1", "phase_lag_rad", "amplitude_mm", ...
  double estimate = no_value;
  double sd = no_value;
  ReportInterval ci95;                 ///< to quote
  std::vector<ReportInterval> pieces;  ///< of it, where there are more than one
  ReportInterval covariance_ci95;      ///< from the covariance
  ReportInterval profile_ci95;         ///< from the profile likelihood
  ReportInterval bootstrap_ci95 = {};  ///< from refits to simulated data; only on request
  ReportProfile profile = {};
};

/// A source of uncertainty.
struct ReportBudgetEntry {
  std::string source, quantity, from;
  double sd = no_value;              ///< of the quantity, in the unit of its name
  bool counted = true;               ///< false: taken as exact
  std::vector<double> contribution;  ///< sd that it gives to each parameter, in their order and units
};

/// A value that was given, not fitted.
struct ReportGiven {
  std::string name;  ///< campaign key
  double value = no_value;
  std::string source;  ///< "campaign", "measured from the marker", ...
};

/// A condition that all runs share, in the unit that its key carries.
struct ReportCondition {
  std::string quantity;  ///< campaign key
  double given = no_value, given_sd = no_value, measured = no_value, sd = no_value;
  double difference_in_sd = no_value;  ///< measured less given
  double used = no_value, used_sd = no_value;
  std::string from;  ///< where the used one came from
};

/// One observable of one run against the model.
struct ReportResidual {
  std::string observable;  ///< "dx_mm", "dy_mm", "alpha_rad", "v_mm_s", ...
  double measured = no_value;
  double modelled = no_value;
  double sd = no_value;
  double standardised = no_value;
};

/// One stage of the plan: done or left out, and why.
struct ReportStage {
  std::string stage;
  bool on = true;
  std::string reason;                ///< with its figure
  double error_bound_px = no_value;  ///< what leaving it out can add to a position; NaN: nobody computed it
};

/// A multiple of the drive's frequency in the platform's motion.
struct ReportHarmonic {
  int order = 2;
  double amplitude_mm = no_value, amplitude_sd_mm = no_value;
  double amplitude_y_mm = no_value, amplitude_y_sd_mm = no_value;
};

/// Platform and gate of one recording: what was measured, and its drawings (platform_drawing.h).
struct ReportPlatform {
  std::vector<double> orbit_x_mm, orbit_y_mm, time_s, phase_left_mrad;  ///< one per tracked frame
  std::vector<double> model_x_mm, model_y_mm;                           ///< one fitted turn
  std::vector<double> gate_phase_rad, gate_share;  ///< the lamp folded, empty without one
  std::vector<double> gate_model_phase_rad, gate_model_share;
  double amplitude_mm = no_value, amplitude_sd_mm = no_value;
  double amplitude_y_mm = no_value, amplitude_y_sd_mm = no_value;
  double w_rad_s = no_value, w_sd_rad_s = no_value;
  double epsilon_rad = no_value, epsilon_sd_rad = no_value;
  double phase_at_zero_rad = no_value;
  double drift_rad_s2 = no_value, drift_sd_rad_s2 = no_value;
  double phi_rad = no_value, phi_sd_rad = no_value;
  double dtau_rad = no_value, dtau_sd_rad = no_value;
  std::string gate_source;  ///< "lamp", "scope", "lamp and scope"; empty: as commanded
  double lamp_off_level = no_value, lamp_on_level = no_value;  ///< grey levels; where the lamp gave phi
  std::vector<ReportHarmonic> harmonics;                       ///< those above their noise
};

/// One run of the campaign. Free slides stand in the table of runs too; their figure is a ReportSlide.
struct ReportRun {
  std::string name;
  std::string video;    ///< empty for a run measured elsewhere
  std::string kind;     ///< "displacement", "trajectory", "free_slide"
  std::string failure;  ///< one sentence; empty if all went well. A failed run is not part of the fit.
  double phi_rad = no_value;
  double dtau_rad = no_value;
  double alpha_rad = no_value, alpha_sd_rad = no_value;
  double v_mm_s = no_value, v_sd_mm_s = no_value;
  double modelled_alpha_rad = no_value, modelled_v_mm_s = no_value;
  int cycles = 0;  ///< N
  std::size_t frames_ok = 0, frames_lost = 0, frames_edge = 0;
  double frame_rate_hz = no_value;
  std::string time_base;           ///< where the frame rate comes from
  double sigma_px = no_value;      ///< median sd of a tracked position, per axis
  std::vector<std::string> notes;  ///< short remarks under the table: "measured in the camera's frame", ...

  /// Path over the first frame, in the recording's pixels; NaN where the part was not measured.
  std::vector<double> x_px, y_px;
  /// The first analysed frame as PNG or JPEG; may be smaller than the recording (it is stretched to
  /// frame_width_px x frame_height_px). Empty: no picture.
  std::vector<unsigned char> first_frame;
  int frame_width_px = 0, frame_height_px = 0;

  /// Path in the platform's frame (or the camera's, see notes), y up; NaN where not measured.
  std::vector<double> x_mm, y_mm;
  /// The model's path at the fitted parameters at the same times, and where the part was after each whole
  /// cycle (model_path.h). Empty where there is no fit, or the path holds the platform's motion.
  std::vector<double> model_x_mm, model_y_mm, cycle_x_mm, cycle_y_mm;
  /// Of every frame; NaN where the part was not measured.
  std::vector<double> time_s, sigma_all_px, ncc;
  std::vector<double> influence;  ///< change of each parameter without this run, in its sd; empty: not known

  /// The part's rotation over time, NaN where it is not seen; empty where it is nowhere.
  std::vector<double> theta_rad;
  double sigma_theta_rad = no_value;  ///< median sd

  std::vector<ReportResidual> residuals;
  bool in_camera_frame = false;                 ///< the path holds the platform's motion
  std::size_t points = 0, outlying_points = 0;  ///< trajectory fits: used, and of them beyond 6 sigma
  std::vector<ReportStage> plan;
  vision::Audit audit;
  ReportPlatform platform;
};

/// Runs that differ in one of phi, dtau and share the other, with the model's curve through them.
/// Made by group_over_phi / group_over_dtau (groups.h), the curve by add_curves (curves.h).
struct ReportGroup {
  double shared_rad = no_value;     ///< dtau of a group over phi, phi of a group over dtau
  std::vector<std::size_t> runs;    ///< indices into ReportData::runs
  std::vector<double> curve_x_rad;  ///< the varied parameter
  std::vector<double> curve_alpha_rad,
      curve_alpha_sd_rad;  ///< sd by the parameters' covariance; NaN: not known
  std::vector<double> curve_v_mm_s, curve_v_sd_mm_s;
};

/// A part sliding freely on the resting platform: distance along its path against time.
struct ReportSlide {
  std::string name;
  std::vector<double> time_s;
  std::vector<double> position_mm;
  std::vector<double> sigma_mm;   ///< per point; may be empty
  std::vector<double> fitted_mm;  ///< the model at the fitted parameters, same times
  std::string sentence;           ///< its result: "Initial speed 812 mm/s; ..."
};

/// A free slide by itself.
struct ReportSlideResult {
  std::string name;
  double mu1 = no_value, mu1_sd = no_value;
  ReportInterval ci95 = {};
  double chi2 = no_value, p_value = no_value;
  int dof = 0;
  std::int64_t first_frame = 0, last_frame = 0;
  bool spin_seen = false;
  double spin_rad_s = no_value, spin_rad_s_sd = no_value, spin_ratio = no_value, spin_ratio_sd = no_value;
  double slope_rad = 0;                   ///< of its incline; 0: level
  double change_by_half_spin = no_value;  ///< of mu1, relative; where no spin was seen
  std::vector<std::int64_t> blow_frames = {};
  std::string sentence = {};
};

/// A run that contradicts the others.
struct ReportOutlier {
  std::string run;
  double deviation = no_value;           ///< standard deviations from the fit to the others
  double chance = no_value;              ///< that the largest of so many runs lies as far
  double looks_like_phi_rad = no_value;  ///< where a wrong phi alone explains it
};

/// One friction model among those compared.
struct ReportModel {
  std::string name;
  int unknowns = 0;
  double chi2 = no_value, aic = no_value, bic = no_value;
  std::string finding;  ///< its own parameters, as a sentence
};

/// A run worth filming, and the intervals to expect with it.
struct ReportNextRun {
  double phi_rad = no_value, dtau_rad = no_value;
  double amplitude_mm = no_value, w_rad_s = no_value;
  std::string aim;  ///< campaign key of the parameter it is for; empty: all of them
  std::vector<ReportInterval> predicted_ci95;  ///< in the order of parameters
  std::string sentence;
};

enum class ReportVerdict { identifiable, weak, not_identifiable };

/// An input file by its bytes.
struct ReportSource {
  std::string name;
  std::string hash;  ///< with its kind: "xxh3-128:...", and what of the file it is of where not all
};

struct ReportData {
  std::string title = "tribotrack report";
  std::string part;    ///< "6 × 0.8 mm", empty where it is not stated
  std::string filmed;  ///< day or days of the recordings, empty where they do not say
  std::vector<std::string> warnings;
  std::vector<std::string> missing;  ///< of the warnings, those about files that are gone from the folder

  bool converged = false;
  bool fitted = true;  ///< false: there is no fit (yet); the page shows the measurements alone
  std::vector<ReportParameter> parameters;
  std::vector<ReportGiven> given;
  std::vector<ReportCondition> conditions;
  std::vector<std::vector<double>> correlation;  ///< in the order of parameters
  std::string phase_reference;                   ///< what phi counts from: a sentence
  double chi2 = no_value;
  int dof = 0;
  fit::Agreement agreement = fit::Agreement::unknown;  ///< of model and data, as the fit judged it
  double scatter_mm = 0;           ///< added per axis because the residuals exceed the errors; 0: none
  std::string covariance_meaning;  ///< a sentence
  ReportVerdict identifiability = ReportVerdict::identifiable;
  std::vector<std::string> weak_directions;
  std::vector<std::string> other_minima;  ///< that fit nearly as well, a sentence each
  std::string next_experiment;            ///< a sentence
  std::vector<ReportNextRun> next_runs;   ///< the best for all parameters first

  int bootstrap_refits = 0;  ///< 0: none requested
  unsigned bootstrap_seed = 0;
  std::string shared_scale;             ///< the scale the recordings share: a sentence
  double p_value = no_value;            ///< of chi-square before scatter seen in the residuals was added
  double runs_test_p_value = no_value;  ///< small: neighbouring residuals share their sign
  std::vector<ReportOutlier> outliers;  ///< farthest first
  std::vector<ReportModel> models;      ///< the one fitted first; empty where none was compared
  std::vector<std::string> left_out;    ///< analyses that were not needed, and why
  bool scatter_dominates = false;       ///< FitResult::scatter_dominates
  std::vector<ReportBudgetEntry> budget;
  std::string improve_first;
  std::vector<std::string> systematics;  ///< effect of an error in a given value, a sentence each

  std::vector<ReportRun> runs;
  std::vector<ReportGroup> over_phi;   ///< figures 9a and v against phi
  std::vector<ReportGroup> over_dtau;  ///< figures 9b and 10
  std::vector<ReportSlide> slides;
  std::vector<ReportSlideResult> slide_results;  ///< mu1 slide by slide
  double between_slides = 0;                     ///< sd of mu1 between them
  double between_slides_p_value = no_value;      ///< that they differ so by chance; NaN for a single slide

  std::string program_version;
  std::vector<ReportSource> inputs;
  std::string configuration;  ///< effective, as text
};

}  // namespace tribotrack::apps
