#include "apps/files/campaign/campaign.h"
#include "apps/files/campaign/keys.h"
#include "apps/files/campaign/sections.h"

namespace tribotrack::apps {

namespace {

Json fit_configuration(const FitSection& fit) {
  Json json = written(fit_keys(), fit);
  for (const auto& [name, values] : {std::pair{"fixed", &fit.fixed}, std::pair{"guess", &fit.guess}}) {
    json[name] = Json::object();
    for (const auto& [parameter, value] : *values) json[name][fit::to_string(parameter)] = value;
  }
  json["prior"] = Json::object();
  for (const auto& [parameter, prior] : fit.prior)
    json["prior"][fit::to_string(parameter)] = {{"mean", prior.mean}, {"sd", prior.sd}};
  return json;
}

/// What a run says itself; what it does not stands in the sections.
Json run_configuration(const CampaignRun& run) {
  Json json = Json::object();
  const Json own = written(run_keys(), run);
  for (const auto& [key, value] : own.items())
    if (!value.is_null() && value != "" && (run.track || !key.starts_with("track"))) json[key] = value;
  if (!run.pooled_from.empty()) json["pooled_from"] = run.pooled_from;
  return json;
}

}  // namespace

Json Campaign::effective_configuration() const {
  Json json;
  if (!title.empty()) json["title"] = title;
  json["platform"] = written(platform_keys(), platform);
  json["part"] = written(part_keys(), part);
  json["camera"] = written(camera_keys(), camera);
  json["scope"] = written(scope_keys(), scope);
  json["data"] = written(data_keys(), data);
  json["fit"] = fit_configuration(fit);
  json["runs"] = Json::array();
  for (const CampaignRun& run : runs) json["runs"].push_back(run_configuration(run));
  return json;
}

}  // namespace tribotrack::apps
