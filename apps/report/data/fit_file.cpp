#include "apps/report/data/fit_file.h"

#include <limits>

#include "apps/report/data/json.h"

namespace tribotrack::apps {

ReportInterval interval_of(const JsonPlace& place) {
  constexpr double open = std::numeric_limits<double>::infinity();
  if (!place.value.is_array() || place.value.size() != 2) place.refuse("a list of two numbers");
  const auto end = [&](std::size_t k, double if_open) {
    return place.value[k].is_null() ? if_open : place.at(k).number();
  };
  const ReportInterval interval{end(0, -open), end(1, open)};
  if (interval.low > interval.high) place.refuse("an interval, the low end first");
  return interval;
}

double sd_of(const JsonPlace& place) {
  const double sd = place.number_or_null();
  if (sd < 0) place.refuse("0 or more");
  return sd;
}

namespace {

std::vector<ReportInterval> pieces_of(const JsonPlace& parameter) {
  std::vector<ReportInterval> pieces;
  for (const JsonPlace& piece : parameter.items("ci95_pieces")) pieces.push_back(interval_of(piece));
  return pieces;
}

void read_parameters(const JsonPlace& fit, ReportData& data) {
  const JsonPlace parameters = fit.at("parameters").object();
  if (parameters.value.empty()) parameters.refuse("an object with the fitted parameters");
  for (const auto& item : parameters.value.items()) {
    const JsonPlace p = parameters.at(item.key());
    data.parameters.push_back({.name = item.key(),
                               .estimate = p.at("estimate").number(),
                               .sd = sd_of(p.at("sd")),
                               .ci95 = interval_of(p.at("ci95")),
                               .pieces = pieces_of(p),
                               .covariance_ci95 = interval_at(p, "covariance_ci95"),
                               .profile_ci95 = interval_at(p, "profile_ci95"),
                               .bootstrap_ci95 = interval_at(p, "bootstrap_ci95")});
  }
  for (ReportParameter& parameter : data.parameters)
    if (const auto profile = parameters.at(parameter.name).find("profile")) {
      parameter.profile.value = numbers_at(*profile, "value");
      parameter.profile.rise = numbers_at(*profile, "chi2_rise");
      parameter.profile.level = number_at(*profile, "level");
    }
  const JsonPlace correlation = fit.at("correlation");
  for (const ReportParameter& row : data.parameters) {
    data.correlation.emplace_back();
    for (const ReportParameter& column : data.parameters)
      data.correlation.back().push_back(correlation.at(row.name).at(column.name).number_or_null());
  }
  data.covariance_meaning = fit.text("covariance_meaning");
  if (const auto bootstrap = fit.find("bootstrap")) {
    data.bootstrap_refits = bootstrap->integer("refits", 0);
    data.bootstrap_seed = static_cast<unsigned>(bootstrap->whole("seed", 0));
  }
  if (const auto shared = fit.find("shared_scale")) data.shared_scale = shared->text("finding");
}

/// All minima but the best.
void read_other_minima(const JsonPlace& fit, ReportData& data) {
  const std::vector<JsonPlace> minima = fit.items("minima");
  for (std::size_t i = 1; i < minima.size(); ++i) data.other_minima.push_back(minima[i].text("sentence"));
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
  data.weak_directions = identifiability.texts("weak_directions");
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

void read_checks(const JsonPlace& fit, ReportData& data) {
  data.scatter_mm = number_at(fit, "scatter_mm");
  data.p_value = number_at(fit, "p_value");
  data.runs_test_p_value = number_at(fit, "runs_test_p_value");
  for (const JsonPlace& outlier : fit.items("outliers"))
    data.outliers.push_back({outlier.text("run"), number_at(outlier, "deviation"),
                             number_at(outlier, "chance"), number_at(outlier, "looks_like_phi_rad")});
  for (const JsonPlace& model : fit.items("models"))
    data.models.push_back({model.text("name"), model.integer("unknowns", 0), number_at(model, "chi2"),
                           number_at(model, "aic"), number_at(model, "bic"), model.text("sentence")});
  data.left_out = fit.texts("left_out");
  data.systematics = fit.texts("systematics");
  data.improve_first = fit.text("improve_first");
  data.scatter_dominates = fit.boolean("scatter_dominates", false);
}

ReportNextRun next_run(const JsonPlace& next, const std::vector<ReportParameter>& parameters) {
  ReportNextRun run{.phi_rad = number_at(next, "phi_rad"),
                    .dtau_rad = number_at(next, "dtau_rad"),
                    .amplitude_mm = number_at(next, "amplitude_mm"),
                    .w_rad_s = number_at(next, "angular_frequency_rad_s"),
                    .aim = next.text("aim"),
                    .predicted_ci95 = {},
                    .sentence = next.text("sentence")};
  const auto predicted = next.find("predicted_ci95");
  for (const ReportParameter& parameter : parameters)
    run.predicted_ci95.push_back(predicted ? interval_at(*predicted, parameter.name) : ReportInterval{});
  return run;
}

void read_next_runs(const JsonPlace& fit, ReportData& data) {
  if (const auto next = fit.find("next_experiment")) {
    data.next_experiment = next->text("sentence");
    data.next_runs.push_back(next_run(*next, data.parameters));
  }
  for (const JsonPlace& next : fit.items("other_next_experiments"))
    data.next_runs.push_back(next_run(next, data.parameters));
}

void read_slides(const JsonPlace& fit, ReportData& data) {
  for (const JsonPlace& s : fit.items("slides")) {
    ReportSlideResult slide{.name = s.text("name"),
                            .mu1 = number_at(s, "mu1"),
                            .mu1_sd = number_at(s, "mu1_sd"),
                            .ci95 = interval_at(s, "ci95"),
                            .chi2 = number_at(s, "chi2"),
                            .p_value = number_at(s, "p_value"),
                            .dof = s.integer("dof", 0),
                            .first_frame = s.whole("first_frame", 0),
                            .last_frame = s.whole("last_frame", 0),
                            .spin_seen = s.boolean("spin_seen", false),
                            .spin_rad_s = number_at(s, "spin_rad_s"),
                            .spin_rad_s_sd = number_at(s, "spin_rad_s_sd"),
                            .spin_ratio = number_at(s, "spin_ratio"),
                            .spin_ratio_sd = number_at(s, "spin_ratio_sd"),
                            .slope_rad = s.number("slope_rad", 0),
                            .change_by_half_spin = number_at(s, "mu1_change_by_half_spin"),
                            .blow_frames = {},
                            .sentence = s.text("sentence")};
    for (const JsonPlace& blow : s.items("blows")) slide.blow_frames.push_back(blow.whole("frame", 0));
    data.slide_results.push_back(std::move(slide));
  }
  if (const auto between = fit.find("between_slides")) {
    data.between_slides = between->number("sd", 0);
    data.between_slides_p_value = number_at(*between, "p_value");
  }
}

}  // namespace

void read_budget(const JsonPlace& budget, ReportData& data) {
  for (const JsonPlace& row : budget.items()) {
    ReportBudgetEntry entry{.source = row.text("source"),
                            .quantity = row.text("quantity"),
                            .from = row.text("from"),
                            .sd = number_at(row, "sd_of_source"),
                            .counted = row.boolean("counted", true),
                            .contribution = {}};
    const auto contribution = row.find("contribution");
    for (const ReportParameter& parameter : data.parameters)
      entry.contribution.push_back(contribution ? number_at(*contribution, parameter.name) : no_value);
    data.budget.push_back(entry);
  }
}

void read_conditions(const JsonPlace& conditions, ReportData& data) {
  for (const JsonPlace& row : conditions.items())
    data.conditions.push_back({.quantity = row.text("quantity"),
                               .given = number_at(row, "given"),
                               .given_sd = number_at(row, "given_sd"),
                               .measured = number_at(row, "measured"),
                               .sd = number_at(row, "sd"),
                               .difference_in_sd = number_at(row, "difference_in_sd"),
                               .used = number_at(row, "used"),
                               .used_sd = number_at(row, "used_sd"),
                               .from = row.text("from")});
}

void read_fit(const Json& fit, ReportData& data) {
  const JsonPlace place{fit, ""};
  data.converged = place.at("converged").boolean();
  data.chi2 = place.at("chi2").number_or_null();
  data.dof = place.at("dof").integer();
  read_agreement(place.at("agreement"), data);
  read_parameters(place, data);
  read_identifiability(place.at("identifiability"), data);
  data.warnings = place.texts("warnings");
  data.phase_reference = place.text("phase_reference");
  if (const auto conditions = place.find("conditions")) read_conditions(*conditions, data);
  if (const auto budget = place.find("budget")) read_budget(*budget, data);
  read_other_minima(place, data);
  read_checks(place, data);
  read_slides(place, data);
  read_next_runs(place, data);
}

}  // namespace tribotrack::apps
