#include "apps/files/camera.h"
#include "apps/files/campaign/campaign.h"
#include "apps/files/run_folder.h"

namespace tribotrack::apps {

namespace {

Json in_mm(const std::optional<double>& metres) {
  return metres ? Json(*metres * 1e3) : Json();
}

}  // namespace

Json Campaign::effective_configuration(const CampaignRun& run) const {
  using Marker = vision::MarkerChoice::Kind;
  Json json = {
      {"name", run.name},
      {"video", run.video ? Json(run.video->filename().string()) : Json()},
      {"kind", run.free_slide ? "free_slide" : "pulses"},
      {"phi_rad", run.phi},
      {"phi_rad_sd", optional_json(run.phi_sd)},
      {"dtau_rad", run.dtau},
      {"dtau_rad_sd", optional_json(run.dtau_sd)},
      {"start", model::to_string(run.start)},
      {"cycles", run.cycles},
      {"amplitude_mm", in_mm(run.amplitude ? run.amplitude : platform.amplitude)},
      {"amplitude_mm_sd", in_mm(run.amplitude ? run.amplitude_sd : platform.amplitude_sd)},
      {"amplitude_y_mm", in_mm(platform.amplitude_y)},
      {"angular_frequency_rad_s",
       optional_json(run.angular_frequency ? run.angular_frequency : platform.angular_frequency)},
      {"angular_frequency_rad_s_sd",
       optional_json(run.angular_frequency ? run.angular_frequency_sd : platform.angular_frequency_sd)},
      {"phase_shift_rad", optional_json(platform.phase_shift)},
      {"phase_at_zero_rad", optional_json(run.phase_at_zero)},
      {"phase_at_zero_rad_sd", optional_json(run.phase_at_zero_sd)},
      {"start_phase_rad", optional_json(run.start_phase)},
      {"start_phase_rad_sd", optional_json(run.start_phase_sd)},
      {"frames", run.first_frame ? Json::array({*run.first_frame, *run.last_frame}) : Json()},
      {"frame_rate_hz", optional_json(camera.frame_rate_hz)},
      {"frame_rate_hz_sd", optional_json(camera.frame_rate_sd_hz)},
      {"mm_per_px", optional_json(run.mm_per_px ? run.mm_per_px : camera.mm_per_px)},
      {"mm_per_px_sd", run.mm_per_px ? run.mm_per_px_sd.value_or(0) : camera.mm_per_px_sd},
      {"calibration", camera.calibration ? Json(camera.calibration->filename().string()) : Json()},
      {"diameter_mm", optional_json(part.diameter_mm)},
      {"diameter_sd_mm", part.diameter_sd_mm},
      {"height_mm", optional_json(part.height_mm)},
      {"height_mm_sd", optional_json(part.height_sd_mm)},
      {"working_distance_mm", optional_json(camera.working_distance_mm)},
      {"working_distance_mm_sd", optional_json(camera.working_distance_sd_mm)},
      {"xi_axis_rad", camera.xi_axis_rad},
      {"xi_axis_rad_sd", optional_json(camera.xi_axis_sd_rad)},
      {"row_time_s", camera.row_time_s},
      {"disc_px", circle_json(run.template_px ? std::nullopt
                              : run.disc_px   ? run.disc_px
                                              : camera.disc_px)},
      {"template_px", rect_json(run.disc_px       ? std::nullopt
                                : run.template_px ? run.template_px
                                                  : camera.template_px)},
      {"marker_px", circle_json(run.marker_px ? run.marker_px : camera.marker_px)},
      {"marker", camera.marker.kind == Marker::texture ? "texture"
                 : camera.marker.kind == Marker::find  ? "auto"
                 : camera.marker.kind == Marker::none  ? "none"
                 : camera.marker.kind == Marker::tag   ? tag_word(camera.marker)
                                                       : "texture where the ground moves"},
      {"gate_px", circle_json(camera.gate_px)},
      {"scope", run.scope ? Json(run.scope->filename().string()) : Json()}};
  if (run.second_scope)
    json["scope"] = Json::array({run.scope->filename().string(), run.second_scope->filename().string()});
  if (run.track) {
    json["track"] = run.track->filename().string();
    json["track_unit"] = run.reading.unit;
    json["track_y"] = run.reading.y == TrackReading::YAxis::up     ? "up"
                      : run.reading.y == TrackReading::YAxis::down ? "down"
                                                                   : "by unit";
    json["track_point"] = run.reading.point;
    json["track_mark"] = run.reading.mark;
  }
  if (camera.tag_mm) {
    json["tag_mm"] = *camera.tag_mm;
    json["tag_mm_sd"] = camera.tag_mm_sd;
  }
  if (run.slope) {
    json["slope_rad"] = *run.slope;
    json["slope_rad_sd"] = optional_json(run.slope_sd);
  }
  if (!part.name.empty()) json["part"] = part.name;
  if (!run.pooled_from.empty()) json["pooled_from"] = run.pooled_from;
  return json;
}

Json Campaign::effective_configuration() const {
  Json json;
  if (!title.empty()) json["title"] = title;
  json["platform"] = {{"amplitude_mm", in_mm(platform.amplitude)},
                      {"amplitude_mm_sd", in_mm(platform.amplitude_sd)},
                      {"amplitude_y_mm", in_mm(platform.amplitude_y)},
                      {"amplitude_y_mm_sd", in_mm(platform.amplitude_y_sd)},
                      {"angular_frequency_rad_s", optional_json(platform.angular_frequency)},
                      {"angular_frequency_rad_s_sd", optional_json(platform.angular_frequency_sd)},
                      {"phase_shift_rad", optional_json(platform.phase_shift)},
                      {"phase_shift_rad_sd", optional_json(platform.phase_shift_sd)},
                      {"gravity_m_s2", platform.gravity},
                      {"gravity_m_s2_sd", optional_json(platform.gravity_sd)},
                      {"tilt_x_rad", platform.tilt_x},
                      {"tilt_x_rad_sd", optional_json(platform.tilt_x_sd)},
                      {"tilt_y_rad", platform.tilt_y},
                      {"tilt_y_rad_sd", optional_json(platform.tilt_y_sd)}};
  json["scope"] = {{"sensor_channel", scope.sensor_channel},
                   {"actuator_channel", scope.actuator_channel},
                   {"carrier_hz", scope.carrier_hz},
                   {"sensor_delay_s", scope.sensor_delay_s},
                   {"sensor_delay_sd_s", scope.sensor_delay_sd_s},
                   {"tie", scope.tie},
                   {"trigger_time_s", optional_json(scope.trigger_time_s)},
                   {"tie_sd_s", scope.tie_sd_s}};
  if (!data.tables.empty()) {
    json["data"] = {{"table", Json::array()},
                    {"alpha_sd_rad", optional_json(data.alpha_sd)},
                    {"v_sd_mm_s", in_mm(data.v_sd)}};
    for (const std::filesystem::path& table : data.tables)
      json["data"]["table"].push_back(table.filename().string());
  }
  json["part"] = {{"diameter_mm", optional_json(part.diameter_mm)},
                  {"diameter_sd_mm", part.diameter_sd_mm},
                  {"height_mm", optional_json(part.height_mm)},
                  {"height_mm_sd", optional_json(part.height_sd_mm)}};
  Json fit_json;
  fit_json["parameters"] = Json::array();
  for (const fit::FitParameter parameter : fit.parameters)
    fit_json["parameters"].push_back(fit::to_string(parameter));
  fit_json["data"] = fit.trajectory ? "trajectory" : "summary";
  for (const auto& [name, values] : {std::pair{"fixed", &fit.fixed}, std::pair{"guess", &fit.guess}}) {
    fit_json[name] = Json::object();
    for (const auto& [parameter, value] : *values) fit_json[name][fit::to_string(parameter)] = value;
  }
  fit_json["prior"] = Json::object();
  for (const auto& [parameter, prior] : fit.prior)
    fit_json["prior"][fit::to_string(parameter)] = {{"mean", prior.mean}, {"sd", prior.sd}};
  json["fit"] = fit_json;
  json["runs"] = Json::array();
  for (const CampaignRun& run : runs) {
    Json entry = effective_configuration(run);
    if (run.alpha)
      for (const auto& [name, value] :
           {std::pair{"alpha_rad", *run.alpha}, std::pair{"alpha_sd_rad", *run.alpha_sd},
            std::pair{"v_mm_s", *run.v * 1e3}, std::pair{"v_sd_mm_s", *run.v_sd * 1e3}})
        entry[name] = value;
    json["runs"].push_back(entry);
  }
  return json;
}

}  // namespace tribotrack::apps
