#include "apps/program/context.h"

#include <sched.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string>

namespace tribotrack::apps {

int threads_to_use(const Context& context) {
  if (context.threads > 0) return context.threads;
  int count = 1;
  cpu_set_t cpus;
  if (sched_getaffinity(0, sizeof cpus, &cpus) == 0) count = CPU_COUNT(&cpus);
  if (const char* slurm = std::getenv("SLURM_CPUS_PER_TASK"))
    if (const int given = std::atoi(slurm); given > 0) count = std::min(count, given);
  std::ifstream quota_file("/sys/fs/cgroup/cpu.max");
  std::string quota;
  double period = 0;
  if (quota_file >> quota >> period && quota != "max" && period > 0)
    count = std::min(count, std::max(1, static_cast<int>(std::atof(quota.c_str()) / period)));
  return std::max(1, count);
}

}  // namespace tribotrack::apps
