#include "apps/bench/vision/command_shares.h"

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <utility>
#include <vector>

#include "vision/stages/stage_clock.h"

namespace tribotrack::bench {

namespace {

/// The heading of the table of times in `track --explain`, and the stages in it beside the tracker's.
constexpr const char* kTimes = "time of each stage";
constexpr const char *kStarting = "starting", *kHashing = "hashing the inputs",
                     *kWriting = "writing the results";

using Share = double CommandShares::*;

Share share_of(const std::string& stage) {
  using vision::Stage;
  static const std::vector<std::pair<std::string, Share>> shares = {
      {kStarting, &CommandShares::starting},
      {kHashing, &CommandShares::hashing},
      {kWriting, &CommandShares::writing},
      {to_string(Stage::reading), &CommandShares::reading},
      {to_string(Stage::camera), &CommandShares::looking},
      {to_string(Stage::finding), &CommandShares::looking},
      {to_string(Stage::setup), &CommandShares::looking},
      {to_string(Stage::part), &CommandShares::part},
      {to_string(Stage::marker), &CommandShares::mark},
      {to_string(Stage::layers_learning), &CommandShares::learning},
      {to_string(Stage::layers_measuring), &CommandShares::measuring},
      {to_string(Stage::radius), &CommandShares::radius},
      {to_string(Stage::rotation), &CommandShares::rotation},
      {to_string(Stage::audit), &CommandShares::audit}};
  for (const auto& [name, share] : shares)
    if (name == stage) return share;
  return nullptr;
}

}  // namespace

CommandShares shares_from(const std::string& explanation, double wall) {
  CommandShares shares;
  double told = 0;
  std::istringstream text(explanation);
  std::string line;
  while (std::getline(text, line) && !line.starts_with(kTimes)) {
  }
  // "  first pass: part                0.1234   12 %"
  while (std::getline(text, line) && line.starts_with("  ") && line.ends_with(" %")) {
    const auto end = line.find("  ", 2);
    if (end == std::string::npos) continue;
    const Share share = share_of(line.substr(2, end - 2));
    if (!share) continue;
    const double seconds = std::strtod(line.c_str() + end, nullptr);
    shares.*share += seconds / wall;
    told += seconds / wall;
  }
  shares.rest = std::max(0.0, 1 - told);
  return shares;
}

}  // namespace tribotrack::bench
