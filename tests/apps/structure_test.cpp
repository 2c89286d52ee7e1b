// The house: which room may use which, what is public, and where libraries of others may be included.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace tribotrack {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = TRIBOTRACK_SOURCE_DIR;

using Rooms = std::set<std::string>;

/// Room -> the rooms it may use. A room is a folder below vision/, model/, fit/ or apps/. Not listed, since
/// always allowed: public headers (those that lie directly in vision/, model/ or fit/) in the direction of
/// kLibraries. The sources that lie directly in a library are its top loops, listed by file.
const std::map<std::string, Rooms> kMayUse = {
    {"vision/io", {"vision/kernels"}},
    {"vision/kernels", {}},
    {"vision/timing", {"vision/kernels", "vision/io"}},
    {"vision/formats",
     {"vision/formats/cine", "vision/formats/libav", "vision/formats/pictures", "vision/timing",
      "vision/io"}},
    {"vision/audit", {"vision/kernels"}},
    {"vision/stages", {"vision/audit"}},
    {"vision/coding", {"vision/audit", "vision/kernels"}},
    {"vision/formats/cine", {"vision/io"}},
    {"vision/formats/libav", {"vision/timing", "vision/io"}},
    {"vision/formats/pictures", {"vision/io"}},
    {"vision/camera", {"vision/kernels", "vision/io"}},
    {"vision/discs", {"vision/kernels", "vision/io"}},
    {"vision/registration", {"vision/audit", "vision/kernels", "vision/io"}},
    {"vision/following",
     {"vision/discs", "vision/registration", "vision/audit", "vision/kernels", "vision/io"}},
    {"vision/platform_motion", {"vision/kernels", "vision/io"}},
    {"vision/layers/model", {"vision/kernels", "vision/io"}},
    {"vision/layers/registration", {"vision/layers/model", "vision/audit", "vision/kernels", "vision/io"}},
    {"vision/layers",
     {"vision/layers/model", "vision/layers/registration", "vision/stages", "vision/audit", "vision/discs",
      "vision/camera", "vision/kernels", "vision/io"}},
    {"vision/tracking",
     {"vision/stages", "vision/camera", "vision/discs", "vision/following", "vision/registration",
      "vision/platform_motion", "vision/tags", "vision/audit", "vision/kernels", "vision/io"}},
    {"vision/tags", {"vision/kernels"}},
    {"vision/rotation", {"vision/stages", "vision/audit", "vision/kernels", "vision/io"}},
    {"vision/tracker.cpp",
     {"vision/tracking", "vision/rotation", "vision/audit", "vision/stages", "vision/layers", "vision/discs",
      "vision/camera", "vision/coding", "vision/io"}},
    {"vision/calibration", {"vision/io", "vision/tags"}},
    {"vision/drawing", {"vision/io"}},
    {"vision/survey", {"vision/discs", "vision/io"}},
    {"vision/synthesis", {"vision/io"}},

    {"model/equation", {}},
    {"model/processor", {}},
    {"model/series", {"model/equation"}},
    {"model/arcs", {"model/equation", "model/processor"}},
    {"model/solver", {"model/arcs", "model/series", "model/equation"}},
    {"model/spin", {"model/equation"}},
    {"model/lanes", {"model/solver", "model/processor", "model/equation"}},
    {"model/orbit", {"model/lanes", "model/solver"}},
    {"model/run", {"model/orbit", "model/solver", "model/spin", "model/equation"}},
    {"model/batch", {"model/lanes", "model/solver", "model/equation"}},
    {"model/plan", {}},
    {"model/rivals", {}},
    {"model/trajectory.cpp", {"model/run"}},

    {"fit/tools", {}},
    {"fit/measuring", {"fit/tools"}},
    {"fit/residuals", {"fit/tools"}},
    {"fit/slides", {"fit/residuals", "fit/tools"}},
    {"fit/minimum", {"fit/residuals", "fit/tools"}},
    {"fit/variances", {"fit/minimum", "fit/residuals", "fit/tools"}},
    {"fit/uncertainty", {"fit/variances", "fit/minimum", "fit/residuals", "fit/tools"}},
    {"fit/checks", {"fit/uncertainty", "fit/minimum", "fit/residuals", "fit/tools"}},
    {"fit/design", {"fit/uncertainty", "fit/residuals", "fit/tools"}},
    {"fit/report", {"fit/uncertainty", "fit/variances", "fit/minimum", "fit/residuals", "fit/tools"}},
    {"fit/estimate.cpp",
     {"fit/slides", "fit/report", "fit/design", "fit/checks", "fit/uncertainty", "fit/variances",
      "fit/minimum", "fit/residuals", "fit/tools"}},

    {"apps/program", {}},
    {"apps/text/toml", {"apps/program"}},
    {"apps/text", {"apps/text/toml", "apps/program"}},
    {"apps/json", {"apps/text"}},
    {"apps/files/kinds", {"apps/text", "apps/program"}},
    {"apps/files/tables", {"apps/text", "apps/program"}},
    {"apps/files/traces", {"apps/text", "apps/program"}},
    {"apps/files", {"apps/files/kinds", "apps/json", "apps/text", "apps/program"}},
    {"apps/files/campaign",
     {"apps/files", "apps/files/kinds", "apps/files/tables", "apps/json", "apps/text", "apps/program"}},
    {"apps/files/tracks", {"apps/files/campaign", "apps/files", "apps/text", "apps/program"}},
    {"apps/files/parts", {"apps/files", "apps/json", "apps/text", "apps/program"}},
    {"apps/files/sweeps", {"apps/files/parts", "apps/files", "apps/text", "apps/program"}},
    {"apps/recording", {"apps/files/campaign", "apps/files", "apps/text", "apps/program"}},
    {"apps/measuring", {"apps/files/traces", "apps/files", "apps/text", "apps/program"}},
    {"apps/campaign",
     {"apps/files/campaign", "apps/measuring", "apps/files/traces", "apps/files", "apps/text",
      "apps/program"}},
    {"apps/simulating", {"apps/files/sweeps", "apps/files", "apps/text", "apps/program"}},
    {"apps/fitting",
     {"apps/files/campaign", "apps/campaign", "apps/measuring", "apps/recording", "apps/files/tracks",
      "apps/files", "apps/text", "apps/program"}},
    {"apps/workflow",
     {"apps/files/campaign", "apps/recording", "apps/page/assets", "apps/files", "apps/text",
      "apps/program"}},
    {"apps/figures", {"apps/text", "apps/program"}},
    {"apps/page/assets", {}},
    {"apps/page", {"apps/page/assets", "apps/figures", "apps/text"}},
    {"apps/report/data",
     {"apps/campaign", "apps/measuring", "apps/files", "apps/json", "apps/text", "apps/program"}},
    {"apps/report/figures", {"apps/report/data", "apps/page", "apps/figures"}},
    {"apps/report/findings", {"apps/report/data", "apps/page"}},
    {"apps/report/tables", {"apps/report/findings", "apps/report/data", "apps/page", "apps/text"}},
    {"apps/report/page/parameters", {"apps/report/findings", "apps/report/data", "apps/page"}},
    {"apps/report/page",
     {"apps/report/page/parameters", "apps/report/figures", "apps/report/findings", "apps/report/data",
      "apps/page", "apps/figures"}},
    {"apps/report",
     {"apps/report/page", "apps/report/tables", "apps/report/figures", "apps/report/data", "apps/figures",
      "apps/campaign", "apps/files", "apps/text", "apps/program"}},
    {"apps/bench/timing", {}},
    {"apps/bench/peers", {}},
    {"apps/bench/claims", {"apps/program"}},
    {"apps/bench/model", {"apps/bench/peers", "apps/bench/timing"}},
    {"apps/bench/extremes", {"apps/bench/model", "apps/bench/timing"}},
    {"apps/bench/scale", {"apps/bench/timing"}},
    {"apps/bench/vision", {"apps/bench/timing"}},
    {"apps/bench/fit", {"apps/bench/peers", "apps/bench/timing"}},
    {"apps/bench/verdicts", {"apps/bench/model", "apps/bench/vision", "apps/bench/fit"}},
    {"apps/bench/figures",
     {"apps/bench/verdicts", "apps/bench/model", "apps/bench/vision", "apps/bench/scale", "apps/bench/fit",
      "apps/page", "apps/figures"}},
    {"apps/bench/tables",
     {"apps/bench/figures", "apps/bench/scale", "apps/bench/verdicts", "apps/bench/claims",
      "apps/bench/model", "apps/bench/vision", "apps/bench/fit", "apps/page", "apps/figures", "apps/text",
      "apps/program"}},
    {"apps/bench/page",
     {"apps/bench/tables", "apps/bench/verdicts", "apps/bench/timing", "apps/bench/peers", "apps/page",
      "apps/figures", "apps/text"}},
    {"apps/usage", {"apps/text"}},
    {"apps/doctor", {"apps/figures", "apps/text", "apps/program"}},
    {"apps/survey",
     {"apps/files/campaign", "apps/page", "apps/page/assets", "apps/files/traces", "apps/files", "apps/text",
      "apps/program"}},
    {"apps/pipeline",
     {"apps/files/campaign", "apps/report", "apps/campaign", "apps/recording", "apps/files/tracks",
      "apps/files", "apps/text", "apps/program"}},
    {"apps/watch", {"apps/files/campaign", "apps/survey", "apps/files", "apps/text", "apps/program"}},
    {"apps/paper",
     {"apps/bench/claims", "apps/page", "apps/page/assets", "apps/figures", "apps/files/sweeps", "apps/files",
      "apps/text"}},
    {"apps/commands",
     {"apps/files/campaign", "apps/usage",        "apps/doctor",      "apps/watch",       "apps/pipeline",
      "apps/survey",         "apps/paper",        "apps/bench/page",  "apps/bench/peers", "apps/bench/vision",
      "apps/report",         "apps/workflow",     "apps/page/assets", "apps/figures",     "apps/fitting",
      "apps/campaign",       "apps/recording",    "apps/measuring",   "apps/simulating",  "apps/files/tracks",
      "apps/files/traces",   "apps/files/sweeps", "apps/files/parts", "apps/files",       "apps/json",
      "apps/bench/tables",   "apps/text",         "apps/program"}},
    {"apps/python",
     {"apps/files/campaign", "apps/fitting", "apps/campaign", "apps/recording", "apps/measuring",
      "apps/simulating", "apps/files/tracks", "apps/files/sweeps", "apps/files", "apps/text",
      "apps/program"}},
    {"apps/examples", {}},
    {"apps/main.cpp", {"apps/commands", "apps/program", "apps/text"}},
};

