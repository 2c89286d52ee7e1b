#include "fit/fit_result_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace tribotrack::fit {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Every field set to something of its own.
FitResult full() {
  FitResult fit;
  fit.parameters.resize(2);
  fit.parameters[0] = {.parameter = FitParameter::amplitude,
                       .estimate = 0.28e-3,
                       .sd = 1e-6,
                       .ci95 = {0.27e-3, 0.29e-3},
                       .ci95_pieces = {{0.27e-3, 0.275e-3}, {0.28e-3, 0.29e-3}},
                       .covariance_ci95 = {0.278e-3, 0.282e-3},
                       .profile_ci95 = {0.27e-3, kInfinity},
                       .profile = {{0.27e-3, 3.8}, {0.29e-3, 3.9}},
                       .profile_level = 3.84,
                       .bootstrap_ci95 = {0.26e-3, 0.3e-3}};
  fit.parameters[1].parameter = FitParameter::scale;
  fit.parameters[1].estimate = 1.02;
  fit.parameters[1].sd = kInfinity;
  fit.correlation.resize(2, 2);
  fit.correlation << 1, -0.5, -0.5, 1;
  fit.chi2 = 20.5;
  fit.dof = 25;
  fit.p_value = 0.7;
  fit.agreement = Agreement::only_with_scatter;
  fit.converged = true;
  fit.scatter = 2e-6;
  fit.correlated_errors.time = 1.5;
  fit.correlated_errors.walk = 3e-6;
  fit.minima = {{{{FitParameter::amplitude, 0.3e-3}}, 1.2, "Another minimum."}};
  fit.identifiability = {Verdict::weak, {"A up 1 % is hidden."}, {3, 0.1}};
  RunResult& run = fit.runs.emplace_back();
  run.name = "a";
  run.residuals = {{"dx_mm", 1, 1.1, 0.1, -1}};
  run.fitted.drive.amplitude = 0.28e-3;
  run.fitted.friction.phase = 1.5;
  run.influence = {0.1, -0.2};
  run.points = 7;
  run.nuisance["initial_speed_mm_s"] = 612;
  run.slide = {{0, 0.1}, {0, 0.05}, {0, 0.051}, "Slowly."};
  SlideResult& slide = fit.slides.emplace_back();
  slide.run = "a";
  slide.mu1 = {0.148, 0.002};
  slide.spin_seen = true;
  slide.spin_ratio = {0.4, 0.01};
  slide.blows = {{231, 0.5, 0.6, 0.4, 0.2}};
  NextExperiment next;
  next.phi = 0.5;
  next.amplitude = 0.28e-3;
  next.aim = FitParameter::scale;
  next.predicted_sd[FitParameter::amplitude] = 5e-7;
  next.predicted_ci95[FitParameter::amplitude] = {0.279e-3, 0.281e-3};
  fit.next_experiment = next;
  fit.outliers = {{"a", 9, 1e-6, 1.5, "Run a."}};
  fit.verdict = Use::care;
  fit.verdict_reasons = {"a doubt"};
  fit.quoted_under = {"a tilt"};
  fit.as_assumed[FitParameter::amplitude] = {0.281e-3, 2e-6, {0.277e-3, 0.285e-3}};
  Explanation& tilt = fit.explanations.emplace_back();
  tilt.name = "tilt";
  tilt.chi2_fall = 12.5;
  tilt.dof = 2;
  tilt.p_after = 0.4;
  tilt.size = 1e-3;
  tilt.unit = "rad";
  tilt.refitted = tilt.explains = true;
  tilt.parameters = fit.as_assumed;
  BudgetEntry& entry = fit.budget.emplace_back();
  entry.source = "scale";
  entry.quantity = "mm_per_px";
  entry.sd = 0.01;
  entry.contribution = Eigen::Vector2d(1e-6, 0.02);
  entry.sensitivity = Eigen::Vector2d(1e-4, 1);
  fit.loss = Loss::huber;
  fit.bootstrap = {400, 7};
  fit.warnings = {"Read this."};
  return fit;
}

TEST(FitResultJson, ReadsBackAsItWasWritten) {
  const Json written = in_key_units(full(), 0.02), again = written.get<FitResult>();
  const Json first = written.flatten(), second = again.flatten();  // by their paths
  ASSERT_EQ(first.size(), second.size());
  for (const auto& [path, value] : first.items()) {
    ASSERT_TRUE(second.contains(path)) << path;
    if (value.is_number_float())  // of lengths the last bit may go between mm and m
      EXPECT_DOUBLE_EQ(second[path].get<double>(), value.get<double>()) << path;
    else
      EXPECT_EQ(second[path], value) << path;
  }
}

