// What every command is given.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "apps/program/errors.h"

namespace tribotrack::apps {

struct Called;

/// The options every command has, and how the command ended.
struct Context {
  bool quiet = false;
  int threads = 0;             ///< 0: as many as this process may use
  ExitCode exit_code = kDone;  ///< set by a command that completed with a reservation
  /// Told of progress, beside the terminal, by any of the threads at work and by several at once. What it
  /// throws ends the work; runs of a campaign go on after a std::exception.
  std::function<void(const std::string& stage, std::int64_t done, std::int64_t total)> progress;
  Called* called = nullptr;  ///< by a program instead of from a shell (called.h)

  /// Of what stands against using the results: said on stderr, quiet or not, or handed to the caller.
  void doubt(ExitCode code, const std::string& sentence);
  void tell(const std::string& stage, std::int64_t done, std::int64_t total) const {
    if (progress) progress(stage, done, total);
  }
};

/// --threads, else min(affinity, SLURM_CPUS_PER_TASK, cgroup quota).
int threads_to_use(const Context& context);

}  // namespace tribotrack::apps