/// Library -> the libraries whose public headers it may use.
const std::map<std::string, Rooms> kLibraries = {{"model", {"model"}},
                                                 {"vision", {"vision"}},
                                                 {"fit", {"fit", "model"}},
                                                 {"apps", {"fit", "model", "vision"}}};

/// Library -> how many doors it may have.
const std::map<std::string, std::size_t> kPublicHeaders = {{"vision", 15}, {"model", 9}, {"fit", 11}};

constexpr std::size_t kSourcesInOneRoom = 20;

/// Benchmarks look inside the libraries.
bool may_look_inside(const std::string& room) {
  return room.starts_with("apps/bench/");
}

struct Source {
  fs::path path;  ///< from the top of the repository
  std::string library() const { return path.begin()->string(); }
  std::string folder() const { return path.parent_path().generic_string(); }
  bool at_the_top() const { return folder() == library(); }
  bool header() const { return path.extension() == ".h"; }
  bool is_public() const { return at_the_top() && header() && library() != "apps"; }
  std::string room() const { return at_the_top() && !header() ? path.generic_string() : folder(); }
};

std::vector<Source> sources() {
  std::vector<Source> found;
  for (const auto& [library, uses] : kLibraries)
    for (const auto& entry : fs::recursive_directory_iterator(kSource / library)) {
      const std::string extension = entry.path().extension().string();
      if (extension == ".h" || extension == ".cpp") found.push_back({fs::relative(entry.path(), kSource)});
    }
  return found;
}

