// tribotrack bench-peer: what others do with a recording, as a process that `bench` takes the time of.
#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "apps/bench/vision/command_peers.h"
#include "apps/commands/command.h"
#include "apps/text/output_file.h"

namespace tribotrack::apps {

namespace {

struct PeerOptions {
  std::string kind, input, output;
  std::vector<double> part, mark;
};

void run_peer(const PeerOptions& options) {
  std::vector<vision::Circle> targets;
  for (const auto* circle : {&options.part, &options.mark})
    if (!circle->empty()) targets.push_back({(*circle)[0], (*circle)[1], (*circle)[2]});
  std::vector<vision::Point> positions;
  if (options.kind == "matching")
    positions = bench::follow_by_matching(options.input, targets);
  else
    bench::read_windows(options.input, targets);
  std::string table = "x_px,y_px\n";
  for (const vision::Point& p : positions) table += fmt::format("{:.6f},{:.6f}\n", p.x, p.y);
  write_file(options.output, table);
}

}  // namespace

void add_bench_peer(CLI::App& app) {
  auto options = std::make_shared<PeerOptions>();
  CLI::App& command = *app.add_subcommand(
      "bench-peer", "Follow part and mark by cv::matchTemplate in windows, or only read these windows");
  command.group("");
  command.add_option("KIND", options->kind)->check(CLI::IsMember({"matching", "reading"}))->required();
  command.add_option("RECORDING", options->input)->required();
  for (const auto& [flag, circle] : {std::pair{"--part", &options->part}, {"--mark", &options->mark}})
    command.add_option(flag, *circle, "Where it lies in the first frame")
        ->delimiter(',')
        ->expected(3)
        ->type_name("X,Y,R");
  command.get_option("--part")->required();
  command.add_option("-o,--output", options->output, "Positions of the part")->required();
  command.callback([options] { run_peer(*options); });
}

}  // namespace tribotrack::apps
