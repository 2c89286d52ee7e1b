#include "apps/figures/printed.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "apps/figures/figure_csv.h"
#include "apps/program/errors.h"
#include "apps/text/json.h"
#include "apps/text/output_file.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

constexpr const char* kScript = "figures.py";
constexpr const char* kInterpreter = "/usr/bin/python3";  // Debian's, whose packages hold matplotlib

/// Runs Debian's python3 with these arguments; what it says.
std::string run_python(const std::vector<std::string>& given, int& status) {
  // Isolated: a json.py that lies in the folder is not what a script imports.
  std::vector<std::string> words = {kInterpreter, "-I", "-B"};
  words.insert(words.end(), given.begin(), given.end());
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::array<int, 2> pipe{};
  if (::pipe(pipe.data()) != 0)
    throw InvalidInput(fmt::format("no pipe to {}: {}", kInterpreter, std::strerror(errno)));
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(pipe[1], STDERR_FILENO);
    ::dup2(pipe[1], STDOUT_FILENO);
    ::close(pipe[0]);
    ::close(pipe[1]);
    ::execv(kInterpreter, arguments.data());
    ::_exit(127);
  }
  ::close(pipe[1]);
  std::string said;
  std::array<char, 4096> buffer{};
  for (ssize_t count = 0;
       (count = ::read(pipe[0], buffer.data(), buffer.size())) > 0 || (count < 0 && errno == EINTR);)
    if (count > 0) said.append(buffer.data(), static_cast<std::size_t>(count));
  ::close(pipe[0]);
  if (child < 0)
    throw InvalidInput(fmt::format("{} cannot be started: {}", kInterpreter, std::strerror(errno)));
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return said;
}

bool ended_well(int status) {
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

bool has_no_python(int status) {
  return WIFEXITED(status) && WEXITSTATUS(status) == 127;
}

/// The last line that says something.
std::string last_line(const std::string& text) {
  const auto end = text.find_last_not_of(" \n");
  if (end == std::string::npos) return "";
  const auto begin = text.find_last_of('\n', end);
  return text.substr(begin == std::string::npos ? 0 : begin + 1,
                     end - (begin == std::string::npos ? 0 : begin + 1) + 1);
}

}  // namespace

std::vector<fs::path> printed_files(const std::vector<Figure>& figures, const fs::path& folder) {
  std::vector<fs::path> files = {folder / kScript};
  for (const Figure& figure : figures)
    for (const char* ending : {".csv", ".json", "-84mm.svg", "-84mm.pdf", "-174mm.svg", "-174mm.pdf"})
      files.push_back(folder / (figure.id + ending));
  return files;
}

std::string why_not_printed() {
  int status = 0;
  const std::string said = run_python({"-c", "import matplotlib"}, status);
  if (ended_well(status)) return "";
  return has_no_python(status) ? fmt::format("there is no {}", kInterpreter) : last_line(said);
}

void print_figures(const std::vector<Figure>& figures, const fs::path& folder, std::string_view script) {
  create_folder(folder);
  write_file(folder / kScript, script);
  for (const Figure& figure : figures) {
    write_file(folder / (figure.id + ".csv"), csv_of(figure));
    write_file(folder / (figure.id + ".json"), text_of(json_of(figure, Numbers::left_out)));
  }
  if (figures.empty()) return;
  int status = 0;
  std::vector<std::string> words = {(folder / kScript).string()};
  for (const Figure& figure : figures) words.push_back(figure.id);
  const std::string said = run_python(words, status);
  if (ended_well(status)) return;
  const bool missing = has_no_python(status) || said.find("ModuleNotFoundError") != std::string::npos;
  const std::string reason =
      has_no_python(status) ? fmt::format("there is no {}", kInterpreter) : last_line(said);
  throw InvalidInput(
      fmt::format("{}: the figures were not drawn: {}; {} (numbers and script are there)", folder.string(),
                  reason.empty() ? "the plotting program failed" : reason,
                  missing ? fmt::format("install Debian's python3-matplotlib, then `python3 {}` draws them",
                                        (folder / kScript).string())
                          : fmt::format("`python3 {}` says more", (folder / kScript).string())));
}

}  // namespace tribotrack::apps
