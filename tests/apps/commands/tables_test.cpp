// From a spreadsheet, from another program's track, from any oscilloscope: the whole way through the program.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "apps/program.h"
#include "model/alpha_v.h"
#include "model/trajectory.h"

namespace tribotrack::apps {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

constexpr double pi = std::numbers::pi;
constexpr const char* kPlatform =
    "[platform]\namplitude_mm = 0.28\nangular_frequency_rad_s = 62.8\nphase_shift_rad = \"pi/2\"\n";

/// mu1 = 0.1, mu2 = 0.0125, lag = 0.2, from rest, 20 cycles.
model::Scenario scenario(double phi, double dtau) {
  model::Scenario s;
  s.drive.amplitude = s.drive.amplitude_y = 0.28e-3;
  s.drive.angular_frequency = 62.8;
  s.friction.nominal = 0.1;
  s.friction.reduced = 0.0125;
  s.friction.lag = 0.2;
  s.friction.phase = phi;
  s.friction.pulse_width = dtau;
  s.cycles = 20;
  return s;
}

struct Point {
  double phi, dtau, alpha, v;  ///< v in mm/s
};

std::vector<Point> points() {
  std::vector<Point> all;
  for (const auto& [phi, dtau] :
       {std::pair(0.0, 1.0), {2.0, 1.0}, {4.0, 1.0}, {0.0, 2.0}, {0.0, 0.5}, {1.0, 1.5}}) {
    const model::Trajectory run = model::integrate(scenario(phi, dtau));
    const Eigen::Vector2d moved = run.end().position;
    all.push_back(
        {phi, dtau, model::displacement_angle(moved), 1e3 * model::mean_velocity(moved, run.end_time())});
  }
  return all;
}

class TablesOnTheWay : public ProgramTest {
 protected:
  json fitted(const std::string& name, const std::string& campaign) {
    put(in_folder(name + ".toml"), campaign);
    const Outcome outcome = run("fit " + name + ".toml -o " + name + ".json --quiet");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return json::parse(content_of(in_folder(name + ".json")));
  }
  static double estimate(const json& fit, const char* parameter) {
    return fit["parameters"][parameter]["estimate"];
  }
};

TEST_F(TablesOnTheWay, ATableGivesTheFrictionThatMadeIt) {
  std::string table = "phi_deg,dtau_deg,alpha_deg,alpha_sd_deg,v_mm_s,v_sd_mm_s\n";
  for (const Point& p : points())
    table +=
        fmt::format("{},{},{},0.5,{},0.02\n", p.phi * 180 / pi, p.dtau * 180 / pi, p.alpha * 180 / pi, p.v);
  put(in_folder("alpha_v.csv"), table);
  const json fit = fitted("c", std::string(kPlatform) + "[data]\ntable = \"alpha_v.csv\"\n");
  EXPECT_NEAR(estimate(fit, "mu1"), 0.1, 1e-6);
  EXPECT_NEAR(estimate(fit, "mu2"), 0.0125, 1e-6);
  EXPECT_NEAR(estimate(fit, "phase_lag_rad"), 0.2, 1e-5);
}

TEST_F(TablesOnTheWay, TheRunsTableOfARunIsATable) {
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal;
  std::string table = "name;phi_rad;dtau_rad;alpha_rad;alpha_sd_rad;v_mm_s;v_sd_mm_s\n";
  for (const Point& p : points())
    table += fmt::format("\"run, {}\";{};{};{};0.02;{};0.1\n", table.size(), p.phi + 1e-3 * p.dtau, p.dtau,
                         p.alpha + 0.02 * normal(random), p.v + 0.1 * normal(random));
  put(in_folder("alpha_v.csv"), table);
  put(in_folder("c.toml"), std::string(kPlatform) + "[data]\ntable = \"alpha_v.csv\"\n");
  const Outcome first = run("run c.toml -o out --quiet");
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const json fit = json::parse(content_of(in_folder("out/fit.json")));
  const json again = fitted("back", std::string(kPlatform) + "[data]\ntable = \"out/runs.csv\"\n");
  for (const char* parameter : {"mu1", "mu2", "phase_lag_rad"}) {
    // But for the last bits of v in mm/s.
    const double sd = fit["parameters"][parameter]["sd"];
    EXPECT_NEAR(estimate(again, parameter), estimate(fit, parameter), 1e-9 * sd) << parameter;
    EXPECT_NEAR(again["parameters"][parameter]["sd"].get<double>(), sd, 1e-9 * sd) << parameter;
  }
  EXPECT_EQ(again["runs"].size(), fit["runs"].size());
  EXPECT_EQ(again["runs"][0]["name"], fit["runs"][0]["name"]);
}

TEST_F(TablesOnTheWay, TracksOfOthersGiveTheFrictionThatMadeThem) {
  // Tracker's export, of the camera: the platform's motion and the part's on it. y up, mm, 500 frames/s.
  std::mt19937_64 random(9);
  std::normal_distribution<double> normal;
  std::string campaign = std::string(kPlatform) + "[data]\ntrack_unit = \"mm\"\n";
  int number = 0;
  for (const auto& [phi, dtau] : {std::pair(0.0, 1.0), {2.0, 1.0}, {0.0, 2.0}, {1.0, 1.5}}) {
    const model::Trajectory motion = model::integrate(scenario(phi, dtau));
    std::string text = "mass_A\nt\tx\ty\n";
    for (double t = 0; t < motion.end_time(); t += 0.002) {
      const Eigen::Vector2d at = 1e3 * motion.at(t).position;
      const double x = 0.28 * std::cos(62.8 * t) + at.x() + 1e-3 * normal(random);
      const double y = 0.28 * std::cos(62.8 * t + pi / 2) + at.y() + 1e-3 * normal(random);
      text += fmt::format("{:.9E}\t{:.9E}\t{:.9E}\n", t, x, y);
    }
    put(in_folder(fmt::format("t{}.txt", ++number)), text);
    campaign += fmt::format("[[run]]\ntrack = \"t{}.txt\"\nphi_rad = {}\ndtau_rad = {}\n", number, phi, dtau);
  }
  const json fit = fitted("c", campaign + "[fit]\nexact = true\ncycles = 19\n");
  for (const auto& [parameter, truth] : {std::pair("mu1", 0.1), {"mu2", 0.0125}, {"phase_lag_rad", 0.2}}) {
    const json& p = fit["parameters"][parameter];
    EXPECT_LT(std::abs(p["estimate"].get<double>() - truth), 4 * p["sd"].get<double>()) << parameter;
    EXPECT_LT(p["sd"].get<double>(), 0.02 * truth) << parameter;
  }
  EXPECT_THAT(fit["warnings"].dump(), HasSubstr("4 of 4 runs are tracks without standard deviations"));
  // `run` keeps a copy of each as a track of ours.
  const Outcome outcome = run("run c.toml -o out --quiet");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(json::parse(content_of(in_folder("out/fit.json")))["parameters"], fit["parameters"]);
  const Outcome measured = run("measure t1.txt --track-unit mm --omega-rad-s 62.8 --cycles 19 --json");
  ASSERT_EQ(measured.exit_code, 0) << measured.err;
  EXPECT_THAT(measured.err, HasSubstr("note: read as a track of Tracker"));
  EXPECT_EQ(json::parse(measured.out)["dx_mm"],
            json::parse(content_of(in_folder("out/measurements/t1.json")))["dx_mm"]);
}

TEST_F(TablesOnTheWay, ProbeTellsTheChannelsOfATrace) {
  std::string text = "x-axis,1,2\nsecond,Volt,Volt\n";
  for (int n = 0; n < 60000; ++n) {
    const double t = n * 1e-5, turn = std::fmod(62.8 * t, 2 * pi);
    text += fmt::format("{:.6e},{:.4f},{:.4f}\n", t,
                        turn > 1 && turn < 2 ? 5 * std::sin(2 * pi * 5000 * t) : 0.0, turn < 0.2 ? 3.3 : 0.0);
  }
  put(in_folder("trace.csv"), text);
  const Outcome outcome = run("probe trace.csv");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("channels 2 name                     CH2\n"));
  const json told = json::parse(run("probe trace.csv --json").out);
  EXPECT_EQ(told["channels"][1], (json{{"name", "CH2"}, {"min_v", 0.0}, {"max_v", 3.3}}));
  put(in_folder("table.csv"), "a,b\n1,2\n");
  EXPECT_EQ(run("probe table.csv").exit_code, 3);
}

}  // namespace
}  // namespace tribotrack::apps
