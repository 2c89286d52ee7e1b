// A whole command as its user waits for it: a process of its own, from its start to its end.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tribotrack::bench {

struct ChildRun {
  int exit_code = -1;  ///< -1 where a signal ended it
  double cpu = 0;      ///< s, user and system, of all its threads: loading, work and tearing down
  double wall = 0;     ///< s
  double memory = 0;   ///< bytes, the most that was resident
};

/// Runs `command` (program and arguments, no shell) to its end; its stdout is dropped, its stderr goes into a
/// file. Throws std::runtime_error where it cannot be started.
ChildRun run_child(const std::vector<std::string>& command, const std::filesystem::path& stderr_file);

}  // namespace tribotrack::bench
