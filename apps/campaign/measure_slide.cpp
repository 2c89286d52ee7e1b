#include "apps/campaign/measure_slide.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/text/number_text.h"
#include "fit/estimate.h"

namespace tribotrack::apps {

namespace {

/// sd of the curvature of a track of length `time` whose errors of sd `sd` last for `correlation` each: that
/// of a parabola through as many independent points, 720/n sd^2/time^4.
double slow_curvature_sd(double sd, double correlation, double time) {
  if (!(sd > 0) || !(time > 0)) return 0;
  const double independent = std::max(3.0, correlation > 0 ? time / correlation : 3.0);
  return sd * std::sqrt(720 / independent) / (time * time);
}

std::string with_sd(double value, double sd) {
  return sd > 0 ? fmt::format("{} +- {}", rounded_to_sd(value, sd), rounded_to_sd(sd, sd))
                : fmt::format("{:.6g}", value);
}

std::string line(const char* name, const std::string& text) {
  return fmt::format("{:<16}{}\n", name, text);
}

Json finite(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

}  // namespace

SlideMeasurement measure_slide(const std::string& name, const TrackFile& track, double gravity) {
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
  const fit::FitResult fit = fit::estimate(problem, options);

  SlideMeasurement m;
  m.slide = fit.slides.front();
  m.gravity = gravity;
  const double scale = track.mm_per_px ? track.mm_per_px_sd.value_or(0) / *track.mm_per_px : 0;
  const double deceleration = m.slide.mu1.value * gravity;
  m.deceleration = {deceleration, std::hypot(m.slide.mu1.sd * gravity, scale * deceleration)};
  m.stop_seen = m.slide.stop_time < track.table.time.back();
  const double start = fit.runs.front().nuisance.at("onset_time_s");
  const double seen = std::min(m.slide.stop_time, fit.runs.front().nuisance.at("end_time_s")) - start;
  const double slow_sd = track.facts.audit.slow_sd * track.mm_per_px.value_or(0) * 1e-3;
  m.deceleration_slow_sd = slow_curvature_sd(slow_sd, track.facts.audit.slow_time, seen);
  m.warnings = fit.warnings;
  if (fit.agreement == fit::Agreement::poor || fit.agreement == fit::Agreement::only_with_scatter)
    m.warnings.push_back(
        fmt::format("{}: the deceleration is not constant within the track's errors (chi2 {:.3g} at "
                    "{} degrees of freedom); the sd counts the scatter",
                    name, m.slide.chi2, m.slide.dof));
  return m;
}

Json slide_result_json(const fit::SlideResult& slide) {
  Json json = {{"name", slide.run},
               {"mu1", finite(slide.mu1.value)},
               {"mu1_sd", finite(slide.mu1.sd)},
               {"ci95", Json::array({finite(slide.ci95.low), finite(slide.ci95.high)})},
               {"chi2", finite(slide.chi2)},
               {"dof", slide.dof},
               {"p_value", finite(slide.p_value)},
               {"scatter_mm", slide.scatter * 1e3},
               {"points", slide.points},
               {"first_frame", slide.first_frame},
               {"last_frame", slide.last_frame},
               {"speed_mm_s", finite(slide.speed * 1e3)},
               {"stop_time_s", finite(slide.stop_time)},
               {"spin_seen", slide.spin_seen}};
  if (slide.spin_seen) {
    json["spin_rad_s"] = finite(slide.spin.value);
    json["spin_rad_s_sd"] = finite(slide.spin.sd);
    json["spin_ratio"] = finite(slide.spin_ratio.value);
    json["spin_ratio_sd"] = finite(slide.spin_ratio.sd);
    json["bearing_over_radius"] = finite(slide.bearing.value);
    json["bearing_over_radius_sd"] = finite(slide.bearing.sd);
  } else {
    json["mu1_change_by_half_spin"] = finite(slide.change_by_half_spin);
  }
  json["blows"] = Json::array();
  for (const fit::Blow& blow : slide.blows)
    json["blows"].push_back({{"frame", blow.frame},
                             {"time_s", blow.time},
                             {"jump_mm_s", blow.jump * 1e3},
                             {"speed_before_mm_s", blow.speed_before * 1e3},
                             {"speed_after_mm_s", blow.speed_after * 1e3}});
  json["sentence"] = slide.sentence;
  return json;
}

Json slide_measurement_json(const SlideMeasurement& m, const TrackFile& track) {
  Json json = slide_result_json(m.slide);
  json.erase("name");
  json["kind"] = "free_slide";
  json["deceleration_mm_s2"] = finite(m.deceleration.value * 1e3);
  json["deceleration_mm_s2_sd"] = finite(m.deceleration.sd * 1e3);
  json["deceleration_mm_s2_slow_sd"] = finite(m.deceleration_slow_sd * 1e3);
  json["gravity_m_s2"] = m.gravity;
  json["stop_seen"] = m.stop_seen;
  if (track.mm_per_px) {
    json["mm_per_px"] = *track.mm_per_px;
    json["mm_per_px_sd"] = track.mm_per_px_sd.value_or(0);
  }
  json["frames"] = track.frames;
  json["tracked"] = track.table.time.size();
  json["warnings"] = m.warnings;
  return json;
}

std::string slide_measurement_text(const SlideMeasurement& m, const TrackFile& track) {
  const fit::SlideResult& s = m.slide;
  std::string text =
      line("frames", fmt::format("{}, part tracked in {}", track.frames, track.table.time.size()));
  text +=
      line("free slide", fmt::format("frames {} to {}, {} points", s.first_frame, s.last_frame, s.points));
  text += line("speed", fmt::format("{:.4g} mm/s at its first point", 1e3 * s.speed));
  text += line("deceleration", with_sd(1e3 * m.deceleration.value, 1e3 * m.deceleration.sd) + " mm/s^2");
  if (m.deceleration_slow_sd > 0)
    text += line("  slow sd", fmt::format("{:.2g} mm/s^2: what the track's slow errors can add",
                                          1e3 * m.deceleration_slow_sd));
  text += line("mu1", fmt::format("{} with g = {} m/s^2", with_sd(s.mu1.value, m.deceleration.sd / m.gravity),
                                  m.gravity));
  text += line("stop", fmt::format("{:.5g} s{}", s.stop_time, m.stop_seen ? "" : ", after the track ends"));
  if (s.spin_seen) {
    text += line("spin", with_sd(s.spin.value, s.spin.sd) + " rad/s at its first point");
    text += line("  rim / slide", with_sd(s.spin_ratio.value, s.spin_ratio.sd) + " of the speed");
  } else {
    text +=
        line("spin", fmt::format("not seen; a rim speed of half the slide's would make mu1 {:.2g} % larger",
                                 100 * s.change_by_half_spin));
  }
  text += line("chi2", fmt::format("{:.4g} at {} degrees of freedom", s.chi2, s.dof));
  if (track.mm_per_px)
    text += line("scale", with_sd(*track.mm_per_px, track.mm_per_px_sd.value_or(0)) + " mm per pixel");
  return text;
}

}  // namespace tribotrack::apps
