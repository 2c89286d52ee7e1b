// Before any recording is tracked: what is known of a campaign's conditions, and what its runs could tell.
#include <fmt/format.h>

#include <cmath>

#include "apps/open/session.h"
#include "apps/pipeline/line.h"
#include "fit/prediction.h"

namespace tribotrack::apps {

namespace {

double guess_of(const Campaign& campaign, fit::FitParameter parameter, double otherwise) {
  for (const auto* values : {&campaign.fit.guess, &campaign.fit.fixed})
    if (const auto found = values->find(parameter); found != values->end()) return found->second;
  return otherwise;
}

/// The run as if measured elsewhere, with the displacement that the model has for it.
CampaignRun modelled(const Campaign& campaign, CampaignRun run, const model::Friction& friction) {
  constexpr double kRelative = 0.01, kAbsolute = 1e-5;  // of a displacement, m
  const PlatformSection& platform = campaign.platform;
  model::Scenario scenario;
  model::Drive& drive = scenario.drive;
  drive.amplitude = run.amplitude.value_or(*platform.amplitude);
  drive.amplitude_y = platform.amplitude_y.value_or(drive.amplitude);
  drive.angular_frequency = run.angular_frequency.value_or(*platform.angular_frequency);
  drive.phase_shift = platform.phase_shift.value_or(drive.phase_shift);
  drive.gravity = platform.gravity;
  scenario.friction = friction;
  scenario.friction.phase = run.phi;
  scenario.friction.pulse_width = run.dtau;
  scenario.cycles = run.cycles;
  scenario.start = run.start;
  const Eigen::Vector2d moved = fit::modelled_displacement(scenario);
  const double length = moved.norm(), sd = kAbsolute + kRelative * length,
               duration = run.cycles * 2 * M_PI / drive.angular_frequency;
  run.alpha = std::atan2(moved.y(), moved.x());
  run.alpha_sd = sd / std::max(length, sd);
  run.v = length / duration;
  run.v_sd = sd / duration;
  run.video.reset();
  run.track.reset();
  run.scope.reset();
  run.second_scope.reset();
  return run;
}

}  // namespace

Json forecast_of(const Campaign& campaign, const Context& context) {
  using enum fit::FitParameter;
  if (!campaign.platform.amplitude || !campaign.platform.angular_frequency)
    return {{"sentence", "Give amplitude and frequency, roughly: they are for this forecast alone."}};
  Campaign imagined = campaign;
  imagined.runs.clear();
  model::Friction friction;
  friction.nominal = guess_of(campaign, mu1, 0.1);
  friction.reduced = guess_of(campaign, mu2, friction.nominal / 8);
  friction.lag = guess_of(campaign, lag, 0);
  for (const CampaignRun& run : campaign.runs)
    if (!run.free_slide) imagined.runs.push_back(modelled(campaign, run, friction));
  if (imagined.runs.empty()) return {{"sentence", "No run is driven: free slides tell mu1, each by itself."}};
  Context quiet = context;
  quiet.quiet = true;
  fit::FitResult result;
  try {
    result = fit_campaign(imagined, {}, quiet).result;
  } catch (const std::exception& error) {
    return {{"sentence", fmt::format("These runs cannot be fitted: {}", error.what())}};
  }
  Json parameters = Json::object();
  for (const fit::ParameterEstimate& one : result.parameters)
    parameters[fit::to_string(one.parameter)] = {
        {"assumed", one.estimate / si_per_campaign_unit(one.parameter)},
        {"sd", std::isfinite(one.sd) ? Json(one.sd / si_per_campaign_unit(one.parameter)) : Json()}};
  const fit::Verdict verdict = result.identifiability.verdict;
  return {
      {"sentence",
       fmt::format(
           "{} driven run{} {}", imagined.runs.size(), imagined.runs.size() == 1 ? "" : "s",
           verdict == fit::Verdict::identifiable ? "can tell the parameters apart."
           : verdict == fit::Verdict::weak
               ? "tell the parameters apart only weakly."
               : "cannot tell the parameters apart: film the one named below, or vary dtau as well as phi.")},
      {"parameters", parameters},
      {"weak", result.identifiability.weak_directions},
      {"next", result.next_experiment ? Json(result.next_experiment->sentence) : Json()}};
}

Json conditions_of(const Campaign& campaign) {
  const PlatformSection& platform = campaign.platform;
  const CameraSection& camera = campaign.camera;
  const bool mark = camera.marker_px || camera.marker.kind != vision::MarkerChoice::Kind::none;
  const std::string seen =
      camera.marker_px ? "measured from the mark" : "measured where texture or mark show it";
  Json list = Json::array();
  const auto add = [&](const char* name, const char* section, const char* key,
                       const std::optional<double>& value, const std::optional<double>& sd,
                       const Digits& digits, const std::string& otherwise) {
    const bool given = sd.value_or(0) > 0;
    const double counted = value ? given ? *sd : default_sd(campaign.fit.exact, key, *value, digits) : 0;
    list.push_back({{"name", name},
                    {"section", section},
                    {"key", key},
                    {"given", optional_json(value)},
                    {"sd", value ? Json(counted) : Json()},
                    {"from", !value        ? otherwise
                             : given       ? "given, with its sd"
                             : counted > 0 ? "given; sd by its last digit or by the trade"
                                           : "taken as exact"}});
  };
  const auto mm = [](const std::optional<double>& m) { return m ? std::optional(*m * 1e3) : m; };
  add("Amplitude A, mm", "platform", "amplitude_mm", mm(platform.amplitude), mm(platform.amplitude_sd),
      platform.digits, mark ? seen : "not known");
  add("Angular frequency w, rad/s", "platform", "angular_frequency_rad_s", platform.angular_frequency,
      platform.angular_frequency_sd, platform.digits, mark ? seen : "not known");
  add("Phase shift epsilon, rad", "platform", "phase_shift_rad", platform.phase_shift,
      platform.phase_shift_sd, platform.digits, mark ? seen : "assumed pi/2");
  add("Diameter of the part, mm", "part", "diameter_mm", campaign.part.diameter_mm,
      campaign.part.diameter_sd_mm, campaign.part.digits, "not given");
  add("Scale, mm/px", "camera", "mm_per_px", camera.mm_per_px, camera.mm_per_px_sd, camera.digits,
      camera.calibration          ? "by the calibration"
      : campaign.part.diameter_mm ? "by the part's diameter"
      : camera.tag_mm             ? "by the tag"
                                  : "not known: give the part's diameter");
  add("Frame rate, Hz", "camera", "frame_rate_hz", camera.frame_rate_hz, camera.frame_rate_sd_hz,
      camera.digits, "by the recordings");
  add("Gravity, m/s^2", "platform", "gravity_m_s2", platform.gravity, platform.gravity_sd, platform.digits,
      "");
  return list;
}

}  // namespace tribotrack::apps
