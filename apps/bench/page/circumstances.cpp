#include "apps/bench/page/circumstances.h"

#include <cstdlib>
#include <fstream>

#include "apps/bench/peers/library_peers.h"

namespace tribotrack::bench {
namespace {

std::string cpu_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name"))
      if (const auto colon = line.find(": "); colon != std::string::npos) return line.substr(colon + 2);
  return "unknown";
}

apps::Json json_of(const LoadAverage& load) {
  return load ? apps::Json(*load) : apps::Json();
}

}  // namespace

LoadAverage load_average() {
  std::array<double, 3> load{};
  if (getloadavg(load.data(), 3) != 3) return {};
  return load;
}

Circumstances circumstances_here() {
  Circumstances here;
  here.program = "tribotrack " TRIBOTRACK_VERSION;
  here.cpu = cpu_name();
  here.compiler = TRIBOTRACK_COMPILER;
  here.compiler_flags = TRIBOTRACK_COMPILER_FLAGS;
  here.clock =
      "CPU time of the measuring thread, of whole commands of their process; medians of repetitions in which "
      "the methods take turns";
  here.model_reference =
      "Dormand-Prince 5(4) in extended precision (64-bit mantissa), segmented at the friction switches, "
      "local "
      "tolerance 1e-17 of the scene's scales (1e-15 with --quick); in the marginal scene, where explicit "
      "methods hang, tribotrack's own result at tolerance 1e-17. Each row names its reference";
  here.vision_reference =
      "truth of analytically rendered pictures; the bound is Cramer-Rao with everything but the position "
      "known, the 1/12 of rounding included";
  here.fit_reference = "truth of simulated campaigns; 1 degree on alpha and 2 % on v per run";
  here.peers =
      "own compact implementations of the paper's recipe, Dormand-Prince and Moreau-Jean, and Boost.odeint, "
      "compiled with the same flags (odeint a second time for AVX2 and FMA); SUNDIALS and OpenCV as "
      "installed, on one thread";
  here.missing = peers::missing_libraries();
  here.load_before = load_average();
  return here;
}

apps::Json json_of(const Circumstances& circumstances) {
  return {{"program", circumstances.program},
          {"cpu", circumstances.cpu},
          {"compiler", circumstances.compiler},
          {"compiler_flags", circumstances.compiler_flags},
          {"threads", 1},
          {"clock", circumstances.clock},
          {"load_average_before", json_of(circumstances.load_before)},
          {"load_average_after", json_of(circumstances.load_after)},
          {"reference",
           {{"model", circumstances.model_reference},
            {"vision", circumstances.vision_reference},
            {"fit", circumstances.fit_reference}}},
          {"peers_missing", circumstances.missing},
          {"peers", circumstances.peers}};
}

}  // namespace tribotrack::bench
