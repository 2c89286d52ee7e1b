// Runs the built program as its user would, and hands back what it said; other programs that tests run.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/program/errors.h"

namespace tribotrack::test {

inline std::string output_of(const std::string& command) {
  std::string output;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot run " + command);
  char buffer[65536];
  while (const std::size_t n = fread(buffer, 1, sizeof buffer, pipe)) output.append(buffer, n);
  pclose(pipe);
  return output;
}

/// The browser's program, or nullopt where none is installed.
inline std::optional<std::string> chromium() {
  std::string found =
      output_of("command -v chromium || command -v chromium-browser || command -v google-chrome");
  if (found.empty()) return std::nullopt;
  return found.substr(0, found.find('\n'));
}

/// A folder of its own that goes with the object.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "tribotrack-test-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make a temporary folder");
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline std::size_t occurrences(const std::string& text, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + word.size()))
    ++count;
  return count;
}

}  // namespace tribotrack::test

namespace tribotrack::apps {

struct Outcome {
  int exit_code = -1;
  std::string out, err;
};

inline std::string content_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

inline void put(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

/// What `read` complains of as InvalidInput.
template <class Read>
std::string complaint_of(const Read& read) {
  try {
    read();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "no complaint";
}

/// A scene of 40 frames at 1000 frames/s: a disc of 12 px radius slides freely over a platform at rest.
struct Slide {
  std::string velocity_x = "100", velocity_y = "40";  ///< mm/s
  std::string video = {};                             ///< further lines of [video]
  int texture = 0;                                    ///< rms of the platform's
};
inline std::string scene_of(const Slide& slide) {
  return "[platform]\namplitude_mm = 0\n[friction]\nmu1 = 0.2\n[run]\nvelocity_x_mm_s = " + slide.velocity_x +
         "\nvelocity_y_mm_s = " + slide.velocity_y +
         "\n[video]\nwidth = 160\nheight = 120\nframe_rate_hz = 1000\nexposure_s = 0.2e-3\nframes = 40\n" +
         slide.video +
         "[camera]\nmm_per_px = 0.05\n[disc]\nradius_px = 12\nscratches = 0\nhighlight = 0\n[surface]\n"
         "texture_rms = " +
         std::to_string(slide.texture) + "\n";
}
/// A campaign of free slides; `camera`: further lines of [camera].
inline std::string slides_campaign(const std::vector<std::string>& videos,
                                   const std::string& camera = "mm_per_px = 0.05\n") {
  std::string text = "[platform]\namplitude_mm = 0\n[camera]\n" + camera + "[fit]\nparameters = [\"mu1\"]\n";
  for (const std::string& video : videos)
    text += "[[run]]\nvideo = \"" + video + "\"\nkind = \"free_slide\"\n";
  return text;
}

/// A folder of its own for each test, gone afterwards; relative paths on command lines are relative to it.
class ProgramTest : public ::testing::Test {
 protected:
  /// `arguments` go through the shell, as typed. `environment` such as "NO_COLOR=1 ".
  Outcome run(const std::string& arguments, const std::string& environment = "") const {
    const std::string command = "cd '" + folder_.string() + "' && " + environment +
                                "'" TRIBOTRACK_BINARY "' " + arguments +
                                " >stdout.txt 2>stderr.txt </dev/null";
    const int status = std::system(command.c_str());
    Outcome outcome{WIFEXITED(status) ? WEXITSTATUS(status) : -1, content_of(folder_ / "stdout.txt"),
                    content_of(folder_ / "stderr.txt")};
    std::filesystem::remove(folder_ / "stdout.txt");
    std::filesystem::remove(folder_ / "stderr.txt");
    return outcome;
  }
  void render_slide(const std::string& name, const Slide& slide = {}) const {
    put(in_folder("scene.toml"), scene_of(slide));
    const Outcome outcome = run("synth scene.toml -o " + name + " --overwrite -q");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  }
  std::filesystem::path in_folder(const std::string& name) const { return folder_ / name; }
  std::filesystem::path source(const std::string& name) const {
    return std::filesystem::path(TRIBOTRACK_SOURCE_DIR) / name;
  }
  /// Names in the test's folder: what a command left behind.
  std::vector<std::string> left_behind() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_))
      names.push_back(entry.path().filename().string());
    return names;
  }

  test::TemporaryFolder own_;
  const std::filesystem::path folder_ = own_.path();
};

/// One sentence on stderr, nothing on stdout, this exit code, and the words that must stand in it.
inline void expect_refused(const Outcome& outcome, int exit_code, const std::vector<std::string>& words) {
  EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  for (const auto& word : words)
    EXPECT_NE(outcome.err.find(word), std::string::npos) << "missing \"" << word << "\" in: " << outcome.err;
}

}  // namespace tribotrack::apps