/// visit(source, included header, line number)
void for_each_include(const std::function<void(const Source&, const std::string&, int)>& visit) {
  static const std::regex include(R"re(^\s*#\s*include\s*[<"]([^>"]+)[>"])re");
  int seen = 0;
  for (const Source& source : sources()) {
    std::ifstream file(kSource / source.path);
    std::string line;
    for (int number = 1; std::getline(file, line); ++number) {
      std::smatch match;
      if (!std::regex_search(line, match, include)) continue;
      visit(source, match[1].str(), number);
      ++seen;
    }
  }
  ASSERT_GT(seen, 100) << "found hardly any include: this test shows nothing";
}

std::string place(const Source& source, int line) {
  return source.path.generic_string() + ":" + std::to_string(line);
}

TEST(Structure, IncludesFollowTheTable) {
  for_each_include([](const Source& source, const std::string& header, int line) {
    const Source target{header};
    if (!kLibraries.contains(target.library()) || header.find('/') == std::string::npos) return;
    const std::string from = source.room(), to = target.folder();
    if (target.is_public()) {
      EXPECT_TRUE(kLibraries.at(source.library()).contains(target.library()))
          << place(source, line) << " includes " << header << " against the direction of the libraries";
      return;
    }
    EXPECT_FALSE(source.is_public()) << place(source, line) << " is public and includes the private "
                                     << header;
    if (source.is_public() || from == to) return;
    if (may_look_inside(from) && target.library() != "apps") return;
    ASSERT_TRUE(kMayUse.contains(from)) << from << " is no room of the table in this test";
    EXPECT_TRUE(kMayUse.at(from).contains(to)) << place(source, line) << " includes " << header;
  });
}

