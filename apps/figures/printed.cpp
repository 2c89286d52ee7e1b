#include "apps/figures/printed.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <cstdio>
#include <string>

#include "apps/program/errors.h"
#include "apps/text/output_file.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

/// Runs the script as Debian's python3 does, with nothing of the user's settings, of the current folder or of
/// the script's own: a json.py or matplotlibrc that lies there is not what it reads. What it says; its
/// status, 127 where there is no python3.
std::string run_script(const std::string& script, int& status) {
  std::string quoted;
  for (const char c : script) quoted += c == '\'' ? std::string("'\\''") : std::string{c};
  const std::string command = fmt::format(
      "d=$(mktemp -d) && cd \"$d\" && env -i HOME=\"$d\" MPLCONFIGDIR=\"$d\" LC_ALL=C.UTF-8 /usr/bin/python3 "
      "-I -B "
      "'{}' 2>&1; s=$?; rm -rf \"$d\"; exit $s",
      quoted);
  std::FILE* pipe = ::popen(command.c_str(), "r");
  if (!pipe) throw InvalidInput("/usr/bin/python3 cannot be started");
  std::string said;
  for (int c; (c = std::fgetc(pipe)) != EOF;) said += static_cast<char>(c);
  const int ended = ::pclose(pipe);
  status = WIFEXITED(ended) ? WEXITSTATUS(ended) : 1;
  return said;
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
