// From fit.json to the page: what must stand there, and what must not where the file is silent.
#include "apps/report/data/sources.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "apps/files/run_folder.h"
#include "apps/program.h"
#include "apps/report/data/json.h"
#include "apps/report/findings/verdict.h"
#include "apps/report/page/page.h"
#include "apps/report/page/results.h"
#include "apps/report/tables/tables.h"

namespace tribotrack::apps {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// The keys every fit.json holds, and no others.
Json bare() {
  return Json::parse(R"({
    "parameters": {
      "mu1": {"estimate": 0.1, "sd": 0.002, "ci95": [0.096, 0.104], "profile_ci95": [0.095, null]},
      "phase_lag_rad": {"estimate": 0.3, "sd": 0.01, "ci95": [0.28, 0.32], "profile_ci95": [0.281, 0.321]}},
    "correlation": {"mu1": {"mu1": 1, "phase_lag_rad": -0.5}, "phase_lag_rad": {"mu1": -0.5, "phase_lag_rad": 1}},
    "chi2": 20.0, "dof": 25, "agreement": "good", "converged": true, "scatter_mm": 0.0, "covariance_meaning": "",
    "identifiability": {"verdict": "identifiable", "weak_directions": []},
    "next_experiment": null, "warnings": []})");
}

ReportData collected(const Json& fit) {
  ReportData data;
  read_fit(fit, data);
  return data;
}

std::string page_text(const ReportData& data) {
  return verdict_box(data) + warning_box(data) + parameter_section(data, {}).html +
         check_section(data, {}).html + next_section(data).html;
}

TEST(ReportFit, WhatTheFileDoesNotHoldIsNotOnThePage) {
  const std::string page = page_text(collected(bare()));
  EXPECT_THAT(page, HasSubstr("<td class=\"n ends\">0.0960 to 0.1040</td>"));
  for (const char* absent :
       {"bootstrap", "Which covariance", "Other minima", "Remedy", "taken as known is wrong", "Scale of the",
        "p = ", "contradict", "Other models", "not needed", "What to film next", "nan", "warning"})
    EXPECT_THAT(page, Not(HasSubstr(absent))) << absent;
}

TEST(ReportFit, OpenProfileEndsAreInfinite) {
  EXPECT_THAT(page_text(collected(bare())), HasSubstr("<td class=\"n ends\">0.0950 to ∞</td>"));
}

TEST(ReportFit, TheThreeIntervalsStandSideBySide) {
  Json fit = bare();
  fit["parameters"]["mu1"]["bootstrap_ci95"] = {0.0961, 0.1042};
  fit["bootstrap"] = {{"refits", 400}, {"seed", 7}};
  fit["covariance_meaning"] = "sd from the data's own sigma.";
  const std::string page = parameter_section(collected(fit), {}).html;
  EXPECT_THAT(page, HasSubstr("<th class=\"n\">95 % interval</th><th class=\"n\">by profile</th><th "
                              "class=\"n\">by bootstrap</th>"));
  EXPECT_THAT(page,
              HasSubstr("<td class=\"n ends\">0.0960 to 0.1040</td><td class=\"n ends\">0.0950 to ∞</td>"
                        "<td class=\"n ends\">0.0961 to 0.1042</td>"));
  EXPECT_THAT(page, HasSubstr("95 % of 400 refits to simulated data (seed 7)"));
  EXPECT_THAT(page, HasSubstr("<b>Which covariance this is:</b> sd from the data&#39;s own sigma."));
}

TEST(ReportFit, WithoutProfilesTheirColumnAndAdviceAreLeftOut) {
  Json fit = bare();
  for (auto& parameter : fit["parameters"]) parameter.erase("profile_ci95");
  EXPECT_THAT(parameter_section(collected(fit), {}).html, Not(HasSubstr("profile")));
}

TEST(ReportFit, AnotherMinimumIsADoubtAndHasItsPlace) {
  Json fit = bare();
  const char* sentence = "Another minimum fits nearly as well (chi2 higher by 1.2): mu1 = 0.154.";
  fit["warnings"] = {"Something else.", sentence};
  fit["minima"] = {{{"parameters", {{"mu1", 0.1}}}, {"chi2_above_best", 0.0}, {"sentence", ""}},
                   {{"parameters", {{"mu1", 0.154}}}, {"chi2_above_best", 1.2}, {"sentence", sentence}}};
  const ReportData data = collected(fit);
  EXPECT_THAT(data.other_minima, ElementsAre(HasSubstr("mu1 = 0.154")));
  EXPECT_EQ(data.warnings.size(), 2u) << "it stays a warning, too";
  EXPECT_THAT(parameter_section(data, {}).html, HasSubstr("<h3>Other minima</h3>"));
  EXPECT_THAT(verdict_of(data).heading, HasSubstr("other values fit nearly as well"));
}

