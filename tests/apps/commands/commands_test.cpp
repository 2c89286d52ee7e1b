// Every command as a user types it: what it prints, writes and refuses.
#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using Json = nlohmann::json;

const std::vector<std::string> kCommands = {"simulate",  "sweep",   "synth", "probe",  "track",
                                            "calibrate", "measure", "fit",   "report", "run",
                                            "bench",     "init",    "watch", "open",   "paper"};

class Commands : public ProgramTest {};

TEST_F(Commands, EachHasHelpWithAnExampleAndAVersion) {
  for (const std::string& command : kCommands) {
    const Outcome help = run(command + " --help");
    EXPECT_EQ(help.exit_code, 0) << command;
    EXPECT_THAT(help.out, HasSubstr("Example:")) << command;
    EXPECT_THAT(help.out, HasSubstr("tribotrack " + command)) << command;
    EXPECT_THAT(help.out, HasSubstr("--json")) << command;
    EXPECT_EQ(run(command + " --version").exit_code, 0) << command;
  }
}

TEST_F(Commands, UsageErrorsAreExit2) {
  expect_refused(run("no-such-command"), 2, {});
  for (const std::string& command : kCommands)
    expect_refused(run(command + " --no-such-option"), 2, {"--help"});
  EXPECT_THAT(left_behind(), IsEmpty());
}

TEST_F(Commands, SimulateReachesTheKnownEndPoint) {
  const Outcome outcome =
      run("simulate --mu1 .1 --mu2 .0125 --amplitude-mm .28 --omega-rad-s 62.8 --phi-rad 0.5 --dtau-rad pi/2 "
          "--cycles 20 --json -o t.csv");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json json = Json::parse(outcome.out);
  EXPECT_NEAR(json["end_x_mm"], 5.470210818697445, 1e-11);
  EXPECT_NEAR(json["end_y_mm"], -10.98396194698849, 1e-11);
  EXPECT_EQ(json["stops"], 0);
  const std::string table = content_of(in_folder("t.csv"));
  EXPECT_EQ(table.substr(0, table.find('\n')), "time_s,x_mm,y_mm,vx_mm_s,vy_mm_s,mu,state");
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 2002);
  EXPECT_THAT(content_of(in_folder("t.csv.meta.json")), HasSubstr("\"schema\": 1"));
}

TEST_F(Commands, ARenderedSlideIsTrackedOntoItsTruth) {
  render_slide("slide.cine");
  const Outcome outcome = run("track slide.cine --mm-per-px 0.05 -o t.csv --overlay t.png --json -q");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(Json::parse(outcome.out)["ok"], 40);
  std::istringstream track(content_of(in_folder("t.csv"))),
      truth(content_of(in_folder("slide.cine.truth.csv")));
  std::string row, true_row;
  std::getline(track, row);
  std::getline(truth, true_row);
  EXPECT_EQ(row,
            "frame,time_s,x_px,y_px,sigma_x_px,sigma_y_px,rho_xy,ncc,status,x_mm,y_mm,sigma_x_mm,sigma_y_mm");
  double worst = 0;
  int rows = 0;
  while (std::getline(track, row) && std::getline(truth, true_row)) {
    double x = 0, y = 0, true_x = 0, true_y = 0;
    ASSERT_EQ(std::sscanf(row.c_str(), "%*[^,],%*[^,],%lf,%lf", &x, &y), 2) << row;
    ASSERT_EQ(std::sscanf(true_row.c_str(), "%*[^,],%*[^,],%lf,%lf", &true_x, &true_y), 2) << true_row;
    worst = std::max(worst, std::hypot(x - true_x, y - true_y));
    ++rows;
  }
  EXPECT_EQ(rows, 40);
  EXPECT_LT(worst, 0.02);  // noise of 0.003 px, and a constant: the centre found in the first frame
}

TEST_F(Commands, AFreeSlideGivesMuAndAReport) {
  render_slide("slide.cine");
  put(in_folder("campaign.toml"), slides_campaign({"slide.cine"}));
  const Outcome outcome = run("run campaign.toml -o out -q");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json fit = Json::parse(content_of(in_folder("out/fit.json")));
  const Json& mu1 = fit["parameters"]["mu1"];
  EXPECT_NEAR(mu1["estimate"], 0.2, 5 * mu1["sd"].get<double>());
  EXPECT_LT(mu1["sd"], 0.004);
  EXPECT_THAT(content_of(in_folder("out/report.html")), HasSubstr("<!DOCTYPE html>"));

  // Same inputs, same bytes; a second call keeps the track.
  const std::string first = content_of(in_folder("out/fit.json")),
                    page = content_of(in_folder("out/report.html"));
  const Outcome again = run("run campaign.toml -o out");
  EXPECT_THAT(again.err, HasSubstr("1 of 1 tracks were current"));
  EXPECT_EQ(content_of(in_folder("out/fit.json")), first);
  EXPECT_EQ(content_of(in_folder("out/report.html")), page);
  EXPECT_EQ(run("report out -o again.html -q").exit_code, 0);
  EXPECT_EQ(content_of(in_folder("again.html")), page);
  EXPECT_THAT(run("run campaign.toml -o out --dry-run").out, HasSubstr("its track is current"));

  // fit by itself, from the same tracks and from the video.
  ASSERT_EQ(run("fit campaign.toml --tracks out/tracks -o f1.json -q").exit_code, 0);
  ASSERT_EQ(run("fit campaign.toml -o f2.json -q").exit_code, 0);
  EXPECT_EQ(content_of(in_folder("f1.json")), first);
  EXPECT_EQ(content_of(in_folder("f2.json")), first);
}

TEST_F(Commands, BootstrapLossAndRivalsAreToldInTheResult) {
  std::string text = "[platform]\namplitude_mm = 0.28\nangular_frequency_rad_s = 62.8\n";
  const double alpha[] = {5.7, 5.2, 4.9, 4.6}, v[] = {2.2, 4.2, 5.6, 6.6};
  for (int k = 0; k < 4; ++k)
    text += "[[run]]\nphi_rad = 0\ndtau_rad = " + std::to_string(0.5 + 0.5 * k) +
            "\nalpha_rad = " + std::to_string(alpha[k]) +
            "\nalpha_sd_rad = 0.3\nv_mm_s = " + std::to_string(v[k]) + "\nv_sd_mm_s = 0.5\n";
  put(in_folder("c.toml"), text);
  EXPECT_NE(run("fit c.toml -o fit.json --bootstrap 30 --seed 7 --compare-models -q").exit_code, 2);
  Json fit = Json::parse(content_of(in_folder("fit.json")));
  EXPECT_EQ(fit["bootstrap"]["seed"], 7);
  EXPECT_TRUE(fit["parameters"]["mu1"]["bootstrap_ci95"].is_array());
  EXPECT_THAT(run("fit c.toml -o fit.json --bootstrap 30").err, Not(HasSubstr("\r")));  // off a terminal
  EXPECT_GE(fit["models"].size(), 4U);
  EXPECT_NE(run("fit c.toml -o fit.json --loss huber -q").exit_code, 2);
  fit = Json::parse(content_of(in_folder("fit.json")));
  EXPECT_EQ(fit["loss"], "huber");
  EXPECT_THAT(fit["covariance_meaning"].get<std::string>(), HasSubstr("Robust loss (Huber)"));
}

}  // namespace
}  // namespace tribotrack::apps
