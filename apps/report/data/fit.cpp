#include "apps/report/data/fit.h"

#include "apps/report/data/json.h"

namespace tribotrack::apps {
namespace {

void collect_parameters(const Json& fit, ReportData& data) {
  for (const auto& [name, p] : fit.at("parameters").items())
    data.parameters.push_back({name,
                               number_at(p, "estimate"),
                               number_at(p, "sd"),
                               interval_at(p, "ci95"),
                               interval_at(p, "profile_ci95"),
                               {},
                               interval_at(p, "bootstrap_ci95")});
  for (const ReportParameter& row : data.parameters) {
    data.correlation.emplace_back();
    for (const ReportParameter& column : data.parameters)
      data.correlation.back().push_back(number_at(fit.at("correlation").at(row.name), column.name));
  }
  data.covariance_meaning = word_at(fit, "covariance_meaning");
  if (const auto bootstrap = fit.find("bootstrap"); bootstrap != fit.end()) {
    data.bootstrap_refits = bootstrap->value("refits", 0);
    data.bootstrap_seed = bootstrap->value("seed", 0u);
  }
  if (const auto shared = fit.find("shared_scale"); shared != fit.end())
    data.shared_scale = word_at(*shared, "finding");
}

/// All minima but the best.
void collect_other_minima(const Json& fit, ReportData& data) {
  const Json minima = fit.value("minima", Json::array());
  for (std::size_t i = 1; i < minima.size(); ++i) data.other_minima.push_back(word_at(minima[i], "sentence"));
}

void collect_identifiability(const Json& fit, ReportData& data) {
  const Json& identifiability = fit.at("identifiability");
  const std::string verdict = word_at(identifiability, "verdict");
  data.identifiability = verdict == "identifiable" ? ReportVerdict::identifiable
                         : verdict == "weak"       ? ReportVerdict::weak
                                                   : ReportVerdict::not_identifiable;
  data.weak_directions = sentences_at(identifiability, "weak_directions");
}

void collect_checks(const Json& fit, ReportData& data) {
  data.chi2 = number_at(fit, "chi2");
  data.dof = fit.at("dof").get<int>();
  data.scatter_mm = number_at(fit, "scatter_mm");
  data.p_value = number_at(fit, "p_value");
  data.runs_test_p_value = number_at(fit, "runs_test_p_value");
  if (const auto outliers = fit.find("outliers"); outliers != fit.end())
    for (const Json& outlier : *outliers)
      data.outliers.push_back({word_at(outlier, "run"), number_at(outlier, "deviation"),
                               number_at(outlier, "chance"), number_at(outlier, "looks_like_phi_rad")});
  if (const auto models = fit.find("models"); models != fit.end())
    for (const Json& model : *models)
      data.models.push_back({word_at(model, "name"), model.value("unknowns", 0), number_at(model, "chi2"),
                             number_at(model, "aic"), number_at(model, "bic"), word_at(model, "sentence")});
  data.left_out = sentences_at(fit, "left_out");
  data.systematics = sentences_at(fit, "systematics");
}

ReportNextRun next_run(const Json& next, const std::vector<ReportParameter>& parameters) {
  ReportNextRun run{.phi_rad = number_at(next, "phi_rad"),
                    .dtau_rad = number_at(next, "dtau_rad"),
                    .amplitude_mm = number_at(next, "amplitude_mm"),
                    .w_rad_s = number_at(next, "angular_frequency_rad_s"),
                    .aim = word_at(next, "aim"),
                    .predicted_ci95 = {},
                    .sentence = word_at(next, "sentence")};
  const Json predicted = next.value("predicted_ci95", Json::object());
  for (const ReportParameter& parameter : parameters)
    run.predicted_ci95.push_back(interval_at(predicted, parameter.name));
  return run;
}

void collect_next_runs(const Json& fit, ReportData& data) {
  if (const Json& next = fit.at("next_experiment"); next.is_object()) {
    data.next_experiment = word_at(next, "sentence");
    data.next_runs.push_back(next_run(next, data.parameters));
  }
  if (const auto others = fit.find("other_next_experiments"); others != fit.end())
    for (const Json& next : *others) data.next_runs.push_back(next_run(next, data.parameters));
}

}  // namespace

void collect_fit(const Json& fit, ReportData& data) {
  data.converged = fit.at("converged").get<bool>();
  data.warnings = sentences_at(fit, "warnings");
  data.phase_reference = word_at(fit, "phase_reference");
  collect_parameters(fit, data);
  collect_identifiability(fit, data);
  collect_other_minima(fit, data);
  collect_checks(fit, data);
  collect_next_runs(fit, data);
}

}  // namespace tribotrack::apps
