// What every command is given.
#pragma once

#include "apps/program/errors.h"

namespace tribotrack::apps {

/// What every command can be told, and how it ended.
struct Context {
  bool quiet = false;
  int threads = 0;             ///< 0: as many as this process may use
  ExitCode exit_code = kDone;  ///< set by a command that ends orderly but not well
};

/// min(affinity, SLURM_CPUS_PER_TASK, cgroup quota) where the user does not say.
int threads_to_use(const Context& context);

}  // namespace tribotrack::apps
