#include "apps/measuring/measure_track.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "apps/measuring/measure_run.h"
#include "apps/program/errors.h"
#include "apps/text/number_text.h"
#include "fit/estimate.h"
#include "fit/fit_result_json.h"

namespace tribotrack::apps {

namespace {

using Kind = fit::MotionKind;

/// Of the amplitude, and sd of the mark: a circle leaves less.
constexpr double kNoCircle = 0.3, kBeyondNoise = 3;
constexpr double kAnotherFrequency = 0.2;  ///< as of a slip

double mm(double metres) {
  return 1e3 * metres;
}

double amplitude_of(const fit::PlatformMotion& platform) {
  return std::max(platform.amplitude.value, platform.amplitude_y.value);
}

bool circles(const fit::PlatformMotion& platform, const fit::TrackTable& table) {
  double sigma = 0;
  for (const double s : table.marker_sigma) sigma += s / static_cast<double>(table.marker_sigma.size());
  return platform.residual_rms < std::max(kNoCircle * amplitude_of(platform), kBeyondNoise * sigma);
}

/// The part against the mark, or the other way round: one distance.
bool keeps_to_mark(const fit::TrackTable& table) {
  fit::TrackTable apart = table;
  apart.marker.clear();
  if (!table.platform_frame)
    for (std::size_t i = 0; i < apart.position.size(); ++i) apart.position[i] -= table.marker[i];
  return fit::shown_motion(apart).kind == Kind::at_rest;
}

std::string w_of(const fit::Oscillation& o) {
  return fmt::format("{} rad/s", quoted(o.angular_frequency.value, o.angular_frequency.sd));
}

std::string sentence_of(const fit::ShownMotion& m, const fit::TrackTable& table) {
  const auto frame = [&](std::size_t row) { return table.frame[row]; };
  switch (m.kind) {
    case Kind::driven:
      return fmt::format(
          "the part is driven at {}: {:.1f} cycles of {:.3g} by {:.3g} mm, moving on by {:.3g} mm",
          w_of(*m.oscillation), m.oscillation->cycles, mm(m.oscillation->major), mm(m.oscillation->minor),
          mm(m.oscillation->drift));
    case Kind::swinging:
      return fmt::format(
          "the part swings at {}: {:.1f} cycles of {:.3g} mm{}, about a place that moves by {:.3g} mm",
          w_of(*m.oscillation), m.oscillation->cycles, mm(m.oscillation->major),
          m.oscillation->last_over_first < 0.95
              ? fmt::format(", in the end {:.0f} % of that in the beginning",
                            100 * m.oscillation->last_over_first)
              : "",
          mm(m.oscillation->drift));
    case Kind::slide:
      return fmt::format("the part slides and slows down, from about {:.3g} mm/s in frames {} to {}",
                         mm(m.braking->speed), frame(m.braking->first), frame(m.braking->last - 1));
    case Kind::incline:
      return fmt::format(
          "the part gains speed evenly, by about {:.3g} mm/s^2 to {:.3g} mm/s in frames {} to {}, as down an "
          "incline",
          mm(-m.braking->deceleration), mm(m.braking->speed), frame(m.braking->first),
          frame(m.braking->last - 1));
    case Kind::pulled:
      return fmt::format(
          "the part moves on in one direction, by {:.3g} mm at {:.3g} mm/s on average, without constant "
          "deceleration, as a part that is pulled",
          mm(m.way), mm(m.speed));
    case Kind::at_rest:
      return fmt::format(
          "the part rests: it keeps within {:.2g} mm, its positions are uncertain by {:.2g} mm", mm(m.way),
          mm(m.noise));
    case Kind::with_background:
    case Kind::unknown:
      break;
  }
  return fmt::format(
      "the part moves by up to {:.3g} mm, and neither circles, nor swings, nor decelerates constantly, nor "
      "goes one way",
      mm(m.way));
}

}  // namespace

TrackMotion motion_of(const Track& track, const std::optional<fit::PlatformMotion>& platform) {
  TrackMotion motion;
  if (!platform) {
    motion.shown = fit::shown_motion(track.table);
    motion.sentence = sentence_of(motion.shown, track.table);
    return motion;
  }
  const double time = track.table.time.back() - track.table.time.front();
  if (circles(*platform, track.table)) {
    const fit::Estimate& w = platform->angular_frequency;
    motion.platform_seen = true;
    motion.shown.kind = Kind::driven;
    motion.sentence =
        fmt::format("the platform is driven at {} rad/s, {:.3g} by {:.3g} mm", quoted(w.value, w.sd),
                    mm(platform->amplitude.value), mm(platform->amplitude_y.value));
    motion.shown.oscillation = fit::Oscillation{.angular_frequency = w,
                                                .cycles = w.value * time / (2 * std::numbers::pi),
                                                .major = amplitude_of(*platform)};
    return motion;
  }
  motion.shown.kind = Kind::with_background;
  motion.sentence = fmt::format(
      "the mark moves and does not circle ({:.2g} mm rms are left of a circle of {:.2g} mm): the camera or "
      "the platform was moved{}",
      mm(platform->residual_rms), mm(amplitude_of(*platform)),
      keeps_to_mark(track.table) ? ", and the part goes with it" : "");
  return motion;
}

std::string TrackMotion::remedy() const {
  switch (shown.kind) {
    case Kind::driven:
      if (platform_seen) return "leave out --free-slide for alpha and v";
      return "for alpha and v give the drive's frequency as it is set (--omega-rad-s), or track with "
             "--marker";
    case Kind::swinging:
      return "no friction follows from it; where a platform drives it give --omega-rad-s";
    case Kind::incline:
      return "for mu1 fit it as kind = \"free_slide\" with slope_rad";
    case Kind::pulled:
      return "for mu1 film a part that is let go and slides to rest, or choose those frames";
    case Kind::at_rest:
      return "film it while it moves, or track other frames";
    case Kind::with_background:
      return "fix the camera, or track with a mark on what the part slides on";
    case Kind::slide:
      return "leave out --omega-rad-s for mu1";
    case Kind::unknown:
      break;
  }
  return "is it the part that was tracked? see track --overlay, and choose the frames in which it slides or "
         "is driven";
}

namespace {

/// Why what was measured over cycles of the w given is not what the part shows: it does something else, or
/// circles at another frequency. Empty where it may be.
std::string against_drive(const TrackMotion& motion, double angular_frequency) {
  switch (motion.shown.kind) {
    case Kind::slide:
    case Kind::incline:
    case Kind::at_rest:
    case Kind::with_background:
      return motion.sentence + ": no drive";
    case Kind::driven:
      break;
    default:
      return "";
  }
  const double seen = motion.shown.oscillation->angular_frequency.value, ratio = seen / angular_frequency;
  if (std::abs(ratio - std::max(1.0, std::round(ratio))) < kAnotherFrequency) return "";
  const std::string slip = likely_slip("angular_frequency_rad_s", angular_frequency, seen);
  return fmt::format("{}; given is {:.6g}{}", motion.sentence, angular_frequency,
                     slip.empty() ? "" : " (" + slip + ")");
}

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
  given.cycles = choices.cycles;
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
  constexpr double kRejected = 1e-3;  // by chance one in a thousand
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
  const std::vector<std::string>& warnings = fit.warnings;
  TrackMeasurement result{slide_json(fit, track, gravity, warnings),
                          warnings,
                          {{"free_slide", true}, {"gravity_m_s2", gravity}},
                          ""};
  const auto refused = [&](const std::string& why) {
    TrackMeasurement alone = motion_alone(name, track, motion);
    alone.configuration = result.configuration;
    alone.failure = name + ": " + why;
    for (const char* key : {"chi2", "dof", "p_value"}) alone.json[key] = result.json[key];
    return alone;
  };
  if (!(slide.mu1.sd < kHardly * slide.mu1.value))
    return refused(fmt::format(
        "the part slows down by too little to tell mu1 (sd {:.2g}); film more of the way", slide.mu1.sd));
  if (fit.p_value < kRejected)
    return refused(fmt::format(
        "{}; its deceleration is not constant within the track's errors (chi2 {:.3g} at {} degrees of "
        "freedom) and no single mu1 describes it: a fit of it as a free slide says under what friction "
        "values hold",
        motion.sentence, fit.chi2, fit.dof));
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
  if (const std::string broken = broken_motion(track, measured); !broken.empty())
    result.failure = fmt::format("{}: {}", name, broken);
  else if (measured.coded && measured.coded->exceeds)
    result.failure = fmt::format(
        "{}: attenuation or delay by the codec exceeds the interval of what the track tells", name);
  else if (!motion.platform_seen && (measured.platform || !track.table.platform_frame))
    if (const std::string why = against_drive(motion, measured.angular_frequency->value); !why.empty())
      result.failure = fmt::format("{}: {}; {}", name, why, motion.remedy());
  return result;
}

}  // namespace tribotrack::apps
