// tribotrack bench as a user calls it.
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "apps/bench/peers/library_peers.h"
#include "apps/bench/tables/tables.h"

namespace tribotrack::apps {
namespace {

namespace fs = std::filesystem;

std::string text_in(const fs::path& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string first_line(const fs::path& path) {
  const std::string text = text_in(path);
  return text.substr(0, text.find('\n'));
}

class BenchCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "tribotrack_bench_XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }
  int call(const std::string& arguments) const {
    const std::string command = std::string(TRIBOTRACK_BINARY) + " bench " + arguments + " > " +
                                (folder_ / "stdout").string() + " 2> " + (folder_ / "stderr").string();
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  fs::path folder_;
};

TEST_F(BenchCommand, AllQuickWritesEveryTableItsMetaFileAndThePage) {
  const fs::path out = folder_ / "out";
  ASSERT_EQ(call("all --quick -o " + out.string()), 0) << text_in(folder_ / "stderr");
  EXPECT_EQ(first_line(out / "bench_model.csv"),
            "scene,method,tolerance,max_step_s,finished,steps,end_x_mm,end_y_mm,error_m,path_error_m,time_s,"
            "repetitions,time_over_ours,reference");
  EXPECT_EQ(
      first_line(out / "bench_model_extremes.csv"),
      "case,finite,end_x_mm,end_y_mm,steps,stops,time_s,time_per_cycle_over_ordinary,invariant,violation,"
      "allowed,held,derivatives_finite,one_sided,failure");
  EXPECT_EQ(
      first_line(out / "bench_model_plan.csv"),
      "omission,scene,time_with_s,time_without_s,saving,error_m,error_bound_m,repetitions");
  EXPECT_EQ(first_line(out / "bench_model_claims.csv"), "claim,verdict,conditions,quantity,value,unit");
  EXPECT_EQ(first_line(out / "bench_vision.csv"),
            "scene,radius_px,noise_levels,method,frames,lost,rms_px,bound_px,rms_over_bound,offset_px,"
            "peak_locking_px,time_s,rms_over_ours,time_over_ours");
  EXPECT_EQ(first_line(out / "bench_vision_limit.csv"),
            "radius_px,texture_levels,noise_levels,layered,components,lost,rms_px,bound_px,rms_over_bound,"
            "standardised_rms,halves,noise_found_levels,time_s");
  EXPECT_EQ(
      first_line(out / "bench_vision_decoding.csv"),
      "coding,brushed,radius_px,frames,layered,lost,rms_px,decoding_s,tracking_s,tracking_over_decoding");
  EXPECT_EQ(first_line(out / "bench_commands.csv"),
            "coding,brushed,diameter_px,width_px,height_px,frames,layers_off,layered,repetitions,lost,rms_px,"
            "matching_rms_px,cpu_s,wall_s,cpu_two_threads_s,wall_two_threads_s,matching_cpu_s,reading_cpu_s,"
            "cpu_over_matching,cpu_over_reading,share_starting,share_hashing,share_reading,share_looking,"
            "share_registering_part,share_registering_mark,share_learning,share_measuring,share_radius,share_"
            "rotation,share_audit,"
            "share_writing,share_rest");
  EXPECT_EQ(
      first_line(out / "bench_fit.csv"),
      "data,method,campaigns,converged,time_s,solves,time_over_ours,off_minimum_sd,mu1_rms_error_relative,"
      "mu1_mean_sd_relative,mu1_covered,mu2_rms_error_relative,mu2_mean_sd_relative,mu2_covered,"
      "lag_rms_error_rad,lag_mean_sd_rad,lag_covered");
  EXPECT_EQ(first_line(out / "bench_fit_coverage.csv"),
            "design,noise,parameter,campaigns,usable,weak,open,covered,covered_low,covered_high,covered_of_"
            "all,score");
  EXPECT_EQ(first_line(out / "bench_vision_audit.csv"),
            "radius_px,texture_levels,noise_levels,frames,halves_x,halves_y,checkerboard,high_frequency,"
            "widened_by,standardised_rms");
  const std::string page = text_in(out / "bench.html");
  for (const char* section : {"model", "extremes", "plan", "batch", "claims", "tracking", "audit", "fit",
                              "coverage", "circumstances"})
    EXPECT_NE(page.find("<section id=\"" + std::string(section)), std::string::npos) << section;
  EXPECT_EQ(page.find("Not run for this page"), std::string::npos);
  for (const char* figure :
       {"model-error-time", "tracking-error-time", "fit-error-time", "fit-minimum-time", "coverage"})
    EXPECT_NE(page.find("<figure class=\"plot\" id=\"figure-" + std::string(figure)), std::string::npos)
        << figure;
  EXPECT_EQ(first_line(out / "bench_model_batch.csv"),
            "sweep,wanted,instruction_set,scenarios,share_in_lanes,share_of_lanes_used,time_scalar_s,"
            "time_lanes_s,speedup,sweep_of_a_million_s,difference_amplitudes,repetitions");
  for (const char* name : {"bench_model", "bench_model_extremes", "bench_model_plan", "bench_model_batch",
                           "bench_model_claims", "bench_vision", "bench_vision_limit", "bench_vision_audit",
                           "bench_vision_decoding", "bench_commands", "bench_fit", "bench_fit_coverage"})
    EXPECT_TRUE(fs::exists(out / (std::string(name) + ".csv.meta.json"))) << name;
  const auto json = nlohmann::json::parse(text_in(out / "bench.json"));
  for (const char* key : {"cpu", "compiler", "compiler_flags", "threads", "reference", "results"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_EQ(json["results"]["model"]["laws_broken"], 0);
  EXPECT_EQ(json["peers_missing"], bench::peers::missing_libraries());
  // Results on stdout, tables for people on stderr.
  EXPECT_NE(text_in(folder_ / "stdout").find("bench_fit.csv\n"), std::string::npos);
  EXPECT_EQ(text_in(folder_ / "stdout").find("always slipping"), std::string::npos);
  EXPECT_NE(text_in(folder_ / "stderr").find("always slipping"), std::string::npos);
  for (const std::string& library : bench::peers::missing_libraries())
    EXPECT_NE(text_in(folder_ / "stderr").find("made without " + library), std::string::npos);
}

TEST_F(BenchCommand, ScaleWritesWhatEachSizeCosts) {
  const fs::path out = folder_ / "out";
  ASSERT_EQ(call("scale --quick -o " + out.string()), 0) << text_in(folder_ / "stderr");
  EXPECT_EQ(first_line(out / "bench_scale.csv"), "series,size,cpu_s,wall_s,memory_bytes,file_calls");
  EXPECT_EQ(first_line(out / "bench_scale_exponents.csv"), "series,cost,from,to,exponent,exponent_sd");
  EXPECT_NE(text_in(out / "bench.html").find("id=\"figure-scale"), std::string::npos);
  const auto exponents = nlohmann::json::parse(text_in(out / "bench.json"))["results"]["scale"]["exponents"];
  for (const char* series : {"recordings", "frames", "runs", "points", "scenarios"})
    for (const char* cost : {"cpu", "memory"})
      EXPECT_TRUE(exponents[series][cost]["exponent"].is_number()) << series << ", " << cost;
}

TEST_F(BenchCommand, PartsOfCoverageAreJoinedByteForByte) {
  const std::string campaigns = "coverage --campaigns 2 ";
  ASSERT_EQ(call(campaigns + "-o " + (folder_ / "whole").string()), 0) << text_in(folder_ / "stderr");
  for (const char* part : {"1", "2", "3"})
    ASSERT_EQ(call(campaigns + "--part " + part + "/3 -o " + (folder_ / part).string()), 0)
        << text_in(folder_ / "stderr");
  const auto folders = [&](std::initializer_list<const char*> names) {
    std::string all = "coverage -o " + (folder_ / "joined").string() + " --join";
    for (const char* name : names) all += " " + (folder_ / name).string();
    return all;
  };
  ASSERT_EQ(call(folders({"3", "1", "2"})), 0) << text_in(folder_ / "stderr");
  for (const char* name : {"bench_fit_campaigns.csv", "bench_fit_campaigns.csv.meta.json",
                           "bench_fit_coverage.csv", "bench_fit_coverage.csv.meta.json"})
    EXPECT_EQ(text_in(folder_ / "joined" / name), text_in(folder_ / "whole" / name)) << name;
  EXPECT_EQ(first_line(folder_ / "whole" / "bench_fit_campaigns.csv"),
            "design,noise,campaign,parameter,fit,open,holds,score");

  EXPECT_EQ(call(folders({"3", "1"})), 3);
  EXPECT_NE(text_in(folder_ / "stderr").find("part 2 of 3 is not given"), std::string::npos);
  EXPECT_EQ(call(folders({"3", "1", "1", "2"})), 3);
  EXPECT_NE(text_in(folder_ / "stderr").find("give each part once"), std::string::npos);
  EXPECT_EQ(call(folders({"whole"})), 3);
  EXPECT_NE(text_in(folder_ / "stderr").find("bench coverage --part K/N"), std::string::npos);
  EXPECT_EQ(call("fit --quick --part 1/2 -o " + (folder_ / "x").string()), 2);
  EXPECT_FALSE(fs::exists(folder_ / "x"));
}

TEST_F(BenchCommand, WholeCommandsKeepTheirRecordingsAndTellEveryStage) {
  const fs::path kept = folder_ / "kept";
  bench::WholeCommandOptions options = bench::quick_whole_command_options();
  options.program = TRIBOTRACK_BINARY;
  options.keep = kept;
  const auto rows = bench::bench_whole_commands(options);
  ASSERT_EQ(rows.size(), 6U) << "two codings of the brushed scene; of the plain one also without layers";
  for (const bench::WholeCommandRow& row : rows) {
    SCOPED_TRACE(row.coding + (row.brushed ? ", brushed" : ", plain") +
                 (row.layers_off ? ", layers off" : ""));
    EXPECT_EQ(row.lost, 0);
    EXPECT_GT(row.rms, 0);
    EXPECT_LT(row.rms, 0.1);
    EXPECT_GT(row.matching_rms, row.coding == "cine" ? row.rms : 0);
    for (const double seconds :
         {row.cpu, row.wall, row.cpu_two_threads, row.wall_two_threads, row.matching, row.reading})
      EXPECT_GT(seconds, 0);
    const bench::CommandShares& s = row.shares;
    for (const double share :
         {s.starting, s.hashing, s.reading, s.looking, s.part, s.mark, s.writing, s.rest})
      EXPECT_GT(share, 0);
    if (row.brushed) {
      EXPECT_GT(s.learning, 0);
    }
    if (row.layers_off) {
      EXPECT_EQ(s.learning, 0);
    }
    EXPECT_LE(s.learning + s.measuring + s.looking + s.starting, 1);
    EXPECT_FALSE(row.layers_off && row.layered);
  }
  const auto written = fs::last_write_time(kept / "plain_40px_24frames_240x120.cine");
  EXPECT_EQ(bench::bench_whole_commands(options)[0].rms, rows[0].rms);
  EXPECT_EQ(fs::last_write_time(kept / "plain_40px_24frames_240x120.cine"), written) << "it was there";
}

TEST_F(BenchCommand, WholeCommandsSayWhichOneFailed) {
  bench::WholeCommandOptions options = bench::quick_whole_command_options();
  options.program = "/bin/false";
  try {
    bench::bench_whole_commands(options);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("`/bin/false bench-peer matching"), std::string::npos)
        << error.what();
    EXPECT_NE(std::string(error.what()).find("exit code 1"), std::string::npos);
  }
}

TEST_F(BenchCommand, MetaFileHoldsNothingVolatile) {
  const fs::path out = folder_ / "out";
  ASSERT_EQ(call("fit --quick --quiet -o " + out.string()), 0);
  EXPECT_EQ(text_in(folder_ / "stderr"), "");
  const std::string before = text_in(out / "bench_fit.csv.meta.json");
  ASSERT_EQ(call("fit --quick --quiet -o " + out.string()), 0);
  EXPECT_EQ(text_in(out / "bench_fit.csv.meta.json"), before);
}

TEST_F(BenchCommand, FiguresLeaveAsFilesForPrint) {
  const fs::path figures = folder_ / "figures";
  ASSERT_EQ(call("fit --quick -o " + (folder_ / "out").string() + " --figures " + figures.string()), 0)
      << text_in(folder_ / "stderr");
  for (const char* name : {"fit-error-time", "fit-minimum-time", "coverage"})
    for (const char* ending : {".csv", ".json", "-84mm.svg", "-84mm.pdf", "-174mm.svg", "-174mm.pdf"})
      EXPECT_GT(fs::file_size(figures / (std::string(name) + ending)), 0U) << name << ending;
}

TEST_F(BenchCommand, RefusesWhatItDoesNotKnow) {
  EXPECT_EQ(call("speed -o " + folder_.string()), 2);
  EXPECT_EQ(call("model"), 2);
  EXPECT_EQ(call("commands --frames 3 -o " + folder_.string()), 2);
  EXPECT_EQ(call("commands --quick --diameters 300 -o " + folder_.string()), 2);
  EXPECT_EQ(call("model --quick -o /proc/none"), 3);
}

TEST(BenchTables, SayWhereAPeerWins) {
  bench::ModelBenchRow ours, peer;
  ours.scene = peer.scene = "s";
  ours.method = "tribotrack";
  ours.ours = true;
  peer.method = "quick, \"rough\"";
  peer.time_over_ours = 0.5;
  const bench::BenchTable table = table_of(std::vector{ours, peer});
  EXPECT_NE(table.text.find("PEER WINS x2.00"), std::string::npos);
  EXPECT_NE(table.csv.find("\"quick, \"\"rough\"\"\""), std::string::npos);
  peer.time_over_ours = 3;
  EXPECT_EQ(table_of(std::vector{ours, peer}).text.find("PEER WINS"), std::string::npos);
}

TEST(BenchTables, NameTheSolversTheBuildLacks) {
  const std::vector<bench::ModelBenchRow> rows(1);
  EXPECT_EQ(table_of(rows).text.find("made without"), std::string::npos);
  const bench::BenchTable table = table_of(rows, {"Boost.odeint", "SUNDIALS"});
  EXPECT_NE(table.text.find("Boost.odeint, which this build was made without"), std::string::npos);
  EXPECT_NE(table.text.find("SUNDIALS, which this build was made without"), std::string::npos);
  EXPECT_EQ(table.csv, table_of(rows).csv);
}

TEST(BenchTables, EmptyCellsForWhatDoesNotExist) {
  std::vector<bench::BatchBenchRow> rows(1);
  rows[0].sweep = "all";
  rows[0].wanted = "ends";
  rows[0].instruction_set = "avx2";
  rows[0].in_lanes = 0.5;
  rows[0].time_scalar = rows[0].time_lanes = rows[0].speedup = rows[0].difference = NAN;
  const bench::BenchTable table = table_of(rows);
  EXPECT_EQ(table.csv.substr(table.csv.find('\n') + 1), "\"all\",ends,avx2,0,0.5,0,,,,0,,0\n");
  EXPECT_NE(
      table.text.find("\nends         avx2         50.0 %    0 %          -          -        -      0.0 s"
                      "          -  all\n"),
      std::string::npos);
}

}  // namespace
}  // namespace tribotrack::apps
