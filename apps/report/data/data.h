// What a campaign's report shows: the fit's result, its runs with their tracks, and where all of it came
// from. page/page.h turns it into HTML. NaN = no value.
#pragma once

#include <limits>
#include <map>
#include <string>
#include <vector>

#include "apps/files/run_folder.h"
#include "apps/files/track_file.h"
#include "fit/fit_result.h"
#include "fit/measurement.h"

namespace tribotrack::apps {

inline constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

/// A quantity that was not fitted, in the unit that its key carries.
struct ReportCondition {
  std::string quantity;  ///< campaign key
  double given = no_value, given_sd = no_value, measured = no_value, sd = no_value;
  double difference_in_sd = no_value;  ///< measured less given
  double used = no_value, used_sd = no_value;
  std::string from;  ///< where the used one came from
};

/// One run of the campaign.
struct ReportRun {
  std::string name;
  std::string video;  ///< or another program's track; empty for a run measured elsewhere
  bool free_slide = false;
  std::string failure;  ///< one sentence; empty if all went well. A failed run is not part of the fit.
  double phi_rad = no_value, dtau_rad = no_value;

  /// What was measured or, of a run measured elsewhere, given: by the keys and in the units of
  /// measurements/NAME.json, "alpha_rad", "v_mm_s", "amplitude_mm", ...
  std::map<std::string, fit::Estimate> measured;
  fit::Estimate value(const std::string& key) const {
    const auto found = measured.find(key);
    return found == measured.end() ? fit::Estimate{no_value, no_value} : found->second;
  }
  int cycles = 0;                        ///< N
  std::vector<fit::Harmonic> harmonics;  ///< of the platform's motion, those above their noise
  std::string gate_source;               ///< "lamp", "scope", "lamp and scope"; empty: as commanded

  Track track;  ///< at the scale used; empty without one
  std::size_t frames_ok() const { return track.frames - track.lost - track.edge - track.repeats; }
  /// Median sds of a tracked position, per axis, and of a rotation.
  double sigma_px = no_value, sigma_theta_rad = no_value;
  std::vector<unsigned char>
      first_frame;                 ///< the first analysed one as PNG or JPEG, maybe reduced; may be empty
  std::vector<std::string> notes;  ///< short remarks under the table: "measured in the camera's frame", ...

  fit::RunResult fitted;  ///< without residuals where it took no part in the fit
  double residual(const char* observable, double fit::Residual::*number) const {
    for (const fit::Residual& r : fitted.residuals)
      if (r.observable == observable) return r.*number;
    return no_value;
  }
  double modelled(const char* observable) const { return residual(observable, &fit::Residual::modelled); }

  /// The model's path at the fitted parameters at the track's times, and where the part was after each whole
  /// cycle (add_model_path). Empty where there is no fit, or the path holds the platform's motion.
  std::vector<double> model_x_mm, model_y_mm, cycle_x_mm, cycle_y_mm;
  /// The platform as seen and as measured (add_drawings); empty without a mark.
  fit::PlatformPicture platform;
};

/// Runs that differ in one of phi, dtau and share the other, with the model's curve through them.
/// Made by groups_over(), the curve by add_curves (curves.h).
struct ReportGroup {
  double shared_rad = no_value;     ///< dtau of a group over phi, phi of a group over dtau
  std::vector<std::size_t> runs;    ///< indices into ReportData::runs
  std::vector<double> curve_x_rad;  ///< the varied parameter
  std::vector<double> curve_alpha_rad,
      curve_alpha_sd_rad;  ///< sd by the parameters' covariance; NaN: not known
  std::vector<double> curve_v_mm_s, curve_v_sd_mm_s;
};

struct ReportData {
  std::string title = "tribotrack report";
  std::string part;    ///< "6 × 0.8 mm", empty where it is not stated
  std::string filmed;  ///< day or days of the recordings, empty where they do not say
  std::vector<std::string> warnings;
  std::vector<std::string> missing;  ///< of the warnings, those about files that are gone from the folder

  /// In the units of the keys (fit::in_key_units); its runs and warnings stand in `runs` and `warnings`.
  /// Without parameters there is no fit: the page shows the measurements alone.
  fit::FitResult fit;
  bool fitted() const { return !fit.parameters.empty(); }
  std::vector<fit::NextExperiment> next_runs() const;  ///< the best for all parameters first
  std::vector<ReportCondition> conditions;
  std::vector<std::string> exact;  ///< campaign keys of what was taken as exact
  std::string phase_reference;     ///< what phi counts from: a sentence
  std::string shared_scale;        ///< the scale the recordings share: a sentence

  std::vector<ReportRun> runs;
  std::vector<ReportGroup> over_phi;   ///< figures 9a and v against phi
  std::vector<ReportGroup> over_dtau;  ///< figures 9b and 10

  std::string program_version;
  std::vector<Input> inputs;
  std::string configuration;  ///< effective, as text
};

inline std::vector<fit::NextExperiment> ReportData::next_runs() const {
  std::vector<fit::NextExperiment> next = fit.other_next_experiments;
  if (fit.next_experiment) next.insert(next.begin(), *fit.next_experiment);
  return next;
}

/// How many steps of the model (IntegrationSummary::steps) the curves of a report may take together: seconds.
inline constexpr long kMostCurveSteps = 5'000'000;

/// From the folder that `run` has filled: reads fit.json, its meta file, the tracks and measurements. Throws
/// InvalidInput naming the file and the key that is missing or wrong. `most_steps`: of the model, for its
/// curves.
ReportData collect(const RunFolder& folder, long most_steps = kMostCurveSteps);

/// Sentences that differ in the run they name, and in numbers, as one each: "runs a, b: ..."; in the order of
/// the first of each.
std::vector<std::string> pooled_by_cause(const std::vector<std::string>& sentences,
                                         const std::vector<ReportRun>& runs);

}  // namespace tribotrack::apps
