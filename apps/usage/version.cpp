#include "apps/usage/version.h"

#include <fmt/format.h>

#include <CLI/Version.hpp>
#include <Eigen/Core>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/program/context.h"
#include "apps/text/output_file.h"
#include "apps/usage/commit.h"
#include "fit/estimate.h"
#include "vision/libraries.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

std::string temporary_files() {
  std::error_code error;
  const fs::path folder = fs::temp_directory_path(error);
  if (error) return fmt::format("none ({}): let TMPDIR name a folder that exists", error.message());
  try {
    TemporaryFile attempt(folder / "tribotrack-version");
  } catch (const InvalidInput& failure) {
    return fmt::format("none ({}): let TMPDIR name a folder that is yours to write to", failure.what());
  }
  const auto space = fs::space(folder, error);
  return fmt::format("{}, {:.1f} GB free", folder.string(), 1e-9 * static_cast<double>(space.available));
}

}  // namespace

std::string version_text() {
  const std::string commit = source_commit();
  std::string text =
      "tribotrack " TRIBOTRACK_VERSION + (commit.empty() ? "" : fmt::format(" ({})", commit)) + "\nwith ";
  std::string missing;
  for (const auto& library : vision::libraries(true)) {
    if (library.name != "OpenCV imgcodecs") text += fmt::format("{} {}, ", library.name, library.version);
    if (!library.missing.empty())
      missing += fmt::format("\nMISSING, {}: {}", library.purpose, library.missing);
  }
  text += fmt::format("{}, Eigen {}.{}.{}, CLI11 {}, fmt {}.{}.{}, nlohmann-json {}.{}.{}", fit::solver(),
                      EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION, CLI11_VERSION,
                      FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100,
                      NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR, NLOHMANN_JSON_VERSION_PATCH);
  return text + missing +
         fmt::format("\nthreads: {} of {} processors\ntemporary files: {}", threads_to_use({}),
                     std::thread::hardware_concurrency(), temporary_files());
}

}  // namespace tribotrack::apps
