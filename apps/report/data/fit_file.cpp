#include "apps/report/data/fit_file.h"

#include "apps/report/data/json.h"

namespace tribotrack::apps {
namespace {

std::vector<ReportInterval> pieces_of(const Json& parameter) {
  std::vector<ReportInterval> pieces;
  const Json list = parameter.value("ci95_pieces", Json::array());
  const JsonPlace place{list, "ci95_pieces"};
  for (std::size_t i = 0; i < list.size(); ++i) pieces.push_back(place.at(i).interval());
  return pieces;
}

void read_parameters(const JsonPlace& fit, ReportData& data) {
  const JsonPlace parameters = fit.at("parameters").object();
  if (parameters.value.empty()) parameters.refuse("an object with the fitted parameters");
  for (const auto& item : parameters.value.items()) {
    const JsonPlace p = parameters.at(item.key());
    data.parameters.push_back({.name = item.key(),
                               .estimate = p.at("estimate").number(),
                               .sd = p.at("sd").sd_or_null(),
                               .ci95 = p.at("ci95").interval(),
                               .pieces = pieces_of(p.value),
                               .covariance_ci95 = interval_at(p.value, "covariance_ci95"),
                               .profile_ci95 = interval_at(p.value, "profile_ci95"),
                               .bootstrap_ci95 = interval_at(p.value, "bootstrap_ci95")});
  }
  const JsonPlace correlation = fit.at("correlation");
  for (const ReportParameter& row : data.parameters) {
    data.correlation.emplace_back();
    for (const ReportParameter& column : data.parameters)
      data.correlation.back().push_back(correlation.at(row.name).at(column.name).number_or_null());
  }
  data.covariance_meaning = text_at(fit.value, "covariance_meaning");
  if (const auto bootstrap = fit.value.find("bootstrap"); bootstrap != fit.value.end()) {
    data.bootstrap_refits = bootstrap->value("refits", 0);
    data.bootstrap_seed = bootstrap->value("seed", 0u);
  }
  if (const auto shared = fit.value.find("shared_scale"); shared != fit.value.end())
    data.shared_scale = text_at(*shared, "finding");
}

/// All minima but the best.
void read_other_minima(const Json& fit, ReportData& data) {
  const Json minima = fit.value("minima", Json::array());
  for (std::size_t i = 1; i < minima.size(); ++i) data.other_minima.push_back(text_at(minima[i], "sentence"));
}

void read_identifiability(const JsonPlace& identifiability, ReportData& data) {
  const JsonPlace verdict = identifiability.at("verdict");
  const std::string word = verdict.text();
  if (word == "identifiable")
    data.identifiability = ReportVerdict::identifiable;
  else if (word == "weak")
    data.identifiability = ReportVerdict::weak;
  else if (word == "not identifiable")
    data.identifiability = ReportVerdict::not_identifiable;
  else
    verdict.refuse("\"identifiable\", \"weak\" or \"not identifiable\"");
  data.weak_directions = sentences_at(identifiability.value, "weak_directions");
}

void read_agreement(const JsonPlace& place, ReportData& data) {
  using enum fit::Agreement;
  const std::string word = place.text();
  for (const fit::Agreement agreement : {good, only_with_scatter, poor, too_good, unknown})
    if (word == fit::to_string(agreement)) {
      data.agreement = agreement;
      return;
    }
  place.refuse("\"good\", \"only with scatter\", \"poor\", \"too good\" or \"unknown\"");
}

void read_checks(const Json& fit, ReportData& data) {
  data.scatter_mm = number_at(fit, "scatter_mm");
  data.p_value = number_at(fit, "p_value");
  data.runs_test_p_value = number_at(fit, "runs_test_p_value");
  if (const auto outliers = fit.find("outliers"); outliers != fit.end())
    for (const Json& outlier : *outliers)
      data.outliers.push_back({text_at(outlier, "run"), number_at(outlier, "deviation"),
                               number_at(outlier, "chance"), number_at(outlier, "looks_like_phi_rad")});
  if (const auto models = fit.find("models"); models != fit.end())
    for (const Json& model : *models)
      data.models.push_back({text_at(model, "name"), model.value("unknowns", 0), number_at(model, "chi2"),
                             number_at(model, "aic"), number_at(model, "bic"), text_at(model, "sentence")});
  data.left_out = sentences_at(fit, "left_out");
  data.systematics = sentences_at(fit, "systematics");
  data.improve_first = text_at(fit, "improve_first");
  data.scatter_dominates = fit.value("scatter_dominates", false);
}

ReportNextRun next_run(const Json& next, const std::vector<ReportParameter>& parameters) {
  ReportNextRun run{.phi_rad = number_at(next, "phi_rad"),
                    .dtau_rad = number_at(next, "dtau_rad"),
                    .amplitude_mm = number_at(next, "amplitude_mm"),
                    .w_rad_s = number_at(next, "angular_frequency_rad_s"),
                    .aim = text_at(next, "aim"),
                    .predicted_ci95 = {},
                    .sentence = text_at(next, "sentence")};
  const Json predicted = next.value("predicted_ci95", Json::object());
  for (const ReportParameter& parameter : parameters)
    run.predicted_ci95.push_back(interval_at(predicted, parameter.name));
  return run;
}

void read_next_runs(const Json& fit, ReportData& data) {
  if (const auto next = fit.find("next_experiment"); next != fit.end() && next->is_object()) {
    data.next_experiment = text_at(*next, "sentence");
    data.next_runs.push_back(next_run(*next, data.parameters));
  }
  if (const auto others = fit.find("other_next_experiments"); others != fit.end())
    for (const Json& next : *others) data.next_runs.push_back(next_run(next, data.parameters));
}

void read_slides(const Json& fit, ReportData& data) {
  for (const Json& s : fit.value("slides", Json::array())) {
    ReportSlideResult slide{.name = text_at(s, "name"),
                            .mu1 = number_at(s, "mu1"),
                            .mu1_sd = number_at(s, "mu1_sd"),
                            .ci95 = interval_at(s, "ci95"),
                            .chi2 = number_at(s, "chi2"),
                            .p_value = number_at(s, "p_value"),
                            .dof = s.value("dof", 0),
                            .first_frame = s.value("first_frame", std::int64_t{0}),
                            .last_frame = s.value("last_frame", std::int64_t{0}),
                            .spin_seen = s.value("spin_seen", false),
                            .spin_rad_s = number_at(s, "spin_rad_s"),
                            .spin_rad_s_sd = number_at(s, "spin_rad_s_sd"),
                            .spin_ratio = number_at(s, "spin_ratio"),
                            .spin_ratio_sd = number_at(s, "spin_ratio_sd"),
                            .change_by_half_spin = number_at(s, "mu1_change_by_half_spin"),
                            .blow_frames = {},
                            .sentence = text_at(s, "sentence")};
    for (const Json& blow : s.value("blows", Json::array()))
      slide.blow_frames.push_back(blow.value("frame", std::int64_t{0}));
    data.slide_results.push_back(std::move(slide));
  }
  if (const auto between = fit.find("between_slides"); between != fit.end()) {
    data.between_slides = between->value("sd", 0.0);
    data.between_slides_p_value = number_at(*between, "p_value");
  }
}

}  // namespace

void read_budget(const Json& budget, ReportData& data) {
  for (const Json& row : budget) {
    ReportBudgetEntry entry{.source = text_at(row, "source"),
                            .quantity = text_at(row, "quantity"),
                            .from = text_at(row, "from"),
                            .sd = number_at(row, "sd_of_source"),
                            .counted = row.value("counted", true),
                            .contribution = {}};
    const Json contribution = row.value("contribution", Json::object());
    for (const ReportParameter& parameter : data.parameters)
      entry.contribution.push_back(number_at(contribution, parameter.name));
    data.budget.push_back(entry);
  }
}

void read_conditions(const Json& conditions, ReportData& data) {
  for (const Json& row : conditions)
    data.conditions.push_back({.quantity = text_at(row, "quantity"),
                               .given = number_at(row, "given"),
                               .given_sd = number_at(row, "given_sd"),
                               .measured = number_at(row, "measured"),
                               .sd = number_at(row, "sd"),
                               .difference_in_sd = number_at(row, "difference_in_sd"),
                               .used = number_at(row, "used"),
                               .used_sd = number_at(row, "used_sd"),
                               .from = text_at(row, "from")});
}

void read_fit(const Json& fit, ReportData& data) {
  const JsonPlace place{fit, ""};
  data.converged = place.at("converged").boolean();
  data.chi2 = place.at("chi2").number_or_null();
  data.dof = place.at("dof").integer();
  read_agreement(place.at("agreement"), data);
  read_parameters(place, data);
  read_identifiability(place.at("identifiability"), data);
  data.warnings = sentences_at(fit, "warnings");
  data.phase_reference = text_at(fit, "phase_reference");
  read_conditions(fit.value("conditions", Json::array()), data);
  read_budget(fit.value("budget", Json::array()), data);
  read_other_minima(fit, data);
  read_checks(fit, data);
  read_slides(fit, data);
  read_next_runs(fit, data);
}

}  // namespace tribotrack::apps
