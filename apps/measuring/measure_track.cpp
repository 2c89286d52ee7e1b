// What is measured of one track, and the table that sets it against what was given.
#include "apps/measuring/measure_track.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "apps/measuring/likely_slip.h"
#include "apps/measuring/measure_run.h"
#include "apps/measuring/track_motion.h"
#include "apps/program/errors.h"
#include "apps/text/number_text.h"
#include "fit/estimate.h"
#include "fit/fit_result_json.h"

namespace tribotrack::apps {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kNear = 0.1;

struct Slip {
  double factor;  ///< from what was given to what was meant
  const char* given_as;
};

/// A length in mm.
const std::vector<Slip> kLengths = {{1e3, "in metres"}, {10, "in cm"}, {25.4, "in inches"}, {1e-3, "in um"}};

std::vector<Slip> slips_of(const std::string& quantity) {
  if (quantity == "angular_frequency_rad_s")
    return {{2 * kPi, "in Hz"},
            {2 * kPi / 60, "in revolutions per minute"},
            {kPi / 180, "in degrees per second"},
            {1 / (2 * kPi), "times 2 pi"},
            {2e3 * kPi, "in kHz"}};
  if (quantity == "phase_shift_rad") return {{kPi / 180, "in degrees"}, {2 * kPi, "in turns"}};
  std::vector<Slip> slips = kLengths;
  if (quantity.starts_with("amplitude")) {
    slips.push_back({0.5, "peak to peak"});
    slips.push_back({std::numbers::sqrt2, "as its root mean square"});
  }
  if (quantity == "diameter_mm") slips.push_back({2, "as its radius"});
  return slips;
}

std::string unit_of(const std::string& quantity) {
  return quantity.ends_with("_rad_s") ? "rad/s" : quantity.ends_with("_rad") ? "rad" : "mm";
}

bool is_near(const std::string& quantity, double meant, double measured) {
  if (quantity.ends_with("_rad"))
    return std::abs(std::remainder(meant - measured, 2 * kPi)) < kNear * kPi / 2;
  return std::abs(meant - measured) < kNear * std::abs(measured);
}

}  // namespace

std::string likely_slip(const std::string& quantity, double given, double measured) {
  for (const auto& [factor, given_as] : slips_of(quantity))
    if (is_near(quantity, given * factor, measured))
      return fmt::format("{:.4g} is {:.4g} {} {}", given, given * factor, unit_of(quantity), given_as);
  if (quantity == "angular_frequency_rad_s" && given > 0)
    for (const auto& [seconds, name] : {std::pair{1.0, "s"}, std::pair{1e-3, "ms"}})
      if (const double meant = 2 * kPi / (given * seconds); is_near(quantity, meant, measured))
        return fmt::format("{:.4g} {} is the period of {:.4g} rad/s", given, name, meant);
  return "";
}