TEST(ReportFit, AFlatDirectionComesWithItsRemedy) {
  Json fit = bare();
  fit["identifiability"] = {
      {"verdict", "not identifiable"},
      {"weak_directions", {"mu1 up 1 % is hidden by phase_lag_rad down 0.021, exactly."}}};
  fit["other_next_experiments"] = {
      {{"phi_rad", 0.0}, {"dtau_rad", 3.0}, {"sentence", "For mu1 film dtau = 3."}}};
  const std::string page = parameter_section(collected(fit), {}).html;
  EXPECT_THAT(page, HasSubstr("<li>μ₁ up 1 % is hidden by lag down 0.021, exactly.</li>"));
  EXPECT_THAT(page, HasSubstr("<b>Remedy:</b> For μ₁ film Δτ = 3."));
}

TEST(ReportFit, SystematicsAndTheSharedScaleAreShown) {
  Json fit = bare();
  fit["systematics"] = {"A up 1 %: mu1 up 1.1 %.", "w up 1 %: mu1 up 2.1 %."};
  fit["shared_scale"] = {{"used", true}, {"finding", "14 recordings share one scale"}};
  const std::string page = parameter_section(collected(fit), {}).html;
  EXPECT_THAT(page, HasSubstr("<li>A up 1 %: μ₁ up 1.1 %.</li><li>w up 1 %: μ₁ up 2.1 %.</li>"));
  EXPECT_THAT(page, HasSubstr("<p>14 recordings share one scale.</p>"));
}

TEST(ReportFit, WithScatterFromTheResidualsChiSquareIsNotPraised) {
  Json fit = bare();
  fit["scatter_mm"] = 0.5;
  fit["agreement"] = "only with scatter";
  EXPECT_THAT(verdict_of(collected(fit)).paragraph, HasSubstr("χ² no longer tests"));
  EXPECT_THAT(verdict_of(collected(fit)).paragraph, Not(HasSubstr("within their errors")));
  fit["agreement"] = "good";  // the scatter comes from repeated runs, and with it the model agrees
  EXPECT_THAT(verdict_of(collected(fit)).paragraph, HasSubstr("within their errors"));
}

TEST(ReportFit, ARunThatContradictsTheOthersIsADoubt) {
  Json fit = bare();
  fit["outliers"] = {{{"run", "a"}, {"deviation", 9.0}, {"chance", 1e-6}, {"looks_like_phi_rad", nullptr}}};
  EXPECT_THAT(verdict_of(collected(fit)).heading, HasSubstr("one run contradicts the others"));
  EXPECT_THAT(check_section(collected(fit), {}).html, HasSubstr("<td><b>a</b></td><td class=\"n\">9 σ</td>"));
}

TEST(ReportFit, RunsToFilmNextReadAsPredicted) {
  Json fit = bare();
  fit["next_experiment"] = {
      {"phi_rad", 0.5},
      {"dtau_rad", 2.0},
      {"amplitude_mm", 0.28},
      {"angular_frequency_rad_s", 62.8},
      {"aim", nullptr},
      {"sentence", "Film next."},
      {"predicted_ci95", {{"mu1", {0.099, 0.101}}, {"phase_lag_rad", {0.29, nullptr}}}}};
  const ReportData data = collected(fit);
  ASSERT_EQ(data.next_runs.size(), 1u);
  EXPECT_EQ(data.next_runs[0].aim, "");
  EXPECT_EQ(data.next_runs[0].predicted_ci95[0].high, 0.101);
  EXPECT_TRUE(std::isinf(data.next_runs[0].predicted_ci95[1].high));
  EXPECT_THAT(next_section(data).html, HasSubstr("<p>Film next.</p>"));
}

/// What `fit` itself writes, where one run cannot tell three parameters.
class ReportOfAFit : public ProgramTest {};

