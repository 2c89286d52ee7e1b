// What every command is given.
#pragma once

#include "apps/program/errors.h"

namespace tribotrack::apps {

/// The options every command has, and how the command ended.
struct Context {
  bool quiet = false;
  int threads = 0;             ///< 0: as many as this process may use
  ExitCode exit_code = kDone;  ///< set by a command that completed with a reservation
};

/// --threads, else min(affinity, SLURM_CPUS_PER_TASK, cgroup quota).
int threads_to_use(const Context& context);

}  // namespace tribotrack::apps
