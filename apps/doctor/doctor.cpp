#include "apps/doctor/doctor.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "apps/figures/printed.h"
#include "apps/program/errors.h"
#include "apps/text/output_file.h"
#include "vision/libraries.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

constexpr double kMemoryOfOneRecording = 0.5e9;  ///< bytes, of 1280 x 800 px and any length, by measurement

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

Finding temporary_folder() {
  std::error_code error;
  const fs::path folder = fs::temp_directory_path(error);
  if (error)
    return {"temporary folder", error.message(),
            "let TMPDIR name a folder that is there and yours to write to"};
  try {
    TemporaryFile probe(folder / "tribotrack-doctor");
  } catch (const InvalidInput& failure) {
    return {"temporary folder", failure.what(), "let TMPDIR name a folder that is yours to write to"};
  }
  const auto space = fs::space(folder, error);
  return {"temporary folder",
          fmt::format("{}, {:.1f} GB free", folder.string(), 1e-9 * static_cast<double>(space.available)),
          error || space.available > 1'000'000'000
              ? ""
              : "frames decoded once are kept there: free some space, or set TMPDIR",
          false};
}

Finding memory() {
  rlimit limit{};
  getrlimit(RLIMIT_AS, &limit);
  const double pages =
      static_cast<double>(sysconf(_SC_AVPHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  const double free =
      limit.rlim_cur == RLIM_INFINITY ? pages : std::min(pages, static_cast<double>(limit.rlim_cur));
  return {"memory", fmt::format("{:.1f} GB free", 1e-9 * free),
          free > kMemoryOfOneRecording
              ? ""
              : "large recordings need about half a GB each: --threads 1 tracks one at a time",
          false};
}

}  // namespace

std::vector<Finding> examine(int threads) {
  std::vector<Finding> findings;
  for (const auto& library : vision::libraries(true))
    findings.push_back(
        {library.purpose, fmt::format("{} {}", library.name, library.version), library.missing});
  const std::string figures = why_not_printed();
  findings.push_back({"figures for print", figures.empty() ? "python3 with matplotlib" : figures,
                      figures.empty() ? "" : "only `--figures` needs it: apt-get install python3-matplotlib",
                      false});
  findings.push_back({"processors",
                      fmt::format("{} here, {} to be used", std::thread::hardware_concurrency(), threads), "",
                      false});
  findings.push_back(memory());
  findings.push_back(temporary_folder());
  for (const char* name : {"TMPDIR", "NO_COLOR", "TERM", "LANG", "LC_ALL", "SLURM_CPUS_PER_TASK"})
    if (const std::string value = environment(name); !value.empty())
      findings.push_back({"environment", fmt::format("{}={}", name, value), "", false});
  return findings;
}

}  // namespace tribotrack::apps
