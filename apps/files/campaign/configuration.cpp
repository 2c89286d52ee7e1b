#include <sstream>

#include "apps/files/campaign/campaign.h"
#include "apps/files/campaign/keys.h"
#include "apps/files/campaign/sections.h"

namespace tribotrack::apps {

namespace {

/// What the entry of a run holds, in this order: its own values, else those of the sections that it inherits.
constexpr const char* kOfEveryRun =
    "name video kind phi_rad phi_rad_sd dtau_rad dtau_rad_sd start cycles amplitude_mm amplitude_mm_sd "
    "amplitude_y_mm angular_frequency_rad_s angular_frequency_rad_s_sd phase_shift_rad phase_at_zero_rad "
    "phase_at_zero_rad_sd start_phase_rad start_phase_rad_sd frames frame_rate_hz frame_rate_hz_sd mm_per_px "
    "mm_per_px_sd calibration diameter_mm diameter_sd_mm chamfer_mm height_mm height_mm_sd "
    "working_distance_mm "
    "working_distance_mm_sd xi_axis_rad xi_axis_rad_sd row_time_s disc_px template_px marker_px marker "
    "gate_px "
    "scope";

/// Those of a section among the names.
Json picked(const Json& values, std::initializer_list<const char*> names) {
  Json json = Json::object();
  for (const char* name : names) json[name] = values.at(name);
  return json;
}

Json part_configuration(const PartSection& part) {
  return picked(written(part_keys(), part),
                {"diameter_mm", "diameter_sd_mm", "chamfer_mm", "height_mm", "height_mm_sd"});
}

Json run_configuration(const Campaign& campaign, const CampaignRun& run) {
  const Json own = written(run_keys(), run);
  Json inherited = written(platform_keys(), campaign.platform);
  inherited.update(written(camera_keys(), campaign.camera));
  inherited.update(part_configuration(campaign.part));
  Json json;
  std::istringstream names(kOfEveryRun);
  for (std::string name; names >> name;) {
    const std::string quantity = name.ends_with("_sd") ? name.substr(0, name.size() - 3) : name;
    const bool is_own = own.contains(name) && (!own.at(quantity).is_null() || !inherited.contains(name));
    json[name] = is_own ? own.at(name) : inherited.at(name);
  }
  if (run.mm_per_px && !run.mm_per_px_sd) json["mm_per_px_sd"] = 0.0;
  if (run.template_px) json["disc_px"] = nullptr;
  if (run.disc_px) json["template_px"] = nullptr;
  const auto add = [&json](const Json& values) { json.update(values); };
  if (run.track)
    add(picked(own, {"track", "track_unit", "track_y", "track_frame", "track_point", "track_mark"}));
  if (campaign.camera.tag_mm) add(picked(inherited, {"tag_mm", "tag_mm_sd"}));
  if (run.slope) add(picked(own, {"slope_rad", "slope_rad_sd"}));
  if (!campaign.part.name.empty()) json["part"] = campaign.part.name;
  if (!run.pooled_from.empty()) json["pooled_from"] = run.pooled_from;
  if (run.alpha) add(picked(own, {"alpha_rad", "alpha_sd_rad", "v_mm_s", "v_sd_mm_s"}));
  return json;
}

Json fit_configuration(const FitSection& fit) {
  Json json = picked(written(fit_keys(), fit), {"parameters", "data"});
  for (const auto& [name, values] : {std::pair{"fixed", &fit.fixed}, std::pair{"guess", &fit.guess}}) {
    json[name] = Json::object();
    for (const auto& [parameter, value] : *values) json[name][fit::to_string(parameter)] = value;
  }
  if (fit.exact.all || !fit.exact.keys.empty()) json["exact"] = written_exact(fit);
  if (!fit.hold_out.empty()) json["hold_out"] = fit.hold_out;
  json["prior"] = Json::object();
  for (const auto& [parameter, prior] : fit.prior)
    json["prior"][fit::to_string(parameter)] = {{"mean", prior.mean}, {"sd", prior.sd}};
  return json;
}

}  // namespace

Json Campaign::effective_configuration() const {
  Json json;
  if (!title.empty()) json["title"] = title;
  json["platform"] = written(platform_keys(), platform);
  json["scope"] = written(scope_keys(), scope);
  if (!data.tables.empty())
    json["data"] = picked(written(data_keys(), data), {"table", "alpha_sd_rad", "v_sd_mm_s"});
  if (data.runs) json["data"]["runs"] = data.runs->filename().string();
  json["part"] = part_configuration(part);
  json["fit"] = fit_configuration(fit);
  json["runs"] = Json::array();
  for (const CampaignRun& run : runs) json["runs"].push_back(run_configuration(*this, run));
  return json;
}

}  // namespace tribotrack::apps
