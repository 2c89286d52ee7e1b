// The source paper's figures follow data/figure*.toml, and their points are what a single run of the model
// gives; its claims; the page and tables that show both, and the command that writes them.
#include "apps/paper/paper.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/files/scenario_file.h"
#include "apps/page/assets/embedded_assets.h"
#include "apps/page/text.h"
#include "apps/program.h"
#include "model/alpha_v.h"
#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;
using std::numbers::pi;

const Paper& paper() {
  static const Paper made = [] {
    Context context;
    context.quiet = true;
    return Paper{paper_figures(context), paper_claims(context)};
  }();
  return made;
}

const PaperFigure& figure(int number) {
  return *std::ranges::find(paper().figures, number, &PaperFigure::number);
}

const Claim& claim(std::string_view name) {
  return *std::ranges::find(paper().claims, name, &Claim::name);
}

model::Scenario conditions_of(const std::string& name) {
  return read_scenario_file(fs::path(TRIBOTRACK_SOURCE_DIR) / "data" / (name + ".toml")).scenario;
}

/// A line of a panel by its name.
DrawnPath series(const Figure& figure, std::size_t panel, const std::string& name, bool dashed = false) {
  for (const Json& trace : figure.panels.at(panel).traces)
    if (trace["mode"] == "lines" && trace["name"] == name && (trace["line"]["dash"] == "dash") == dashed)
      return {plot::values_of(trace, "x"), plot::values_of(trace, "y")};
  throw std::runtime_error(figure.id + " has no series " + name);
}

/// The y of the point nearest to x, which must lie there.
double y_at(const DrawnPath& series, double x) {
  const auto nearest = std::ranges::min_element(series.x, {}, [x](double at) { return std::abs(at - x); });
  EXPECT_NEAR(*nearest, x, 1e-12);
  return series.y[static_cast<std::size_t>(nearest - series.x.begin())];
}

TEST(PaperFigures, FollowTheFilesOfTheRepository) {
  for (const EmbeddedScenario& scenario : paper_scenarios())
    EXPECT_EQ(scenario.toml,
              content_of(fs::path(TRIBOTRACK_SOURCE_DIR) / "data" / (std::string(scenario.name) + ".toml")));
  const std::string conditions =
      "μ₁ = 0.1, g = 9.81 m/s², Aₑ = 0.28 mm, ω = 62.8 rad/s, ε = π/2, φ = 0, Δτ = π/6";
  EXPECT_THAT(figure(6).caption, HasSubstr("b: " + conditions + "; 20 cycles from rest. "));
  EXPECT_EQ(figure(4).panels[2].title, "c: φ = 11π/9, Δτ = π/4");
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

TEST(PaperClaims, EachHasItsVerdictAndNumber) {
  const std::pair<const char*, Verdict> verdicts[] = {{"circular end state", Verdict::exact},
                                                      {"keeps moving", Verdict::holds},
                                                      {"displacement over dtau", Verdict::holds_in_part},
                                                      {"alpha mostly by phi", Verdict::holds},
                                                      {"full circle", Verdict::holds},
                                                      {"less stretched", Verdict::refuted},
                                                      {"v over dtau", Verdict::holds_in_part},
                                                      {"v over mu1/mu2", Verdict::holds},
                                                      {"v over A_e", Verdict::holds},
                                                      {"v over omega", Verdict::holds_in_part},
                                                      {"v over mu1", Verdict::holds_in_part},
                                                      {"v over phi", Verdict::exact},
                                                      {"alpha linear in phi", Verdict::exact},
                                                      {"alpha over dtau", Verdict::holds_in_part},
                                                      {"alpha over A_e", Verdict::holds_in_part},
                                                      {"alpha over omega", Verdict::exact},
                                                      {"alpha over mu1/mu2", Verdict::holds_in_part},
                                                      {"tilt", Verdict::holds_in_part},
                                                      {"v over dtau, measured", Verdict::holds},
                                                      {"further at wider dtau", Verdict::holds}};
  ASSERT_EQ(paper().claims.size(), std::size(verdicts));
  for (std::size_t k = 0; k < std::size(verdicts); ++k) {
    const Claim& c = paper().claims[k];
    EXPECT_STREQ(c.name, verdicts[k].first);
    EXPECT_EQ(c.verdict, verdicts[k].second) << c.name << ": " << c.finding;
    EXPECT_TRUE(std::isfinite(c.value) && *c.quantity && !c.finding.empty()) << c.name;
  }
}

/// Values of data/README.md.
TEST(PaperClaims, NumbersAreThoseKnown) {
  EXPECT_LT(claim("circular end state").value, 1e-11);
  EXPECT_NEAR(claim("full circle").value, -1, 1e-12);
  EXPECT_NEAR(claim("v over dtau").value, 5.169, 5e-4);
  EXPECT_NEAR(claim("keeps moving").value, 2.9, 0.05);
  EXPECT_NEAR(claim("less stretched").value, 0.73, 0.01);
  EXPECT_NEAR(claim("alpha over mu1/mu2").value, 12, 0.5);
  EXPECT_NEAR(claim("alpha over A_e").value, 9.5, 0.1);
  EXPECT_NEAR(claim("alpha over dtau").value, -0.46, 0.005);
  EXPECT_NEAR(claim("tilt").value, 39.5, 0.1);  // from rest; steady: 32
  EXPECT_THAT(claim("alpha linear in phi").finding, HasSubstr("mu1 = 0.02, dtau = 0.524 rad"));
  EXPECT_THAT(claim("displacement over dtau").finding, HasSubstr("grows 2.5 to 3.9 times"));
}

class PaperCommand : public ProgramTest {};

TEST_F(PaperCommand, WritesThePageAndItsTables) {
  const Outcome outcome = run("paper -o out");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_THAT(outcome.err, HasSubstr("8 figures, 20 claims"));
  std::vector<std::string> names = {"paper.html", "claims.csv"};
  for (const std::string& name : names) {
    EXPECT_TRUE(std::filesystem::exists(in_folder("out") / name)) << name;
    EXPECT_TRUE(std::filesystem::exists(in_folder("out") / (name + ".meta.json"))) << name;
  }
  const auto files = std::filesystem::directory_iterator(in_folder("out"));
  EXPECT_EQ(static_cast<std::size_t>(std::distance(begin(files), end(files))), 2 * names.size());
}

}  // namespace
}  // namespace tribotrack::apps
