#include "apps/report/data/sources.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>

#include "apps/report/data/json.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

std::string file_name(const std::string& path) {
  return fs::path(path).filename().string();
}

/// A campaign by its file's name, or by its folder's where the file is just called campaign.toml.
std::string title_of(const fs::path& campaign) {
  const std::string folder = campaign.parent_path().filename().string();
  const bool plain = campaign.stem() == "campaign" && !folder.empty() && folder != "." && folder != "..";
  return plain ? folder : campaign.stem().string();
}

bool is_sd(const std::string& name) {
  return name.ends_with("_sd") || name == "diameter_sd_mm";
}

/// With its sd where one was given; else the fit takes it as exact.
std::string source_of_given(const JsonPlace& section, const std::string& name) {
  const double sd = number_at(section, name == "diameter_mm" ? "diameter_sd_mm" : name + "_sd");
  return sd > 0 ? fmt::format("campaign, sd {:.3g}", sd) : "campaign, taken as exact";
}

void add_given(const JsonPlace& configuration, ReportData& data) {
  const auto fitted = [&](const std::string& name) {
    return std::any_of(data.parameters.begin(), data.parameters.end(),
                       [&](const ReportParameter& p) { return p.name == name; });
  };
  for (const char* section : {"platform", "part"})
    if (const auto found = configuration.find(section))
      for (const auto& [name, value] : found->object().value.items())
        if (value.is_number() && !fitted(name) && !is_sd(name))
          data.given.push_back({name, value.get<double>(), source_of_given(*found, name)});
  const JsonPlace fixed = configuration.at("fit").at("fixed").object();
  for (const auto& item : fixed.value.items())
    data.given.push_back({item.key(), fixed.at(item.key()).number(), "campaign, held fixed"});
}

ReportSource source_of(const std::string& path, const std::string& xxh3_128, const std::string& hashed) {
  return {file_name(path), "xxh3-128:" + xxh3_128 + (hashed.empty() ? "" : ", " + hashed)};
}

/// The median; NaN where none is finite.
double median_of_finite(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return no_value;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// "2021-03-04", or the first and the last day.
void add_day(const std::string& time, ReportData& data) {
  constexpr std::size_t kDay = 10;  // "2021-03-04"
  if (time.size() < kDay) return;
  const std::string day = time.substr(0, kDay), to = " to ";
  const auto at = data.filmed.find(to);
  std::string first = data.filmed.substr(0, kDay),
              last = at == std::string::npos ? first : data.filmed.substr(at + to.size());
  if (data.filmed.empty()) first = last = day;
  first = std::min(first, day);
  last = std::max(last, day);
  data.filmed = first == last ? first : first + to + last;
}

/// "6 × 0.8 mm", as far as it was given.
std::string part_text(const JsonPlace& configuration) {
  const auto part = configuration.find("part");
  if (!part) return "";
  const double diameter = number_at(*part, "diameter_mm"), height = number_at(*part, "height_mm");
  if (std::isnan(diameter)) return "";
  return std::isnan(height) ? fmt::format("⌀ {:g} mm", diameter)
                            : fmt::format("⌀ {:g} × {:g} mm", diameter, height);
}

}  // namespace

void add_provenance(const Json& meta, ReportData& data) {
  const JsonPlace place{meta, ""};
  const JsonPlace configuration = place.at("configuration");
  add_given(configuration, data);
  data.program_version = place.text("version");
  data.part = part_text(configuration);
  const JsonPlace inputs = place.at("inputs").list();
  for (std::size_t k = 0; k < inputs.value.size(); ++k)
    data.inputs.push_back(source_of(inputs.at(k).at("path").text(), inputs.at(k).at("xxh3_128").text(),
                                    inputs.at(k).text("hashed")));
  if (!data.inputs.empty()) data.title = title_of(inputs.at(0).at("path").text());
  if (const std::string title = configuration.text("title"); !title.empty()) data.title = title;
  data.configuration = configuration.value.dump(2, ' ', false, Json::error_handler_t::replace);
}

void add_track(const Track& track, const RunFolder& folder, ReportRun& run) {
  run.x_px = track.x_px;
  run.y_px = track.y_px;
  run.x_mm = track.x_mm;
  run.y_mm = track.y_mm;
  run.time_s = track.time_s;
  run.sigma_all_px = track.sigma_px;
  run.ncc = track.ncc;
  run.in_camera_frame = track.in_camera_frame;
  run.theta_rad = track.theta_rad;
  run.sigma_theta_rad = median_of_finite(track.sigma_theta_rad);
  run.frames_ok = track.frames - track.lost - track.edge;
  run.frames_lost = track.lost;
  run.frames_edge = track.edge;
  run.sigma_px = median_of_finite(track.sigma_px);
  run.frame_rate_hz = track.frame_rate_hz.value_or(no_value);
  run.time_base = track.time_base;
  run.frame_width_px = track.width_px;
  run.frame_height_px = track.height_px;
  if (track.in_camera_frame && run.kind != "free_slide")
    run.notes.push_back("measured in the camera's frame: no marker");
  run.notes.insert(run.notes.end(), track.warnings.begin(), track.warnings.end());
  run.audit = track.audit;
  for (const vision::PlanStage& stage : track.plan)
    run.plan.push_back({stage.name, stage.on, stage.reason, stage.error_bound_px.value_or(no_value)});
  if (std::ifstream picture(folder.first_frame(run.name), std::ios::binary); picture)
    run.first_frame.assign(std::istreambuf_iterator<char>(picture), {});
}

void add_pooled_note(const std::vector<std::string>& lines, ReportRun& run) {
  if (!lines.empty())
    run.notes.push_back(fmt::format("mean of {} measurements: {}", lines.size(), fmt::join(lines, ", ")));
}

void add_recording(const Track& track, ReportData& data) {
  add_day(track.recorded_at, data);
  for (const Input& input : track.recorded_in)
    data.inputs.push_back(source_of(input.path.string(), input.xxh3_128, input.hashed));
}

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