TEST(FitResultJson, StandsInTheUnitsOfItsKeys) {
  const Json json = in_key_units(full(), 0.02);
  const auto number = [](const Json& value) { return value.get<double>(); };
  const Json& a = json["parameters"]["amplitude_mm"];
  EXPECT_DOUBLE_EQ(number(a["estimate"]), 0.28);
  EXPECT_DOUBLE_EQ(number(a["ci95"][1]), 0.29);
  EXPECT_DOUBLE_EQ(number(a["ci95_pieces"][0][1]), 0.275);
  EXPECT_DOUBLE_EQ(number(a["profile"]["value"][0]), 0.27);
  EXPECT_TRUE(a["profile_ci95"][1].is_null()) << "open";
  EXPECT_DOUBLE_EQ(number(json["parameters"]["mm_per_px"]["estimate"]), 0.0204);
  EXPECT_TRUE(json["parameters"]["mm_per_px"]["sd"].is_null()) << "not determined";
  EXPECT_DOUBLE_EQ(number(json["minima"][0]["parameters"]["amplitude_mm"]), 0.3);
  EXPECT_DOUBLE_EQ(number(json["next_experiment"]["amplitude_mm"]), 0.28);
  EXPECT_DOUBLE_EQ(number(json["next_experiment"]["predicted_ci95"]["amplitude_mm"][0]), 0.279);
  const Json& source = json["budget"][0];
  EXPECT_DOUBLE_EQ(number(source["sd_of_source"]), 2e-4) << "mm/px";
  EXPECT_DOUBLE_EQ(number(source["contribution"]["amplitude_mm"]), 1e-3);
  EXPECT_DOUBLE_EQ(number(source["sensitivity"]["amplitude_mm"]), 0.1 / 0.02) << "mm a mm/px";
  EXPECT_DOUBLE_EQ(number(json["runs"][0]["scenario"]["amplitude_mm"]), 0.28);
  EXPECT_DOUBLE_EQ(number(json["slow_errors"]["walk_mm"]), 3e-3);
}

/// The keys every fit.json holds, and no others.
Json bare() {
  return Json::parse(R"({
    "parameters": {
      "mu1": {"estimate": 0.1, "sd": 0.002, "ci95": [0.096, 0.104], "profile_ci95": [0.095, null]},
      "phase_lag_rad": {"estimate": 0.3, "sd": 0.01, "ci95": [0.28, 0.32]}},
    "correlation": {"mu1": {"mu1": 1, "phase_lag_rad": -0.5}, "phase_lag_rad": {"mu1": -0.5, "phase_lag_rad": 1}},
    "chi2": 20.0, "dof": 25, "agreement": "good", "converged": true,
    "identifiability": {"verdict": "identifiable", "weak_directions": []}, "next_experiment": null})");
}

TEST(FitResultJson, WhatAnOlderFileLacksIsNoNumber) {
  const auto fit = bare().get<FitResult>();
  EXPECT_EQ(fit.parameters[0].profile_ci95.high, kInfinity) << "an open end";
  for (const double absent :
       {fit.parameters[1].profile_ci95.low, fit.parameters[0].bootstrap_ci95.high, fit.p_value, fit.scatter})
    EXPECT_TRUE(std::isnan(absent));
  EXPECT_FALSE(fit.next_experiment);
  EXPECT_TRUE(fit.runs.empty() && fit.slides.empty() && fit.budget.empty() && fit.minima.empty());
}

/// What a damaged file is refused with.
std::string refusal(const std::function<void(Json&)>& damage) {
  Json fit = bare();
  damage(fit);
  try {
    static_cast<void>(fit.get<FitResult>());
  } catch (const WrongContent& error) {
    return error.what();
  }
  return "accepted";
}

TEST(FitResultJson, AFileWithoutItsKeysIsRefusedByName) {
  for (const char* key : {"correlation", "chi2", "dof", "agreement", "converged", "identifiability"})
    EXPECT_EQ(refusal([&](Json& fit) { fit.erase(key); }), "`" + std::string(key) + "` is missing");
  for (const auto& [place, value, name] : std::vector<std::tuple<const char*, Json, const char*>>{
           {"/parameters/mu1", Json::object(), "`parameters.mu1.estimate`"},
           {"/parameters/mu1/ci95", {0.1}, "`parameters.mu1.ci95`"},
           {"/parameters", Json::object(), "`parameters`"},
           {"/parameters/mu9", 1, "`parameters`"},
           {"/correlation/mu1", Json::object(), "`correlation.mu1."},
           {"/identifiability/verdict", "fine", "`identifiability.verdict`"},
           {"/dof", std::uint64_t{1} << 40, "`dof`"},
           {"/bootstrap/refits", "many", "`bootstrap.refits`"},
           {"/budget", 5, "`budget`"},
           {"/outliers/0/deviation", "large", "`outliers[0].deviation`"}})
    EXPECT_THAT(refusal([&](Json& fit) { fit[Json::json_pointer(place)] = value; }),
                testing::StartsWith(name));
}

}  // namespace
}  // namespace tribotrack::fit
