// The figures follow data/figure*.toml as they lie in the repository, and their points are what a single run
// of the model gives.
#include "apps/paper/figures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "apps/figures/figure_csv.h"
#include "apps/files/scenario_file.h"
#include "apps/page/assets/embedded_assets.h"
#include "apps/paper/scenarios.h"
#include "apps/program.h"
#include "model/alpha_v.h"
#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::apps {
namespace {

namespace fs = std::filesystem;
using std::numbers::pi;

const std::vector<Figure>& figures() {
  static const std::vector<Figure> made = paper_figures(1);
  return made;
}

const Figure& figure(int number) {
  return *std::ranges::find(figures(), number, number_of);
}

model::Scenario conditions_of(const std::string& name) {
  return read_scenario_file(fs::path(TRIBOTRACK_SOURCE_DIR) / "data" / (name + ".toml")).scenario;
}

const Series& series(const Figure& figure, std::size_t panel, const std::string& name, bool dashed = false) {
  for (const Series& s : figure.panels.at(panel).series)
    if (s.mark == Mark::line && s.name == name && s.dashed == dashed) return s;
  throw std::runtime_error(figure.id + " has no series " + name);
}

/// The y of the point nearest to x, which must lie there.
double y_at(const Series& series, double x) {
  const auto nearest = std::ranges::min_element(series.x, {}, [x](double at) { return std::abs(at - x); });
  EXPECT_NEAR(*nearest, x, 1e-12) << series.name;
  return series.y[static_cast<std::size_t>(nearest - series.x.begin())];
}

void expect_ends_like(const Series& path, const model::Scenario& scenario) {
  const Eigen::Vector2d end = 1e3 * model::integrate(scenario).end().position;
  EXPECT_NEAR(path.x.back(), end.x(), 1e-9) << path.name;
  EXPECT_NEAR(path.y.back(), end.y(), 1e-9) << path.name;
  EXPECT_EQ(path.x.front(), 0);
}

TEST(PaperScenarios, AreTheFilesOfTheRepository) {
  std::set<std::string> carried, there;
  for (const EmbeddedScenario& scenario : paper_scenarios()) {
    const std::string name(scenario.name);
    carried.insert(name);
    EXPECT_EQ(scenario.toml, content_of(fs::path(TRIBOTRACK_SOURCE_DIR) / "data" / (name + ".toml")));
    EXPECT_GE(paper_scenario(name).sweep.count(), 2u) << name;
  }
  for (const auto& entry : fs::directory_iterator(fs::path(TRIBOTRACK_SOURCE_DIR) / "data"))
    if (entry.path().extension() == ".toml") there.insert(entry.path().stem().string());
  EXPECT_EQ(carried, there);
  EXPECT_THROW(paper_scenario("figure2"), std::logic_error);
}

TEST(PaperScenarios, SettingsAreWrittenAsThePaperDoes) {
  EXPECT_EQ(setting_text("phi_rad", 11 * pi / 9), "φ = 11π/9");
  EXPECT_EQ(setting_text("dtau_rad", pi / 10), "Δτ = π/10");
  EXPECT_EQ(setting_text("amplitude_mm", 0.28), "Aₑ = 0.28 mm");
  EXPECT_EQ(
      conditions_text(paper_scenario("figure6b")),
      "μ₁ = 0.1, g = 9.81 m/s², Aₑ = 0.28 mm, ω = 62.8 rad/s, ε = π/2, φ = 0, Δτ = π/6; 20 cycles from rest");
}

TEST(PaperFigures, EachHasItsPanelsAndCurves) {
  std::vector<std::string> ids;
  std::vector<std::size_t> panels;
  for (const Figure& f : figures()) {
    ids.push_back(f.id);
    panels.push_back(f.panels.size());
    for (const FigurePanel& panel : f.panels)
      for (const Series& s : panel.series) {
        EXPECT_EQ(s.x.size(), s.y.size()) << f.id;
        EXPECT_FALSE(s.x.empty()) << f.id;
      }
  }
  EXPECT_EQ(ids, (std::vector<std::string>{"figure3", "figure4", "figure5", "figure6", "figure7", "figure9",
                                           "figure10", "figure11"}));
  EXPECT_EQ(panels, (std::vector<std::size_t>{3, 4, 2, 4, 4, 2, 1, 3}));
  for (const int number : {4, 5, 11})
    for (const FigurePanel& panel : figure(number).panels) EXPECT_TRUE(panel.equal_scale);
  for (const FigurePanel& panel : figure(5).panels)
    EXPECT_EQ(panel.series.size(), 9u) << "eight and their numbers";
}

TEST(PaperFigures, TrajectoriesEndWhereARunEnds) {
  model::Scenario s = conditions_of("figure3");
  expect_ends_like(series(figure(3), 2, "μ ≠ const"), s);
  s.friction.pulse_width = 0;
  expect_ends_like(series(figure(3), 2, "μ = const"), s);
  s = conditions_of("figure4c");
  expect_ends_like(series(figure(4), 2, "(2) Aₑ = 0.31 mm"), s);
  s.drive.amplitude = s.drive.amplitude_y = 0.32e-3;
  expect_ends_like(series(figure(4), 2, "(3) Aₑ = 0.32 mm"), s);
  s = conditions_of("figure5");
  s.friction.pulse_width = pi;
  s.friction.phase = 5 * pi / 4;
  expect_ends_like(series(figure(5), 1, "(6) φ = 5π/4"), s);
  s = conditions_of("figure11");
  s.friction.phase = pi / 2;
  expect_ends_like(series(figure(11), 1, "(2) φ = π/2"), s);
}

TEST(PaperFigures, FrictionOfFigure3IsThatOfEquation6) {
  const model::Scenario s = conditions_of("figure3");
  const Series& mu = series(figure(3), 1, "μ ≠ const");
  double reduced = 0;  // time
  for (std::size_t k = 1; k < mu.x.size(); ++k)
    if (mu.y[k] == s.friction.reduced) reduced += mu.x[k] - mu.x[k - 1];
  EXPECT_NEAR(reduced, 3 * s.friction.pulse_width / s.drive.angular_frequency, 1e-12);
  EXPECT_NEAR(mu.x.back(), s.end_time(), 1e-12);
}

TEST(PaperFigures, CurvesAreWhatARunGives) {
  model::Scenario s = conditions_of("figure6a");
  s.friction = {0.12, 0.12 / 8, 0, pi / 2, 0};
  EXPECT_NEAR(y_at(series(figure(6), 0, "μ₁ = 0.12"), pi / 2),
              1e3 * model::integrate(s).end().position.norm() / s.end_time(), 1e-9);
  EXPECT_NEAR(y_at(series(figure(6), 0, "μ₁ = 0.12", true), pi / 2),
              1e3 * model::steady_orbit(s)->mean_velocity(s.drive.angular_frequency), 1e-9);
  s = conditions_of("figure6c");
  s.drive.amplitude = s.drive.amplitude_y = 1e-3;
  EXPECT_NEAR(y_at(series(figure(7), 2, "μ₁ = 0.1"), 1),
              model::displacement_angle(model::integrate(s).end().position), 1e-9);
  s = conditions_of("figure9a");
  s.friction.phase = 2 * pi * 18 / 72;
  EXPECT_NEAR(y_at(series(figure(9), 0, "μ₁ = 0.1"), s.friction.phase),
              model::displacement_angle(model::integrate(s).end().position), 1e-9);
  s = conditions_of("figure10");
  s.friction.pulse_width = pi;
  EXPECT_NEAR(y_at(series(figure(10), 0, "μ₁ = 0.1"), pi),
              1e3 * model::integrate(s).end().position.norm() / s.end_time(), 1e-9);
}

TEST(PaperFigures, AnglesBreakWhereTheyStartAgain) {
  const Series& alpha = series(figure(7), 0, "μ₁ = 0.1");
  EXPECT_EQ(std::ranges::count_if(alpha.y, [](double y) { return std::isnan(y); }), 1);
  for (std::size_t k = 1; k < alpha.y.size(); ++k) {
    const double step = std::abs(alpha.y[k] - alpha.y[k - 1]);
    EXPECT_FALSE(step > 0.2) << "at phi = " << alpha.x[k];  // NaN at the break
  }
}

TEST(PaperFigures, ThreadsChangeNothing) {
  const std::vector<Figure> others = paper_figures(3);
  for (std::size_t k = 0; k < others.size(); ++k)
    EXPECT_TRUE(csv_of(others[k]) == csv_of(figures()[k])) << others[k].id;
}

}  // namespace
}  // namespace tribotrack::apps
