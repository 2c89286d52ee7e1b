// The layers: apps -> fit -> model, apps -> vision, and libraries only where they belong.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>

namespace tribotrack {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = TRIBOTRACK_SOURCE_DIR;

template <class Visit>
void for_each_include(const Visit& visit) {
  static const std::regex include(R"re(^\s*#\s*include\s*[<"]([^>"]+)[>"])re");
  int seen = 0;
  for (const char* layer : {"model", "vision", "fit", "apps"})
    for (const auto& entry : fs::recursive_directory_iterator(kSource / layer)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".h" && extension != ".cpp") continue;
      std::ifstream file(entry.path());
      std::string line;
      for (int number = 1; std::getline(file, line); ++number) {
        std::smatch match;
        if (!std::regex_search(line, match, include)) continue;
        visit(std::string(layer), match[1].str(), entry.path(), number);
        ++seen;
      }
    }
  ASSERT_GT(seen, 100) << "found hardly any include: this test shows nothing";
}

TEST(Structure, IncludesFollowTheArrows) {
  const std::map<std::string, std::set<std::string>> may_include = {
      {"model", {"model"}},
      {"vision", {"vision"}},
      {"fit", {"fit", "model"}},
      {"apps", {"apps", "fit", "model", "vision"}}};
  for_each_include([&](const std::string& layer, const std::string& header, const fs::path& file, int line) {
    const std::string target = header.substr(0, header.find('/'));
    if (!may_include.contains(target) || header.find('/') == std::string::npos) return;
    EXPECT_TRUE(may_include.at(layer).contains(target)) << file << ":" << line << " includes " << header;
  });
}

TEST(Structure, LibrariesStayInTheirLayer) {
  for_each_include([&](const std::string& layer, const std::string& header, const fs::path& file, int line) {
    const bool of_pictures =
        header.starts_with("opencv2/") || header.starts_with("libav") || header.starts_with("libsw");
    const bool of_fitting = header.starts_with("ceres/");
    const bool of_peers = (header.starts_with("boost/") && !header.starts_with("boost/math/")) ||
                          header.starts_with("cvode/") || header.starts_with("nvector/") ||
                          header.starts_with("sun");
    EXPECT_TRUE(!of_pictures || layer == "vision") << file << ":" << line << " includes " << header;
    EXPECT_TRUE(!of_fitting || layer == "fit") << file << ":" << line << " includes " << header;
    EXPECT_TRUE(!of_peers || file.parent_path().filename() == "peers")
        << file << ":" << line << " includes " << header;
    // Who links a library must not need the headers of what it hides.
    const bool is_public =
        file.extension() == ".h" && file.parent_path().parent_path() == kSource && layer != "apps";
    const bool hidden = of_pictures || of_fitting || header.find("internal/") != std::string::npos;
    EXPECT_FALSE(is_public && hidden) << file << ":" << line << " includes " << header;
  });
}

}  // namespace
}  // namespace tribotrack