TEST(Structure, TableHasNoCircle) {
  std::set<std::string> settled;  // rooms that use settled rooms only
  for (bool more = true; more;) {
    more = false;
    for (const auto& [room, uses] : kMayUse)
      if (!settled.contains(room) &&
          std::all_of(uses.begin(), uses.end(), [&](const auto& used) { return settled.contains(used); }))
        more = settled.insert(room).second;
  }
  for (const auto& [room, uses] : kMayUse)
    EXPECT_TRUE(settled.contains(room)) << room << " lies on or above a circle";
}

TEST(Structure, EveryRoomIsInTheTableAndNoneIsAHall) {
  std::map<std::string, std::size_t> count;
  for (const Source& source : sources()) {
    ++count[source.folder()];
    if (source.is_public() || source.folder() == "apps") continue;
    EXPECT_TRUE(kMayUse.contains(source.room()))
        << source.path << " lies in no room of the table in this test";
  }
  for (const auto& [room, uses] : kMayUse)
    EXPECT_TRUE(fs::exists(kSource / room)) << room << " is in the table and not in the house";
  for (const auto& [folder, files] : count)
    EXPECT_LE(files, kSourcesInOneRoom) << folder << " has become a hall: give it rooms";
}

TEST(Structure, FewDoors) {
  std::map<std::string, std::size_t> count;
  for (const Source& source : sources()) count[source.library()] += source.is_public();
  for (const auto& [library, most] : kPublicHeaders) EXPECT_LE(count[library], most) << library;
}

TEST(Structure, LibrariesOfOthersStayWhereTheyBelong) {
  for_each_include([](const Source& source, const std::string& header, int line) {
    const bool of_pictures =
        header.starts_with("opencv2/") || header.starts_with("libav") || header.starts_with("libsw");
    const bool of_fitting = header.starts_with("ceres/");
    const bool of_peers = header.starts_with("boost/numeric/odeint") || header.starts_with("cvode/") ||
                          header.starts_with("nvector/") || header.starts_with("sun");
    const bool of_python = header.starts_with("pybind11/");
    const bool hidden =
        of_pictures || of_fitting || header.starts_with("boost/") || header.starts_with("fmt/");
    const std::string room = source.room();
    EXPECT_TRUE(!of_pictures || source.library() == "vision" || room == "apps/bench/vision")
        << place(source, line) << " includes " << header;
    EXPECT_TRUE(!of_fitting || source.library() == "fit") << place(source, line) << " includes " << header;
    EXPECT_TRUE(!of_peers || room == "apps/bench/peers") << place(source, line) << " includes " << header;
    EXPECT_TRUE(!of_python || room == "apps/python") << place(source, line) << " includes " << header;
    // Who links a library must not need the headers of what it hides.
    EXPECT_FALSE(source.is_public() && hidden) << place(source, line) << " includes " << header;
  });
}

}  // namespace
}  // namespace tribotrack
