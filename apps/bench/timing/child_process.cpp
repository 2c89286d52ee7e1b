#include "apps/bench/timing/child_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <stdexcept>
#include <system_error>

namespace tribotrack::bench {

namespace {

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

struct FileActions {
  posix_spawn_file_actions_t actions{};
  explicit FileActions(const std::filesystem::path& stderr_file) {
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, stderr_file.c_str(),
                                     O_WRONLY | O_CREAT | O_TRUNC, 0644);
  }
  ~FileActions() { posix_spawn_file_actions_destroy(&actions); }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;
};

}  // namespace

ChildRun run_child(const std::vector<std::string>& command, const std::filesystem::path& stderr_file) {
  std::vector<char*> arguments;
  arguments.reserve(command.size() + 1);
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const FileActions files(stderr_file);
  const auto begun = std::chrono::steady_clock::now();
  pid_t child = 0;
  if (const int error =
          ::posix_spawn(&child, arguments[0], &files.actions, nullptr, arguments.data(), environ))
    throw std::runtime_error(command.front() +
                             ": cannot be started: " + std::generic_category().message(error));
  int status = 0;
  rusage used{};
  while (::wait4(child, &status, 0, &used) < 0)
    if (errno != EINTR) throw std::runtime_error(command.front() + ": its end cannot be waited for");
  ChildRun run;
  run.wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  run.cpu = seconds_of(used.ru_utime) + seconds_of(used.ru_stime);
  run.memory = 1024.0 * static_cast<double>(used.ru_maxrss);
  if (WIFEXITED(status)) run.exit_code = WEXITSTATUS(status);
  return run;
}

}  // namespace tribotrack::bench
