#include "apps/doctor/version.h"

#include <fmt/format.h>

#include <CLI/Version.hpp>
#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "apps/doctor/commit.h"
#include "fit/estimate.h"
#include "vision/libraries.h"

namespace tribotrack::apps {

std::string version_text() {
  const std::string commit = source_commit();
  std::string text =
      "tribotrack " TRIBOTRACK_VERSION + (commit.empty() ? "" : fmt::format(" ({})", commit)) + "\nwith ";
  for (const auto& library : vision::libraries(false))
    if (library.name != "OpenCV imgcodecs") text += fmt::format("{} {}, ", library.name, library.version);
  return text + fmt::format("{}, Eigen {}.{}.{}, CLI11 {}, fmt {}.{}.{}, nlohmann-json {}.{}.{}",
                            fit::solver(), EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION,
                            CLI11_VERSION, FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100,
                            NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
                            NLOHMANN_JSON_VERSION_PATCH);
}

}  // namespace tribotrack::apps