TEST_F(ReportOfAFit, OneRunAloneIsAnsweredOnThePage) {
  put(in_folder("c.toml"), R"(
[platform]
amplitude_mm = 0.28
angular_frequency_rad_s = 62.8
phase_shift_rad = "pi/2"
[fit]
parameters = ["mu1", "mu2", "phase_lag_rad"]
cycles = 20
[[run]]
name = "alone"
phi_rad = 0
dtau_rad = "pi/3"
alpha_rad = 5.61313
alpha_sd_rad = 0.003
v_mm_s = 3.93063
v_sd_mm_s = 0.012
)");
  ASSERT_EQ(run("fit c.toml -o fit.json -q").exit_code, 5);
  const ReportData data = collected(read_json(in_folder("fit.json")));
  EXPECT_FALSE(data.other_minima.empty()) << "quite different values reach chi2 = 0 too";
  ASSERT_FALSE(data.next_runs.empty());
  EXPECT_GT(data.next_runs[0].predicted_ci95.at(0).low, 0);
  const std::string page = page_text(data);
  for (const char* words :
       {"Do not use these values", "hidden by", "<b>Remedy:</b> Film next", "Other minima",
        "nothing checks the model", "the widths of the intervals are meaningful"})
    EXPECT_THAT(page, HasSubstr(words));
}

/// What a damaged file is refused with.
std::string refusal(const std::function<void(Json&)>& damage) {
  Json fit = bare();
  damage(fit);
  ReportData data;
  try {
    read_fit(fit, data);
  } catch (const WrongContent& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ReportFit, AFileWithoutItsKeysIsRefusedByName) {
  EXPECT_EQ(refusal([](Json& fit) { fit = Json::array(); }), "must hold an object, not []");
  for (const char* key :
       {"parameters", "correlation", "chi2", "dof", "agreement", "converged", "identifiability"})
    EXPECT_EQ(refusal([&](Json& fit) { fit.erase(key); }), "`" + std::string(key) + "` is missing");
  EXPECT_EQ(refusal([](Json& fit) { fit["parameters"]["mu1"].erase("estimate"); }),
            "`parameters.mu1.estimate` is missing");
  EXPECT_EQ(refusal([](Json& fit) { fit["parameters"]["mu1"]["estimate"] = "0.1"; }),
            "`parameters.mu1.estimate` must be a number, not \"0.1\"");
  EXPECT_EQ(refusal([](Json& fit) { fit["parameters"]["mu1"]["ci95"] = {0.1}; }),
            "`parameters.mu1.ci95` must be a list of two numbers, not [0.1]");
  EXPECT_EQ(refusal([](Json& fit) { fit["parameters"] = nullptr; }),
            "`parameters` must be an object, not null");
  EXPECT_EQ(refusal([](Json& fit) { fit["parameters"] = Json::object(); }),
            "`parameters` must be an object with the fitted parameters, not {}");
  EXPECT_EQ(refusal([](Json& fit) { fit["correlation"]["mu1"].erase("phase_lag_rad"); }),
            "`correlation.mu1.phase_lag_rad` is missing");
  EXPECT_EQ(
      refusal([](Json& fit) { fit["identifiability"]["verdict"] = "fine"; }),
      "`identifiability.verdict` must be \"identifiable\", \"weak\" or \"not identifiable\", not \"fine\"");
  EXPECT_EQ(refusal([](Json& fit) { fit["dof"] = std::uint64_t{1} << 40; }),
            "`dof` must be a whole number below 2147483648, not 1099511627776");
  EXPECT_EQ(refusal([](Json& fit) {
              fit["bootstrap"] = {{"refits", "many"}};
            }),
            "`bootstrap.refits` must be a whole number, not \"many\"");
  EXPECT_EQ(refusal([](Json& fit) { fit["budget"] = 5; }), "`budget` must be a list, not 5");
  EXPECT_EQ(refusal([](Json& fit) {
              fit["outliers"] = {{{"deviation", "large"}}};
            }),
            "`outliers[0].deviation` must be a number, not \"large\"");
  EXPECT_EQ(refusal([](Json& fit) { fit["agreement"] = "fine"; }),
            "`agreement` must be \"good\", \"only with scatter\", \"poor\", \"too good\" or \"unknown\", not "
            "\"fine\"");
}

}  // namespace
}  // namespace tribotrack::apps