namespace {

/// sd of the curvature of a track of length `time` whose errors of sd `sd` last for `correlation` each: that
/// of a parabola through as many independent points, 720/n sd^2/time^4.
double slow_curvature_sd(double sd, double correlation, double time) {
  if (!(sd > 0) || !(time > 0)) return 0;
  const double independent = std::max(3.0, correlation > 0 ? time / correlation : 3.0);
  return sd * std::sqrt(720 / independent) / (time * time);
}

fit::FitResult fitted_slide(const std::string& name, const Track& track, double gravity) {
  fit::Problem problem;
  problem.free = {fit::FitParameter::mu1};
  fit::TrajectoryRun run;
  run.name = name;
  run.free_slide = true;
  run.scenario.drive.amplitude = run.scenario.drive.amplitude_y = 0;
  run.scenario.drive.gravity = gravity;
  run.track = track.table;
  problem.trajectory_runs = {run};
  fit::FitOptions options;
  options.profiles = options.next_experiment = false;
  return fit::estimate(problem, options);
}

/// The object `measure --json` prints of a free slide: mu1 g is the deceleration of the sliding part before
/// any spin spares it friction.
Json slide_json(const fit::FitResult& fit, const Track& track, double gravity,
                const std::vector<std::string>& warnings) {
  const fit::SlideResult& slide = fit.slides.front();
  const auto& nuisance = fit.runs.front().nuisance;
  const double scale = track.mm_per_px ? track.mm_per_px_sd.value_or(0) / *track.mm_per_px : 0;
  const double deceleration = slide.mu1.value * gravity;
  const double seen = std::min(slide.stop_time, nuisance.at("end_time_s")) - nuisance.at("onset_time_s");
  double slow_sd = 0;  // of the track's slow errors
  for (const fit::SlowError& slow : track.table.slow)
    slow_sd = std::hypot(slow_sd, slow_curvature_sd(slow.sd, slow.time, seen));
  Json json = slide;
  json.erase("name");
  json["kind"] = "free_slide";
  json["deceleration_mm_s2"] = finite_json(deceleration * 1e3);
  json["deceleration_mm_s2_sd"] = finite_json(std::hypot(slide.mu1.sd * gravity, scale * deceleration) * 1e3);
  json["deceleration_mm_s2_slow_sd"] = finite_json(slow_sd * 1e3);
  json["gravity_m_s2"] = gravity;
  json["stop_seen"] = slide.stop_time < track.table.time.back();
  put_recording(json, track, warnings);
  return json;
}

GivenConditions given_by(const MeasureChoices& choices) {
  if (choices.omega_rad_s && !(*choices.omega_rad_s > 0))
    throw UsageError("--omega-rad-s must be greater than 0");
  GivenConditions given;
  given.angular_frequency = choices.omega_rad_s;
  given.phase_shift = choices.epsilon_rad;
  if (choices.cycles) {
    if (!(*choices.cycles >= 1 && *choices.cycles <= 1e6) || *choices.cycles != std::floor(*choices.cycles))
      throw UsageError(fmt::format("--cycles must be a whole number, 1 to 1000000, not {}", *choices.cycles));
    given.cycles = static_cast<int>(*choices.cycles);
  }
  if (choices.free_slide && choices.omega_rad_s)
    throw UsageError("--free-slide and --omega-rad-s contradict each other: a free slide's platform rests");
  return given;
}

void put_motion(const TrackMotion& motion, TrackMeasurement& result) {
  Json json = {{"motion", fit::to_string(motion.shown.kind)}, {"motion_sentence", motion.sentence}};
  json.update(result.json);
  result.json = std::move(json);
}

/// What a track shows that is neither of a drive known nor of a slide: no friction follows from it.
TrackMeasurement motion_alone(const std::string& name, const Track& track, const TrackMotion& motion) {
  TrackMeasurement result;
  result.json = Json::object();
  if (motion.shown.oscillation) {
    const fit::Estimate& w = motion.shown.oscillation->angular_frequency;
    result.json["angular_frequency_rad_s"] = finite_json(w.value);
    result.json["angular_frequency_rad_s_sd"] = finite_json(w.sd);
  }
  put_recording(result.json, track, {});
  put_motion(motion, result);
  result.failure = fmt::format("{}: {}; {}", name, motion.sentence, motion.remedy());
  return result;
}

/// A part that slides on the resting platform: no drive is given, none is seen. A fit would make a friction
/// of any other motion as well.
TrackMeasurement measure_free_slide(const std::string& name, const Track& track,
                                    const MeasureChoices& choices) {
  constexpr std::size_t kFewest = 8;  // points that tell a motion; what fewer lack the fit says
  constexpr double kHardly = 0.5;     // sd of mu1 over mu1
  const double gravity = choices.gravity_m_s2.value_or(9.81);
  if (!(gravity > 0)) throw UsageError("--gravity-m-s2 must be greater than 0");
  const bool told = track.table.time.size() >= kFewest;
  TrackMotion motion;
  if (told) {
    motion = motion_of(track, fit::measure_platform_motion(track.table));
    if (motion.shown.kind != fit::MotionKind::slide) {
      TrackMeasurement result = motion_alone(name, track, motion);
      result.configuration = {{"free_slide", choices.free_slide}, {"gravity_m_s2", gravity}};
      return result;
    }
  }
  const fit::FitResult fit = fitted_slide(name, track, gravity);
  const fit::SlideResult& slide = fit.slides.front();
  std::vector<std::string> warnings = fit.warnings;
  if (fit.agreement == fit::Agreement::poor || fit.agreement == fit::Agreement::only_with_scatter)
    warnings.push_back(
        fmt::format("{}: the deceleration is not constant within the track's errors (chi2 {:.3g} at "
                    "{} degrees of freedom); the sd counts the scatter",
                    name, slide.chi2, slide.dof));
  TrackMeasurement result{slide_json(fit, track, gravity, warnings),
                          warnings,
                          {{"free_slide", true}, {"gravity_m_s2", gravity}},
                          ""};
  if (!(slide.mu1.sd < kHardly * slide.mu1.value)) {
    const Json configuration = result.configuration;
    result = motion_alone(name, track, motion);
    result.configuration = configuration;
    result.failure =
        fmt::format("{}: the part slows down by too little to tell mu1 (sd {:.2g}); film more of the way",
                    name, slide.mu1.sd);
    return result;
  }
  put_motion(motion, result);
  return result;
}

}  // namespace

TrackMeasurement measure_track(const std::string& name, const Track& track, const MeasureChoices& choices) {
  const GivenConditions given = given_by(choices);
  if (choices.free_slide) return measure_free_slide(name, track, choices);
  RunMeasurement measured = measure_run(name, track, given);
  for (std::string& difference : differences(name, measured, given))
    measured.warnings.push_back(std::move(difference));
  if (!measured.displacement) return measure_free_slide(name, track, choices);
  if (choices.gravity_m_s2)
    throw UsageError("--gravity-m-s2 belongs to free slides; this track shows a moving platform");
  TrackMeasurement result{measurement_json(measured, track),
                          measured.warnings,
                          {{"omega_rad_s", optional_json(given.angular_frequency)}, {"cycles", given.cycles}},
                          ""};
  const TrackMotion motion = motion_of(track, measured.platform);
  put_motion(motion, result);
  if (measured.coded && measured.coded->exceeds)
    result.failure = fmt::format(
        "{}: attenuation or delay by the codec exceeds the interval of what the track tells", name);
  else if (!motion.platform_seen && (measured.platform || !track.table.platform_frame))
    if (const std::string why = against_drive(motion, measured.angular_frequency->value); !why.empty())
      result.failure = fmt::format("{}: {}; {}", name, why, motion.remedy());
  return result;
}

}  // namespace tribotrack::apps
