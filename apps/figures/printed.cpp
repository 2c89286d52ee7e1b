#include "apps/figures/printed.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <cerrno>
#include <string>
#include <system_error>

#include "apps/program/errors.h"
#include "apps/text/output_file.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

constexpr const char* kInterpreter = "/usr/bin/python3";  // Debian's, whose packages hold matplotlib

/// A folder for what matplotlib keeps, gone with this object.
struct Scratch {
  std::string path = (fs::temp_directory_path() / "tribotrack_XXXXXX").string();
  Scratch() {
    if (::mkdtemp(path.data()) == nullptr) throw InvalidInput(path + ": the folder cannot be made");
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
};

/// Runs the script as Debian's python3 does, with nothing of the user's settings, of the current folder or of
/// the script's own: a json.py or matplotlibrc that lies there is not what it reads. What it says; its
/// status, 127 where there is no python3.
std::string run_script(std::string script, int& status) {
  const Scratch scratch;
  const std::string said = scratch.path + "/said";
  std::string interpreter = kInterpreter, isolated = "-I", no_cache = "-B", home = "HOME=" + scratch.path,
              settings = "MPLCONFIGDIR=" + scratch.path, letters = "LC_ALL=C.UTF-8";
  char* const arguments[] = {interpreter.data(), isolated.data(), no_cache.data(), script.data(), nullptr};
  char* const environment[] = {home.data(), settings.data(), letters.data(), nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 1, said.c_str(), O_WRONLY | O_CREAT, 0600);
  posix_spawn_file_actions_adddup2(&actions, 1, 2);
  posix_spawn_file_actions_addchdir_np(&actions, scratch.path.c_str());
  pid_t child = 0;
  const int failed = posix_spawn(&child, kInterpreter, &actions, nullptr, arguments, environment);
  posix_spawn_file_actions_destroy(&actions);
  status = 127;
  if (failed != 0) return fmt::format("{} cannot be started", kInterpreter);
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  status = WIFEXITED(status) ? WEXITSTATUS(status) : 1;
  return fs::exists(said) ? read_text(said) : "";
}

/// The last line that says something.
std::string last_line(const std::string& text) {
  const auto end = text.find_last_not_of(" \n");
  if (end == std::string::npos) return "the plotting program failed";
  const auto begin = text.rfind('\n', end);
  return text.substr(begin == std::string::npos ? 0 : begin + 1, end - begin);
}

}  // namespace

std::vector<fs::path> printed_files(const fs::path& folder) {
  std::vector<fs::path> files = {folder / "figures.py", folder / "runs.csv"};
  for (const char* name : {"alpha-phi", "alpha-dtau", "v-phi", "v-dtau", "residuals"})
    for (const char* ending : {"-84mm.svg", "-84mm.pdf", "-174mm.svg", "-174mm.pdf"})
      files.push_back(folder / (std::string(name) + ending));
  return files;
}

void print_figures(const fs::path& folder, std::string_view runs_csv, std::string_view script) {
  create_folder(folder);
  const std::string path = fs::absolute(folder / "figures.py").string();
  write_file(path, script);
  write_file(folder / "runs.csv", runs_csv);
  int status = 0;
  const std::string said = run_script(path, status);
  if (status == 0) return;
  const bool missing = status == 127 || said.find("ModuleNotFoundError") != std::string::npos;
  throw InvalidInput(fmt::format(
      "{}: the figures were not drawn: {}; {} (table and script are there)", folder.string(), last_line(said),
      missing ? fmt::format("install Debian's python3-matplotlib, then `python3 {}` draws them", path)
              : fmt::format("`python3 {}` says more", path)));
}

}  // namespace tribotrack::apps
