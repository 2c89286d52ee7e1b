// The three rules of the house: the direction of includes, where libraries of others may be used, and what
// public headers may show.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <string>

namespace tribotrack {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = TRIBOTRACK_SOURCE_DIR;

/// Library -> the libraries whose public headers it may use.
const std::map<std::string, std::set<std::string>> kMayUse = {{"model", {"model"}},
                                                              {"vision", {"vision"}},
                                                              {"fit", {"fit", "model"}},
                                                              {"apps", {"apps", "fit", "model", "vision"}}};

std::string library_of(const std::string& path) {
  return path.substr(0, path.find('/'));
}

/// Headers that lie directly in vision/, model/ or fit/.
bool is_public(const std::string& path) {
  return path.ends_with(".h") && std::count(path.begin(), path.end(), '/') == 1 && !path.starts_with("apps/");
}

bool starts_with_any(const std::string& header, std::initializer_list<const char*> beginnings) {
  return std::any_of(beginnings.begin(), beginnings.end(),
                     [&](const char* b) { return header.starts_with(b); });
}

/// visit(source, included header, "source:line"), paths from the top of the repository
void for_each_include(
    const std::function<void(const std::string&, const std::string&, const std::string&)>& visit) {
  static const std::regex include(R"re(^\s*#\s*include\s*[<"]([^>"]+)[>"])re");
  int seen = 0;
  for (const auto& [library, uses] : kMayUse)
    for (const auto& entry : fs::recursive_directory_iterator(kSource / library)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".h" && extension != ".cpp") continue;
      const std::string source = fs::relative(entry.path(), kSource).generic_string();
      std::ifstream file(entry.path());
      std::string line;
      for (int number = 1; std::getline(file, line); ++number) {
        std::smatch match;
        if (!std::regex_search(line, match, include)) continue;
        visit(source, match[1].str(), source + ":" + std::to_string(number) + " includes " + match[1].str());
        ++seen;
      }
    }
  ASSERT_GT(seen, 100) << "found hardly any include: this test shows nothing";
}

TEST(Structure, IncludesGoFromAppsToFitToModelAndFromAppsToVision) {
  for_each_include([](const std::string& source, const std::string& header, const std::string& place) {
    const std::string from = library_of(source), to = library_of(header);
    if (!kMayUse.contains(to) || header.find('/') == std::string::npos) return;
    EXPECT_TRUE(kMayUse.at(from).contains(to)) << place << " against the direction of the libraries";
    // Benchmarks look inside.
    EXPECT_TRUE(from == to || is_public(header) || source.starts_with("apps/bench/"))
        << place << ", which is private to " << to;
  });
}

TEST(Structure, OpenCvAndLibavAreUsedInVisionAndCeresInFit) {
  for_each_include([](const std::string& source, const std::string& header, const std::string& place) {
    if (starts_with_any(header, {"opencv2/", "libav", "libsw"})) {
      EXPECT_TRUE(source.starts_with("vision/") || source.starts_with("apps/bench/")) << place;
    }
    EXPECT_TRUE(!header.starts_with("ceres/") || source.starts_with("fit/")) << place;
  });
}

// Who links a library must not need what it hides.
TEST(Structure, PublicHeadersIncludePublicHeaders) {
  for_each_include([](const std::string& source, const std::string& header, const std::string& place) {
    if (!is_public(source)) return;
    EXPECT_TRUE(!kMayUse.contains(library_of(header)) || is_public(header)) << place;
    EXPECT_FALSE(starts_with_any(header, {"opencv2/", "libav", "libsw", "ceres/", "boost/", "fmt/", "tbb/"}))
        << place;
  });
}

}  // namespace
}  // namespace tribotrack
