#include "apps/campaign/shared_conditions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/campaign/compared_runs.h"
#include "apps/campaign/conditions.h"
#include "apps/files/camera.h"
#include "apps/measuring/measure_run.h"
#include "apps/program/errors.h"
#include "apps/text/number_text.h"

namespace tribotrack::apps {

using fit::Estimate;
using fit::PooledQuantity;
using fit::Source;

namespace {

/// Given values with the sds that are given, else with those by default. SI but for mm/px.
class Given {
 public:
  Given(const Campaign& campaign, const Digits& digits) : exact_(campaign.fit.exact), digits_(digits) {}
  double default_sd(const char* key, double value) const {
    const double unit = std::string_view(key).ends_with("_mm") ? 1e-3 : 1;
    return unit * apps::default_sd(exact_, key, value / unit, digits_);
  }
  Estimate known(const char* key, double value, const std::optional<double>& sd) const {
    return {value, sd ? *sd : default_sd(key, value)};
  }
  std::optional<Estimate> estimate(const char* key, const std::optional<double>& value,
                                   const std::optional<double>& sd) const {
    return value ? std::optional(known(key, *value, sd)) : std::nullopt;
  }

 private:
  const Exact& exact_;
  const Digits& digits_;
};

/// What a run says beats what the platform's table says.
std::optional<fit::GivenValue> given_value(const std::optional<Estimate>& of_run,
                                           const std::optional<Estimate>& of_all) {
  if (of_run) return fit::GivenValue{*of_run, true};
  return of_all ? std::optional(fit::GivenValue{*of_all, false}) : std::nullopt;
}

/// Of the scale at the part's top over that of the platform, 1 - height/distance, relative.
double parallax_error(const Campaign& campaign) {
  const PartSection& part = campaign.part;
  const CameraSection& camera = campaign.camera;
  if (!part.height_sd_mm && !camera.working_distance_sd_mm) return 0;
  const double height = *part.height_mm;
  const double distance =
      camera.calibration ? read_calibration(*camera.calibration).distance_mm() : *camera.working_distance_mm;
  return std::hypot(part.height_sd_mm.value_or(0) / distance,
                    height * camera.working_distance_sd_mm.value_or(0) / (distance * distance)) /
         (1 - height / distance);
}

/// The length that scales in the pictures go by; nothing where none does.
struct Length {
  Source source = Source::diameter;
  Estimate value;  ///< mm
  bool assumed = false;
};
std::optional<Length> length_of(const Campaign& campaign) {
  const PartSection& part = campaign.part;
  const CameraSection& camera = campaign.camera;
  const auto length = [&](Source source, double mm, double sd, const Digits& digits) {
    const double otherwise = default_sd(campaign.fit.exact, fit::to_string(source), mm, digits);
    return Length{source, {mm, sd > 0 ? sd : otherwise}, !(sd > 0) && otherwise > 0};
  };
  if (camera.tag_mm) return length(Source::tag, *camera.tag_mm, camera.tag_mm_sd, camera.digits);
  if (part.diameter_mm) return length(Source::diameter, *part.diameter_mm, part.diameter_sd_mm, part.digits);
  return std::nullopt;
}

/// What a scale without an sd is known to by the length it goes by, or as it is written; relative.
double scale_by_default(const Campaign& campaign, const Run& run) {
  const Track& track = *run.track;
  if (track.scale_source == kScaledByDiameter || track.scale_source == kScaledByTag) {
    const auto length = length_of(campaign);
    return length && length->assumed ? length->value.sd / length->value.value : 0;
  }
  const std::optional<double>& given = run.given.mm_per_px ? run.given.mm_per_px : campaign.camera.mm_per_px;
  if (!given || track.mm_per_px_sd.value_or(0) > 0) return 0;
  const Digits& digits = run.given.mm_per_px ? run.given.digits : campaign.camera.digits;
  return default_sd(campaign.fit.exact, "mm_per_px", *given, digits) / *given;
}

fit::SharedEvidence shared_evidence(const Campaign& campaign, const std::vector<Run>& runs) {
  const PlatformSection& platform = campaign.platform;
  const CameraSection& camera = campaign.camera;
  fit::SharedEvidence shared;
  const auto seen = std::ranges::find_if(runs, [](const Run& run) {
    return run.takes_part() && !run.given.free_slide && run.measurement && run.measurement->platform;
  });
  shared.seen_by = seen == runs.end() ? "" : seen->measurement->phase_source;
  if (campaign.part.diameter_mm)
    shared.diameter = Estimate{1e-3 * *campaign.part.diameter_mm, 1e-3 * campaign.part.diameter_sd_mm};
  const auto assume = [&](Source source, bool assumed) {
    if (assumed) shared.assumed.push_back(source);
  };
  shared.scale = camera.calibration ? Source::calibration : camera.tag_mm ? Source::tag : Source::scale;
  if (const auto length = length_of(campaign)) {
    shared.length_sd = length->value.sd / length->value.value;
    assume(length->source, length->assumed);
  }
  shared.parallax_sd = parallax_error(campaign);
  if (camera.frame_rate_hz) shared.clock_sd = camera.frame_rate_sd_hz.value_or(0) / *camera.frame_rate_hz;
  shared.gravity_sd = platform.gravity_sd.value_or(0) / platform.gravity;
  const Given given(campaign, platform.digits);
  shared.tilt_x_sd = given.known("tilt_x_rad", platform.tilt_x, platform.tilt_x_sd).sd;
  shared.tilt_y_sd = given.known("tilt_y_rad", platform.tilt_y, platform.tilt_y_sd).sd;
  const bool one_amplitude = !platform.amplitude_y && !campaign.fit.exact.holds("amplitude_y_mm");
  if (one_amplitude) shared.amplitude_ratio_sd = given.default_sd("amplitude_ratio", 1);
  if (!platform.phase_shift) shared.phase_shift_sd = given.default_sd("phase_shift_rad", 0);
  if (!campaign.fit.exact.holds("start_phase_rad")) shared.start_phase_sd = fit::kUnknownAngle;
  shared.law_is_exact = campaign.fit.exact.holds(fit::to_string(Source::friction_law));
  const auto no_run_gives = [&](std::optional<double> CampaignRun::*sd) {
    return std::ranges::none_of(campaign.runs, [&](const CampaignRun& run) { return (run.*sd).has_value(); });
  };
  assume(Source::amplitude, !platform.amplitude_sd && no_run_gives(&CampaignRun::amplitude_sd));
  assume(Source::amplitude_y, !platform.amplitude_y_sd);
  assume(Source::angular_frequency,
         !platform.angular_frequency_sd && no_run_gives(&CampaignRun::angular_frequency_sd));
  assume(Source::phase_shift, !platform.phase_shift_sd);
  assume(Source::tilt_x, !platform.tilt_x_sd);
  assume(Source::tilt_y, !platform.tilt_y_sd);
  assume(Source::slope, no_run_gives(&CampaignRun::slope_sd));
  assume(Source::scale, !(camera.mm_per_px_sd > 0) && no_run_gives(&CampaignRun::mm_per_px_sd));
  shared.sensor_axis_sd = camera.xi_axis_sd_rad.value_or(0);
  shared.fitted = campaign.fit.parameters;
  return shared;
}

/// Of those that take part.
fit::Conditions pooled(const Campaign& campaign, const std::vector<Run>& runs) {
  std::vector<fit::RunEvidence> evidence;
  std::vector<fit::RunConditions> start;
  for (const Run& run : runs) {
    if (!run.takes_part()) continue;
    evidence.push_back(evidence_of(campaign, run));
    start.push_back({run.scenario.drive, run.own, run.amplitude_from_track});
  }
  return fit::pool(evidence, shared_evidence(campaign, runs), std::move(start));
}

// Sentences. A quantity in the unit of its campaign key.

double in_unit(Source source, double value) {
  return std::string_view(fit::to_string(source)).ends_with("_mm") ? value / 1e-3 : value;
}
Estimate in_unit(Source source, const Estimate& estimate) {
  return {in_unit(source, estimate.value), in_unit(source, estimate.sd)};
}

/// The k-th of those that take part.
const CampaignRun& counted(const std::vector<Run>& runs, std::size_t k) {
  for (const Run& run : runs)
    if (run.takes_part() && k-- == 0) return run.given;
  return runs.front().given;
}

/// What gives the scale may be wrong instead, by the inverse factor where it is a diameter.
std::string wrong_scale(const Campaign& campaign, const CampaignRun& run, double factor) {
  std::string scale = "calibration", slip;
  if (run.mm_per_px || campaign.camera.mm_per_px) {
    scale = fmt::format("mm_per_px = {:.4g}", run.mm_per_px ? *run.mm_per_px : *campaign.camera.mm_per_px);
  } else if (!campaign.camera.calibration && campaign.part.diameter_mm) {
    const double diameter = *campaign.part.diameter_mm;
    scale = fmt::format("diameter_mm = {:.4g}", diameter);
    slip = likely_slip("diameter_mm", diameter, diameter * factor);
  }
  return fmt::format("; or {}, by which it was measured, is wrong{}{}", scale, slip.empty() ? "" : ": ",
                     slip);
}

std::string text_of(const Estimate& estimate) {
  return estimate.sd > 0 ? quoted(estimate.value, estimate.sd) : fmt::format("{:.6g}", estimate.value);
}

constexpr const char* kImplied = " (amplitude_mm, as it is not given)";

[[noreturn]] void refuse(const Campaign& campaign, const CampaignRun& run, const fit::Slip& slip,
                         const std::string& seen_by) {
  const std::string key = fit::to_string(slip.quantity), file = campaign.file.string();
  const double given = in_unit(slip.quantity, slip.given.value.value);
  const Estimate seen = in_unit(slip.quantity, slip.seen);
  const std::string likely = likely_slip(key, given, seen.value);
  const std::string meant = likely.empty() ? "more than an error of measuring" : likely;
  if (slip.quantity == Source::diameter)
    throw InvalidInput(
        "{}: [part] diameter_mm = {:.6g}, but the part measures {:.4g} mm by the scale that is given: {}; "
        "mend diameter_mm, mm_per_px or calibration",
        file, given, seen.value, meant);
  const bool implied = slip.quantity == Source::amplitude_y && !campaign.platform.amplitude_y;
  const bool angle = slip.quantity == Source::phase_shift;
  const std::string cause = slip.quantity == Source::angular_frequency ? "; or frame_rate_hz is wrong"
                            : angle                                    ? ""
                                    : wrong_scale(campaign, run, given / seen.value);
  throw InvalidInput(
      "{}{}: {} = {:.6g}{}, but the {} shows {}{}: {}{}; mend it, or leave it out to use what was measured",
      slip.given.of_run || slip.runs == 1 ? run.place : file,
      slip.runs == 1 ? fmt::format(": run \"{}\"", run.name) : "", key, given, implied ? kImplied : "",
      seen_by, quoted(seen.value, seen.sd), slip.runs > 1 ? fmt::format(" in {} runs", slip.runs) : "", meant,
      cause);
}

std::string contradiction(const PooledQuantity& q, const std::string& seen_by) {
  const Estimate given = in_unit(q.quantity, *q.given), measured = in_unit(q.quantity, *q.measured);
  return fmt::format("{}: the campaign gives {}{}, the {} shows {} in {} run{}, {:.1f} sd off: {}",
                     fit::to_string(q.quantity), text_of(given), q.implied ? kImplied : "", seen_by,
                     text_of(measured), q.runs, q.runs == 1 ? "" : "s", std::abs(*q.difference_in_sd),
                     q.exact ? "the given value is used; leave it out to use the measured one, or give its sd"
                     : q.assumed
                         ? "the mean of both is used, weighted by 1/sd^2, the given one's by its last digit "
                           "or the trade; mend it, give its sd, or leave it out"
                         : "the mean of both is used, weighted by 1/sd^2; one of the sds is too small");
}

std::string scattered(const PooledQuantity& q, const std::string& seen_by) {
  const PooledQuantity::Scatter& scatter = *q.scatter;
  return fmt::format(
      "{} is not one quantity in all runs: {:.7g} to {:.7g} in {}, {} run{}, chi2 {:.3g} at {} degrees of "
      "freedom (p = {:.1g}): each run keeps what it shows itself; does the drive hold it?",
      fit::to_string(q.quantity), in_unit(q.quantity, scatter.low), in_unit(q.quantity, scatter.high),
      seen_by, scatter.runs, scatter.runs == 1 ? "" : "s", scatter.chi2, scatter.runs - 1, scatter.p_value);
}

std::vector<std::string> warnings_of(const fit::Conditions& conditions) {
  std::vector<std::string> warnings;
  bool said_of_x = false;
  for (const PooledQuantity& q : conditions.quantities) {
    if (q.contradicted() && !(q.implied && said_of_x))
      warnings.push_back(contradiction(q, conditions.seen_by));
    said_of_x = q.quantity == Source::amplitude && q.contradicted();
    if (q.scatter) warnings.push_back(scattered(q, conditions.seen_by));
  }
  if (conditions.sensor_axis_not_used)
    warnings.push_back(
        "xi_axis_rad_sd is not used: phi was measured in the camera's own phase in every run, a turned "
        "camera cancels");
  return warnings;
}

/// Over whole cycles of the w that is used. Its error moves the model, not the data; only in the camera's
/// frame does it also leave some of the platform's own motion in them.
void measure_displacement_again(Run& run, double relative_w_sd) {
  if (run.given.free_slide) return;
  const double w = run.scenario.drive.angular_frequency;
  const CampaignRun& given = run.given;
  try {
    if (run.track) {
      const double sd = std::hypot(relative_w_sd * w, run.own.sd(model::Parameter::angular_frequency));
      const bool camera_frame = !run.track->table.platform_frame;
      run.displacement =
          fit::measure_displacement(run.track->table, {w, camera_frame ? sd : 0}, given.cycles);
      run.scenario.cycles = run.displacement.cycles;
    } else {
      run.displacement = fit::displacement_from_alpha_v({*given.alpha, *given.alpha_sd},
                                                        {*given.v, *given.v_sd}, w, given.cycles);
    }
  } catch (const std::exception& error) {
    run.failure = failure_of(given, error);
  }
}

}  // namespace

fit::RunEvidence evidence_of(const Campaign& campaign, const Run& run) {
  const PlatformSection& platform = campaign.platform;
  const CampaignRun& given = run.given;
  fit::RunEvidence evidence;
  evidence.driven = !given.free_slide;
  const Given of_run(campaign, given.digits), of_all(campaign, platform.digits);
  const char *amplitude = "amplitude_mm", *w = "angular_frequency_rad_s";
  evidence.amplitude = given_value(of_run.estimate(amplitude, given.amplitude, given.amplitude_sd),
                                   of_all.estimate(amplitude, platform.amplitude, platform.amplitude_sd));
  evidence.amplitude_y =
      given_value({}, of_all.estimate("amplitude_y_mm", platform.amplitude_y, platform.amplitude_y_sd));
  evidence.angular_frequency =
      given_value(of_run.estimate(w, given.angular_frequency, given.angular_frequency_sd),
                  of_all.estimate(w, platform.angular_frequency, platform.angular_frequency_sd));
  evidence.phase_shift =
      given_value({}, of_all.estimate("phase_shift_rad", platform.phase_shift, platform.phase_shift_sd));
  evidence.phi = {given.phi, given.phi_sd.value_or(0)};
  evidence.dtau = {given.dtau, given.dtau_sd.value_or(0)};
  evidence.start_phase = of_run.estimate("start_phase_rad", given.start_phase, given.start_phase_sd);
  evidence.slope = of_run.estimate("slope_rad", given.slope, given.slope_sd);
  evidence.from_rest = given.start == model::Start::rest;
  if (const auto& measured = run.measurement) {
    evidence.phase_at_zero =
        of_run.estimate("phase_at_zero_rad", given.phase_at_zero, given.phase_at_zero_sd);
    evidence.seen = measured->platform;
    evidence.start_time = measured->start_time;
    evidence.start = measured->phase_at_start;
    evidence.start_assumed = measured->phase_source == "assumed 0";
    evidence.gate = run.gate;
    evidence.gate_by_camera = run.gate_reference == "camera";
    if (measured->coded) {
      evidence.coder_attenuation = measured->coded->attenuation;
      evidence.coder_delay = measured->coded->delay;
    }
  }
  if (!evidence.gate) {  // what is seen of it is not to be corrected by the digits of a command
    evidence.phi = of_run.known("phi_rad", given.phi, given.phi_sd);
    evidence.dtau = of_run.known("dtau_rad", given.dtau, given.dtau_sd);
  } else if (run.gate_reference == "command") {
    evidence.phi.sd = 0;  // counted with the gate
  }
  if (run.track && run.track->mm_per_px && *run.track->mm_per_px > 0) {
    const Track& track = *run.track;
    const double mm_per_px = *track.mm_per_px;
    evidence.scale = {mm_per_px, track.mm_per_px_sd.value_or(0) / mm_per_px,
                      track.scale_source == kScaledByDiameter ? Source::diameter
                      : track.scale_source == kScaledByTag    ? Source::tag
                                                              : Source::scale};
    evidence.scale->relative_sd = std::hypot(evidence.scale->relative_sd, scale_by_default(campaign, run));
    if (track.disc_radius_px > 0)
      evidence.diameter = Estimate{2e-3 * track.disc_radius_px * mm_per_px,
                                   2e-3 * track.disc_radius_common_sd_px * mm_per_px};
  }
  return evidence;
}

void require_no_slips(const Campaign& campaign, const std::vector<Run>& runs) {
  const fit::Conditions conditions = pooled(campaign, runs);
  for (const fit::Slip& slip : conditions.slips)
    if (slip.everywhere && slip.quantity != Source::diameter)
      refuse(campaign, counted(runs, slip.run), slip, conditions.seen_by);
}

SharedConditions share_conditions(const Campaign& campaign, std::vector<Run>& runs) {
  fit::Conditions conditions = pooled(campaign, runs);
  if (!conditions.slips.empty()) {
    const fit::Slip& slip = conditions.slips.front();
    refuse(campaign, counted(runs, slip.run), slip, conditions.seen_by);
  }
  const PooledQuantity* w = conditions.find(Source::angular_frequency);
  std::size_t k = 0;
  for (Run& run : runs) {
    if (!run.takes_part()) continue;
    const fit::RunConditions& found = conditions.runs[k++];
    run.scenario.drive = found.drive;
    run.own = found.own;
    run.amplitude_from_track = found.amplitude_from_track;
    measure_displacement_again(run, w == nullptr ? 0 : w->shared_sd);
  }
  std::vector<std::string> warnings = warnings_of(conditions);
  return {std::move(conditions), std::move(warnings)};
}

void add_to(Json& fit, const SharedConditions& shared) {
  fit["conditions"] = Json::array();
  for (const PooledQuantity& q : shared.pooled.quantities) {
    const auto value = [&](const std::optional<Estimate>& e) {
      return e ? finite_json(in_unit(q.quantity, e->value)) : Json();
    };
    const auto sd = [&](const std::optional<Estimate>& e) {  // none of an exact value
      return e && e->sd > 0 ? finite_json(in_unit(q.quantity, e->sd)) : Json();
    };
    fit["conditions"].push_back(
        {{"quantity", fit::to_string(q.quantity)},
         {"given", value(q.given)},
         {"given_sd", sd(q.given)},
         {"measured", value(q.measured)},
         {"sd", sd(q.measured)},
         {"difference_in_sd", q.difference_in_sd ? finite_json(*q.difference_in_sd) : Json()},
         {"runs", q.runs},
         {"p_value", finite_json(q.p_value)},
         {"used", value(q.used)},
         {"used_sd", sd(q.used)},
         {"from", shared.pooled.from(q)}});
  }
  fit["taken_as_exact"] = Json::array();
  for (const Source source : shared.pooled.taken_as_exact)
    fit["taken_as_exact"].push_back(fit::to_string(source));
  fit["what_not_knowing_costs"] = Json::array();
  for (const Json& entry : fit.value("budget", Json::array()))
    if (entry["counted"] && fit::is_assumed(entry["from"].get<std::string>()))
      fit["what_not_knowing_costs"].push_back({{"quantity", entry["quantity"]},
                                               {"sd_of_source", entry["sd_of_source"]},
                                               {"from", entry["from"]},
                                               {"contribution", entry["contribution"]}});
  for (const std::string& warning : shared.warnings) fit["warnings"].push_back(warning);
}

std::string costs_text(const Json& fit) {
  std::string text;
  for (const Json& cost : fit["what_not_knowing_costs"]) {
    std::string shares;
    for (const auto& [name, contribution] : cost["contribution"].items()) {
      const Json& sd = fit["parameters"][name]["sd"];
      if (!sd.is_number() || !contribution.is_number()) continue;
      const double share = 100 * std::pow(contribution.get<double>() / sd.get<double>(), 2);
      if (share >= 0.5) shares += fmt::format("{} {} {:.0f} %", shares.empty() ? "" : ",", name, share);
    }
    if (!shares.empty())
      text += fmt::format("  {}, sd {:.2g} ({}):{}\n", cost["quantity"].get<std::string>(),
                          cost["sd_of_source"].get<double>(), cost["from"].get<std::string>(), shares);
  }
  return text.empty() ? ""
                      : "what not knowing costs, of the variance (give a better value with its _sd)\n" + text;
}

std::string conditions_text(const fit::Conditions& conditions) {
  if (conditions.quantities.empty()) return "";
  std::string text = fmt::format("{:<26}{:>22}{:>28}{:>18}   {}\n", "condition", "given", "measured",
                                 "difference in sd", "used");
  for (const PooledQuantity& q : conditions.quantities) {
    const auto cell = [&](const std::optional<Estimate>& e) {
      return e ? text_of(in_unit(q.quantity, *e)) : "-";
    };
    text +=
        fmt::format("{:<26}{:>22}{:>28}{:>18}   {}, {}\n", fit::to_string(q.quantity), cell(q.given),
                    cell(q.measured), q.difference_in_sd ? fmt::format("{:.1f}", *q.difference_in_sd) : "-",
                    cell(q.used), conditions.from(q));
  }
  return text;
}

}  // namespace tribotrack::apps
